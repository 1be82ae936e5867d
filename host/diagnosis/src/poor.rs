//! Whether the model that is written describes the recording.
//!
//! What the search calls hysteresis is more than an operator model can have: curves that fall, hills, loops that cross. So the model
//! itself is held against that, against models that need no operator ([`trivial`](super::trivial)), and against the error up to which
//! a model may drive a valve ([`DEPLOYABLE`]): what is off by more is neither adequate nor explained. A good model that is off by its form
//! alone is explained by that.

use super::Columns;
use super::extend::heldout::standard_error;
use super::extend::{Extended, Split};
use super::search::Search;
use super::trivial::Trivial;
use recording::figures::stroke;
use recording::numbers::root_mean_square;
use recording::worth::{DEPLOYABLE, GOOD, Limit};

/// The model that is written may have so many times the error of a hysteresis of any form: with more, three quarters of the squared
/// error are due to its form. Models of sound muscles come to 0.6 to 1.6.
const MULTIPLE: f64 = 2.0;

/// What is better than the model that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Better {
    /// A hysteresis of any form, over all samples.
    AnyHysteresis,
    /// A model that needs no operator, on samples that took no part in the fit.
    Trivial(Trivial),
}

/// That the model that is written does not describe the recording. Errors are root mean squares in output unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Poor {
    /// Its error.
    pub rmse: f64,
    /// That over the stroke of the recording. Unit: percent.
    pub percent_of_stroke: f64,
    /// What is better, and the error of that; None where nothing is, but the model is further off than one that drives a valve may be.
    pub better: Option<(Better, f64)>,
    /// What of the output's course over the input no operator model can follow; None where nothing of the kind is seen.
    pub limit: Option<Limit>,
}

/// Whether the model that is written, or the one with the named causes, is too poor for its verdict; None where neither is.
pub fn poor(search: &Search<'_>, columns: &Columns, extended: &Extended) -> Option<Poor> {
    let stroke = stroke(&columns.output, &columns.scored);
    let Columns { input, output, scored: is_scored, .. } = columns;
    let of = |rmse: f64, better| {
        let limit = Limit::of_shape(input, output, is_scored, rmse);
        Poor { rmse, percent_of_stroke: 100.0 * rmse / stroke, better, limit }
    };
    let written = extended.written(columns, None)?;
    let errors = |simulated: &[f64], rows: &[usize]| -> Vec<f64> {
        rows.iter().map(|&row| columns.output[row] - simulated[row]).collect()
    };
    let scored = search.signals.scored();
    let (all, any) = (
        root_mean_square(&errors(&written.simulated, &scored)),
        root_mean_square(&search.baseline.fit.residual),
    );
    if all > MULTIPLE * any {
        return Some(of(all, Some((Better::AnyHysteresis, any))));
    }
    let Split { taught, untaught, .. } = Split::of(columns, &scored);
    let held = errors(&written.taught.answer(columns)?, &untaught);
    let rmse = root_mean_square(&held);
    let trivial = |trivial: Trivial| {
        let errors = trivial.errors(columns, &taught, &untaught);
        let better_rmse = root_mean_square(&errors);
        let is_better = rmse - better_rmse > standard_error(&errors, &held);
        is_better.then_some((Better::Trivial(trivial), better_rmse))
    };
    let better = Trivial::ALL.into_iter().filter_map(trivial);
    if let Some(better) = better.min_by(|(_, one), (_, other)| one.total_cmp(other)) {
        return Some(of(rmse, Some(better)));
    }
    // With a valve, what carries the named causes is not what is written where that predicts no better.
    let farthest = all.max(extended.extended_rmse);
    // What the sensor's noise is of it, no model could do better.
    let noise = columns.noise_floor().deviation;
    (farthest.powi(2) - noise.powi(2) > (DEPLOYABLE * stroke).powi(2)).then(|| of(farthest, None))
}

impl Poor {
    /// Whether it is the form alone of a model that is good otherwise: nothing of the output's course keeps an operator from following
    /// it, and a hysteresis of any form is far nearer. What is left then depends on nothing else.
    pub fn is_form(&self) -> bool {
        matches!(self.better, Some((Better::AnyHysteresis, _)))
            && self.limit.is_none()
            && self.percent_of_stroke <= 100.0 * GOOD
    }
}

impl Better {
    /// The word in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::AnyHysteresis => "any_hysteresis",
            Self::Trivial(trivial) => trivial.name(),
        }
    }

    /// What it is, for people.
    pub fn words(self) -> &'static str {
        match self {
            Self::AnyHysteresis => "a hysteresis of any form",
            Self::Trivial(trivial) => trivial.words(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_form_is_what_a_good_model_gets_wrong_only_where_an_operator_could_follow() {
        let better = Some((Better::AnyHysteresis, 0.1));
        let form = Poor { rmse: 0.3, percent_of_stroke: 0.4, better, limit: None };
        assert!(form.is_form());
        for other in [
            Poor { percent_of_stroke: 1.1, ..form },
            Poor { limit: Some(Limit::Falls), ..form },
            Poor { better: Some((Better::Trivial(Trivial::StaticCurve), 0.1)), ..form },
            Poor { better: None, ..form },
        ] {
            assert!(!other.is_form(), "{other:?}");
        }
    }
}
