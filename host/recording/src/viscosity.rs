//! How much of a model's viscosity may be a dead time in truth.
//!
//! A viscous muscle and one behind a line follow a steady move equally late, and differ where they
//! turn round or begin to move ([`crate::transients`]). A diagnosis that takes one for the other is
//! right in the mean lateness, and a loop that is tuned for a lag swings with a dead time. So the
//! recording is simulated with shares of the viscosity, each with the lateness that fits it best.
//! What is not excluded is told: the least share whose squared error is not larger than the least
//! one by more than two standard errors of the difference, over blocks of time.
//!
//! # Limits
//! A viscosity that damps a mass is taken as it is: it is seen by what the mass overshoots, which
//! no dead time makes.

use model_core::ParameterError;

use crate::model::HostExtendedModel;
use crate::model_file::ModelFile;
use crate::model_file::control::Split;
use crate::numbers::is_within_chance;
use crate::simulation::Rows;
use crate::transients::{Errors, Transients, total};

/// The shares that are tried beside the whole, the least first.
const SHARES: [f64; 4] = [0.0, 0.25, 0.5, 0.75];
/// How far latenesses that are tried are apart, as a share of that of the whole viscosity, from
/// parabola to parabola.
const APART: [f64; 3] = [0.5, 0.2, 0.05];

/// The least share of a model's viscosity that a recording does not exclude, where it is
/// less than the whole. `simulated` is what the model answers.
///
/// # Errors
/// The parameters make no valid model.
pub(crate) fn split(
    file: &ModelFile,
    rows: &Rows<'_>,
    simulated: &[f64],
    seen: &Transients<'_>,
) -> Result<Option<Split>, ParameterError> {
    let acting = file.acting();
    if acting.viscous_lag.is_none() || acting.inertia.is_some() {
        return Ok(None);
    }
    let answer = |share: f64| -> Result<Option<Vec<f64>>, ParameterError> {
        let mut extensions = acting.clone();
        match &mut extensions.viscous_lag {
            Some(viscous) if share > 0.0 => viscous.values.iter_mut().for_each(|value| *value *= share),
            viscous => *viscous = None,
        }
        Ok(rows.answer(&HostExtendedModel::try_new(&file.parameters, &extensions)?).ok())
    };
    let mut fitted = Vec::with_capacity(SHARES.len() + 1);
    let mut whole_s = 0.0;
    for share in SHARES {
        let Some(less) = answer(share)? else { return Ok(None) };
        let late_s = behind_s(seen, &less, simulated);
        whole_s = f64::max(whole_s, late_s);
        if whole_s <= 0.0 {
            return Ok(None);
        }
        fitted.push((Split { share, late_s }, best(seen, &less, late_s, whole_s)));
    }
    fitted.push((Split { share: 1.0, late_s: 0.0 }, best(seen, simulated, 0.0, whole_s)));
    let Some(least) =
        fitted.iter().map(|(_, errors)| *errors).min_by(|a, b| total(a, None).total_cmp(&total(b, None)))
    else {
        return Ok(None);
    };
    let is_open = |errors: &Errors| {
        let differences: Vec<f64> = errors.iter().zip(&least).map(|(other, least)| other - least).collect();
        is_within_chance(&differences)
    };
    let open = fitted.into_iter().find(|(_, errors)| is_open(errors));
    Ok(open.map(|(split, _)| split).filter(|split| split.share < 1.0 && split.late_s > 0.0))
}

/// How far one signal is behind another one in the mean over its moves. Unit: s.
fn behind_s(seen: &Transients<'_>, ahead: &[f64], behind: &[f64]) -> f64 {
    let (mut products, mut squares) = (0.0, 0.0);
    for row in 1..behind.len().saturating_sub(1) {
        if !seen.scored[row - 1..=row + 1].contains(&false) {
            let rate = (behind[row + 1] - behind[row - 1]) / (seen.time_s[row + 1] - seen.time_s[row - 1]);
            products += rate * (ahead[row] - behind[row]);
            squares += rate * rate;
        }
    }
    if squares > 0.0 { products / squares } else { 0.0 }
}

