//! The bank with thresholds that change from sample to sample, all by the same factor.
//!
//! Each play stays within its present threshold of the input: zᵢ = limit(zᵢ, v - g rᵢ, v + g rᵢ).
//! Where g falls plays follow on either side at once, so none of the order holds that
//! [`FewPlays::drive`] halves by: every play is looked at. What u is over v, all else given, rises
//! and bends where a play begins or ceases to follow; the inverse goes from bend to bend, of which
//! a sample usually passes none or one.

use super::{FEW_PLAYS, FewPlays, Outputs};
use crate::direction::{go, passes};
use crate::real::Real;

impl<T: Real> FewPlays<T> {
    /// Moves to `v` with thresholds `times` as wide, and answers u.
    #[inline(always)]
    pub(crate) fn drive_wider(&self, state: &mut Outputs<T>, v: T, times: T) -> T {
        state.v = v;
        let mut u = self.direct.slope * v;
        let plays = state.outputs.iter_mut().zip(&self.thresholds).zip(&self.weights);
        for ((z, &threshold), &weight) in plays {
            let wide = times * threshold;
            *z = z.limit(v - wide, v + wide);
            u += weight * *z;
        }
        u
    }

    /// The answer of such a move. Moves nothing.
    #[inline(always)]
    fn output_wider(&self, state: &Outputs<T>, v: T, times: T) -> T {
        self.drive_wider(&mut state.clone(), v, times)
    }

    /// What the plays hold back, over what they do where all follow a rise with thresholds as they
    /// are: from there (1), or with thresholds that are wider beyond, to where all follow a fall
    /// (-1). Within these limits. Unit: 1.
    pub(crate) fn held_back(&self, state: &Outputs<T>) -> T {
        let [.., all] = self.driven;
        if all.moment <= T::ZERO {
            return T::ZERO;
        }
        let mut sum = T::ZERO;
        for (&z, &weight) in state.outputs.iter().zip(&self.weights) {
            sum += weight * (state.v - z);
        }
        (sum / all.moment).limit(-T::ONE, T::ONE)
    }

    /// The v to move to with thresholds `times` as wide for the answer `u`. Moves nothing.
    #[inline(always)]
    pub(crate) fn input_wider(&self, state: &Outputs<T>, u: T, times: T) -> T {
        let here = self.output_wider(state, state.v, times);
        if u >= here {
            self.input_toward::<true>(state, (u, here), times)
        } else {
            self.input_toward::<false>(state, (u, here), times)
        }
    }

    /// From the bank's v, where it would give `here`, in one direction to `u`.
    #[inline(never)]
    fn input_toward<const RISING: bool>(&self, state: &Outputs<T>, (u, mut here): (T, T), times: T) -> T {
        // Where each play ceases to follow, and where it begins to.
        let mut ends = [(T::ZERO, T::ZERO); FEW_PLAYS];
        for ((ends, &z), &threshold) in ends.iter_mut().zip(&state.outputs).zip(&self.thresholds) {
            let wide = times * threshold;
            *ends = (go::<T, RISING>(z, -wide), go::<T, RISING>(z, wide));
        }
        let mut v = state.v;
        for _ in 0..=2 * FEW_PLAYS {
            let mut slope = self.direct.slope;
            let mut bend = if RISING { T::INFINITY } else { -T::INFINITY };
            for (&(left, taken), &weight) in ends.iter().zip(&self.weights) {
                let is_held = passes::<T, RISING>(left, v);
                let next = if is_held { left } else { taken };
                let bends = passes::<T, RISING>(next, v);
                if is_held || !bends {
                    slope += weight;
                }
                if bends && passes::<T, RISING>(bend, next) {
                    bend = next;
                }
            }
            let reached = v + (u - here) / slope;
            if slope > T::ZERO && !passes::<T, RISING>(reached, bend) {
                return reached;
            }
            here += slope * (bend - v);
            v = bend;
        }
        v
    }
}

#[cfg(test)]
mod tests {
    use crate::paper;
    use crate::play::PlayBank;

    /// Inputs that go to and fro by more and by less, with factors that rise and fall.
    fn history() -> impl Iterator<Item = (f64, f64)> {
        (0..4000).map(|tick| {
            let t = f64::from(tick) * 0.01;
            (3.0 * (t.sin() + 0.7 * (3.7 * t).sin()), 1.0 + 1.5 * (2.3 * t).sin().max(0.0))
        })
    }

    #[test]
    fn thresholds_that_stay_are_those_of_the_bank() {
        let bank =
            PlayBank::<f64, { paper::SIZE }>::try_new(&paper::mgpi().expect("valid").plays).expect("valid");
        let (mut one, mut other) = (bank.rest_state(0.0), bank.rest_state(0.0));
        for (v, _) in history() {
            let (u, wider) = (bank.advance(&mut one, v), bank.advance_wider(&mut other, v, 1.0));
            assert!((u - wider).abs() < 1e-12, "{u} {wider}");
        }
    }

    #[test]
    fn the_inverse_of_every_sample_is_its_input() {
        let bank =
            PlayBank::<f64, { paper::SIZE }>::try_new(&paper::mgpi().expect("valid").plays).expect("valid");
        let mut state = bank.rest_state(0.0);
        for (v, times) in history() {
            let before = state.clone();
            let u = bank.advance_wider(&mut state, v, times);
            let found = bank.input_wider(&before, u, times);
            assert!((found - v).abs() < 1e-9, "{found} for {v}");
        }
    }
}
