//! What the control code asks of a board.

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
    /// Load and temperature, as far as the board measures them.
    pub surroundings: Surroundings<f32>,
}

/// The ADC did not finish within its bounded wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AcquisitionError;

/// Sensors and valve.
pub trait Board {
    /// Samples pressure and contraction, in bounded time.
    ///
    /// # Errors
    /// A conversion did not finish in time.
    fn read(&mut self) -> Result<Samples, AcquisitionError>;

    /// Writes the valve's set point.
    fn drive(&mut self, code: DacCode);
}
