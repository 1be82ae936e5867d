//! Dead time: what the muscle sees of the pressure is older than the present by the delay.
//!
//! Between samples the pressure is taken to move evenly; before the first one it was what it then
//! is. The samples that are younger than the delay, and the next older one, have to fit into the
//! line: [`DELAY_SAMPLES`].
//!
//! The inverse cannot answer a reference earlier than it comes: it has to be given the reference
//! ahead. The controller keeps it for its feedback as long as the delay lasts, see
//! [`crate::tracking`].

use crate::convert;
use crate::error::{Check, InputError, ParameterError};
use crate::real::Real;

use super::ring::Ring;
use super::sum::Sum;

/// How many samples a delay can last, at most.
pub const DELAY_SAMPLES: usize = 512;

/// Raw parameters of a delay.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TransportDelayParameters<T> {
    /// Unit: s, at least 0.
    pub delay_s: T,
}

impl<T: Real> TransportDelayParameters<T> {
    pub(super) fn convert<U: Real>(&self) -> TransportDelayParameters<U> {
        TransportDelayParameters { delay_s: convert::number(self.delay_s) }
    }

    /// The delay. Unit: s.
    pub(super) fn checked(&self) -> Result<T, ParameterError> {
        Check::new("transport_delay delay_s", "s").at_least(self.delay_s, T::ZERO)
    }
}

/// What was put in, with its time; the oldest is at or before the present less the delay, once
/// there is one.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub(super) struct DelayLine<T> {
    samples: Ring<(T, T), DELAY_SAMPLES>,
    now: Sum<T>,
}

impl<T: Real> DelayLine<T> {
    pub(super) fn new() -> Self {
        Self { samples: Ring::new(), now: Sum::default() }
    }

    /// Makes room for the sample after a step of `dt`.
    ///
    /// # Errors
    /// There is no room: [`InputError::DelayTooLong`], and nothing has changed.
    pub(super) fn make_room(&mut self, delay_s: T, dt: T) -> Result<(), InputError> {
        self.forget_before(self.now.value() + dt - delay_s);
        if self.samples.is_full() { Err(InputError::DelayTooLong) } else { Ok(()) }
    }

    /// Stores the value after a step of `dt`, and returns the value of a delay ago.
    pub(super) fn step(&mut self, delay_s: T, dt: T, value: T) -> T {
        self.now.add(dt);
        let then = self.now.value() - delay_s;
        // Room has been made.
        self.samples.push((self.now.value(), value));
        self.forget_before(then);
        let Some(&(time, old)) = self.samples.get(0) else { return value };
        match self.samples.get(1) {
            Some(&(next_time, next)) if time <= then => {
                old + (next - old) * ((then - time) / (next_time - time))
            }
            _ => old,
        }
    }

    /// Forgets the samples that are older than the youngest one before a time.
    fn forget_before(&mut self, time: T) {
        for _ in 0..DELAY_SAMPLES {
            match self.samples.get(1) {
                Some(&(next_time, _)) if next_time <= time => self.samples.forget_oldest(),
                _ => break,
            };
        }
    }
}
