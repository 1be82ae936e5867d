//! The inner output u over a recording, and its sensitivities to the coordinates.
//!
//! A play's output is the coordinate v of the moment that last drove it, minus or plus its threshold; so its
//! derivatives are those of v at that moment, minus or plus that of the threshold. They are carried along
//! with the play, exactly, with no finite differences.

use super::coordinates::{COUNT, Inner};

/// u for every normalised input, from rest.
pub fn simulate(inner: &Inner, inputs: &[f64], u: &mut Vec<f64>) {
    let mut plays = vec![0.0_f64; inner.thresholds.len()];
    u.clear();
    u.extend(inputs.iter().map(|&t| {
        let v = inner.envelope(t);
        let mut sum = inner.s * v;
        for ((z, r), p) in plays.iter_mut().zip(&inner.thresholds).zip(&inner.weights) {
            // Not f64::clamp: it panics where rounding turns the two limits around.
            *z = z.max(v - r).min(v + r);
            sum += p * *z;
        }
        sum
    }));
}

/// A play with the derivatives of its output by ln a, b and ln α.
#[derive(Clone, Copy, Default)]
struct Play {
    output: f64,
    by: [f64; 3],
}

/// The derivatives of u by the coordinates for every normalised input, from rest.
pub fn sensitivities(inner: &Inner, inputs: &[f64]) -> Vec<[f64; COUNT]> {
    let mut plays = vec![Play::default(); inner.thresholds.len()];
    let by_logit = inner.s * (1.0 - inner.s);
    let share = if inner.s < 1.0 { 1.0 / (1.0 - inner.s) } else { 0.0 };
    let sample = |&t: &f64| {
        let [v, by_ln_a, by_b] = inner.envelope_derivatives(t);
        let mut by = [inner.s * by_ln_a, inner.s * by_b, 0.0, 0.0, 0.0];
        let mut by_s = v;
        for (i, play) in plays.iter_mut().enumerate() {
            let (r, p) = (inner.thresholds[i], inner.weights[i]);
            if v - r > play.output {
                *play = Play { output: v - r, by: [by_ln_a, by_b, -r] };
            } else if v + r < play.output {
                *play = Play { output: v + r, by: [by_ln_a, by_b, r] };
            }
            for (sum, derivative) in by.iter_mut().zip(&play.by) {
                *sum += p * derivative;
            }
            by[3] += inner.weights_by_ln_beta[i] * play.output;
            by_s -= share * p * play.output;
        }
        by[4] = by_logit * by_s;
        by
    };
    inputs.iter().map(sample).collect()
}
