//! The reference of the feedback, where that of the inverse is given ahead of time.
//!
//! What the inverse commands acts a delay later, and the reference that a mass is to follow is
//! smoothed on its way there ([`super::smoother`]). So the controller gets the reference that is
//! due then, and the feedback, which compares with what is measured now, the one that it got as
//! long ago. Between samples the reference is taken to move evenly; before the first one it was
//! that.

use crate::error::{Check, ParameterError, Requirement};
use crate::real::Real;

use super::transport_delay::DELAY_SAMPLES;

/// A delay at a fixed period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Preview<T> {
    /// Whole periods.
    periods: usize,
    /// What is beyond them, in periods: 0 to 1.
    beyond: T,
}

/// The last references, in a ring.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PreviewLine<T> {
    references: [T; DELAY_SAMPLES],
    /// How many have been put in; a ring or more, where the ring has been filled.
    count: usize,
}

impl<T: Real> Preview<T> {
    /// None for no delay. `delay_s`: how far ahead the reference is given, s.
    ///
    /// # Errors
    /// The delay lasts for more samples than the line holds.
    pub(crate) fn try_new(delay_s: T, period_s: T) -> Result<Option<Self>, ParameterError> {
        let longest = period_s * T::from_f64((DELAY_SAMPLES - 2) as f64);
        if delay_s > longest {
            let requirement = Requirement::AtMost(longest.to_f64());
            return Err(Check::new("transport_delay delay_s", "s").error(delay_s.to_f64(), requirement));
        }
        let delay = (delay_s / period_s).to_f64();
        let periods = libm::floor(delay);
        let preview = Self { periods: periods as usize, beyond: T::from_f64(delay - periods) };
        Ok((delay > 0.0).then_some(preview))
    }

    /// Puts the reference in that is due after the delay, and answers the one that is due now.
    #[inline(always)]
    pub(crate) fn due(&self, line: &mut PreviewLine<T>, reference: T) -> T {
        if let Some(place) = line.references.get_mut(line.count % DELAY_SAMPLES) {
            *place = reference;
        }
        let younger = line.before(self.periods, reference);
        let older = line.before(self.periods + 1, reference);
        line.count += 1;
        if line.count >= 2 * DELAY_SAMPLES {
            line.count = DELAY_SAMPLES;
        }
        younger + (older - younger) * self.beyond
    }
}

impl<T: Real> PreviewLine<T> {
    pub(crate) fn new() -> Self {
        Self { references: [T::ZERO; DELAY_SAMPLES], count: 0 }
    }

    /// The reference so many periods before the present one, the first one at the earliest.
    #[inline(always)]
    fn before(&self, periods: usize, present: T) -> T {
        let number = self.count.saturating_sub(periods);
        self.references.get(number % DELAY_SAMPLES).copied().unwrap_or(present)
    }
}
