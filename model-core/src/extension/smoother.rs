//! The reference of a muscle with a mass, without what no mass could follow.
//!
//! The compensation of an inertia takes the second derivative of the reference, and a valve's lag
//! one more. So the rounding of a reference's last digit, and the corners between its rows, would
//! come out as pressure: a ten-thousandth of a millimetre at 1 kHz is 100 mm/s². A second-order low
//! pass goes before, and the reference is given as much earlier ([`super::preview`]), so what is
//! left of its lag is of third order in the frequency.
//!
//! # Why Butterworth
//! Its gain is flat to the fourth order: 1/√(1 + (ωT)⁴), at 1 Hz and 10 ms 8e-6 below 1. Two equal
//! lags would take 4e-3.

use crate::range::Range;
use crate::real::Real;

/// T: the filter's corner is at 1/T. Unit: s.
const SMOOTHED_S: f64 = 0.01;
/// The same in periods at least, at which the filter does not ring from sample to sample.
const SMOOTHED_PERIODS: f64 = 2.0;

/// The low pass at a fixed period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Smoother<T> {
    /// Half a period.
    half_s: T,
    /// 1/T² times half a period.
    spring: T,
    /// √2/T times half a period.
    damping: T,
    /// One over what a step's end takes of speed and spring.
    per_inertia: T,
    /// Of the reference, so that no finite one leads out of the number type.
    reach: Range<T>,
}

/// Where it is, from its first sample on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Smoothed<T> {
    last: Option<Last<T>>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Last<T> {
    reference: T,
    place: T,
    /// Unit: that of the reference per s.
    speed: T,
}

fn smoothed_s<T: Real>(period_s: T) -> T {
    T::from_f64(SMOOTHED_S).at_least(period_s * T::from_f64(SMOOTHED_PERIODS))
}

/// How much later a slow reference leaves the filter. Both: s.
pub(super) fn lag_s<T: Real>(period_s: T) -> T {
    T::from_f64(core::f64::consts::SQRT_2) * smoothed_s(period_s)
}

impl<T: Real> Smoother<T> {
    /// `period_s`: s, above 0. References beyond the reach count as its ends.
    pub(crate) fn new(period_s: T, reach: Range<T>) -> Self {
        let half_s = T::from_f64(0.5) * period_s;
        let smoothed_s = smoothed_s(period_s);
        let spring = half_s / (smoothed_s * smoothed_s);
        let damping = T::from_f64(core::f64::consts::SQRT_2) * half_s / smoothed_s;
        let per_inertia = T::ONE / (T::ONE + damping + spring * half_s);
        Self { half_s, spring, damping, per_inertia, reach }
    }

    /// The filter's output at the next sample, by the trapezoidal rule, whose lag at low
    /// frequencies is that of the filter.
    #[inline(always)]
    pub(crate) fn step(&self, state: &mut Smoothed<T>, reference: T) -> T {
        let reference = self.reach.limit(reference);
        let last = state.last.unwrap_or(Last { reference, place: reference, speed: T::ZERO });
        let (behind, ahead) =
            (last.reference - last.place, reference - last.place - self.half_s * last.speed);
        let speed =
            (last.speed * (T::ONE - self.damping) + self.spring * (behind + ahead)) * self.per_inertia;
        let place = last.place + self.half_s * (last.speed + speed);
        state.last = Some(Last { reference, place, speed });
        place
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(period_s: f64, reference: impl Fn(f64) -> f64, samples: usize) -> (f64, f64) {
        let reach = Range::try_new(-1e3, 1e5, "reach", "mm").expect("a range");
        let (smoother, mut state) = (Smoother::new(period_s, reach), Smoothed::default());
        let time_s = |sample: usize| sample as f64 * period_s;
        let place = (0..samples).fold(0.0, |_, sample| smoother.step(&mut state, reference(time_s(sample))));
        (place, time_s(samples - 1))
    }

    #[test]
    fn a_ramp_leaves_the_filter_its_lag_later() {
        for period_s in [1e-4, 1e-3, 1e-2, 0.5] {
            let (place, time_s) = after(period_s, |time_s| 30.0 * time_s, 2000);
            let error = place - 30.0 * (time_s - lag_s(period_s));
            assert!(error.abs() < 1e-9 * place, "{period_s} s: {error}");
        }
    }

    #[test]
    fn a_hertz_passes_with_an_error_of_a_four_thousandth() {
        let reference = |time_s: f64| (core::f64::consts::TAU * time_s).sin();
        for samples in 3000..4000 {
            let (place, time_s) = after(1e-3, reference, samples);
            let error = place - reference(time_s - lag_s(1e-3));
            assert!(error.abs() < 2.5e-4, "{samples}: {error}");
        }
    }

    #[test]
    fn a_wild_reference_is_forgotten() {
        let wild = |time_s: f64| if (1.0..1.001).contains(&time_s) { f64::MAX } else { 70.0 };
        assert!((after(1e-3, wild, 3000).0 - 70.0).abs() < 1e-9);
    }

    #[test]
    fn the_first_reference_is_where_it_begins() {
        assert_eq!(after(1e-3, |_| 70.0, 1), (70.0, 0.0));
        assert_eq!(after(1e-3, |_| 70.0, 5).0, 70.0);
    }
}
