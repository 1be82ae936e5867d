//! What an extended model gains on rows that took no part in its fit.
//!
//! Both models run free through the whole input, the recorded columns and nothing else, so that they come to the first of
//! these rows in the state that history has left them in.

use super::{Extended, Extension, Split};
use crate::Columns;
use recording::figures::Figures;
use recording::numbers::root_mean_square;

/// Blocks of rows that the uncertainty comes from.
const BLOCKS: usize = 10;
/// A free run has to be better by this share, over all rows or over those that were held out.
const GAIN: f64 = 0.05;

/// A gain on rows that the fit has not seen. Output unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldOutGain {
    /// Where the rows begin, if they are all that follow in the recording of the models; None for stretches all through it
    /// and for another recording. Unit: s.
    pub from_s: Option<f64>,
    /// Errors without extensions.
    pub before: Figures,
    /// With them.
    pub after: Figures,
    /// Noise of the measurement, below which no model comes.
    pub noise_floor: f64,
    /// Standard error of after - before, from the differences of blocks of rows in time.
    pub gain_error: f64,
}

impl HeldOutGain {
    /// The share of what could be gained; None where nothing could.
    pub fn share(&self) -> Option<f64> {
        let most = self.before.rmse - self.noise_floor;
        (most > 0.0).then(|| (self.before.rmse - self.after.rmse) / most)
    }

    /// Whether a simulated model is clearly better than another one, whose errors over all rows these are: over these and, by more than
    /// the standard error, over the rows that took no part in the fit; and by `GAIN` over one or the other.
    pub fn is_clear(&self, before: f64, after: f64) -> bool {
        let is_much = |before: f64, after: f64| after < (1.0 - GAIN) * before;
        after < before
            && self.is_sure()
            && (is_much(before, after) || is_much(self.before.rmse, self.after.rmse))
    }

    /// Whether it is more than its standard error.
    pub fn is_sure(&self) -> bool {
        self.is_beyond(1.0)
    }

    /// Whether it is more than so many standard errors.
    pub fn is_beyond(&self, standard_errors: f64) -> bool {
        self.before.rmse - self.after.rmse > standard_errors * self.gain_error
    }
}

/// The gain of the second model over the first on the rows of a recording that have taught neither; None where there are too
/// few rows, or a model refuses one.
pub fn gain(
    columns: &Columns,
    split: &Split,
    models: (&Extension, &Extension),
    noise_floor: f64,
) -> Option<HeldOutGain> {
    Some(HeldOutGain { from_s: split.from_s, ..on_rows(columns, &split.untaught, models, noise_floor)? })
}

/// The same on the given rows of a recording.
fn on_rows(
    columns: &Columns,
    scored: &[usize],
    (before, after): (&Extension, &Extension),
    noise_floor: f64,
) -> Option<HeldOutGain> {
    scored.get(..BLOCKS)?;
    let (before, after) = (before.errors(columns, scored)?, after.errors(columns, scored)?);
    let gain_error = standard_error(&before, &after);
    let figures = |errors: &[f64]| Figures::of(errors, &vec![0.0; errors.len()], &vec![true; errors.len()]);
    Some(HeldOutGain {
        from_s: None,
        before: figures(&before),
        after: figures(&after),
        noise_floor,
        gain_error,
    })
}

/// Standard error of the difference of two root mean square errors at the same samples, from blocks of them in time: each is a
/// tenth of the samples, far longer than residuals are alike.
pub fn standard_error(before: &[f64], after: &[f64]) -> f64 {
    let length = before.len().div_ceil(BLOCKS).max(1);
    let differences: Vec<f64> = before
        .chunks(length)
        .zip(after.chunks(length))
        .map(|(before, after)| root_mean_square(after) - root_mean_square(before))
        .collect();
    let count = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / count;
    let squares: f64 = differences.iter().map(|difference| (difference - mean).powi(2)).sum();
    (squares / (count * (count - 1.0).max(1.0))).sqrt()
}

/// The gain on another recording, which took no part in anything; None as for [`gain`].
pub fn on_another(columns: &Columns, extended: &Extended) -> Option<HeldOutGain> {
    on_all(&extended.seen_from(columns), (&extended.plain, &extended.model.of_muscle()))
}

/// The gain of the second model over the first on all scored rows of a recording; None as for [`gain`].
pub(super) fn on_all(columns: &Columns, models: (&Extension, &Extension)) -> Option<HeldOutGain> {
    let rows: Vec<usize> = (0..columns.scored.len()).filter(|&row| columns.scored[row]).collect();
    on_rows(columns, &rows, models, columns.noise_floor().deviation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_gains_where_it_is_clearly_better_on_rows_that_it_has_not_seen() {
        let of = |rmse| Figures { rmse, mae: rmse, max_error: rmse };
        let heldout = |after, gain_error| HeldOutGain {
            from_s: None,
            before: of(1.0),
            after: of(after),
            noise_floor: 0.01,
            gain_error,
        };
        assert!(heldout(0.9, 0.05).is_clear(1.0, 0.97));
        assert!(heldout(0.97, 0.02).is_clear(1.0, 0.9));
        assert!(!heldout(0.97, 0.02).is_clear(1.0, 0.97), "a little of both");
        assert!(!heldout(0.9, 0.2).is_clear(1.0, 0.8), "within the standard error");
        assert!(!heldout(0.8, 0.02).is_clear(1.0, 1.01), "worse over all rows");
    }
}
