//! The search for the feedback that lessens slow disturbances the most and keeps its margins at
//! every corner.
//!
//! The integral gain is what a slow disturbance is lessened by, and the integral of its error is
//! one over it; so it is made as large as the bound on the largest sensitivity allows, over
//! proportional and derivative gains (Åström, Panagopoulos and Hägglund, Design of PI controllers
//! based on non-convex optimization, Automatica 34, 1998).

use std::f64::consts::PI;

use crate::knowledge::Knowledge;
use crate::margins::{Margins, holds, margins, reach_hz};
use crate::response::{Corner, Dynamics, Feedback, Growth, Plants, Unknown, corners, frequencies};
use crate::slopes::Slope;

/// The largest sensitivity that a tuning may have at any corner: from 1.2 to 2 is usual (Åström
/// and Hägglund, section 4.6), and 1.6 leaves a gain margin of 2.7 and a phase margin of 36
/// degrees.
pub const SENSITIVITY: f64 = 1.6;
/// The largest share of the command's range that the sensor's noise may move the command by, as a
/// standard deviation: the repeatability that makers of proportional regulators state, 0.5 to 1 %.
pub const NOISE: f64 = 0.005;
/// The slowest loop that is worth having, on the steepest slope. Unit: 1/s: a disturbance is halved
/// in 7 s.
pub const SLOWEST: f64 = 0.1;
/// Loop gains on the steepest slope from which proportional gains are tried, and how many times
/// more from one to the next.
const LEAST_LOOP_GAIN: f64 = 0.02;
const LOOP_GAINS: usize = 24;
const GAIN_STEP: f64 = 1.35;
/// Derivative times that are tried, as shares of the lags that are known.
const DERIVATIVES: [f64; 4] = [0.0, 0.33, 0.67, 1.0];
/// The derivative's filter, as a share of the derivative time: from 2 to 20 is usual (Åström and
/// Hägglund, section 3.3).
const FILTERED: f64 = 0.1;
/// From one integral gain that is tried to the next, and how often the last step is halved.
const STEP: f64 = 2.0;
const HALVINGS: usize = 5;
/// What is left of an error that repeats, at the most, from one learning pass to the next: a sixth
/// after five.
const LEFT: f64 = 0.7;
/// Reaches of an observer that are tried, from that of the flattest slope down, each that share of
/// the one before.
const REACHES: usize = 5;
const REACH_STEP: f64 = 0.5;
/// What would be faster without a limit by less than this factor is not limited by it: twice what
/// the search is exact to.
const LIMITS: f64 = 1.1;

