//! The messages, field by field as ROS 2 defines them.

use serde::{Deserialize, Serialize};

/// A moment since 1970: `builtin_interfaces/Time`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Time {
    /// Whole seconds, rounded down. Unit: s.
    pub sec: i32,
    /// Beyond them. Unit: ns.
    pub nanosec: u32,
}

impl Time {
    /// The nearest to so many seconds; beyond the years that fit, the last of them.
    pub fn of_s(seconds: f64) -> Self {
        let whole = seconds.floor();
        let nanosec = ((seconds - whole) * 1e9).round();
        if nanosec >= 1e9 {
            return Self { sec: (whole + 1.0) as i32, nanosec: 0 };
        }
        Self { sec: whole as i32, nanosec: nanosec as u32 }
    }

    /// Unit: s.
    pub fn s(self) -> f64 {
        f64::from(self.sec) + 1e-9 * f64::from(self.nanosec)
    }
}

/// `std_msgs/Header`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// When it was so.
    pub stamp: Time,
    /// In which frame of coordinates, or by which sensor; empty for joints.
    pub frame_id: String,
}

impl Header {
    /// At a moment since 1970. Unit: s.
    pub fn at_s(unix_s: f64) -> Self {
        Self { stamp: Time::of_s(unix_s), frame_id: String::new() }
    }
}

/// `sensor_msgs/JointState`: lists of one length, or empty ones.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JointState {
    /// When it was so.
    pub header: Header,
    /// Names of the joints.
    pub name: Vec<String>,
    /// Unit: m of a joint that moves straight.
    pub position: Vec<f64>,
    /// Unit: m/s.
    pub velocity: Vec<f64>,
    /// Unit: N.
    pub effort: Vec<f64>,
}

/// `trajectory_msgs/JointTrajectoryPoint`: lists of as many numbers as there are joints, or empty
/// ones.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JointTrajectoryPoint {
    /// Unit: m of a joint that moves straight.
    pub positions: Vec<f64>,
    /// Unit: m/s.
    pub velocities: Vec<f64>,
    /// Unit: m/s².
    pub accelerations: Vec<f64>,
    /// Unit: N.
    pub effort: Vec<f64>,
    /// Since the trajectory's start: `builtin_interfaces/Duration`, of the same two numbers.
    pub time_from_start: Time,
}

/// `trajectory_msgs/JointTrajectory`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JointTrajectory {
    /// When it starts; 0 for at once.
    pub header: Header,
    /// Names of the joints.
    pub joint_names: Vec<String>,
    /// Points, in the order of time.
    pub points: Vec<JointTrajectoryPoint>,
}

/// `sensor_msgs/FluidPressure`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FluidPressure {
    /// When it was so; the frame is the sensor's name.
    pub header: Header,
    /// Unit: Pa.
    pub fluid_pressure: f64,
    /// 0 where it is not known. Unit: Pa².
    pub variance: f64,
}

/// `diagnostic_msgs/KeyValue`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeyValue {
    /// What it is, with its unit.
    pub key: String,
    /// A number or words.
    pub value: String,
}

/// `diagnostic_msgs/DiagnosticStatus`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DiagnosticStatus {
    /// See the constants.
    pub level: u8,
    /// Of what.
    pub name: String,
    /// For people.
    pub message: String,
    /// Which piece of hardware.
    pub hardware_id: String,
    /// More of it.
    pub values: Vec<KeyValue>,
}

impl DiagnosticStatus {
    /// All is well.
    pub const OK: u8 = 0;
    /// Something to look at.
    pub const WARN: u8 = 1;
    /// It does not do its work.
    pub const ERROR: u8 = 2;
    /// Nothing has been heard of it for long.
    pub const STALE: u8 = 3;
}

/// `diagnostic_msgs/DiagnosticArray`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DiagnosticArray {
    /// When it was so.
    pub header: Header,
    /// A status a piece of hardware.
    pub status: Vec<DiagnosticStatus>,
}

/// The service `std_srvs/Trigger`: something is done when asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trigger;

/// What comes with the question: a byte, since a message of ROS 2 is never empty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TriggerRequest {
    /// Without a meaning.
    pub structure_needs_at_least_one_member: u8,
}

/// The answer.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TriggerResponse {
    /// Whether it was done.
    pub success: bool,
    /// For people.
    pub message: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_whole_seconds_rounded_down_and_nanoseconds() {
        assert_eq!(Time::of_s(1.25), Time { sec: 1, nanosec: 250_000_000 });
        assert_eq!(Time::of_s(-0.25), Time { sec: -1, nanosec: 750_000_000 });
        assert_eq!(Time::of_s(2.0 - 1e-12), Time { sec: 2, nanosec: 0 });
        assert!((Time::of_s(1.7e9 + 0.125).s() - (1.7e9 + 0.125)).abs() < 1e-6);
    }
}