/// The squared errors with the lateness near `late_s` that makes them least.
fn best(seen: &Transients<'_>, simulated: &[f64], late_s: f64, whole_s: f64) -> Errors {
    let (mut at_s, mut there) = (late_s, seen.errors(simulated, late_s));
    for apart_s in APART.map(|apart| apart * whole_s) {
        let [below, above] =
            [-apart_s, apart_s].map(|by_s| total(&seen.errors(simulated, at_s + by_s), None));
        let bent = below + above - 2.0 * total(&there, None);
        let by = if bent > 0.0 { 0.5 * (below - above) / bent } else { (below - above).signum() };
        let next_s = at_s + by.clamp(-1.0, 1.0) * apart_s;
        let errors = seen.errors(simulated, next_s);
        if total(&errors, None) < total(&there, None) {
            (at_s, there) = (next_s, errors);
        }
    }
    there
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::lateness::{Recording, recorded};
    use crate::synthetic::{Noise, times, triangles};

    const PAPER: &str = include_str!("../../../examples/paper-tables-1-2.toml");
    const VISCOUS: &str = "[extensions.viscous_lag]\nknots_mm = [50.0]\nviscosity_bar_s_per_mm = [0.003]\n";

    fn file(extension: &str) -> ModelFile {
        ModelFile::parse(Path::new("model.toml"), &format!("{PAPER}\n{extension}")).expect("valid")
    }

    /// What a recording of triangles of two speeds shows of a viscosity, of which the muscle has
    /// `share` in truth and, in the place of the rest, a line's dead time; with noise.
    fn shown(share: f64) -> Option<Split> {
        let model = file(VISCOUS);
        let step_s = 0.01;
        let time_s = times(8000, step_s);
        let input: Vec<f64> =
            time_s.iter().map(|&at_s| triangles(at_s, if at_s < 40.0 { 8.0 } else { 4.0 })).collect();
        let rows = Rows { time_s: &time_s, input: &input, load: None, temperature: None };
        let answer = |file: &ModelFile| rows.answer(&file.extended().expect("valid")).expect("finite");
        let simulated = answer(&model);
        let scored = vec![true; time_s.len()];
        let seen = |output| Transients { time_s: &time_s, scored: &scored, output };
        let part =
            if share > 0.0 { VISCOUS.replace("0.003", &(0.003 * share).to_string()) } else { String::new() };
        let quick = answer(&file(&part));
        let late_s = behind_s(&seen(&simulated), &quick, &simulated);
        let mut noise = Noise::new(3);
        let output: Vec<f64> = (0..time_s.len())
            .map(|row| {
                let (whole, part) = ((late_s / step_s).floor(), (late_s / step_s).fract());
                let at = |back: usize| quick[row.saturating_sub(back)];
                at(whole as usize) * (1.0 - part) + at(whole as usize + 1) * part + noise.white(0.03)
            })
            .collect();
        let recording = Recording { rows, scored: &scored, output: &output, command: None };
        recorded(&model, &recording).expect("finite").split
    }

    #[test]
    fn a_dead_time_that_a_model_has_put_into_a_viscosity_is_not_excluded_and_a_viscosity_is_kept() {
        let none = shown(0.0).expect("open");
        assert!(none.share == 0.0 && none.late_s > 0.03, "{none:?}");
        let half = shown(0.5).expect("open");
        assert!(half.share > 0.0 && half.share <= 0.5 && half.late_s > 0.015, "{half:?}");
        assert_eq!(shown(1.0).filter(|split| split.share < 0.75), None);
    }

    #[test]
    fn without_a_viscosity_nothing_is_a_dead_time_in_its_place() {
        let (time_s, scored) = (times(100, 0.01), [true; 100]);
        let rows = Rows { time_s: &time_s, input: &time_s, load: None, temperature: None };
        let seen = Transients { time_s: &time_s, scored: &scored, output: &time_s };
        assert_eq!(split(&file(""), &rows, &time_s, &seen).expect("valid"), None);
    }

    #[test]
    fn a_model_file_keeps_what_may_be_a_dead_time() {
        let shown = "[recorded]\nstep_s = 0.005\nnoise_mm = 0.01\nsteeper = 1.2\nlate_s = 0.0\nlate_error_s = 0.001\n";
        let split = |keys: &str| {
            let read = file(&format!("{shown}{keys}"));
            let again = ModelFile::parse(Path::new("model.toml"), &read.to_toml()).expect("valid");
            again.recorded.expect("there").split
        };
        let kept = split("viscosity_least = 0.25\nviscosity_late_s = 0.03\n");
        assert_eq!(kept, Some(Split { share: 0.25, late_s: 0.03 }));
        assert_eq!(split(""), None, "files of earlier versions do not say it");
    }
}
