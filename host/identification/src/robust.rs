//! Huber's loss: residuals beyond a few robust standard deviations count with their size, not with
//! its square.
//!
//! Found by winsorised residuals (Huber 1981, section 7.8): the measurement is moved to where it is
//! no farther from the model than the limit, the model is fitted to that by least squares, and so
//! on until neither moves. The standard deviation is that of the median of the absolute residuals,
//! at each round.
//!
//! Standard errors are those of the winsorised residuals; with few outliers that is nearly what
//! Huber's are.

use std::borrow::Cow;

use super::CONVERGED;
use super::data::Data;
use super::descent::{End, Limits, is_clearly_better, search};
use super::problem::Point;
use super::starts::Start;
use crate::progress::Part;
use recording::numbers::{NORMAL_MEDIAN, median};

/// The limit in robust standard deviations: 95 % as efficient as least squares on normal residuals.
const LIMIT: f64 = 1.345;
/// Beyond so many robust standard deviations a row is listed as an outlier.
const OUTLIER: f64 = 5.0;
/// The most rounds.
const ROUNDS: usize = 30;
/// The change of the standard deviation from round to round, as a share of it, at which all has
/// settled.
const SETTLED: f64 = 1e-4;

/// A fit, and what it is one of.
pub struct Robust<'a> {
    /// The recording, with winsorised outputs if outliers count less.
    pub data: Cow<'a, Data>,
    /// Where the search on it ended.
    pub end: End,
    /// The rows of the recording that are outliers.
    pub outliers: Vec<usize>,
}

/// Robust fits from the best least-squares end of each kind of muscle, the one to be believed
/// first: outliers can hide which kind it is from least squares.
pub fn of_both_kinds<'a, const K: usize>(data: &Data, ends: &[End], part: &Part<'_>) -> Vec<Robust<'a>> {
    let best = |preconditioned| ends.iter().find(|(end, _)| end.preconditioned == preconditioned);
    let best = [best(true), best(false)].into_iter().flatten();
    let mut fits: Vec<Robust> = best.map(|(end, _)| fit::<K>(data, end, part)).collect();
    if let [preconditioned, fresh] = &fits[..]
        && is_clearly_better(&fresh.end, &preconditioned.end)
    {
        fits.reverse();
    }
    fits
}

/// Goes on from a least-squares fit.
fn fit<'a, const K: usize>(data: &Data, start: &Start, part: &Part<'_>) -> Robust<'a> {
    let converge = |data: &Data, start: &Start| search::<K>(data, start, Limits::to_the_end(CONVERGED), part);
    let mut end = converge(data, start);
    let mut winsorised = data.clone();
    let mut before = f64::INFINITY;
    let mut outliers = Vec::new();
    for _ in 0..ROUNDS {
        let model = model::<K>(&winsorised, &end.0);
        let counted: Vec<usize> = (0..data.rows.len()).filter(|&row| data.rows[row].weight > 0.0).collect();
        let residuals: Vec<f64> =
            counted.iter().zip(&model).map(|(&row, model)| data.rows[row].output - model).collect();
        let deviation = deviation(&residuals);
        outliers = beyond(&residuals, deviation).map(|place| counted[place]).collect();
        if deviation == 0.0 || (deviation - before).abs() <= SETTLED * deviation {
            break;
        }
        before = deviation;
        let limit = LIMIT * deviation;
        let mut places = model.iter().zip(&residuals);
        for row in winsorised.rows.iter_mut().filter(|row| row.weight > 0.0) {
            if let Some((model, r)) = places.next() {
                row.output = model + r.clamp(-limit, limit);
            }
        }
        end = converge(&winsorised, &end.0);
    }
    Robust { data: Cow::Owned(winsorised), end, outliers }
}

/// Robust standard deviation of residuals.
pub fn deviation(residuals: &[f64]) -> f64 {
    median(&mut residuals.iter().map(|residual| residual.abs()).collect::<Vec<f64>>()) / NORMAL_MEDIAN
}

/// The places of the residuals that are outliers beside a standard deviation.
pub fn beyond(residuals: &[f64], deviation: f64) -> impl Iterator<Item = usize> {
    (0..residuals.len()).filter(move |&place| residuals[place].abs() > OUTLIER * deviation)
}

/// The model's outputs at the rows that count.
fn model<const K: usize>(data: &Data, at: &Start) -> Vec<f64> {
    let residuals = Point::<K>::new(data, at.clone(), None).residuals(data);
    let counted = data.rows.iter().filter(|row| row.weight > 0.0);
    counted.zip(residuals).map(|(row, residual)| row.output + residual).collect()
}
