//! A tone that has nothing to do with the input: amplitude * sin(2π frequency t + phase).
//!
//! It is made by an oscillator: each step turns a pointer, by its own small difference so that the
//! frequency is exact in `f32` too, and pulls its length back to 1.

use core::f64::consts::{PI, TAU};

use crate::convert;
use crate::error::{Check, ParameterError};
use crate::real::Real;

/// Raw parameters of a tone.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PeriodicDisturbanceParameters<T> {
    /// Output unit, at least 0.
    pub amplitude: T,
    /// Unit: Hz, above 0.
    pub frequency_hz: T,
    /// At the first sample. Unit: rad, within ±2π.
    pub phase_rad: T,
    /// Whether the inverse takes it off; else it is left to feedback. The phase has to be that of
    /// the board's start.
    pub compensated: bool,
}

impl<T: Real> PeriodicDisturbanceParameters<T> {
    pub(super) fn convert<U: Real>(&self) -> PeriodicDisturbanceParameters<U> {
        PeriodicDisturbanceParameters {
            amplitude: convert::number(self.amplitude),
            frequency_hz: convert::number(self.frequency_hz),
            phase_rad: convert::number(self.phase_rad),
            compensated: self.compensated,
        }
    }
}

/// A validated tone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PeriodicDisturbance<T> {
    amplitude: T,
    frequency_hz: T,
    phase_rad: T,
}

/// A pointer of length 1.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Pointer<T> {
    sine: T,
    cosine: T,
}

/// A turn of a pointer: its sine, and by how much its cosine is less than 1.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Turn<T> {
    sine: T,
    lack: T,
}

impl<T: Real> PeriodicDisturbance<T> {
    pub(super) fn try_new(parameters: &PeriodicDisturbanceParameters<T>) -> Result<Self, ParameterError> {
        let PeriodicDisturbanceParameters { amplitude, frequency_hz, phase_rad, .. } = *parameters;
        let phase = Check::new("periodic_disturbance phase_rad", "rad");
        let turn = T::from_f64(TAU);
        phase.at_least(phase.at_most(phase_rad, turn)?, -turn)?;
        Ok(Self {
            amplitude: Check::new("periodic_disturbance amplitude", "output unit")
                .at_least(amplitude, T::ZERO)?,
            frequency_hz: Check::new("periodic_disturbance frequency_hz", "Hz")
                .above(frequency_hz, T::ZERO)?,
            phase_rad,
        })
    }

    /// The pointer a time after the first sample. Unit: s.
    pub(super) fn start(&self, time_s: T) -> Pointer<T> {
        let Turn { sine, lack } = turn(self.phase_rad.to_f64() + self.angle(time_s));
        Pointer { sine: T::from_f64(sine), cosine: T::from_f64(1.0 - lack) }
    }

    /// What a step of time turns it by.
    pub(super) fn step(&self, dt: T) -> Turn<T> {
        let Turn { sine, lack } = turn(self.angle(dt));
        Turn { sine: T::from_f64(sine), lack: T::from_f64(lack) }
    }

    fn angle(&self, time_s: T) -> f64 {
        let turns = self.frequency_hz.to_f64() * time_s.to_f64();
        TAU * (turns - libm::floor(turns))
    }

    /// Output unit.
    #[inline(always)]
    pub(super) fn value(&self, pointer: &Pointer<T>) -> T {
        self.amplitude * pointer.sine
    }
}

impl<T: Real> Pointer<T> {
    #[inline(always)]
    pub(super) fn turn(&mut self, by: &Turn<T>) {
        let sine = self.sine + (self.cosine * by.sine - self.sine * by.lack);
        let cosine = self.cosine - (self.sine * by.sine + self.cosine * by.lack);
        // The first step of Newton's iteration for 1/length.
        let pull = (T::ONE - (sine * sine + cosine * cosine)) * T::from_f64(0.5);
        *self = Self { sine: sine + sine * pull, cosine: cosine + cosine * pull };
    }
}

/// By an angle within ±4π. By the power series, of the angle within ±π: `libm`'s functions reduce
/// angles of any size by a table, and as far as a compiler knows its index can panic.
fn turn(angle: f64) -> Turn<f64> {
    let mut angle = angle;
    for _ in 0..2 {
        if angle > PI {
            angle -= TAU;
        } else if angle < -PI {
            angle += TAU;
        }
    }
    let (mut term, mut sine, mut lack) = (angle, angle, 0.0);
    for k in 1..=TERMS {
        term *= angle / f64::from(2 * k);
        lack += term;
        term *= -angle / f64::from(2 * k + 1);
        sine += term;
    }
    Turn { sine, lack }
}

/// The next terms, from π²⁸/28! on, are below the last place of 1.
const TERMS: u8 = 13;
