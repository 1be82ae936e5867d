//! From a model of a muscle to the feedback that goes with it, with stated margins, and learning
//! over repetitions.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | [`slopes`] | how steeply the model answers, everywhere on its loop, driven on and just turned round |
//! | `rates` | how much later it answers where its width depends on the rate |
//! | `knowledge` | what is known of a plant, and what has to be assumed |
//! | [`response`] | the loop in the frequency domain, for every way in which the plant may be |
//! | [`margins`] | gain margin, phase margin, largest sensitivity |
//! | `search` | the feedback with the largest integral gain that keeps its margins at every corner, and what limits it |
//! | [`zero_phase`], [`learning`] | what repeats is learnt, up to where that converges |
//!
//! # Why the slopes are enough
//! At every instant a model of plays is a slope times the rate of its input, and the slope lies
//! between the two that [`slopes`] finds at a place. The margins at both slopes, and at slopes
//! beyond them by the factor that the recording shows, are a necessary part of the circle criterion
//! for such an element, and are what is stated. They are not the whole of it, and are measured on
//! plants besides (docs/control.md).
//!
//! # Contract
//! Every tuning keeps a largest sensitivity of [`SENSITIVITY`] at every corner of what is not
//! known, or there is none, and the reason is told. Nothing is random.

mod knowledge;
pub mod learning;
pub mod margins;
mod rates;
pub mod response;
mod search;
pub mod slopes;
pub mod zero_phase;

use model_core::ParameterError;
use recording::model_file::ModelFile;
use recording::model_file::control::Observer;
pub use recording::model_file::control::Tuning;
use thiserror::Error;

use knowledge::Knowledge;
use margins::Margins;
use response::{Corner, Dynamics, Feedback, Growth, Plants, Unknown, corners};
use search::{Found, Task};
pub use search::{Limit, NOISE, SENSITIVITY, SLOWEST};
use slopes::Slope;

/// Standard deviations of the sensor's noise within which a move is none: one sample in 16,000 lies
/// beyond.
const BAND: f64 = 4.0;
/// Standard error above which a recording says nothing of a lateness. Unit: s.
const LEAST_KNOWN_S: f64 = 1.0;

/// Why there is no tuning.
#[derive(Debug, Error)]
pub enum Refusal {
    /// The parameters make no valid model.
    #[error("no loop can be made of the model: {0}")]
    Parameter(#[from] ParameterError),
    /// The model is too far off.
    #[error("{0}: its slopes say nothing of the muscle's, and no gain is known to be safe")]
    Poor(String),
    /// The recording does not say when the muscle moves.
    #[error(
        "the recording leaves open whether the muscle answers {0:.1} s late: it has too little movement; mgpi plan \
         writes a command that shows it"
    )]
    Open(f64),
    /// The valve has a dead band.
    #[error(
        "the valve ignores changes of its command below {0} {1}, as play in a gear does: with any integral the loop \
         hunts about that, whatever its gain"
    )]
    DeadBand(f64, String),
    /// No feedback has its margins.
    #[error(
        "no loop of {SLOWEST} /s on the steepest slope, or faster, keeps a largest sensitivity of {SENSITIVITY}: dead \
         time, lags, slopes and noise together do not allow one"
    )]
    Unsafe,
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
    fn of(
        file: &ModelFile,
        period_s: f64,
        valve_lag_s: Option<f64>,
    ) -> Result<(Self, Knowledge), ParameterError> {
        let knowledge = Knowledge::of(file, Dynamics::of(&file.extensions, period_s)?, valve_lag_s);
        let mut slopes = slopes::slopes(&file.model);
        rates::add(file, &mut slopes)?;
        let view = Self { dynamics: knowledge.dynamics.clone(), slopes, unknown: knowledge.unknown };
        Ok((view, knowledge))
    }

    /// The slopes of the model.
    pub fn slopes(&self) -> &[Slope] {
        &self.slopes
    }

    fn corners(&self) -> Vec<Corner> {
        corners(&self.slopes, &self.unknown, &self.dynamics)
    }

    /// The plant in all ways in which it may be, as a feedback finds it.
    pub fn plants(&self, feedback: &Feedback) -> Plants {
        Plants::of(&self.dynamics, &self.corners(), feedback.observer)
    }
}

/// The feedback of a tuning.
pub fn feedback(tuning: &Tuning) -> Feedback {
    let Tuning { kp, ki, kd, derivative_filter_s: filter_s, .. } = *tuning;
    let observer = tuning.observer.map(|Observer { slope, reach, .. }| Growth { slope, reach });
    Feedback { kp, ki, kd, filter_s, observer }
}