/// What limits a feedback.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// Dead time that is known.
    Delay,
    /// Dead time that the recording cannot exclude.
    UnseenDelay,
    /// A lag of the valve.
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
            Self::Valve => "the lag of the valve",
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
    /// The gains.
    pub feedback: Feedback,
    /// The least margins over all corners.
    pub margins: Margins,
    /// Up to where disturbances are lessened, where that is least and where it is most. Unit: Hz.
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
        corners(self.slopes, unknown, &self.knowledge.dynamics)
    }

    fn plants(&self, unknown: &Unknown, growth: Option<Growth>) -> Plants {
        Plants::of(&self.knowledge.dynamics, &self.corners(unknown), growth)
    }

    /// How much the sensor's noise moves the command, at the most, on these plants. Standard
    /// deviation, input unit.
    fn command_noise(&self, plants: &Plants, feedback: &Feedback) -> f64 {
        let omegas = &plants.omegas;
        let controller: Vec<_> = omegas.iter().map(|&omega| feedback.response(omega)).collect();
        let power = |(plant, factor): (&Vec<num_complex::Complex<f64>>, &f64)| {
            let density = |k: usize| (factor * controller[k] / (1.0 + plant[k] * controller[k])).norm_sqr();
            // White noise of one sample each period: its density is even up to half the rate.
            (1..omegas.len())
                .map(|k| 0.5 * (density(k - 1) + density(k)) * (omegas[k] - omegas[k - 1]))
                .sum::<f64>()
                * self.knowledge.dynamics.period_s
                / PI
        };
        let powers = plants.responses.iter().zip(&plants.factors).map(power);
        self.knowledge.noise * powers.fold(0.0, f64::max).sqrt()
    }

    /// The largest value, from a first one on, for which all that were tried before it hold too.
    /// None where the first does not.
    fn largest(first: f64, last: f64, holds: impl Fn(f64) -> bool) -> Option<f64> {
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

    /// The feedback of the largest integral gain.
    fn best(&self, growth: Option<Growth>) -> Option<Feedback> {
        let Knowledge { dynamics, unknown, .. } = self.knowledge;
        let (plants, exact) = (self.plants(unknown, growth), self.plants(&Unknown::NOTHING, growth));
        let noisiest = NOISE * self.command_range;
        let steepest = self.steepest();
        let is_good = |feedback: &Feedback| {
            holds(&plants, feedback, SENSITIVITY) && self.command_noise(&exact, feedback) <= noisiest
        };
        let lag_s = dynamics.known_lag_s() + dynamics.unled_lag_s;
        let mut best: Option<Feedback> = None;
        for share in DERIVATIVES {
            let derivative_s = share * lag_s;
            let filter_s = (FILTERED * derivative_s).max(2.0 * dynamics.period_s);
            let mut loop_gain = LEAST_LOOP_GAIN;
            for _ in 0..LOOP_GAINS {
                let kp = loop_gain / steepest;
                let with = |ki| Feedback { kp, ki, kd: kp * derivative_s, filter_s, observer: growth };
                let most = 1.0 / (dynamics.period_s * steepest);
                let Some(ki) = Self::largest(SLOWEST / steepest, most, |ki| is_good(&with(ki))) else {
                    break;
                };
                if best.is_none_or(|best| ki > best.ki) {
                    best = Some(with(ki));
                }
                loop_gain *= GAIN_STEP;
            }
            if lag_s == 0.0 {
                break;
            }
        }
        best
    }

    /// How fast a disturbance is taken back where that is slowest. Unit: 1/s.
    fn slowest(&self, feedback: &Feedback) -> f64 {
        let plants = self.plants(&Unknown::NOTHING, feedback.observer);
        feedback.ki * plants.slopes.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// The feedback with the observer by which a disturbance is taken back the fastest where that is
    /// slowest, and nowhere slower than without one; without one where that gains nothing.
    fn observed(&self) -> Option<Feedback> {
        let flattest = self.slopes.iter().map(|slope| slope.turned).fold(f64::INFINITY, f64::min);
        let slope = self.steepest();
        let reaches = (0..REACHES).map(|step| slope / flattest * REACH_STEP.powi(step as i32));
        // No slope is counted on that is flatter than slopes are known to.
        let is_known = |reach: &f64| *reach > 1.0 && reach * self.knowledge.slope_error <= slope;
        let growths = reaches.filter(is_known).map(|reach| Growth { slope, reach });
        let alone = self.best(None)?;
        let others = growths.filter_map(|growth| self.best(Some(growth)));
        let no_slower = others.filter(|other| LIMITS * other.ki >= alone.ki);
        let rated =
            std::iter::once(alone).chain(no_slower).map(|feedback| (self.slowest(&feedback), feedback));
        rated.reduce(|best, next| if next.0 > LIMITS * best.0 { next } else { best }).map(|(_, found)| found)
    }

    /// The feedback, and what it promises; `observes`: whether there may be an observer. None where
    /// none is safe.
    pub fn run(&self, observes: bool) -> Option<Found> {
        let feedback = if observes { self.observed() } else { self.best(None) }?;
        let plants = self.plants(&self.knowledge.unknown, feedback.observer);
        let reach = reach_hz(&plants, &feedback);
        Some(Found {
            margins: margins(&plants, &feedback),
            reach_hz: (
                reach.iter().copied().fold(f64::INFINITY, f64::min),
                reach.iter().copied().fold(0.0, f64::max),
            ),
            learning_hz: self.learning_hz(&feedback),
            limit: self.limit(&feedback),
            feedback,
        })
    }

    /// What would let the integral gain be larger the most, if it were known or not there.
    fn limit(&self, feedback: &Feedback) -> Limit {
        let Feedback { ki, observer, .. } = *feedback;
        let larger = |change: &dyn Fn(&mut Knowledge)| {
            let mut knowledge = self.knowledge.clone();
            change(&mut knowledge);
            Task { knowledge: &knowledge, ..*self }.best(observer).map_or(0.0, |best| best.ki / ki)
        };
        let mut all = vec![
            (Limit::Delay, larger(&|knowledge| knowledge.dynamics.delay_s = 0.0)),
            (
                Limit::UnseenDelay,
                larger(&|knowledge| (knowledge.unknown.late_s, knowledge.unknown.split) = (0.0, (1.0, 0.0))),
            ),
            (
                Limit::Valve,
                larger(&|knowledge| {
                    let of = &mut knowledge.dynamics;
                    (of.led_lag_s, of.behind_s, of.unled_lag_s) = (0.0, 0.0, 0.0);
                }),
            ),
            (Limit::Slope, larger(&|knowledge| knowledge.unknown.slope = 1.0)),
            (Limit::Noise, larger(&|knowledge| knowledge.noise = 0.0)),
        ];
        if self.knowledge.dynamics.has_mass() {
            all.push((Limit::Mass, larger(&|knowledge| knowledge.unknown.frequency = 0.0)));
        }
        let most = all.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
        most.filter(|(_, gain)| *gain > LIMITS).map_or(Limit::Period, |(limit, _)| limit)
    }

    /// Up to where a filter of [`crate::zero_phase`] may let repetitions be learnt from, so that an
    /// error that repeats becomes smaller from pass to pass at every corner.
    fn learning_hz(&self, feedback: &Feedback) -> f64 {
        let Knowledge { dynamics, unknown, .. } = self.knowledge;
        learning_hz(dynamics, &self.corners(unknown), feedback)
    }
}

/// Up to where repetitions may be learnt from beside a feedback. Unit: Hz; 0 where nowhere.
pub fn learning_hz(dynamics: &Dynamics, corners: &[Corner], feedback: &Feedback) -> f64 {
    let omegas = frequencies(dynamics.period_s);
    let left: Vec<(f64, f64)> = omegas
        .iter()
        .map(|&omega| {
            let of = |corner: &Corner| (1.0 - dynamics.tracking(corner, feedback, omega)).norm();
            (omega / (2.0 * PI), corners.iter().map(of).fold(0.0, f64::max))
        })
        .collect();
    let converges =
        |hz: f64| left.iter().all(|(at_hz, left)| crate::zero_phase::gain(*at_hz, hz) * left <= LEFT);
    Task::largest(omegas[0] / (2.0 * PI), 0.25 / dynamics.period_s, converges).unwrap_or(0.0)
}
