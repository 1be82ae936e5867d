//! What is known of a plant, and what has to be assumed.

use recording::model_file::ModelFile;
use recording::model_file::control::{Late, Recorded};

use crate::response::{Dynamics, Unknown};

/// The muscle's slope may be that of the model up to this factor at least, whatever a recording
/// shows: a load moves it to where its inverse does not look. Under a fifth of its blocked force in
/// the middle of its stroke the rig's muscle is three times as steep as the inverse takes it to be.
const LEAST_STEEPER: f64 = 3.0;
/// And by no more: what moves then is not the muscle of this model.
const MOST_STEEPER: f64 = 5.0;
/// Elements of creep that are faster stand for a lateness that may be of any kind. Unit: s.
const FAST_S: f64 = 1.0;
/// Share by which a valve's lag, or a natural frequency, may differ from what was found: the bound
/// that the game of hidden causes holds the diagnosis to is 15 %, and a valve is not quite of first
/// order.
pub const SHARE: f64 = 0.2;
/// Lag of a valve that nobody has seen. Unit: s; twice that of the slowest sound regulator of the
/// zoo, 0.06 s.
pub const UNSEEN_VALVE_S: f64 = 0.12;
/// Dead time of a muscle whose recording is not known, and the most that is allowed for where one
/// leaves more open. Unit: s; that of a line of 15 m at the speed of sound.
pub const UNSEEN_S: f64 = 0.045;
/// Standard errors that a bound stands above a mean.
const ERRORS: f64 = 2.0;

/// What a tuning goes by.
#[derive(Clone, Debug)]
pub struct Knowledge {
    /// The linear part.
    pub dynamics: Dynamics,
    /// What may be otherwise.
    pub unknown: Unknown,
    /// Lag of the valve that is known, and not in the model. Unit: s.
    pub lag_s: f64,
    /// Dead time that is known, and not in the model. Unit: s.
    pub delay_s: f64,
    /// Standard deviation of the contraction's noise. Output unit.
    pub noise: f64,
    /// What had to be assumed, a sentence each.
    pub assumptions: Vec<String>,
}

/// The lateness that is sure to be there. Unit: s.
fn known(late: &Late) -> f64 {
    if late.mean_s > ERRORS * late.error_s { late.mean_s } else { 0.0 }
}

/// The most that there may be beside it. Unit: s.
fn open(late: &Late) -> f64 {
    // Nothing comes earlier than its cause.
    (late.mean_s - known(late)).max(0.0) + ERRORS * late.error_s
}

impl Knowledge {
    /// Of a model with its dynamics.
    pub fn of(file: &ModelFile, mut dynamics: Dynamics) -> Self {
        let mut assumptions = Vec::new();
        let from_command = file.input.words().starts_with("command");
        let has_lag = dynamics.led_lag_s > 0.0;
        // What creep explains of a lateness may be a delay.
        let fast_s = file.extensions.creep.as_ref().map_or(0.0, |creep| {
            let all = creep.time_constants_s.iter().zip(&creep.fractions);
            all.filter(|(time_s, _)| **time_s < FAST_S).map(|(time_s, share)| time_s * share).sum()
        });
        let (muscle_s, mut late_s) = match &file.recorded {
            Some(Recorded { late, .. }) => (known(late), fast_s + open(late).min(UNSEEN_S)),
            None => {
                assumptions.push(format!(
                    "the model file does not say what its recording shows of time: a dead time of up to {UNSEEN_S} s is \
                     allowed for (mgpi tune --recording REC.csv finds it out)"
                ));
                (0.0, UNSEEN_S)
            }
        };
        if file.recorded.is_some_and(|recorded| open(&recorded.late) > UNSEEN_S) {
            assumptions.push(format!(
                "the recording leaves open how late the muscle is, as one at a single speed does: a dead time of up to \
                 {UNSEEN_S} s is allowed for"
            ));
        }
        // A muscle that is late for sure may have a mass in the place of a dead time.
        let error_s = file.recorded.map_or(0.0, |recorded| recorded.late.error_s);
        let swing_s = if dynamics.has_mass() || muscle_s == 0.0 { 0.0 } else { muscle_s + ERRORS * error_s };
        let (mut delay_s, mut lag_s) = (muscle_s, 0.0);
        match file.recorded.as_ref().and_then(|recorded| recorded.valve) {
            Some(valve) if has_lag => {
                delay_s += known(&valve);
                late_s += open(&valve);
            }
            Some(valve) => {
                lag_s = known(&valve);
                late_s += open(&valve);
            }
            None if from_command || has_lag => {}
            None => {
                assumptions.push(format!(
                    "no command beside the pressure: the valve is not known, and a lag of up to {UNSEEN_VALVE_S} s is allowed for"
                ));
                dynamics.unled_lag_s = UNSEEN_VALVE_S;
            }
        }
        dynamics.led_lag_s += lag_s;
        dynamics.delay_s += delay_s;
        let noise = file.recorded.map_or(0.0, |recorded| recorded.noise);
        if file.recorded.is_none() {
            assumptions.push("the sensor's noise is not known, and taken to be none".to_owned());
        }
        Self {
            dynamics,
            unknown: Unknown {
                slope: file
                    .recorded
                    .map_or(LEAST_STEEPER, |recorded| recorded.steeper.clamp(LEAST_STEEPER, MOST_STEEPER)),
                late_s,
                swing_s,
                in_place_of_s: muscle_s,
                lag: SHARE,
                frequency: SHARE,
            },
            lag_s,
            delay_s,
            noise,
            assumptions,
        }
    }
}
