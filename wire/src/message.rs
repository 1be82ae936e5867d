//! The messages.

use core::fmt::{self, Write as _};

use model_core::{Mode, ParameterError, Tracking, TrackingParameters};
use serde::{Deserialize, Serialize};

use crate::{CaptureOrder, Captured, Fault, FaultRecord, Protection, Telemetry};

/// Version of the messages. Raised with every change that the other side would misread.
pub const VERSION: u16 = 11;
/// The largest number of plays that a board takes.
pub const PLAYS: usize = 32;
/// The largest number of dead zones that a board takes.
pub const DEAD_ZONES: usize = 32;

/// The raw parameters of the board's controller, in its number type and capacity.
pub type BoardParameters = TrackingParameters<f32, PLAYS, DEAD_ZONES>;
/// The controller in the board's number type and capacity.
pub type BoardTracking = Tracking<f32, PLAYS, DEAD_ZONES>;

/// From the host to the board. Every request is answered by one response.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
// The configuration is the one large message; boxing it needs a heap, which the board does not
// have.
#[allow(clippy::large_enum_variant)]
pub enum Request {
    /// Who are you? Answer: [`Response::Hello`].
    Identify,
    /// Take this model, these gains and limits. Refused while tracking.
    Configure(Configuration),
    /// Start tracking from rest in the given mode. Refused without a configuration, with a fault,
    /// or where nothing has armed the board.
    Start(Mode),
    /// Change the mode while tracking, without a bump.
    SetMode(Mode),
    /// Stop tracking and vent.
    Stop,
    /// The next reference, for a board that takes its samples by its own timer; for a model with a
    /// delay, the one that is due after it. Unit: mm.
    Reference(f32),
    /// The samples of one tick, for an emulated board. Answer: [`Response::Tick`].
    Tick(TickRequest),
    /// Take these limits of the plant. Refused unless vented.
    Protect(Protection),
    /// The fault has been seen to: test the board again, and be ready.
    Acknowledge,
    /// Put this code out, slew and pressure limited, without a controller: for wiring and
    /// calibration. The first one enters the service state; [`Request::Stop`] leaves it. Unit: DAC
    /// code.
    Service(u16),
    /// Answer: [`Response::Telemetry`].
    Telemetry,
    /// What was the first fault? Answer: [`Response::FaultRecord`].
    FaultRecord,
    /// Record the loop, or read what was recorded. Answer to a reading: [`Response::Captured`].
    Capture(CaptureOrder),
    /// Be ready to start: a start, or the first [`Request::Service`], is taken within the next
    /// [`crate::registers::ARMED_TICKS`], and not without.
    Arm,
    /// The host lives. A number that it has sent before says nothing: only another one is a sign of
    /// life.
    Heartbeat(u16),
}

/// From the board to the host.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
// What was captured is the one large response; boxing it needs a heap, which the board does not
// have.
#[allow(clippy::large_enum_variant)]
pub enum Response {
    /// Sent at the start of the board and on [`Request::Identify`].
    Hello(Hello),
    /// Done.
    Accepted,
    /// Not done, nothing changed; but see [`Refusal::NotStored`].
    Refused(Refusal),
    /// The outcome of a tick.
    Tick(TickReply),
    /// The state of the board in numbers.
    Telemetry(Telemetry),
    /// The first fault since the last acknowledgement, if any.
    FaultRecord(Option<FaultRecord>),
    /// A part of the recorded loop.
    Captured(Captured),
}

/// Who a board is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hello {
    /// Version of the messages, [`VERSION`].
    pub version: u16,
    /// Version of the firmware: major, minor, patch.
    pub firmware: [u16; 3],
    /// The board's state.
    pub state: State,
    /// The fault that is latched.
    pub fault: Option<Fault>,
    /// ADC code of the pressure in bar.
    pub pressure: Scaling,
    /// ADC code of the contraction in mm.
    pub contraction: Scaling,
    /// DAC code of the command in bar.
    pub command: Scaling,
    /// Ticks since the board started.
    pub ticks: u32,
    /// Ticks that found the one before unfinished.
    pub overruns: u32,
}

/// A straight line between a quantity and a converter's code.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scaling {
    /// The code of 0. Unit: code.
    pub zero_code: f32,
    /// Unit: code per unit of the quantity, above 0.
    pub codes_per_unit: f32,
    /// Lowest code that a working sensor or an allowed command has.
    pub code_min: u16,
    /// Highest code that a working sensor or an allowed command has.
    pub code_max: u16,
}

