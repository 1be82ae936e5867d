//! From a model of a muscle to the feedback that goes with it, with stated margins, and learning
//! over repetitions.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | [`slopes`] | how steeply the model answers, everywhere on its loop, driven on and just turned round |
//! | [`lateness`] | what a recording shows of time and noise beside its model |
//! | `knowledge` | what is known of a plant, and what has to be assumed |
//! | [`response`] | the loop in the frequency domain, for every way in which the plant may be |
//! | [`margins`] | gain margin, phase margin, largest sensitivity |
//! | `search` | the fastest feedback that keeps its margins at every corner, and what limits it |
//! | [`zero_phase`], [`learning`] | what repeats is learnt, up to where that converges |
//!
//! The feedback is a disturbance observer on the inverse model (`model_core::observer`) and a
//! proportional gain; for the mode of feedback alone an integral takes the observer's place.
//!
//! # Why the slopes are enough
//! At every instant a model of plays is a slope times the rate of its input, and the slope lies
//! between the two that [`slopes`] finds at a place. A loop of such an element and a linear system
//! is stable by the circle criterion where the linear system keeps clear of the disc that the two
//! slopes span; the margins at both slopes, and at slopes beyond them by the factor that the model
//! may be wrong by, are a necessary part of that, and are what is stated. They are not the whole of
//! it, and are measured on plants besides (docs/control.md).
//!
//! # Contract
//! Every tuning keeps a largest sensitivity of [`SENSITIVITY`] at every corner of what is not
//! known, or there is none, and the reason is told. Nothing is random.

mod knowledge;
pub mod lateness;
pub mod learning;
pub mod margins;
pub mod response;
mod search;
pub mod slopes;
pub mod zero_phase;

use model_core::ParameterError;
use recording::model_file::ModelFile;
pub use recording::model_file::control::Tuning;
use thiserror::Error;

use knowledge::Knowledge;
use margins::Margins;
use response::{Corner, Dynamics, Feedback, Unknown, corners};
use search::{Found, Task};
pub use search::{Limit, NOISE, SENSITIVITY, SLOWEST};
use slopes::Slope;

/// Time constant of the derivative's filter; no tuning has a derivative, but a user may. Unit: s.
const FILTER_S: f64 = 0.02;
/// The command may go through its whole range in the valve's time constant, which is as fast as a
/// lag of first order answers a jump; in no less than the first and no more than the second of
/// these. Unit: s. The first is the fastest that a board takes (200 bar/s), the second is for a
/// valve that nobody has seen.
const RANGE_S: (f64, f64) = (0.03, 0.12);
/// Longest dead time or lag that a recording may leave open. Unit: s.
const LEAST_KNOWN_S: f64 = 1.0;

/// Why there is no tuning.
#[derive(Debug, Error)]
pub enum Refusal {
    /// The model is none.
    #[error("no loop can be made of the model: {0}")]
    Parameter(#[from] ParameterError),
    /// The model is too far off.
    #[error("{0}: its slopes say nothing of the muscle's, and no gain is known to be safe")]
    Poor(String),
    /// The recording does not say when the muscle moves.
    #[error(
        "the recording leaves open whether the muscle answers {0:.1} s late: it has too little movement, or at one speed \
         only; mgpi plan writes a command that shows it"
    )]
    Open(f64),
    /// No feedback has its margins.
    #[error(
        "no observer faster than {SLOWEST} /s keeps a largest sensitivity of {SENSITIVITY}; what limits it: {0}"
    )]
    Unsafe(&'static str),
}

/// A tuning with what it was made from.
#[derive(Clone, Debug)]
pub struct Tuned {
    /// For the model file.
    pub tuning: Tuning,
    /// What had to be assumed, a sentence each.
    pub assumptions: Vec<String>,
    /// What limits it.
    pub limit: Limit,
    /// The loop.
    pub view: View,
}

