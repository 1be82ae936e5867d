//! Messages between a host and a board that drives a joint: two muscles, each on a regulator of its
//! own, and an angle sensor. They have the frames of the other messages, and images of their own.
//!
//! # Two ways to drive
//! With a joint's model the board controls angle and stiffness: `Configure`, `Arm`, `Start`, then
//! `Aim`, again and again. Without one a host tells both pressures, as for a recording: `Arm`,
//! `Service`, then `Press`, again and again. Either ends by `Stop`.
//!
//! # Signs of life
//! While tracking, and while a joint is tried, it is `Aim` with a target; in service it is `Press`.
//! None of them stands in for the other, and neither does a question (`Aim` without a target).
//!
//! # Reading back
//! Questions are answered in every state, and change nothing: `Identify`, `Aim` and `Settings`
//! without a content, `Installed`, `Control`, `Status`.

pub mod fault;
pub mod settings;

use core::fmt;

use model_core::joint::{JointControl, JointControlParameters, JointTarget};
use serde::{Deserialize, Serialize};

use crate::{Fault, Refusal, Scaling};
pub use fault::{JointFault, Motion};
pub use settings::{JointCalibration, JointSettings};

/// Version of these messages. Raised with every change that the other side would misread.
pub const JOINT_VERSION: u16 = 7;
/// The largest number of stops that a board takes.
pub const STOPS: usize = 12;

/// The raw parameters of the board's controller, in its number type and capacity.
pub type BoardJointParameters = JointControlParameters<f32, STOPS>;
/// The controller in the board's number type and capacity.
pub type BoardJointControl = JointControl<f32, STOPS>;

/// From the host to the board. Every request is answered by one response.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
// As of the board with one muscle: boxing the large message needs a heap.
#[allow(clippy::large_enum_variant)]
pub enum JointRequest {
    /// Who are you? Answer: [`JointResponse::Hello`].
    Identify,
    /// Take this joint, and keep it without power. Refused while a valve is driven, and at fault;
    /// [`Refusal::NotStored`]: it is in use until power-off.
    Configure(JointConfiguration),
    /// Be ready to start: a start, or [`JointRequest::Service`], is taken within the next
    /// [`crate::registers::ARMED_TICKS`], and not without.
    Arm,
    /// Fill both muscles, try the joint with a small motion and a swing, at this stiffness; then
    /// track. Of the targets that come meanwhile the torque from outside counts. Unit: N m/rad.
    Start(f32),
    /// Vent both.
    Stop,
    /// The fault has been seen to.
    Acknowledge,
    /// The samples of one tick, for an emulated board. Answer: [`JointResponse::Tick`].
    Tick(JointTickRequest),
    /// Go there, for a board whose ticks have a clock of their own; a sign of life but in service,
    /// where it is refused. `None` only asks, and is no sign of life. Answer:
    /// [`JointResponse::Report`].
    Aim(Option<JointAim>),
    /// Take both pressures from the host, by [`JointRequest::Press`], without a model: for a
    /// recording. Both begin at 0 bar. Refused where nothing has armed the board.
    Service,
    /// Sets both pressures from the next tick on, as fast as soft start and slew rate allow: first
    /// that of the muscle that turns the joint to larger angles. Unit: bar. It is a sign of life
    /// unless it is refused: in other states than service, and above what the board allows.
    /// Answer: [`JointResponse::Report`].
    Press([f32; 2]),
    /// Take these limits and lines of the sensors, as a whole, and keep them without power; refused
    /// as a configuration is. `None` only asks. Answer: [`JointResponse::Settings`].
    Settings(Option<JointSettings>),
    /// Which joint do you have? Answer: [`JointResponse::Installed`].
    Installed,
    /// What is this joint, with its controller? Answer: [`JointResponse::Control`], or
    /// [`Refusal::NotHere`] where what the board has kept is not the joint that it runs.
    Control,
    /// How are you? Answer: [`JointResponse::Status`].
    Status,
}

/// Where a joint is to go.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointAim {
    /// What it is to do at last.
    pub target: JointTarget<f32>,
    /// By which tick of the board it is to have got there, along a straight line from what it is to
    /// do now. One that is over, or is the next: at once. A host that sends the target of some
    /// ticks ahead makes a smooth course of few messages.
    pub by_tick: u32,
}

/// From the board to the host.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
// As of the requests.
#[allow(clippy::large_enum_variant)]
pub enum JointResponse {
    /// Sent at the start of the board and on [`JointRequest::Identify`].
    Hello(JointHello),
    /// Done.
    Accepted,
    /// Not done, nothing changed.
    Refused(Refusal),
    /// The joint is in a state in which this has no place; nothing changed.
    WrongState(JointBoardState),
    /// The outcome of a tick.
    Tick(JointTickReply),
    /// The last tick.
    Report(JointReport),
    /// What the board is set to.
    Settings(JointSettings),
    /// The [`fingerprint`](crate::fingerprint) of the joint that the board has, of
    /// [`JointConfiguration::control`]; none without one.
    Installed(Option<u32>),
    /// The raw parameters of the joint that the board has, as a host has sent them; none without
    /// one.
    Control(Option<BoardJointParameters>),
    /// What the board reads of itself.
    Status(JointStatus),
}

