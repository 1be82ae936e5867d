//! Whether the model that is written describes the recording.
//!
//! What the search calls hysteresis is more than an operator model can have: curves that fall, hills, loops that cross. So the model
//! itself is held against that, and against models that need no operator ([`trivial`](super::trivial)).

use super::Columns;
use super::extend::heldout::standard_error;
use super::extend::{Extended, Split};
use super::search::Search;
use super::trivial::Trivial;
use recording::figures::stroke;
use recording::numbers::root_mean_square;

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
    /// What is better.
    pub better: Better,
    /// The error of that.
    pub better_rmse: f64,
}

/// Whether the model that is written is too poor for its verdict; None where it is not.
pub fn poor(search: &Search<'_>, columns: &Columns, extended: &Extended) -> Option<Poor> {
    let of = |rmse: f64, better: Better, better_rmse: f64| {
        let percent_of_stroke = 100.0 * rmse / stroke(&columns.output, &columns.scored);
        Poor { rmse, percent_of_stroke, better, better_rmse }
    };
    let written = extended.written(columns, None)?;
    let errors = |simulated: &[f64], rows: &[usize]| -> Vec<f64> {
        rows.iter().map(|&row| columns.output[row] - simulated[row]).collect()
    };
    let scored = search.signals.scored();
    let (rmse, any) = (
        root_mean_square(&errors(&written.simulated, &scored)),
        root_mean_square(&search.baseline.fit.residual),
    );
    if rmse > MULTIPLE * any {
        return Some(of(rmse, Better::AnyHysteresis, any));
    }
    let Split { taught, untaught, .. } = Split::of(columns, &scored);
    let held = errors(&written.taught.answer(columns)?, &untaught);
    let rmse = root_mean_square(&held);
    let trivial = |trivial: Trivial| {
        let errors = trivial.errors(columns, &taught, &untaught);
        let better_rmse = root_mean_square(&errors);
        let is_better = rmse - better_rmse > standard_error(&errors, &held);
        is_better.then(|| of(rmse, Better::Trivial(trivial), better_rmse))
    };
    let better = Trivial::ALL.into_iter().filter_map(trivial);
    better.min_by(|one, other| one.better_rmse.total_cmp(&other.better_rmse))
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
