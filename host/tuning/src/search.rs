//! The search for the fastest feedback that keeps its margins at every corner.

use std::f64::consts::PI;

use crate::knowledge::Knowledge;
use crate::margins::{Margins, frequencies, holds, margins, reach_hz};
use crate::response::{Corner, Feedback, Unknown, corners};
use crate::slopes::Slope;

/// The largest sensitivity that a tuning may have at any corner. Where the muscle is as its model
/// says, it is then near 1.4: the ends of the range that is usual.
pub const SENSITIVITY: f64 = 2.0;
/// The largest share of the command's range that the sensor's noise may move the command by, as a
/// standard deviation: the repeatability that makers of proportional regulators state.
pub const NOISE: f64 = 0.005;
/// The slowest observer that is worth having. Unit: 1/s: a disturbance is halved in 7 s.
pub const SLOWEST: f64 = 0.1;
/// Proportional gains that are tried, as loop gains on the steepest slope.
const PROPORTIONAL: [f64; 6] = [0.05, 0.1, 0.2, 0.4, 0.8, 1.6];
/// From one rate that is tried to the next.
const STEP: f64 = 1.25;
/// How often the last step is halved.
const HALVINGS: usize = 6;
/// What is left of an error that repeats, at the most, from one learning pass to the next.
const LEFT: f64 = 0.7;

/// What limits a feedback.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// Dead time that is known.
    Delay,
    /// Dead time that the recording cannot exclude.
    UnseenDelay,
    /// A lag of the valve that the model does not have, or not exactly.
    Valve,
    /// A mass whose frequency is not known exactly.
    Mass,
    /// How steep the muscle may be beside the model.
    Slope,
    /// The sensor's noise.
    Noise,
    /// The tick.
    Period,
}

impl Limit {
    /// In a word, for files.
    pub fn key(self) -> &'static str {
        match self {
            Self::Delay => "delay",
            Self::UnseenDelay => "unseen_delay",
            Self::Valve => "valve",
            Self::Mass => "mass",
            Self::Slope => "slope",
            Self::Noise => "noise",
            Self::Period => "period",
        }
    }

    /// In words, for people.
    pub fn words(self) -> &'static str {
        match self {
            Self::Delay => "the dead time of the muscle's line",
            Self::UnseenDelay => "a dead time that the recording cannot exclude",
            Self::Valve => "a lag of the valve that the model does not have, or not exactly",
            Self::Mass => "the mass, whose natural frequency is not known exactly",
            Self::Slope => "how much steeper the muscle may be than its model",
            Self::Noise => "the noise of the contraction's sensor",
            Self::Period => "the period of the board's tick",
        }
    }
}

/// A feedback with what it promises.
#[derive(Clone, Debug)]
pub struct Found {
    /// The feedback in the mode of feed-forward and feedback: the observer, and kp.
    pub both: Feedback,
    /// That of the feedback alone: kp and ki.
    pub alone: Feedback,
    /// The least margins of the first over all corners.
    pub margins: Margins,
    /// Up to where disturbances are lessened, on the flattest slope and on the steepest. Unit: Hz.
    pub reach_hz: (f64, f64),
    /// Up to where repetitions may be learnt from. Unit: Hz.
    pub learning_hz: f64,
    /// What limits it.
    pub limit: Limit,
}

/// What a search goes by.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// On the whole loop.
    pub slopes: &'a [Slope],
    /// Of the plant.
    pub knowledge: &'a Knowledge,
    /// Unit: input unit.
    pub command_range: f64,
}

