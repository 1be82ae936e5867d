//! The columns that effects put on the output: linear in their weights.

use std::f64::consts::TAU;

use super::effect::{Driver, Effect, Form};
use super::signals::{Signals, TENTS};

/// Columns of an effect for the scored rows, and whether their weights must not be negative.
pub fn columns(effect: &Effect, signals: &Signals) -> (Vec<Vec<f64>>, bool) {
    let of_rows = |value: &dyn Fn(usize) -> f64| signals.rows.iter().map(|row| value(row.at)).collect();
    let start_s = signals.time_s.first().copied().unwrap_or(0.0);
    let duration_s = signals.duration_s().max(1e-9);
    let time = |at: usize| signals.time_s[at] - start_s;
    let parameter = |i: usize| effect.parameters.get(i).map_or(0.0, |parameter| parameter.value);
    let less =
        |tent: usize, motion: &[f64]| -> Vec<f64> { of_rows(&|at| -signals.tents[at][tent] * motion[at]) };
    match effect.form {
        Form::Added(driver) => {
            let lambda = parameter(0).exp();
            let column = |tent: usize| -> Vec<f64> {
                of_rows(&|at| signals.tents[at][tent] * driven(signals, driver, lambda, at))
            };
            ((0..TENTS).map(column).collect(), false)
        }
        Form::LagBefore => ((0..TENTS).map(|tent| less(tent, &signals.jerk)).collect(), true),
        Form::OutputLag => ((0..TENTS).map(|tent| less(tent, &signals.rate)).collect(), true),
        Form::OutputInertia => {
            let both = [&signals.acceleration, &signals.rate];
            (both.iter().flat_map(|motion| (0..TENTS).map(|tent| less(tent, motion))).collect(), true)
        }
        Form::Creep => (signals.slow.clone(), true),
        Form::Drift => (vec![of_rows(&|at| time(at) / duration_s - 0.5)], false),
        Form::Tone => {
            let phase = |at: usize| TAU * parameter(0) * time(at);
            (vec![of_rows(&|at| phase(at).sin()), of_rows(&|at| phase(at).cos())], false)
        }
        Form::Step => (vec![of_rows(&|at| f64::from(u8::from(signals.time_s[at] >= parameter(0))))], false),
        _ => (Vec::new(), false),
    }
}

/// What drives an effect at a row. `lambda`: output unit.
pub fn driven(signals: &Signals, driver: Driver, lambda: f64, at: usize) -> f64 {
    let recorded = |column: &Option<Vec<f64>>| column.as_ref().map_or(0.0, |column| column[at]);
    match driver {
        Driver::Load => recorded(&signals.load),
        Driver::Temperature => recorded(&signals.temperature),
        Driver::WarmUp => (-signals.travel[at] / lambda).exp(),
        Driver::Rate => signals.rate[at],
    }
}

/// How many columns an effect puts on the output.
pub fn count(effect: &Effect, signals: &Signals) -> usize {
    match effect.form {
        Form::Added(_) | Form::OutputLag | Form::LagBefore => TENTS,
        Form::OutputInertia => 2 * TENTS,
        Form::Drift | Form::Step => 1,
        Form::Tone => 2,
        Form::Creep => signals.slow.len(),
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Columns;
    use crate::causes::Cause;

    #[test]
    fn an_effect_puts_as_many_columns_on_the_output_as_are_counted() {
        let time_s: Vec<f64> = (0..600).map(|row| f64::from(row) * 0.1).collect();
        let input: Vec<f64> = time_s.iter().map(|t| 3.0 + 2.0 * (0.4 * t).sin()).collect();
        let recorded = Columns {
            output: input.iter().map(|u| 20.0 * u).collect(),
            scored: vec![true; time_s.len()],
            load_n: Some(time_s.clone()),
            temperature_c: Some(time_s.clone()),
            time_s,
            input,
            ..Columns::default()
        };
        let signals = Signals::new(&recorded);
        let tone: Vec<f64> =
            signals.rows.iter().map(|row| (TAU * 0.5 * signals.time_s[row.at]).sin()).collect();
        let starts: Vec<Effect> =
            Cause::ALL.into_iter().flat_map(|cause| cause.starts_beside(&signals, &tone)).collect();
        assert!(starts.iter().any(|effect| effect.form == Form::Tone));
        assert!(starts.iter().any(|effect| effect.form == Form::Step));
        for effect in starts {
            assert_eq!(count(&effect, &signals), columns(&effect, &signals).0.len(), "{:?}", effect.form);
        }
    }
}
