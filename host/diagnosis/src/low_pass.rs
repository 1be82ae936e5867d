//! A lag of a signal.

use recording::simulation::SAME_STEP_S;

/// A first-order low-pass from rest at the first value, exact for values that are held.
pub fn low_pass(values: &[f64], time_s: &[f64], time_constant_s: f64) -> Vec<f64> {
    let mut state = values.first().copied().unwrap_or(0.0);
    let (mut last_s, mut known) = (time_s.first().copied().unwrap_or(0.0), (0.0, 0.0));
    values
        .iter()
        .zip(time_s)
        .map(|(value, &time_s)| {
            let step_s = time_s - last_s;
            last_s = time_s;
            if (step_s - known.0).abs() > SAME_STEP_S {
                known = (step_s, -(-step_s / time_constant_s).exp_m1());
            }
            state += (value - state) * known.1;
            state
        })
        .collect()
}