impl Task<'_> {
    fn steepest(&self) -> f64 {
        self.slopes.iter().map(|slope| slope.driven).fold(0.0, f64::max)
    }

    fn corners(&self, unknown: &Unknown) -> Vec<Corner> {
        corners(self.slopes, unknown, self.knowledge.dynamics.has_mass())
    }

    /// How much the sensor's noise moves the command where the loop is as the model has it.
    /// Standard deviation, input unit.
    fn command_noise(&self, feedback: &Feedback) -> f64 {
        let Knowledge { dynamics, noise, .. } = self.knowledge;
        let frequencies = frequencies(dynamics.period_s);
        let of_slope = |at: &Slope| {
            let corner = Corner {
                contraction: at.contraction,
                slope: at.turned,
                ratio: 1.0,
                late_s: 0.0,
                swing_s: 0.0,
                lag: 1.0,
                frequency: 1.0,
            };
            let density = |omega: f64| {
                let open = dynamics.open_loop(&corner, feedback, omega);
                (dynamics.controller(&corner, feedback, omega) / (1.0 + open)).norm_sqr()
            };
            // White noise of one sample each period: its density is even up to half the rate.
            frequencies
                .windows(2)
                .map(|pair| 0.5 * (density(pair[0]) + density(pair[1])) * (pair[1] - pair[0]))
                .sum::<f64>()
                * dynamics.period_s
                / PI
        };
        noise * self.slopes.iter().map(of_slope).fold(0.0, f64::max).sqrt()
    }

    /// The fastest value, from a first one on, for which all before it hold too. None where the
    /// first does not.
    fn fastest(first: f64, last: f64, holds: impl Fn(f64) -> bool) -> Option<f64> {
        if !holds(first) {
            return None;
        }
        let mut good = first;
        while good * STEP < last && holds(good * STEP) {
            good *= STEP;
        }
        let mut step = STEP.sqrt();
        for _ in 0..HALVINGS {
            if good * step < last && holds(good * step) {
                good *= step;
            }
            step = step.sqrt();
        }
        Some(good)
    }

    /// The fastest observer, and the kp that lets it be so.
    fn both(&self, unknown: &Unknown, noise: f64) -> Option<Feedback> {
        let dynamics = &self.knowledge.dynamics;
        let corners = self.corners(unknown);
        let noisiest = NOISE * self.command_range;
        let quieter = noise / self.knowledge.noise.max(f64::MIN_POSITIVE);
        let mut best: Option<(Feedback, f64)> = None;
        for share in PROPORTIONAL {
            let kp = share / self.steepest();
            let with = |rate_per_s| Feedback { kp, rate_per_s, ..Feedback::default() };
            let is_good = |rate| {
                let feedback = with(rate);
                quieter * self.command_noise(&feedback) <= noisiest
                    && holds(dynamics, &corners, &feedback, SENSITIVITY)
            };
            let Some(rate) = Self::fastest(SLOWEST, 0.5 / dynamics.period_s, is_good) else { break };
            let left = self.left(&with(rate));
            if best.is_none_or(|(_, least)| left < least) {
                best = Some((with(rate), left));
            }
        }
        best.map(|(feedback, _)| feedback)
    }

    /// What is left of disturbances whose size falls with their frequency, where the loop is as the
    /// model has it; on all slopes alike.
    fn left(&self, feedback: &Feedback) -> f64 {
        let dynamics = &self.knowledge.dynamics;
        let exact =
            Unknown { slope: 1.0, late_s: 0.0, swing_s: 0.0, in_place_of_s: 0.0, lag: 0.0, frequency: 0.0 };
        let corners = self.corners(&exact);
        let of = |corner: &Corner| -> f64 {
            let frequencies = frequencies(dynamics.period_s);
            let felt = |omega: f64| 1.0 / (1.0 + dynamics.open_loop(corner, feedback, omega)).norm_sqr();
            frequencies.windows(2).map(|pair| felt(pair[0]) * (pair[1] - pair[0]) / (pair[0] * pair[1])).sum()
        };
        corners.iter().map(of).sum()
    }

    /// The feedback, and what it promises. None where none is safe.
    pub fn run(&self) -> Option<Found> {
        let Knowledge { dynamics, unknown, noise, .. } = self.knowledge;
        let both = self.both(unknown, *noise)?;
        let corners = self.corners(unknown);
        let alone = self.alone(&corners, both.kp);
        let reach = |is_wanted: fn(&Corner) -> bool| {
            let all = corners.iter().filter(|corner| is_wanted(corner));
            all.map(|corner| reach_hz(dynamics, corner, &both)).fold(f64::INFINITY, f64::min)
        };
        Some(Found {
            margins: margins(dynamics, &corners, &both),
            reach_hz: (reach(|corner| corner.ratio < 1.0), reach(|corner| corner.ratio > 1.0)),
            learning_hz: self.learning_hz(&corners, &both),
            limit: self.limit(both.rate_per_s),
            both,
            alone,
        })
    }

    /// Proportional and integral gain for the feedback alone.
    fn alone(&self, corners: &[Corner], kp: f64) -> Feedback {
        let dynamics = &self.knowledge.dynamics;
        let with = |ki| Feedback { kp, ki, ..Feedback::default() };
        let is_good = |ki| holds(dynamics, corners, &with(ki), SENSITIVITY);
        let most = 0.5 / (dynamics.period_s * self.steepest());
        with(Self::fastest(SLOWEST / self.steepest(), most, is_good).unwrap_or(0.0))
    }

    /// What would let it be faster the most, if it were known or not there.
    fn limit(&self, rate: f64) -> Limit {
        let Knowledge { dynamics, unknown, noise, .. } = self.knowledge;
        let faster = |change: &dyn Fn(&mut Knowledge, &mut Unknown, &mut f64)| {
            let (mut knowledge, mut unknown, mut noise) = (self.knowledge.clone(), *unknown, *noise);
            change(&mut knowledge, &mut unknown, &mut noise);
            let task = Task { knowledge: &knowledge, ..*self };
            task.both(&unknown, noise).map_or(0.0, |both| both.rate_per_s / rate)
        };
        let mut all = vec![
            (Limit::Delay, faster(&|knowledge, _, _| knowledge.dynamics.delay_s = 0.0)),
            (Limit::UnseenDelay, faster(&|_, unknown, _| (unknown.late_s, unknown.swing_s) = (0.0, 0.0))),
            (
                Limit::Valve,
                faster(&|knowledge, unknown, _| {
                    (knowledge.dynamics.unled_lag_s, unknown.lag) = (0.0, 0.0);
                }),
            ),
            (Limit::Slope, faster(&|_, unknown, _| unknown.slope = 1.0)),
            (Limit::Noise, faster(&|_, _, noise| *noise = 0.0)),
        ];
        if dynamics.has_mass() {
            all.push((Limit::Mass, faster(&|_, unknown, _| unknown.frequency = 0.0)));
        }
        let most = all.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
        // A tenth is what the search itself is exact to.
        most.filter(|(_, gain)| *gain > 1.1).map_or(Limit::Period, |(limit, _)| limit)
    }

    /// Up to where a filter of [`crate::zero_phase`] may let repetitions be learnt from, so that an
    /// error that repeats becomes smaller from pass to pass at every corner.
    fn learning_hz(&self, corners: &[Corner], feedback: &Feedback) -> f64 {
        let dynamics = &self.knowledge.dynamics;
        let frequencies = frequencies(dynamics.period_s);
        let left: Vec<(f64, f64)> = frequencies
            .iter()
            .map(|&omega| {
                let of = |corner: &Corner| (1.0 - dynamics.tracking(corner, feedback, omega)).norm();
                (omega / (2.0 * PI), corners.iter().map(of).fold(0.0, f64::max))
            })
            .collect();
        let converges =
            |hz: f64| left.iter().all(|(at_hz, left)| crate::zero_phase::gain(*at_hz, hz) * left <= LEFT);
        Self::fastest(frequencies[0] / (2.0 * PI), 0.25 / dynamics.period_s, converges).unwrap_or(0.0)
    }
}
