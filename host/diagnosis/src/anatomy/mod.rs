//! The anatomy of a residual: what it goes with, where it is worst, and what is noise in it.
//!
//! # Design
//! Pure functions from columns to plain structs, which go into the report and the JSON as they are.
//!
//! | file | what it tells |
//! |---|---|
//! | `motion` | direction, rate, rest, travel and cycles of the input and the output |
//! | `cells` | fewer rows for the same answer |
//! | [`axis`] | the residual over each axis, and the share of its energy that the axis explains beyond chance |
//! | `recurring` | chance on an axis that comes back to its values: circular shifts |
//! | `progressing` | chance on an axis that goes on and on: the neighbouring frequencies |
//! | [`spectrum`] | the residual by frequency, and its peaks above the local level |
//! //! | [`whiteness`] | whether the residual is white, and how long it remembers |
//! | [`stretches`] | where in the recording it is worst |
//! | [`excitation`] | what the recording excites |
//! | [`examinable`] | which causes it can show at all, and why not the others |
//!
//! Neighbouring residuals are alike, and any slow axis follows any slow residual for a while: every share and every p-value
//! is measured against that, and the false alarms of each test are counted by Monte Carlo in its tests, on white and on
//! autoregressive residuals.
//!
//! # Limits
//! A share says what a residual goes with, not why: axes that go with each other (time and travel, rate and input of a
//! sine) share what they explain. Of a residual of a fitted model, what the model could follow is gone.

#[cfg(test)]
mod alarms;
pub mod axis;
mod cells;
mod distribution;
pub mod examinable;
pub mod excitation;
mod motion;
mod progressing;
mod recurring;
pub mod spectrum;
pub mod stretches;
#[cfg(test)]
mod tests;
pub mod whiteness;

use serde::Serialize;
use thiserror::Error;

use self::axis::AxisMean;
use self::cells::Cells;
use self::motion::Motion;
use self::spectrum::Spectrum;
use self::stretches::Stretch;
use self::whiteness::Whiteness;
use recording::noise::{self, NoiseFloor};
use recording::numbers::root_mean_square;

/// The fewest rows that anything can be said of.
pub const LEAST_ROWS: usize = 100;

/// The scored rows of a recording, beside what a model leaves of them. All lists are equally long; the units of input and
/// output are those of their columns.
#[derive(Clone, Copy, Debug)]
pub struct Residual<'a> {
    /// Strictly increasing; unequal steps and gaps are allowed. Unit: s.
    pub time_s: &'a [f64],
    /// Measured less simulated. Output unit.
    pub residual: &'a [f64],
    /// What the model is driven by.
    pub input: &'a [f64],
    /// The measured output.
    pub output: &'a [f64],
    /// Unit: N, or that of the column.
    pub load: Option<&'a [f64]>,
    /// Unit: °C, or that of the column.
    pub temperature: Option<&'a [f64]>,
}

/// A recording that nothing can be said of.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("{rows} scored rows are too few for a diagnosis; at least {LEAST_ROWS} are needed")]
pub struct TooShort {
    /// Scored rows.
    pub rows: usize,
}

/// What there is to see in a residual. Values in the output's unit, unless said otherwise.
#[derive(Clone, Debug, Serialize)]
pub struct Anatomy {
    /// Root of the mean square residual.
    pub rms: f64,
    /// Mean residual.
    pub mean: f64,
    /// The noise of the measured output, as it is in holds and slow parts.
    pub noise: NoiseFloor,
    /// Whether the residual is white.
    pub whiteness: Whiteness,
    /// The residual over each axis, the one that explains most first.
    pub axes: Vec<AxisMean>,
    /// The residual by frequency.
    pub spectrum: Spectrum,
    /// Where it is worst, the worst first.
    pub stretches: Vec<Stretch>,
}

impl Anatomy {
    /// Takes a residual apart; chance is drawn from `seed`.
    ///
    /// # Errors
    /// There are fewer than [`LEAST_ROWS`] rows.
    pub fn of(residual: &Residual<'_>, seed: u64) -> Result<Self, TooShort> {
        let rows = residual.residual.len();
        if rows < LEAST_ROWS {
            return Err(TooShort { rows });
        }
        let motion = Motion::of(residual);
        let cells = Cells::of(residual.time_s, residual.residual);
        let mut axes = axis::axes(residual, &motion, &cells, seed);
        axes.sort_by(|one, other| other.share.total_cmp(&one.share));
        Ok(Self {
            rms: root_mean_square(residual.residual),
            mean: residual.residual.iter().sum::<f64>() / rows as f64,
            noise: noise::floor(residual.time_s, residual.output),
            whiteness: Whiteness::of(residual.residual, &cells),
            axes,
            spectrum: Spectrum::of(residual.time_s, residual.residual, residual.input),
            stretches: stretches::worst(residual, &motion),
        })
    }
}
