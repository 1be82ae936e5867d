//! How far a model, or a tracked muscle, is from what was measured, or wanted.

use serde_json::{Map, Value};

use crate::numbers::legible;
use crate::unit::Unit;

/// Root mean square, mean absolute and maximum error. Unit: that of the compared values.
///
/// ```
/// use recording::figures::Figures;
///
/// let figures = Figures::of(&[1.0, 5.0, 100.0], &[4.0, 1.0, 0.0], &[true, true, false]);
/// assert_eq!((figures.mae, figures.max_error), (3.5, 4.0)); // the last sample is not scored
/// assert!(figures.mae <= figures.rmse && figures.rmse <= figures.max_error);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Root of the mean square error.
    pub rmse: f64,
    /// Mean absolute error.
    pub mae: f64,
    /// Largest absolute error.
    pub max_error: f64,
}

impl Figures {
    /// The figures of the differences `a - b` over the rows with `scored`; all lists are equally
    /// long.
    ///
    /// NaN where no row is scored.
    pub fn of(a: &[f64], b: &[f64], scored: &[bool]) -> Self {
        let errors =
            || a.iter().zip(b).zip(scored).filter(|(_, scored)| **scored).map(|((a, b), _)| (a - b).abs());
        let count = errors().count() as f64;
        Self {
            rmse: (errors().map(|error| error * error).sum::<f64>() / count).sqrt(),
            mae: errors().sum::<f64>() / count,
            max_error: errors().fold(if count > 0.0 { 0.0 } else { f64::NAN }, f64::max),
        }
    }

    /// The three under their names with the unit: `rmse_mm`, `mae_mm`, `max_error_mm`.
    pub fn keyed(&self, unit: Unit) -> [(String, f64); 3] {
        [("rmse", self.rmse), ("mae", self.mae), ("max_error", self.max_error)]
            .map(|(name, value)| (format!("{name}_{}", unit.suffix()), value))
    }

    /// The three under their names with the unit, for programs.
    pub fn to_json(&self, unit: Unit) -> Value {
        self.keyed(unit).into_iter().map(|(key, value)| (key, value.into())).collect::<Map<_, _>>().into()
    }

    /// The three for people, in percent of the stroke: that of [`stroke`], or of
    /// [`crate::model_file::ModelFile::stroke`].
    pub fn in_words(&self, stroke: f64, unit: Unit) -> String {
        self.in_words_beside((stroke, "stroke"), unit)
    }

    /// The three for people, in percent of a length with a name.
    pub fn in_words_beside(&self, (length, name): (f64, &str), unit: Unit) -> String {
        let share =
            |value: f64| format!("{} {unit} ({:.2} % of {name})", legible(value, 4), 100.0 * value / length);
        format!(
            "RMSE {}, mean absolute error {}, largest error {}",
            share(self.rmse),
            share(self.mae),
            share(self.max_error)
        )
    }
}

/// The stroke of a recording, which percentages refer to: highest less lowest scored value, in the
/// values' unit. Drop-outs are not scored.
pub fn stroke(values: &[f64], scored: &[bool]) -> f64 {
    let scored = values.iter().zip(scored).filter(|(_, scored)| **scored);
    let (min, max) = scored
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), (&value, _)| (min.min(value), max.max(value)));
    max - min
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_those_of_the_scored_rows() {
        let figures = Figures::of(&[1.0, 5.0, 100.0], &[4.0, 1.0, 0.0], &[true, true, false]);
        assert_eq!(figures, Figures { rmse: 12.5_f64.sqrt(), mae: 3.5, max_error: 4.0 });
    }

    #[test]
    fn without_a_scored_row_there_is_no_figure() {
        let figures = Figures::of(&[1.0], &[1.0], &[false]);
        assert!([figures.rmse, figures.mae, figures.max_error].into_iter().all(f64::is_nan));
    }
}