/// A loop at every place, to be looked at or judged.
#[derive(Clone, Debug)]
pub struct View {
    dynamics: Dynamics,
    slopes: Vec<Slope>,
    unknown: Unknown,
}

impl View {
    /// Of a model at a period (s).
    fn of(file: &ModelFile, period_s: f64) -> Result<(Self, Knowledge), ParameterError> {
        let knowledge = Knowledge::of(file, Dynamics::of(&file.extensions, period_s)?);
        let view = Self {
            dynamics: knowledge.dynamics.clone(),
            slopes: slopes::slopes(&file.model),
            unknown: knowledge.unknown,
        };
        Ok((view, knowledge))
    }

    /// The slopes of the model.
    pub fn slopes(&self) -> &[Slope] {
        &self.slopes
    }

    /// The corners.
    pub fn corners(&self) -> Vec<Corner> {
        corners(&self.slopes, &self.unknown, self.dynamics.has_mass())
    }

    /// The linear part.
    pub fn dynamics(&self) -> &Dynamics {
        &self.dynamics
    }

    /// The least margins of a feedback over all corners.
    pub fn margins(&self, feedback: &Feedback) -> Margins {
        margins::margins(&self.dynamics, &self.corners(), feedback)
    }
}

/// The feedback of a tuning, as it acts where both feed-forward and feedback do: with an observer,
/// that is in the place of the integral.
pub fn feedback(tuning: &Tuning) -> Feedback {
    Feedback {
        kp: tuning.kp,
        ki: if tuning.observer_rate_per_s > 0.0 { 0.0 } else { tuning.ki },
        kd: tuning.kd,
        filter_s: tuning.derivative_filter_s,
        rate_per_s: tuning.observer_rate_per_s,
    }
}

/// Tunes a feedback for a model at a board's period (s).
///
/// # Errors
/// See [`Refusal`].
pub fn tune(file: &ModelFile, period_s: f64) -> Result<Tuned, Refusal> {
    if let Some(worth) = file.worth().filter(|worth| !worth.may_deploy()) {
        return Err(Refusal::Poor(worth.to_string()));
    }
    let (view, knowledge) = View::of(file, period_s)?;
    let open_s = file.recorded.map_or(0.0, |recorded| recorded.late.error_s);
    if open_s > LEAST_KNOWN_S {
        return Err(Refusal::Open(open_s));
    }
    let (low, high) = file.parameters.input();
    let task = Task { slopes: &view.slopes, knowledge: &knowledge, command_range: high - low };
    let Found { both, alone, margins, reach_hz, learning_hz, limit } =
        task.run().ok_or(Refusal::Unsafe("delay, lags and slopes together"))?;
    let lag_s = knowledge.dynamics.led_lag_s.max(knowledge.dynamics.unled_lag_s);
    let through_s = if lag_s > 0.0 { lag_s.clamp(RANGE_S.0, RANGE_S.1) } else { RANGE_S.1 };
    let tuning = Tuning {
        kp: both.kp,
        ki: alone.ki,
        kd: 0.0,
        derivative_filter_s: FILTER_S,
        tracking_time_s: (5.0 / both.rate_per_s).clamp(0.1, 1.0),
        observer_rate_per_s: both.rate_per_s,
        slew_per_s: (high - low) / through_s,
        lag_s: knowledge.lag_s,
        delay_s: knowledge.delay_s,
        maximum_sensitivity: margins.maximum_sensitivity,
        gain_margin: margins.gain.min(1e3),
        phase_margin_deg: margins.phase_deg,
        bandwidth_hz: reach_hz,
        learning_hz,
        limited_by: limit.key().to_owned(),
        period_s,
    };
    Ok(Tuned { tuning, assumptions: knowledge.assumptions, limit, view })
}

/// How near the edge gains are that a user gives.
///
/// # Errors
/// The model is none.
pub fn judge(file: &ModelFile, feedback: &Feedback, period_s: f64) -> Result<Margins, ParameterError> {
    Ok(View::of(file, period_s)?.0.margins(feedback))
}
