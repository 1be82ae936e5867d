//! Recordings of the command alone, with the regulator in the chain.

use super::*;
use crate::causes::cause;

use crate::low_pass::low_pass;

/// A regulator that lags by so much, and a muscle with nothing hidden behind it.
fn behind_a_regulator(lag_s: f64) -> Columns {
    behind_a_supply(f64::INFINITY, lag_s)
}

/// The same, fed by a supply of so many bar.
fn behind_a_supply(supply: f64, lag_s: f64) -> Columns {
    let plant = Plant::new();
    let commands: Vec<f64> = plant.time_s.iter().map(|&t| command(t)).collect();
    let supplied: Vec<f64> = commands.iter().map(|command| command.min(supply)).collect();
    let pressure = low_pass(&supplied, &plant.time_s, lag_s);
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

#[test]
fn a_supply_below_the_commands_is_named_from_the_command_alone_and_written() {
    let columns = behind_a_supply(4.9, 0.04);
    let (diagnosis, extended) = diagnose_and_extend(&columns, None, &|_, _| ()).expect("a diagnosis");
    assert_eq!(names(&diagnosis), [cause("supply_saturation")]);
    let supply = parameter(&diagnosis, "supply_bar");
    assert!((supply - 4.9).abs() < 0.06, "{supply}");
    let written = extended.written(&columns, None).expect("a model");
    let supply = written.model.extensions.supply_saturation.expect("a supply").supply;
    assert!((supply - 4.9).abs() < 0.06, "{supply}");
}

#[test]
fn a_supply_and_a_slow_valve_are_both_named_from_the_command_alone() {
    let diagnosis = diagnosed(&behind_a_supply(4.5, 0.3));
    let mut found = names(&diagnosis);
    found.sort_by_key(|cause| cause.name());
    assert_eq!(found, [cause("supply_saturation"), cause("valve_lag")]);
    assert!((parameter(&diagnosis, "supply_bar") - 4.5).abs() < 0.05);
}
