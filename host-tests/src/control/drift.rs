//! A muscle that warms up for half an hour, by the feed-forward alone, with and without adaptation.

use model_core::adaptation::{Adapted, Change};
use model_core::{Mode, Surroundings};
use rig::plant::Plant;
use wire::BoardTracking;
use wire::registers::HIGHEST_BAR;

use super::course::STEP_BAR;
use super::reference::Course;
use crate::PERIOD_S;

/// How long a run takes: half an hour, three time constants of the warming. Unit: s.
const WHOLE_S: f64 = 1800.0;
/// How much warmer than the room the muscle becomes, and how fast: what a muscle that works without
/// a pause is reported to do is 10 to 20 K within some minutes. Unit: K.
const WARMER_K: f64 = 15.0;
/// See there. Unit: s.
const TIME_CONSTANT_S: f64 = 600.0;

/// What becomes of a run.
#[derive(Clone, Debug)]
pub struct Drifted {
    /// Of each minute behind the first. RMSE, mm.
    pub minutes_mm: Vec<f64>,
    /// What was learnt. Unit: mm.
    pub change: Change<f32>,
}

impl Drifted {
    /// Of all of them. RMSE, mm.
    pub fn whole_mm(&self) -> f64 {
        let squares: f64 = self.minutes_mm.iter().map(|mm| mm * mm).sum();
        (squares / self.minutes_mm.len() as f64).sqrt()
    }

    /// Of the worst of them over what it was in `fresh`. Unit: 1.
    pub fn worst_over(&self, fresh: &Self) -> f64 {
        self.minutes_mm.iter().zip(&fresh.minutes_mm).map(|(mm, of)| mm / of).fold(0.0, f64::max)
    }
}

/// Follows `course`, again and again, by the feed-forward alone. `warms`: whether the muscle does;
/// `learns`: whether the feed-forward follows it.
pub fn run(
    tracking: &BoardTracking,
    plant: &mut Plant,
    (course, preview_s, range_mm): (Course, f64, (f64, f64)),
    warms: bool,
    learns: bool,
) -> Drifted {
    let mode = Mode::FeedforwardOnly;
    let mut adapted = Adapted::default();
    let reference_mm = course.points(range_mm);
    let (approach, ticks) = (Course::from_tick(), reference_mm.len());
    let wanted = |tick: usize| {
        let behind = tick.saturating_sub(approach) % (ticks - approach);
        reference_mm[if tick < approach { tick } else { approach + behind }]
    };
    let ahead = (preview_s / PERIOD_S).round() as usize;
    let (mut state, mut surroundings) = (tracking.rest_state(mode), Surroundings::default());
    let (minute, whole) = ((60.0 / PERIOD_S) as usize, (WHOLE_S / PERIOD_S) as usize);
    let mut squares = vec![0.0; whole / minute];
    let prepare = |state: &mut _, tick: usize, surroundings: &_, adapted: &mut _| {
        let reference = wanted(tick + ahead) as f32;
        let asked = if learns { tracking.asked(adapted, reference) } else { reference };
        tracking.prepare_asked(state, (asked, reference), surroundings).expect("finite")
    };
    let mut prepared = prepare(&mut state, 0, &surroundings, &mut adapted);
    let mut command_bar = 0.0;
    for tick in 0..whole {
        let time_s = tick as f64 * PERIOD_S;
        if warms {
            plant.heat(WARMER_K * (1.0 - (-time_s / TIME_CONSTANT_S).exp()));
        }
        let measured = plant.step(command_bar, if tick == 0 { 0.0 } else { PERIOD_S });
        squares[tick / minute] += (wanted(tick) - plant.exact_mm()).powi(2);
        let asked = tracking.act(&mut state, mode, prepared, measured.contraction_mm as f32).expect("finite");
        if learns {
            tracking.learn(&state, &prepared, !asked.limited, &mut adapted);
        }
        let put_out = (f64::from(asked.command) / STEP_BAR).round() * STEP_BAR;
        command_bar = put_out.clamp(0.0, HIGHEST_BAR);
        surroundings = Surroundings { load: Some(measured.load_n as f32), temperature: None };
        prepared = prepare(&mut state, tick + 1, &surroundings, &mut adapted);
    }
    let rmse = |squares: &f64| (squares / minute as f64).sqrt();
    Drifted {
        minutes_mm: squares.iter().skip(1).map(rmse).collect(),
        change: tracking.adapter().in_mm(adapted.change()),
    }
}
