//! A lag of a signal, of the first and of the second order.

use recording::simulation::SAME_STEP_S;

/// A first-order low-pass from rest at the first value, exact for values that are held.
pub fn low_pass(values: &[f64], time_s: &[f64], time_constant_s: f64) -> Vec<f64> {
    low_pass_from(values.first().copied().unwrap_or(0.0), values, time_s, time_constant_s)
}

/// The same from another value.
pub fn low_pass_from(start: f64, values: &[f64], time_s: &[f64], time_constant_s: f64) -> Vec<f64> {
    let mut state = start;
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

/// A second-order low-pass from rest at a value, exact for values that are held. `late_s`: how late it is on a ramp, twice the
/// damping ratio over the natural frequency; from a damping ratio of one on it is two first-order lags.
pub fn low_pass_of_second_order(
    start: f64,
    values: &[f64],
    time_s: &[f64],
    late_s: f64,
    damping_ratio: f64,
) -> Vec<f64> {
    let frequency = 2.0 * damping_ratio / late_s;
    let decay = damping_ratio * frequency;
    // Half of the difference of the poles, squared: negative where it rings.
    let apart = frequency.powi(2) * (damping_ratio.powi(2) - 1.0);
    // What a step leaves of a distance and of a speed, by the exponential of the matrix of the two states.
    let over = |step_s: f64| {
        let turned = apart.abs().sqrt() * step_s;
        let fade = (-decay * step_s).exp();
        // Both exponents of an overdamped one are negative: neither overflows.
        let (even, odd) = if turned < 1e-6 {
            (fade, fade * step_s)
        } else if apart < 0.0 {
            (fade * turned.cos(), fade * turned.sin() * step_s / turned)
        } else {
            let (slow, fast) = ((turned - decay * step_s).exp(), (-turned - decay * step_s).exp());
            (0.5 * (slow + fast), 0.5 * (slow - fast) * step_s / turned)
        };
        [[even + decay * odd, odd], [-frequency.powi(2) * odd, even - decay * odd]]
    };
    let (mut state, mut speed) = (start, 0.0);
    let (mut last_s, mut known) = (time_s.first().copied().unwrap_or(0.0), (0.0, over(0.0)));
    values
        .iter()
        .zip(time_s)
        .map(|(value, &time_s)| {
            let step_s = time_s - last_s;
            last_s = time_s;
            if (step_s - known.0).abs() > SAME_STEP_S {
                known = (step_s, over(step_s));
            }
            let [[kept, gone_on], [pulled, damped]] = known.1;
            let distance = state - value;
            (state, speed) = (value + kept * distance + gone_on * speed, pulled * distance + damped * speed);
            state
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step after a second, in rows of 20 ms.
    fn step() -> (Vec<f64>, Vec<f64>) {
        let time_s: Vec<f64> = (0..300).map(|row| 0.02 * f64::from(row)).collect();
        (time_s.iter().map(|&time_s| f64::from(u8::from(time_s > 1.0))).collect(), time_s)
    }

    #[test]
    fn a_well_damped_one_is_two_lags() {
        let (values, time_s) = step();
        let at_once = low_pass_of_second_order(values[0], &values, &time_s, 0.3, 10.0);
        let one = low_pass(&values, &time_s, 0.3 * 0.5 * (1.0 + (1.0_f64 - 0.01).sqrt()));
        // The shorter of the lags is below a millisecond, a twentieth of a row.
        assert!(at_once.iter().zip(&one).all(|(both, one)| (both - one).abs() < 0.02));
    }

    #[test]
    fn it_is_that_of_its_equation_at_any_damping() {
        let (values, time_s) = step();
        for damping_ratio in [0.3, 0.999_999_999, 1.0, 1.7] {
            let found = low_pass_of_second_order(values[0], &values, &time_s, 0.3, damping_ratio);
            let frequency = 2.0 * damping_ratio / 0.3;
            let (mut state, mut speed) = (0.0, 0.0);
            for (row, value) in values.iter().enumerate().skip(1) {
                for _ in 0..2000 {
                    speed += 1e-5 * frequency * (frequency * (value - state) - 2.0 * damping_ratio * speed);
                    state += 1e-5 * speed;
                }
                assert!((found[row] - state).abs() < 1e-3, "{damping_ratio} {row}: {} {state}", found[row]);
            }
        }
    }
}
