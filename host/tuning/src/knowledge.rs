//! What is known of a plant, and what has to be assumed.

use recording::model_file::ModelFile;
use recording::model_file::control::{Late, Recorded, SeenValve};
use recording::numbers::STANDARD_ERRORS;
use recording::valve_order::FLAT;

use crate::response::{Dynamics, Unknown};
use crate::slopes::DRIVEN;

/// Share by which a valve's lag, a natural frequency or a viscosity may differ from what was found: the bound
/// that the game of hidden causes holds the diagnosis to (docs/game.md).
pub const SHARE: f64 = 0.15;
/// Lag of a valve that nobody has seen. Unit: s; the longest that the diagnosis takes for that of
/// any proportional regulator.
pub const UNSEEN_VALVE_S: f64 = 0.07;
/// Dead time of a muscle whose recording is not known, and the most that is allowed for where one
/// leaves more open. Unit: s; that of a line of 15 m at 340 m/s, the speed of sound.
pub const UNSEEN_S: f64 = 0.045;

/// What a tuning goes by.
#[derive(Clone, Debug)]
pub struct Knowledge {
    /// The linear part.
    pub dynamics: Dynamics,
    /// What may be otherwise.
    pub unknown: Unknown,
    /// Lag of the valve that is known, and not in the model. Unit: s.
    pub lag_s: f64,
    /// Standard deviation of the contraction's noise. Output unit.
    pub noise: f64,
    /// To what a slope of the model is known. Unit: output unit/input unit.
    pub slope_error: f64,
    /// What had to be assumed, a sentence each.
    pub assumptions: Vec<String>,
}

/// The lateness that is sure to be there. Unit: s.
fn known(late: &Late) -> f64 {
    if late.mean_s > STANDARD_ERRORS * late.error_s { late.mean_s } else { 0.0 }
}

/// The most that there may be beside it. Unit: s.
fn open(late: &Late) -> f64 {
    // Nothing comes earlier than its cause.
    (late.mean_s - known(late)).max(0.0) + STANDARD_ERRORS * late.error_s
}

/// What the model is off by, over the stretch that its slopes are taken over: where it answers less
/// than that, as behind a turn in the dead band of a valve that nobody has named, nobody knows how
/// flat the muscle is. Unit: output unit/input unit; 0 of a model without a recording.
fn slope_error(file: &ModelFile) -> f64 {
    let (low, high) = file.parameters.input();
    let misfit = file.identification.as_ref().map_or(0.0, |identification| identification.training.rmse);
    misfit / (DRIVEN * (high - low))
}