impl Scaling {
    /// The quantity behind a code.
    pub fn value(&self, code: u16) -> f32 {
        (f32::from(code) - self.zero_code) / self.codes_per_unit
    }

    /// The nearest code, within the limits of the codes; that of a NaN is the lowest.
    #[allow(clippy::manual_clamp, reason = "clamp panics where the limits are swapped")]
    pub fn code(&self, value: f32) -> u16 {
        // The conversion cuts off towards 0 and saturates; the sum makes it round.
        let nearest = (self.zero_code + value * self.codes_per_unit + 0.5) as u16;
        nearest.min(self.code_max).max(self.code_min)
    }

    /// Whether a code is one of a working sensor.
    pub fn is_plausible(&self, code: u16) -> bool {
        (self.code_min..=self.code_max).contains(&code)
    }
}

/// A board's state; the firmware's state machine tells how they follow each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum State {
    /// Vented, without a configuration.
    #[default]
    Off,
    /// Vented, configured; the board looks at sensors and valve.
    SelfTest,
    /// Vented, tested.
    Ready,
    /// The controller drives the valve.
    Tracking,
    /// The controller holds its last command.
    Holding,
    /// Vented by a fault, which is latched until it is acknowledged.
    Fault,
    /// The host drives the valve by codes, without a controller.
    Service,
}

impl State {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Off, Self::SelfTest, Self::Ready, Self::Tracking, Self::Holding, Self::Fault, Self::Service];

    /// Whether the valve may be open.
    pub const fn is_driven(self) -> bool {
        matches!(self, Self::Tracking | Self::Holding | Self::Service)
    }
}

/// Model with its extensions, gains and limits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Configuration {
    /// Version of the messages, [`VERSION`].
    pub version: u16,
    /// The controller's raw parameters; the board validates them.
    pub tracking: BoardParameters,
}

/// Why a request was refused.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// The frame was damaged or holds no known message.
    Unreadable,
    /// The configuration has another version; this board's is given.
    Version(u16),
    /// A parameter is not valid: the message that names parameter, value and limit.
    Parameter(heapless::String<100>),
    /// The request does not fit the board's state.
    WrongState(State),
    /// The request has no meaning for this board.
    NotHere,
    /// It is carried out, but lost when power is: the flash has not kept it.
    NotStored,
    /// The valve is opened in two steps, and the first has not been taken, or too long ago.
    NotArmed,
}

impl Refusal {
    /// Of a parameter that is not valid, by a message that names parameter, value and limit.
    pub fn parameter(message: fmt::Arguments<'_>) -> Self {
        Self::Parameter(text(message))
    }
}

impl From<ParameterError> for Refusal {
    fn from(error: ParameterError) -> Self {
        Self::parameter(format_args!("{error}"))
    }
}

/// A message, as far as it fits.
pub fn text(message: fmt::Arguments<'_>) -> heapless::String<100> {
    let mut text = heapless::String::new();
    // A text that does not fit ends at its last whole part.
    let _ = text.write_fmt(message);
    text
}

/// The samples of one tick: what the board's ADC would have read.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TickRequest {
    /// Of the next tick; for a model with a delay, the one that is due after it. None leaves it to
    /// what the board has from elsewhere. Unit: mm.
    pub reference_mm: Option<f32>,
    /// Pressure. Unit: ADC code.
    pub pressure_code: u16,
    /// Contraction. Unit: ADC code.
    pub contraction_code: u16,
    /// The load, if it is measured. Unit: N.
    pub load_n: Option<f32>,
    /// The temperature, if it is measured. Unit: °C.
    pub temperature_c: Option<f32>,
}

/// The outcome of one tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TickReply {
    /// What the board wrote to its DAC. Unit: DAC code.
    pub dac_code: u16,
    /// The feed-forward part of the command. Unit: bar.
    pub feedforward_bar: f32,
    /// The feedback part of the command. Unit: bar.
    pub feedback_bar: f32,
    /// What happened.
    pub flags: Flags,
}

/// What happened in a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Flags(pub u8);

impl Flags {
    /// A limit or the slew rate changed the command.
    pub const LIMITED: Self = Self(1);
    /// The controller drove the valve.
    pub const TRACKING: Self = Self(2);
    /// A fault is latched; the valve is vented.
    pub const FAULT: Self = Self(4);
    /// This tick found the one before unfinished.
    pub const OVERRUN: Self = Self(8);

    /// Whether all of `other` are set.
    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// These and `other`, if `condition` holds.
    #[must_use]
    pub fn with(self, other: Self, condition: bool) -> Self {
        if condition { Self(self.0 | other.0) } else { self }
    }
}
