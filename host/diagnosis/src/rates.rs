//! How a measured signal moves: value and derivatives of a cubic through the neighbourhood of every row.

use nalgebra::{SMatrix, SVector};

/// The rate that a width depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rate {
    /// Of the input.
    Input,
    /// Of the contraction: measured, or the simulated one where the model runs free.
    Contraction,
}

/// Half of the window of the local cubic: at least so many rows, and so long. Unit of the second: s.
pub const WINDOW: (usize, f64) = (2, 0.02);
/// A wider one, for the third derivative.
pub const JERK_WINDOW: (usize, f64) = (4, 0.04);
/// A wider one yet, for speeds that enter by a power: there noise would be taken for motion.
const WIDE_WINDOW: (usize, f64) = (4, 0.07);
/// A speed counts as far as it is above so many standard deviations of its noise.
const STANDING: f64 = 2.5;

/// Value, first, second and third derivative of a cubic through the neighbourhood of every row.
pub fn local_cubic(
    time_s: &[f64],
    values: &[f64],
    step_s: f64,
    (rows, window_s): (usize, f64),
) -> [Vec<f64>; 4] {
    let half = rows.max((window_s / step_s.max(1e-9)).round() as usize);
    let longest_s = 3.0 * half as f64 * step_s;
    let mut result = [const { Vec::new() }; 4];
    for row in 0..values.len() {
        let window = row.saturating_sub(half)..(row + half + 1).min(values.len());
        let (mut normal, mut right) = (SMatrix::<f64, 4, 4>::identity() * 1e-9, SVector::<f64, 4>::zeros());
        for i in window {
            // In units of the half window, so that the powers are alike.
            let t = (time_s[i] - time_s[row]) / (half as f64 * step_s);
            if t.abs() * half as f64 * step_s > longest_s {
                continue;
            }
            let powers = SVector::<f64, 4>::new(1.0, t, t * t, t * t * t);
            normal += powers * powers.transpose();
            right += powers * (values[i] - values[row]);
        }
        let fit = normal.cholesky().map_or(SVector::zeros(), |cholesky| cholesky.solve(&right));
        let unit_s = half as f64 * step_s;
        let derivatives = [1.0, 1.0, 2.0, 6.0].iter().zip(&fit).enumerate();
        let derivatives = derivatives.map(|(order, (times, fit))| times * fit / unit_s.powi(order as i32));
        result.iter_mut().zip(derivatives).for_each(|(all, derivative)| all.push(derivative));
        if let Some(value) = result[0].last_mut() {
            *value += values[row];
        }
    }
    result
}

/// The size of the rate of each row, as far as it is above its noise: of the wide window where the narrow one says the
/// same, of the narrow one where things happen fast.
pub fn speed(time_s: &[f64], values: &[f64], step_s: f64, noise: f64) -> Vec<f64> {
    // The noise of a rate from the answer to a single peak.
    let around: Vec<f64> = (0..64).map(|i| f64::from(i) * step_s).collect();
    let mut peak = vec![0.0; around.len()];
    peak[32] = noise;
    let rate = |window| {
        let [_, answer, ..] = local_cubic(&around, &peak, step_s, window);
        let noise = answer.iter().map(|a| a * a).sum::<f64>().sqrt();
        let [_, rate, ..] = local_cubic(time_s, values, step_s, window);
        (rate, STANDING * noise)
    };
    let ((wide, wide_noise), (narrow, narrow_noise)) = (rate(WIDE_WINDOW), rate(WINDOW));
    let size = |(wide, narrow): (&f64, &f64)| {
        if (wide - narrow).abs() > narrow_noise { narrow.abs() } else { (wide.abs() - wide_noise).max(0.0) }
    };
    wide.iter().zip(&narrow).map(size).collect()
}