impl Knowledge {
    /// Of a model with its dynamics. `valve_lag_s`: that of the valve, where a user knows it.
    pub fn of(file: &ModelFile, mut dynamics: Dynamics, valve_lag_s: Option<f64>) -> Self {
        let mut assumptions = Vec::new();
        let from_command = file.input.words().starts_with("command");
        let has_lag = dynamics.led_lag_s > 0.0;
        // An element of creep that makes no more late than a line's dead time may be one.
        let crept_s: f64 = dynamics
            .creep
            .iter()
            .map(|(share, time_s)| share * time_s)
            .filter(|late_s| *late_s <= UNSEEN_S)
            .sum();
        // What the model does not name may be a misfit as well as a dead time: it is allowed for,
        // and the reference is not given ahead by it.
        let seen_s = match &file.recorded {
            Some(Recorded { late, .. }) if late.mean_s - STANDARD_ERRORS * late.error_s > UNSEEN_S => {
                assumptions.push(format!(
                    "the muscle is {:.3} s later than its model, which does not say why (mgpi diagnose does): allowed for \
                     as a dead time",
                    late.mean_s
                ));
                late.mean_s + STANDARD_ERRORS * late.error_s
            }
            Some(Recorded { late, .. }) => {
                let most_s = late.mean_s.max(0.0) + STANDARD_ERRORS * late.error_s;
                if most_s > UNSEEN_S {
                    assumptions.push(format!(
                        "the recording leaves open how late the muscle is, as one at a single speed does: a dead time \
                         of up to {UNSEEN_S} s is allowed for"
                    ));
                }
                most_s.min(UNSEEN_S)
            }
            None => {
                assumptions.push(format!(
                    "the model file does not say what its recording shows of time and noise: a dead time of up to \
                     {UNSEEN_S} s is allowed for, slopes as the model has them, and no noise (--recording REC.csv \
                     finds them out)"
                ));
                UNSEEN_S
            }
        };
        let (mut lag_s, mut late_s) = (0.0, crept_s + seen_s);
        match file.recorded.as_ref().and_then(|recorded| recorded.valve) {
            Some(SeenValve { late, shares }) if has_lag => {
                // A longer lag, not a dead time: `orders` is what the recording shows of a valve
                // of the whole lag, and a dead time would show as an order.
                dynamics.behind_s = known(&late);
                // A valve of second order is as late in small moves. One that is not, and later
                // than the lag that fits it, is so in large moves, which its flow limits: small
                // ones of a reference that is given ahead would come too early.
                if shares.0 > 0.0 {
                    dynamics.ahead_s = dynamics.behind_s;
                }
                late_s += open(&late).min(UNSEEN_VALVE_S);
            }
            Some(SeenValve { late, .. }) => {
                lag_s = known(&late);
                late_s += open(&late).min(UNSEEN_VALVE_S);
            }
            None if from_command || has_lag => {}
            None => match valve_lag_s {
                Some(given_s) => lag_s = given_s,
                None => {
                    assumptions.push(format!(
                        "no command beside the pressure: the valve is not known, and a lag of up to {UNSEEN_VALVE_S} s \
                         is allowed for; one that is slower makes the loop swing (--valve-lag-s says what it is)"
                    ));
                    dynamics.unled_lag_s = UNSEEN_VALVE_S;
                }
            },
        }
        dynamics.led_lag_s += lag_s;
        let seen = file.recorded.as_ref().and_then(|recorded| recorded.valve);
        let orders = seen.map_or((0.0, FLAT), |valve| valve.shares);
        if dynamics.known_lag_s() + dynamics.unled_lag_s > 0.0 && orders.1 >= FLAT && orders.0 < FLAT {
            assumptions.push(
                "the recording does not show whether the valve answers as one lag or as two (of second order): tuned for \
                 both; a command that jumps, beside the pressure and at short intervals, shows it"
                    .to_owned(),
            );
        }
        let split = file.recorded.and_then(|recorded| recorded.split);
        let split = split.map_or((1.0, 0.0), |split| (split.share, split.late_s));
        Self {
            dynamics,
            unknown: Unknown {
                slope: file.recorded.map_or(1.0, |recorded| recorded.steeper.max(1.0)),
                late_s,
                split,
                orders,
                lag: SHARE,
                frequency: SHARE,
                viscosity: SHARE,
            },
            lag_s,
            slope_error: slope_error(file),
            noise: file.recorded.map_or(0.0, |recorded| recorded.noise),
            assumptions,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::margins::margins;
    use crate::{SENSITIVITY, feedback, tune};

    const PAPER: &str = include_str!("../../../examples/paper-tables-1-2.toml");

    /// The paper's model with a valve of a lag of 0.03 s that its recording shows as 0.03 s later,
    /// of these shares of the second order, and a dead time of the muscle.
    fn later(shares: (f64, f64), delay_s: f64) -> ModelFile {
        let (least, most) = shares;
        let delay = if delay_s > 0.0 {
            format!("[extensions.transport_delay]\ndelay_s = {delay_s}\n")
        } else {
            String::new()
        };
        let late_s = 0.03 - delay_s;
        let text = format!(
            "{PAPER}\n[extensions.valve_lag]\ntime_constant_s = 0.03\n{delay}[recorded]\nstep_s = 0.005\nnoise_mm = 0.01\n\
             steeper = 1.2\nlate_s = 0.0\nlate_error_s = 0.0005\nvalve_late_s = {late_s}\n\
             valve_late_error_s = 0.0005\nvalve_second_order_least = {least:?}\nvalve_second_order_most = {most:?}\n"
        );
        ModelFile::parse(Path::new("model.toml"), &text).expect("valid")
    }

    #[test]
    fn a_valve_that_is_later_than_its_lag_has_a_longer_lag_and_not_a_dead_time() {
        let of = |file: &ModelFile| tune(file, 1e-3, None, false).expect("safe").tuning;
        let (lag, dead_time) = (of(&later((0.0, 0.0), 0.0)), of(&later((0.0, 0.0), 0.03)));
        assert!(lag.ki > 2.0 * dead_time.ki, "{} and {} bar/(mm s)", lag.ki, dead_time.ki);
        let of = |file: &ModelFile| {
            let dynamics = Dynamics::of(&file.extensions, 1e-3).expect("valid");
            Knowledge::of(file, dynamics, None).dynamics
        };
        let dynamics = of(&later((0.0, 0.0), 0.0));
        assert!((dynamics.known_lag_s() - 0.06).abs() < 1e-9 && dynamics.delay_s == 0.0, "{dynamics:?}");
    }

    #[test]
    fn a_loop_keeps_its_margins_with_a_viscosity_that_may_be_a_dead_time() {
        let of = |split: &str| {
            let text = format!(
                "{PAPER}\n[extensions.viscous_lag]\nknots_mm = [50.0]\nviscosity_bar_s_per_mm = [0.003]\n[recorded]\n\
                 step_s = 0.005\nnoise_mm = 0.01\nsteeper = 1.2\nlate_s = 0.0\nlate_error_s = 0.0005\n{split}"
            );
            let file = ModelFile::parse(Path::new("model.toml"), &text).expect("valid");
            tune(&file, 1e-3, Some(0.02), false).expect("safe")
        };
        let (viscous, open) = (of(""), of("viscosity_least = 0.5\nviscosity_late_s = 0.04\n"));
        assert!(open.tuning.maximum_sensitivity <= SENSITIVITY, "{:?}", open.tuning);
        let told = feedback(&viscous.tuning);
        let found = margins(&open.view.plants(&told), &told);
        assert!(found.maximum_sensitivity > SENSITIVITY, "{found:?}");
        assert!(open.tuning.ki < viscous.tuning.ki, "{:?}, {:?}", open.tuning, viscous.tuning);
    }

    #[test]
    fn an_observer_counts_on_no_slope_that_is_flatter_than_the_model_is_off() {
        let reach = |rmse: f64| {
            let text = format!(
                "{PAPER}\n[identification]\nrecording = \"rec.csv\"\nsha256 = \"{}\"\ntool = \"mgpi\"\nscored_rows = 6000\n\
                 stroke_mm = 120.0\nstarts = 8\ntermination = \"converged\"\n[identification.training]\n\
                 rmse_mm = {rmse:?}\nmae_mm = {rmse:?}\nmax_error_mm = {rmse:?}\n[identification.standard_errors]\n\
                 [recorded]\nstep_s = 0.005\nnoise_mm = 0.001\nsteeper = 1.2\nlate_s = 0.0\nlate_error_s = 0.02\n",
                "0".repeat(64)
            );
            let file = ModelFile::parse(Path::new("model.toml"), &text).expect("valid");
            let observer = tune(&file, 1e-3, Some(0.02), true).expect("safe").tuning.observer;
            observer.map_or((1.0, 0.0), |observer| (observer.reach, observer.slope))
        };
        let ((well, _), (badly, slope)) = (reach(0.01), reach(1.0));
        // 1 mm over 2 % of 6 bar.
        assert!(badly > 1.0 && badly <= slope / (1.0 / 0.12), "{badly}, {slope} mm/bar");
        assert!(well > 2.0 * badly, "{well}, {badly}");
    }

    #[test]
    fn a_reference_is_given_ahead_of_a_later_valve_where_that_is_of_second_order_alone() {
        let ahead_s = |shares| tune(&later(shares, 0.0), 1e-3, None, false).expect("safe").tuning.delay_s;
        assert_eq!(ahead_s((0.0, 0.0)), 0.0);
        assert_eq!(ahead_s((0.0, FLAT)), 0.0);
        assert!((ahead_s((0.25, FLAT)) - 0.03).abs() < 1e-9);
    }
}