/// Tunes a feedback for a model at a board's period (s). `valve_lag_s` is what a user knows of the
/// valve; it counts where neither model nor recording say more. `observes`: whether gains may grow
/// where the muscle is flatter.
///
/// # Errors
/// See [`Refusal`].
pub fn tune(
    file: &ModelFile,
    period_s: f64,
    valve_lag_s: Option<f64>,
    observes: bool,
) -> Result<Tuned, Refusal> {
    if let Some(worth) = file.worth().filter(|worth| !worth.may_deploy()) {
        return Err(Refusal::Poor(worth.to_string()));
    }
    if let Some(band) = &file.extensions.valve_deadband {
        return Err(Refusal::DeadBand(band.band, file.input.unit.to_string()));
    }
    let (view, knowledge) = View::of(file, period_s, valve_lag_s)?;
    let open_s = file.recorded.map_or(0.0, |recorded| recorded.late.error_s);
    if open_s > LEAST_KNOWN_S {
        return Err(Refusal::Open(open_s));
    }
    let (low, high) = file.parameters.input();
    let task = Task { slopes: &view.slopes, knowledge: &knowledge, command_range: high - low };
    let Found { feedback, margins, reach_hz, learning_hz, limit } =
        task.run(observes).ok_or(Refusal::Unsafe)?;
    // A valve of first order answers a jump through its range with range/lag at first: a command
    // that changes faster gains nothing.
    let lag_s = knowledge.dynamics.led_lag_s;
    let tuning = Tuning {
        kp: feedback.kp,
        ki: feedback.ki,
        kd: feedback.kd,
        derivative_filter_s: feedback.filter_s,
        tracking_time_s: tracking_time_s(&feedback, &view.slopes, view.dynamics.has_mass())
            .max(2.0 * period_s),
        observer: feedback.observer.map(|Growth { slope, reach }| Observer {
            slope,
            reach,
            band: BAND * knowledge.noise,
        }),
        slew_per_s: (lag_s > 0.0).then(|| (high - low) / lag_s),
        lag_s: knowledge.lag_s,
        delay_s: knowledge.dynamics.ahead_s,
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

/// Time constant of the anti-windup. Unit: s. `has_mass`: whether the inverse leads one.
///
/// The integral time, as is usual (Åström and Hägglund, section 3.5). But the inverse of a mass asks
/// for a peak at each knot of the model, and what limits take off it would move the integral by
/// more than the error moves it back, where the loop takes longer than that time to put anything
/// right. So beside a mass it is at least the time of the loop where that is the slowest.
fn tracking_time_s(feedback: &Feedback, slopes: &[Slope], has_mass: bool) -> f64 {
    let integral_s = feedback.kp / feedback.ki;
    if has_mass {
        slopes.iter().map(|slope| 1.0 / (feedback.ki * slope.driven)).fold(integral_s, f64::max)
    } else {
        integral_s
    }
}

/// How near the edge gains are that a user gives.
///
/// # Errors
/// The parameters make no valid model.
pub fn judge(file: &ModelFile, feedback: &Feedback, period_s: f64) -> Result<Margins, ParameterError> {
    Ok(margins::margins(&View::of(file, period_s, None)?.0.plants(feedback), feedback))
}

/// Up to where what repeats may be learnt beside a feedback, with the leads that the model file
/// has. Unit: Hz; 0 where nowhere.
///
/// # Errors
/// The parameters make no valid model.
pub fn learning_hz(file: &ModelFile, feedback: &Feedback, period_s: f64) -> Result<f64, ParameterError> {
    let (mut view, knowledge) = View::of(file, period_s, None)?;
    if file.tuning.is_none() {
        let of = &mut view.dynamics;
        (of.led_lag_s, of.unled_lag_s) = (of.led_lag_s - knowledge.lag_s, of.unled_lag_s + knowledge.lag_s);
        of.ahead_s = 0.0;
    }
    Ok(search::learning_hz(&view.dynamics, &view.corners(), feedback))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Its slowest loop takes 1/(0.5 4) s, its integral time is 0.001/0.5 s.
    const INTEGRAL: Feedback = Feedback { kp: 0.001, ki: 0.5, kd: 0.0, filter_s: 0.0, observer: None };
    const SLOPES: [Slope; 2] = [
        Slope { contraction: 20.0, turned: 10.0, driven: 40.0, sliding_s: [0.0; 3] },
        Slope { contraction: 80.0, turned: 1.0, driven: 4.0, sliding_s: [0.0; 3] },
    ];

    #[test]
    fn beside_a_mass_what_limits_cut_off_is_taken_back_no_faster_than_the_slowest_loop_works() {
        assert!((tracking_time_s(&INTEGRAL, &SLOPES, true) - 0.5).abs() < 1e-9);
        assert!((tracking_time_s(&INTEGRAL, &SLOPES, false) - 0.002).abs() < 1e-9);
    }
}
