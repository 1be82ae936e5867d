//! Messages between a host and a board that drives a joint: two muscles, each on a regulator of its
//! own, and an angle sensor. They have the frames of the other messages, and images of their own.

use core::fmt;

use model_core::joint::{JointControl, JointControlParameters, JointTarget};
use serde::{Deserialize, Serialize};

use crate::{Fault, Refusal, Scaling};

/// Version of these messages. Raised with every change that the other side would misread.
pub const JOINT_VERSION: u16 = 3;
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
    /// Take this joint. Refused while a valve is driven, and at fault.
    Configure(JointConfiguration),
    /// Be ready to start: a start is taken within the next [`crate::registers::ARMED_TICKS`], and
    /// not without.
    Arm,
    /// Fill both muscles, try the joint with a small motion and a swing, at this stiffness; then
    /// track. Unit: N m/rad.
    Start(f32),
    /// Vent both.
    Stop,
    /// The fault has been seen to.
    Acknowledge,
    /// The samples of one tick, for an emulated board. Answer: [`JointResponse::Tick`].
    Tick(JointTickRequest),
    /// Do this from the next tick on, for a board whose ticks have a clock of their own; a sign of
    /// life. `None` only asks, and is no sign of life. Answer: [`JointResponse::Report`].
    Aim(Option<JointTarget<f32>>),
}

/// From the board to the host.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    pub pressure: Scaling,
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
}

impl JointBoardState {
    /// Whether a valve may be open.
    pub const fn is_driven(self) -> bool {
        matches!(self, Self::Starting | Self::Tracking)
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

/// What vents a joint, both muscles at once. Its number is stable ([`Self::code`]).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum JointFault {
    /// Of one channel: a fault of its pressure sensor, its valve or its muscle.
    OfChannel(Channel, Fault),
    /// The angle sensor is open or short.
    AngleSensor,
    /// The angle jumps.
    AngleSpiking,
    /// Of the board as a whole.
    OfBoard(Fault),
    /// The test motion turned the joint the other way.
    WrongWay(Motion),
    /// It hardly turned it.
    Still(Motion),
    /// Each pressure follows the other one's command.
    Crossed,
    /// The swing turned it otherwise than the model's.
    Another(Motion),
}

/// What a motion of a joint has shown. Unit: rad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// From one end to the other, as asked for.
    pub asked: f32,
    /// The same, as it was.
    pub turned: f32,
    /// Where the joint stood from what was asked for, in the mean.
    pub offset: f32,
}

impl JointFault {
    /// The stable number: that of the board's table for a fault of the board, 100 more for one of
    /// channel a, 200 more for one of channel b; from 301 on those of the pair.
    pub const fn code(self) -> u16 {
        match self {
            Self::OfBoard(fault) => fault.code() as u16,
            Self::OfChannel(Channel::A, fault) => 100 + fault.code() as u16,
            Self::OfChannel(Channel::B, fault) => 200 + fault.code() as u16,
            Self::AngleSensor => 301,
            Self::AngleSpiking => 302,
            Self::WrongWay(_) => 303,
            Self::Still(_) => 304,
            Self::Crossed => 305,
            Self::Another(_) => 306,
        }
    }
}

impl fmt::Display for JointFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let title = |fault: Fault| {
            let row = crate::fault::table::TABLE.iter().find(|row| row.fault == fault);
            row.map_or("unknown", |row| row.title)
        };
        let code = self.code();
        match self {
            Self::OfChannel(channel, fault) => {
                write!(f, "fault {code}, channel {channel}: {}", title(*fault))
            }
            Self::OfBoard(fault) => write!(f, "fault {code}: {}", title(*fault)),
            Self::AngleSensor => write!(f, "fault {code}: angle sensor open or short"),
            Self::AngleSpiking => write!(f, "fault {code}: the angle jumps from sample to sample"),
            Self::WrongWay(motion) => write!(
                f,
                "fault {code}: the test motion of {:.1} degrees turned the joint by {:.1} degrees: it turns the \
                 wrong way; the angle sensor counts backwards, or both channels are swapped",
                motion.asked.to_degrees(),
                motion.turned.to_degrees()
            ),
            Self::Still(motion) => write!(
                f,
                "fault {code}: the test motion of {:.1} degrees turned the joint by {:.1} degrees only: is it \
                 blocked, the angle sensor unplugged, or a muscle without air?",
                motion.asked.to_degrees(),
                motion.turned.to_degrees()
            ),
            Self::Crossed => write!(
                f,
                "fault {code}: pressure_a_bar follows command_b_bar, and pressure_b_bar command_a_bar: the two \
                 pressure sensors, or the two regulators, are swapped"
            ),
            Self::Another(motion) => write!(
                f,
                "fault {code}: the joint turns by {:.1} degrees where its model turns by {:.1} degrees, and stands \
                 {:.1} degrees from it in the mean: the model is that of another joint, or of other muscles",
                motion.turned.to_degrees(),
                motion.asked.to_degrees(),
                motion.offset.to_degrees()
            ),
        }
    }
}

impl core::error::Error for JointFault {}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::format;
    use std::string::ToString;
    use std::vec::Vec;

    use super::*;

    #[test]
    fn every_fault_of_a_joint_has_a_number_of_its_own() {
        let still = Motion { asked: 1.0, turned: 0.0, offset: 0.0 };
        let mut codes: Vec<u16> =
            Fault::ALL.into_iter().map(|fault| JointFault::OfBoard(fault).code()).collect();
        for channel in Channel::BOTH {
            codes.extend(Fault::ALL.map(|fault| JointFault::OfChannel(channel, fault).code()));
        }
        let pair = [
            JointFault::AngleSensor,
            JointFault::AngleSpiking,
            JointFault::WrongWay(still),
            JointFault::Still(still),
            JointFault::Crossed,
            JointFault::Another(still),
        ];
        codes.extend(pair.map(JointFault::code));
        let all = codes.len();
        codes.sort_unstable();
        codes.dedup();
        assert_eq!(codes.len(), all);
        assert!(pair.iter().all(|fault| fault.to_string().starts_with(&format!("fault {}", fault.code()))));
    }
}
