use super::*;
use crate::Columns;

/// Triangles of falling height and rising speed. Unit: bar.
fn command(time_s: f64) -> f64 {
    let turns = time_s * (0.05 + 0.002 * time_s);
    let triangle = 1.0 - (2.0 * turns.fract() - 1.0).abs();
    0.3 + (5.5 - 0.04 * time_s) * triangle
}

/// What is found of a valve that was given these commands.
fn found(time_s: &[f64], commands: &[f64], valve: &Valve) -> ValveFit {
    let pressure = valve.simulate(commands[0], time_s, commands);
    let columns = Columns {
        scored: vec![true; time_s.len()],
        output: pressure.clone(),
        command: Some(commands.to_vec()),
        input: pressure,
        time_s: time_s.to_vec(),
        ..Columns::default()
    };
    examine(&columns, 1e-4).expect("there is a command")
}

/// With two lags one behind the other.
fn of_two(one_s: f64, other_s: f64) -> Valve {
    let damping_ratio = 0.5 * (one_s + other_s) / (one_s * other_s).sqrt();
    Valve { damping_ratio: Some(damping_ratio), ..Valve::slow(one_s + other_s) }
}

/// Jumps with holds. Unit: bar.
fn jumps(time_s: &[f64]) -> Vec<f64> {
    time_s.iter().map(|t| [1.0, 4.0, 2.0, 5.0][(0.7 * t) as usize % 4]).collect()
}

#[test]
fn a_slow_valve_behind_an_ordinary_one_is_slow_and_not_late() {
    let time_s: Vec<f64> = (0..4000).map(|row| 0.01 * f64::from(row)).collect();
    for lag_s in [0.08, 0.22] {
        let valve = of_two(lag_s, 0.04);
        let found = found(&time_s, &jumps(&time_s), &valve);
        assert_eq!(found.named.iter().map(|(part, _)| *part).collect::<Vec<_>>(), [ValvePart::Lag]);
        assert!((found.valve.longer_lag_s() / lag_s - 1.0).abs() < 0.05, "{:?}", found.valve);
    }
    let ordinary = of_two(0.02, 0.02);
    assert_eq!(found(&time_s, &jumps(&time_s), &ordinary).named, []);
}

#[test]
fn a_regulator_of_the_second_order_is_not_late() {
    let time_s: Vec<f64> = (0..4000).map(|row| 0.01 * f64::from(row)).collect();
    for (lag_s, damping_ratio) in [(0.15, 0.7), (0.1, 0.4), (0.2, 1.0)] {
        let valve = Valve { damping_ratio: Some(damping_ratio), ..Valve::slow(lag_s) };
        for commands in [jumps(&time_s), time_s.iter().map(|&time_s| command(time_s)).collect()] {
            let found = found(&time_s, &commands, &valve);
            assert_eq!(found.named.iter().map(|(part, _)| *part).collect::<Vec<_>>(), [ValvePart::Lag]);
            assert!((found.valve.lag_s / lag_s - 1.0).abs() < 0.05, "{:?}", found.valve);
        }
    }
}

#[test]
fn a_late_valve_is_late_whether_it_has_one_lag_or_two() {
    let time_s: Vec<f64> = (0..4000).map(|row| 0.01 * f64::from(row)).collect();
    for valve in [Valve::slow(0.04), of_two(0.04, 0.02)] {
        let valve = Valve { delay_s: Some(0.06), ..valve };
        let found = found(&time_s, &jumps(&time_s), &valve);
        assert_eq!(found.named.iter().map(|(part, _)| *part).collect::<Vec<_>>(), [ValvePart::Delay]);
        assert!(found.valve.delay_s.is_some_and(|s| (s / 0.06 - 1.0).abs() < 0.1), "{:?}", found.valve);
    }
}

#[test]
fn a_held_band_is_found_so_closely_that_the_same_commands_are_accepted() {
    let time_s: Vec<f64> = (0..8000).map(|row| 0.01 * f64::from(row)).collect();
    let commands: Vec<f64> = time_s.iter().map(|&time_s| command(time_s)).collect();
    for band in (0..16).map(|i| 0.08 + 0.0213 * f64::from(i)) {
        let valve = Valve { band: Some((BandForm::Hold, band)), ..Valve::slow(0.05) };
        let found = found(&time_s, &commands, &valve);
        let Some((BandForm::Hold, near)) = found.valve.band else { panic!("{:?}", found.valve) };
        assert!((near / band - 1.0).abs() < 2e-3, "{near} instead of {band}");
        assert!(found.rmse_bar < 2e-3, "{band}: {} bar", found.rmse_bar);
    }
}

