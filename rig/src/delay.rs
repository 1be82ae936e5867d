//! A line with dead time: what goes in comes out later, unchanged. Linear between samples.

use std::collections::VecDeque;

/// The line and what is on its way through it.
#[derive(Debug, Clone)]
pub(crate) struct DelayLine {
    delay_s: f64,
    /// Age (s) and value, the youngest last; ages are brought up at every step.
    samples: VecDeque<(f64, f64)>,
}

impl DelayLine {
    /// A line of `delay_s` (0 s and more) that has held `value` for ever.
    pub(crate) fn new(delay_s: f64, value: f64) -> Self {
        Self { delay_s, samples: VecDeque::from([(f64::INFINITY, value), (0.0, value)]) }
    }

    /// Lets `dt_s` pass and `value` in; what comes out.
    pub(crate) fn step(&mut self, value: f64, dt_s: f64) -> f64 {
        for sample in &mut self.samples {
            sample.0 += dt_s;
        }
        self.samples.push_back((0.0, value));
        while self.samples.get(1).is_some_and(|second| second.0 >= self.delay_s) {
            self.samples.pop_front();
        }
        match (self.samples.front(), self.samples.get(1)) {
            (Some(&(old_s, old)), Some(&(new_s, new))) if old_s.is_finite() => {
                old + (new - old) * (old_s - self.delay_s) / (old_s - new_s)
            }
            (Some(&(_, only)), _) => only,
            (None, _) => value,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ramp_comes_out_later_by_the_delay_at_any_steps() {
        for delay_s in [0.0, 0.004, 0.0613, 0.2] {
            let mut line = DelayLine::new(delay_s, 0.0);
            let mut time_s = 0.0;
            for step in 1..400 {
                let dt_s = if step % 3 == 0 { 0.007 } else { 0.01 };
                time_s += dt_s;
                let expected = (time_s - delay_s).max(0.0);
                assert!((line.step(time_s, dt_s) - expected).abs() < 1e-9, "{delay_s} s at {time_s} s");
            }
        }
    }
}
