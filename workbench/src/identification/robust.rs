//! Huber's loss: residuals beyond a few robust standard deviations count with their size, not with its square.
//!
//! Found by winsorised residuals (Huber 1981, section 7.8): the measurement is moved to where it is no farther from the
//! model than the limit, the model is fitted to that by least squares, and so on until neither moves. The standard
//! deviation is that of the median of the absolute residuals, at each round.
//!
//! Standard errors are those of the winsorised residuals; with few outliers that is nearly what Huber's are.

use super::data::Data;
use super::problem::Point;
use super::starts::Start;
use super::{CONVERGENCE, End, is_clearly_better, search};
use crate::numbers::median;

/// The limit in robust standard deviations: 95 % as efficient as least squares on normal residuals.
const LIMIT: f64 = 1.345;
/// Beyond so many robust standard deviations a row is listed as an outlier.
const OUTLIER: f64 = 5.0;
/// Median of the absolute values of a normal variable of standard deviation 1.
const MEDIAN: f64 = 0.6745;
/// The most rounds.
const ROUNDS: usize = 30;
/// The change of the standard deviation from round to round, as a share of it, at which all has settled.
const SETTLED: f64 = 1e-4;

/// A robust fit.
pub struct Robust {
    /// The recording with winsorised outputs.
    pub data: Data,
    /// Where the search on it ended.
    pub end: End,
    /// The rows of the recording that are outliers.
    pub outliers: Vec<usize>,
}

/// Robust fits from the best least-squares end of each kind of muscle, the one to be believed first: outliers can hide
/// which kind it is from least squares.
pub fn of_both_kinds<const K: usize>(data: &Data, ends: Vec<End>) -> Vec<Robust> {
    let (preconditioned, fresh): (Vec<End>, Vec<End>) =
        ends.into_iter().partition(|(start, _)| start.preconditioned);
    let best = [preconditioned, fresh].into_iter().filter_map(|ends| ends.into_iter().next());
    let mut fits: Vec<Robust> = best.map(|end| fit::<K>(data, end)).collect();
    if let [preconditioned, fresh] = &fits[..]
        && is_clearly_better(&fresh.end, &preconditioned.end)
    {
        fits.reverse();
    }
    fits
}

/// Goes on from a least-squares fit.
fn fit<const K: usize>(data: &Data, mut end: End) -> Robust {
    let mut winsorised = data.clone();
    let mut before = f64::INFINITY;
    let mut outliers = Vec::new();
    for _ in 0..ROUNDS {
        let model = model::<K>(&winsorised, &end.0);
        let residuals: Vec<f64> = data.outputs.iter().zip(&model).map(|(y, model)| y - model).collect();
        let deviation =
            median(&mut residuals.iter().map(|residual| residual.abs()).collect::<Vec<f64>>()) / MEDIAN;
        let is_outlier =
            |(&row, residual): (&usize, &f64)| (residual.abs() > OUTLIER * deviation).then_some(row);
        outliers = data.rows.iter().zip(&residuals).filter_map(is_outlier).collect();
        if deviation == 0.0 || (deviation - before).abs() <= SETTLED * deviation {
            break;
        }
        before = deviation;
        let limit = LIMIT * deviation;
        winsorised.outputs =
            model.iter().zip(&residuals).map(|(model, r)| model + r.clamp(-limit, limit)).collect();
        end = search::<K>(&winsorised, &end.0, CONVERGENCE);
    }
    Robust { data: winsorised, end, outliers }
}

/// The model's outputs at the rows that count.
fn model<const K: usize>(data: &Data, at: &Start) -> Vec<f64> {
    let point = Point::<K>::new(data, at.clone());
    point.residuals.iter().zip(&data.outputs).map(|(residual, output)| output + residual).collect()
}
