//! Recordings of the command alone, with the regulator in the chain.

use super::*;
use crate::causes::cause;

use crate::low_pass::low_pass;

/// A regulator that lags by so much, and a muscle with nothing hidden behind it.
fn behind_a_regulator(lag_s: f64) -> Columns {
    let plant = Plant::new();
    let commands: Vec<f64> = plant.time_s.iter().map(|&t| command(t)).collect();
    let pressure = low_pass(&commands, &plant.time_s, lag_s);
    let recorded = plant.recorded(&hysteresis(&pressure));
    Columns { input: commands, input_is_command: true, command: None, ..recorded }
}

#[test]
fn the_lag_of_any_regulator_is_part_of_the_model_and_not_named() {
    for lag_s in [0.02, 0.04, 0.06] {
        let columns = behind_a_regulator(lag_s);
        let (diagnosis, extended) = diagnose_and_extend(&columns, None, &|_, _| ()).expect("a diagnosis");
        assert_eq!(diagnosis.verdict, Verdict::Adequate, "{lag_s} s: {:?}", names(&diagnosis));
        let written = extended.written(&columns, None).expect("a model");
        let lag = written.model.extensions.valve_lag.expect("a lag of the valve");
        assert!((lag.time_constant_s / lag_s - 1.0).abs() < 0.2, "{lag_s} s: {lag:?}");
    }
}

#[test]
fn a_slow_valve_is_named_from_the_command_alone() {
    let diagnosis = diagnosed(&behind_a_regulator(0.3));
    assert_eq!(names(&diagnosis), [cause("valve_lag")]);
    assert!((parameter(&diagnosis, "time_constant_s") / 0.3 - 1.0).abs() < 0.1);
}