/// Who a board is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointHello {
    /// Version of the messages, [`JOINT_VERSION`].
    pub version: u16,
    /// Version of the firmware: major, minor, patch.
    pub firmware: [u16; 3],
    /// The board's state.
    pub state: JointBoardState,
    /// The fault that is latched.
    pub fault: Option<JointFault>,
    /// ADC code of either pressure in bar.
    pub pressures: [Scaling; 2],
    /// ADC code of the angle in rad.
    pub angle: Scaling,
    /// DAC code of either command in bar.
    pub command: Scaling,
    /// Ticks since the board started.
    pub ticks: u32,
}

/// A joint with its controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointConfiguration {
    /// Version of the messages, [`JOINT_VERSION`].
    pub version: u16,
    /// The controller's raw parameters; the board validates them.
    pub control: BoardJointParameters,
}

/// The state of a board with a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum JointBoardState {
    /// Vented, without a joint.
    #[default]
    Off,
    /// Vented, with a joint.
    Ready,
    /// Both muscles are filled, and the joint is tried.
    Starting,
    /// The controller drives both valves.
    Tracking,
    /// Both vented by a fault, which is latched until it is acknowledged.
    Fault,
    /// The host drives both valves by pressures, without a controller.
    Service,
}

impl JointBoardState {
    /// Whether a valve may be open.
    pub const fn is_driven(self) -> bool {
        matches!(self, Self::Starting | Self::Tracking | Self::Service)
    }
}

/// The samples of one tick: what the board's ADC would have read.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointTickRequest {
    /// What the joint is to do; `None` leaves it at what it was told last. Looked at while
    /// tracking.
    pub target: Option<JointTarget<f32>>,
    /// Of both pressures, of the muscle that turns the joint to larger angles first. Unit: ADC
    /// code.
    pub pressure_codes: [u16; 2],
    /// Of the angle. Unit: ADC code.
    pub angle_code: u16,
}

/// The outcome of one tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointTickReply {
    /// What the board wrote to both DACs. Unit: DAC code.
    pub dac_codes: [u16; 2],
    /// The board's state behind the tick.
    pub state: JointBoardState,
    /// The fault that is latched.
    pub fault: Option<JointFault>,
    /// The angle that was due. Unit: rad.
    pub due_rad: f32,
    /// The stiffness that was due. Unit: N m/rad.
    pub stiffness: f32,
    /// The torque that the feedback asked for. Unit: N m.
    pub feedback_nm: f32,
    /// A bound of a pressure, or a limit of a command, keeps the angle from being reached.
    pub is_limited: bool,
    /// The bounds of the pressures allow the stiffness.
    pub is_as_stiff: bool,
}

/// The last tick of a board whose ticks have a clock of their own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointReport {
    /// Ticks since the board started.
    pub ticks: u32,
    /// Of both pressures. Unit: ADC code.
    pub pressure_codes: [u16; 2],
    /// Of the angle. Unit: ADC code.
    pub angle_code: u16,
    /// Pressure before both valves. Unit: ADC code.
    pub supply_code: u16,
    /// Ticks that ended after their deadline, since the start.
    pub late_ticks: u32,
    /// What the start has found that does not vent, the first of it: the crystal that did not start
    /// ([`Fault::Clock`]), a brown-out reset that is off ([`Fault::BrownOut`]).
    pub noted: Option<Fault>,
    /// What came of them.
    pub tick: JointTickReply,
}

/// What a board reads of itself, beside its joint: at the last tick, and since its start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointStatus {
    /// The last tick.
    pub report: JointReport,
    /// Pressure before both valves. Unit: bar.
    pub supply_bar: f32,
    /// Of the processor. Unit: °C.
    pub temperature_c: f32,
    /// What both outputs are read back as; none on a board that does not read them back, or has no
    /// reference voltage. Unit: V.
    pub outputs_v: Option<[f32; 2]>,
    /// Supply of the converters; none on a board without a reference voltage. Unit: V.
    pub converters_supply_v: Option<f32>,
    /// What ticks have taken; none where they have no clock of their own.
    pub timing: Option<JointTiming>,
    /// Resets in a row, less than 10 s apart.
    pub resets: u32,
}

/// What the ticks of a board have taken since its start, from the moment that each was due.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointTiming {
    /// The longest. Unit: core clock cycle.
    pub worst_cycles: u32,
    /// Mean of the last some 256. Unit: core clock cycle.
    pub mean_cycles: u32,
    /// What a tick may take. Unit: core clock cycle.
    pub deadline_cycles: u32,
    /// Ticks that found the one before unfinished.
    pub overruns: u32,
}

/// One of the two muscles with its regulator and sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Channel {
    /// That turns the joint to larger angles.
    A,
    /// The other one.
    B,
}

impl Channel {
    /// Both, in the order of the messages.
    pub const BOTH: [Self; 2] = [Self::A, Self::B];
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::A => "a",
            Self::B => "b",
        })
    }
}
