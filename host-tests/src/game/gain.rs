//! What an extension gains on rows that its fit has not seen, held against what it would gain by what was hidden.
//!
//! A plant's parameters are put into the extensions that were found, as far as these have them ([`super::hidden`]), the operator
//! is fitted again beside them, and both gains are counted alike. What is not among the hidden parameters, such as how a mass is
//! shared out over the contraction, is as the rows before the split have taught it. An extension may come out above 1: a plant is
//! not of the form of its model, and parameters that are fitted make up for a part of that.

use anyhow::{Context, Result, ensure};
use diagnosis::extend::HeldOutGain;
use diagnosis::{Columns, diagnose_and_extend};
use recording::unit::Unit;
use rig::recording::Row;

use super::case::Case;
use super::hidden::with_hidden;

/// The gains in one game.
#[derive(Debug, Clone)]
pub struct Gained {
    /// The game, of one cause.
    pub case: Case,
    /// By the extension that was found.
    pub found: HeldOutGain,
    /// By the same with the hidden parameters.
    pub hidden: HeldOutGain,
}

impl Gained {
    /// The gain of the found extension over that of the hidden parameters.
    pub fn ratio(&self) -> f64 {
        let gain = |gain: &HeldOutGain| gain.before.rmse - gain.after.rmse;
        gain(&self.found) / gain(&self.hidden)
    }
}

impl Case {
    /// Diagnoses this game, which hides one cause, and counts both gains.
    ///
    /// # Errors
    /// There is no diagnosis, or the cause is not named.
    pub fn gained(&self) -> Result<Gained> {
        let columns = columns(&self.recording());
        let truth = self.plant().truth();
        let (cause, parameters) = truth.causes.first_key_value().context("nothing is hidden")?;
        let (diagnosis, extended) = diagnose_and_extend(&columns, None, &|_, _| ())?;
        let is_named = diagnosis.causes.iter().any(|named| named.cause.name() == *cause);
        ensure!(is_named, "{cause} is not named");
        let hidden = extended
            .gain_with(&columns, |taught| with_hidden(taught, self.kind, cause, parameters))
            .with_context(|| {
                format!("the extended model has no {cause}, or does not run with the hidden one")
            })?;
        Ok(Gained { case: self.clone(), found: extended.heldout, hidden })
    }
}

/// What `mgpi diagnose` makes of the same rows in a file.
fn columns(rows: &[Row]) -> Columns {
    let column = |of: fn(&Row) -> f64| -> Vec<f64> { rows.iter().map(of).collect() };
    Columns {
        time_s: column(|row| row.time_s),
        input: column(|row| row.measured.pressure_bar),
        input_unit: Unit::BAR,
        output_unit: Unit::MM,
        input_is_command: false,
        command: Some(column(|row| row.command_bar)),
        load_n: Some(column(|row| row.measured.load_n)),
        temperature_c: Some(column(|row| row.measured.temperature_c)),
        output: column(|row| row.measured.contraction_mm),
        scored: vec![true; rows.len()],
        past_unknown_until_s: None,
        smoothing: None,
        measured_input: None,
        drop_outs: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use rig::effect::Effect;
    use rig::plant::Kind;
    use serde_json::json;

    use super::*;

    #[test]
    fn a_found_delay_gains_what_the_hidden_one_does_and_one_of_twice_the_time_far_less() {
        let case = Case { kind: Kind::Mgpi, effects: vec![Effect::TransportDelay], strength: 1.0, seed: 3 };
        let columns = columns(&case.recording());
        let (_, extended) = diagnose_and_extend(&columns, None, &|_, _| ()).expect("a diagnosis");
        let truth = case.plant().truth();
        let hidden_s = truth.causes["transport_delay"]["delay_s"].as_f64().expect("a time");
        let gain = |delay_s: f64| {
            let parameters = json!({ "delay_s": delay_s });
            let parameters = parameters.as_object().expect("a table");
            let hidden = |taught: &_| with_hidden(taught, case.kind, "transport_delay", parameters);
            let gain = extended.gain_with(&columns, hidden).expect("a gain");
            gain.before.rmse - gain.after.rmse
        };
        let found = extended.heldout.before.rmse - extended.heldout.after.rmse;
        let (right, wrong) = (found / gain(hidden_s), gain(2.0 * hidden_s) / found);
        assert!((right - 1.0).abs() < 0.1, "{right}");
        assert!(wrong < 0.7, "{wrong}");
        assert!(with_hidden(&extended.model, case.kind, "creep", &serde_json::Map::new()).is_none());
    }

    #[test]
    fn a_width_by_the_rate_of_the_pressure_is_found_as_it_is_and_leaves_a_fifth_at_most() {
        let case =
            Case { kind: Kind::Mgpi, effects: vec![Effect::RateDependentWidth], strength: 1.0, seed: 3 };
        let (_, extended) =
            diagnose_and_extend(&columns(&case.recording()), None, &|_, _| ()).expect("a diagnosis");
        let thresholds = extended.model.extensions.rate_dependent_thresholds.as_ref().expect("a width");
        let truth = &case.plant().truth().causes["rate_dependent_width"];
        let found = thresholds.pressure.expect("by the rate of the pressure").gain;
        for (name, found) in [("width_gain", found), ("rate_exponent", thresholds.exponent)] {
            let hidden = truth[name].as_f64().expect("a number");
            assert!((found / hidden - 1.0).abs() < 0.15, "{name}: {found} for {hidden}");
        }
        let share = extended.heldout.share().expect("something to gain");
        assert!(share > 0.8, "{share}");
    }
}