#[test]
fn a_held_band_is_named_and_measured_where_commands_between_rows_were_accepted() {
    // Triangles of about 1 bar/s, now and then a jump; seen every 16 ms, and some rows are lost.
    let fine_s: Vec<f64> = (0..90_000).map(|row| 0.001 * f64::from(row)).collect();
    let slow = |time_s: f64| 5.1 * (1.0 - (2.0 * (0.097 * time_s).fract() - 1.0).abs());
    let jump = |time_s: f64| if time_s % 20.0 > 17.0 { 0.6 } else { 0.0 };
    let commands: Vec<f64> = fine_s.iter().map(|&time_s| slow(time_s) + jump(time_s)).collect();
    let seen = |row: &usize| row.is_multiple_of(16) && row % 7 != 3;
    for (band, lag_s) in [(0.22, 0.05), (0.31, 0.15)] {
        let valve = Valve { band: Some((BandForm::Hold, band)), ..Valve::slow(lag_s) };
        let pressure = valve.simulate(commands[0], &fine_s, &commands);
        let of = |values: &[f64]| -> Vec<f64> { (0..90_000).filter(seen).map(|row| values[row]).collect() };
        let columns = Columns {
            time_s: of(&fine_s),
            command: Some(of(&commands)),
            input: of(&pressure),
            output: of(&pressure),
            ..Columns::default()
        };
        let scored = vec![true; columns.time_s.len()];
        let found = examine(&Columns { scored, ..columns }, 1e-4).expect("there is a command");
        assert!(found.named.iter().any(|(part, _)| *part == ValvePart::Band), "{found:?}");
        let Some((BandForm::HoldBetween, near)) = found.valve.band else { panic!("{found:?}") };
        assert!((near / band - 1.0).abs() < 0.02 && found.rmse_bar < 0.1 * band, "{found:?}");
    }
}

#[test]
fn a_valve_that_has_not_come_to_its_first_command_is_no_farther_off() {
    let time_s: Vec<f64> = (0..6000).map(|row| 0.01 * f64::from(row)).collect();
    let commands: Vec<f64> = time_s.iter().map(|&time_s| 1.0 + command(time_s)).collect();
    for valve in [Valve::slow(0.3), of_two(0.2, 0.1), of_orifice(0.2)] {
        let pressure = valve.simulate(0.0, &time_s, &commands);
        let columns = Columns {
            scored: vec![true; time_s.len()],
            output: pressure.clone(),
            command: Some(commands.clone()),
            input: pressure,
            time_s: time_s.clone(),
            ..Columns::default()
        };
        let found = examine(&columns, 1e-4).expect("there is a command");
        assert_eq!(
            found.named.iter().map(|(part, _)| *part).collect::<Vec<_>>(),
            [ValvePart::Lag],
            "{found:?}"
        );
        assert!(found.rmse_bar < 3e-3, "{found:?}");
    }
}

/// Air through an orifice, filled from 7 bar.
fn of_orifice(lag_s: f64) -> Valve {
    Valve { orifice: Some(Orifice { supply: 8.0, outside: 1.01325 }), ..Valve::slow(lag_s) }
}

#[test]
fn of_a_valve_whose_air_flows_through_an_orifice_nothing_else_is_named() {
    let time_s: Vec<f64> = (0..6000).map(|row| 0.01 * f64::from(row)).collect();
    for (lag_s, named) in [(0.05, vec![]), (0.2, vec![ValvePart::Lag])] {
        for commands in [jumps(&time_s), time_s.iter().map(|&time_s| command(time_s)).collect()] {
            let found = found(&time_s, &commands, &of_orifice(lag_s));
            assert_eq!(found.named.iter().map(|(part, _)| *part).collect::<Vec<_>>(), named, "{found:?}");
            assert!((found.valve.lag_s / lag_s - 1.0).abs() < 0.1, "{found:?}");
            assert!(found.rmse_bar < 3e-3, "{found:?}");
        }
    }
}

#[test]
fn a_dead_band_before_an_orifice_is_named_and_measured() {
    let time_s: Vec<f64> = (0..8000).map(|row| 0.01 * f64::from(row)).collect();
    let commands: Vec<f64> = time_s.iter().map(|&time_s| command(time_s)).collect();
    for form in [BandForm::Hold, BandForm::Backlash] {
        let found = found(&time_s, &commands, &Valve { band: Some((form, 0.15)), ..of_orifice(0.05) });
        assert_eq!(
            found.named.iter().map(|(part, _)| *part).collect::<Vec<_>>(),
            [ValvePart::Band],
            "{found:?}"
        );
        let band = found.valve.band.map_or(0.0, |(_, band)| band);
        assert!((band / 0.15 - 1.0).abs() < 0.05, "{found:?}");
    }
}
