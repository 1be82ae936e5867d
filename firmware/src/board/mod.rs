//! What the control code asks of a board, and the drivers that need no registers.
//!
//! | file | what it drives |
//! |---|---|
//! | [`pwm_valve`] | a solenoid by the duty cycle of anything that has [`embedded_hal::pwm`] |
//! | [`spi_dac`] | a set point by a converter on a bus, by [`embedded_hal::spi`] |
//!
//! The processor's own converters and timers are driven by the crate `bsp`.

pub mod pwm_valve;
pub mod spi_dac;

use model_core::Surroundings;

/// What an analogue input read. Unit: ADC code, 12 bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AdcCode(pub u16);

/// What is written to the analogue output. Unit: DAC code, 12 bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DacCode(pub u16);

/// The samples of one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Samples {
    /// Pressure in the muscle.
    pub pressure: AdcCode,
    /// Contraction of the muscle.
    pub contraction: AdcCode,
    /// Pressure before the valve.
    pub supply: AdcCode,
    /// Temperature of the processor.
    pub temperature: AdcCode,
    /// The voltage at the valve's output, the same number as that of the [`DacCode`] which makes
    /// it; none on a board that does not read it back.
    pub output: Option<AdcCode>,
    /// The reference voltage, as a typical processor would read it; none on a board without one.
    pub reference: Option<AdcCode>,
    /// Load and temperature of the muscle, as far as the board measures them.
    pub surroundings: Surroundings<f32>,
}

/// The ADC has no new samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AcquisitionError;

/// Sensors and valve.
pub trait Board {
    /// The samples of this tick, in bounded time.
    ///
    /// # Errors
    /// There are none that are newer than those of the tick before.
    fn read(&mut self) -> Result<Samples, AcquisitionError>;

    /// Writes the valve's set point.
    fn drive(&mut self, code: DacCode);
}

/// An output that a valve hangs on.
pub trait Valve {
    /// Why the output does not take a code.
    type Error;

    /// Writes the set point.
    ///
    /// # Errors
    /// The output has not taken it.
    fn set(&mut self, code: DacCode) -> Result<(), Self::Error>;
}
