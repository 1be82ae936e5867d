//! Whether a residual is white, and how long it remembers.
//!
//! # Design
//! The test of Ljung and Box on the first lags, each product weighted by its own variance so that noise that is louder
//! in some places is no alarm: Q = Σ (Σ eᵢ eᵢ₋ₖ)² / Σ eᵢ² eᵢ₋ₖ², chi-squared (Lobato, Nankervis and Savin 2001).
//!
//! # Limits
//! Rows are taken as equally spaced; across a gap, neighbours are compared that are none.

use serde::Serialize;

use super::cells::Cells;
use super::distribution::chi_squared_tail;
use identification::autocorrelation::{inflation, memory};

/// The lags that are looked at. Unit: rows.
const LAGS: usize = 20;

/// How alike neighbouring residuals are.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Whiteness {
    /// The test's statistic, about [`Whiteness::lags`] for white residuals.
    pub statistic: f64,
    /// Lags that were looked at. Unit: rows.
    pub lags: usize,
    /// How often white residuals look less white than these.
    pub p_value: f64,
    /// Over how long residuals are alike. Unit: s.
    pub memory_s: f64,
    /// How many white residuals tell as much of a mean as these.
    pub effective_rows: f64,
}

impl Whiteness {
    /// Tests a residual that is also known by its cells.
    pub fn of(residual: &[f64], cells: &Cells) -> Self {
        let mean = residual.iter().sum::<f64>() / residual.len() as f64;
        let centred: Vec<f64> = residual.iter().map(|e| e - mean).collect();
        let statistic: f64 = (1..=LAGS).map(|lag| standardised_square(&centred, lag)).sum();
        Self {
            statistic,
            lags: LAGS,
            p_value: chi_squared_tail(statistic, LAGS as f64),
            memory_s: memory(&cells.value) as f64 * cells.width_s,
            effective_rows: cells.value.len() as f64 / inflation(&cells.value),
        }
    }
}

/// The square of the sum of products at a lag over its variance; 0 where all are 0.
fn standardised_square(centred: &[f64], lag: usize) -> f64 {
    let (sum, squares) = centred.iter().zip(&centred[lag.min(centred.len())..]).fold(
        (0.0, f64::MIN_POSITIVE),
        |(sum, squares), (a, b)| {
            let product: f64 = a * b;
            (sum + product, squares + product * product)
        },
    );
    sum * sum / squares
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anatomy::alarms::alarms;
    use crate::synthetic::{Noise, times};

    fn whiteness(residual: &[f64]) -> Whiteness {
        Whiteness::of(residual, &Cells::of(&times(residual.len(), 0.01), residual))
    }

    #[test]
    fn white_residuals_raise_an_alarm_in_3_to_7_of_100_runs_also_where_their_loudness_changes() {
        for loudness in [|_: usize| 1.0, |row: usize| 1.0 + 4.0 * (row as f64 / 300.0).sin().abs()] {
            let share = alarms(1000, |seed| {
                let mut noise = Noise::new(seed);
                let residual: Vec<f64> = (0..2000).map(|row| noise.white(loudness(row))).collect();
                whiteness(&residual).p_value < 0.05
            });
            assert!((0.03..=0.07).contains(&share), "{share}");
        }
    }

    #[test]
    fn a_slight_likeness_is_found_and_its_memory_told() {
        let share = alarms(100, |seed| whiteness(&Noise::new(seed).autoregressive(4000, 0.2)).p_value < 0.05);
        assert!(share > 0.95, "{share}");
        let long = whiteness(&Noise::new(1).autoregressive(4000, 0.98));
        // The variance of a mean of these is 99 times that of white ones.
        assert!((20.0..90.0).contains(&long.effective_rows), "{}", long.effective_rows);
        assert!((0.5..10.0).contains(&long.memory_s), "{}", long.memory_s);
    }
}
