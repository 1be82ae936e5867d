//! Names, hashes and definitions of the messages, as ROS 2 publishes them.

use crate::messages::{DiagnosticArray, FluidPressure, JointState, JointTrajectory, Trigger};

/// What a definition says of `std_msgs/Header`, and of what is in it.
macro_rules! header {
    () => {
        "================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"
    };
}

/// A type of ROS 2.
pub trait Named {
    /// As people write it: package, kind, name.
    const TYPE: &'static str;
    /// On the network, with what DDS puts in.
    const DDS_TYPE: &'static str;
    /// The hash of its description (REP 2016).
    const HASH: &'static str;
}

/// A type of messages.
pub trait Message: Named {
    /// Its definition, and those of the types in it, as bags hold them (`ros2msg`).
    const DEFINITION: &'static str;
}

impl Named for JointState {
    const TYPE: &'static str = "sensor_msgs/msg/JointState";
    const DDS_TYPE: &'static str = "sensor_msgs::msg::dds_::JointState_";
    const HASH: &'static str = "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e";
}

impl Message for JointState {
    const DEFINITION: &'static str = concat!(
        "std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
",
        header!()
    );
}

impl Named for JointTrajectory {
    const TYPE: &'static str = "trajectory_msgs/msg/JointTrajectory";
    const DDS_TYPE: &'static str = "trajectory_msgs::msg::dds_::JointTrajectory_";
    const HASH: &'static str = "RIHS01_179b33eba59d676f6d967ac71fe35e7ca2f64b2f3928f4a018cec115e213796e";
}

impl Named for DiagnosticArray {
    const TYPE: &'static str = "diagnostic_msgs/msg/DiagnosticArray";
    const DDS_TYPE: &'static str = "diagnostic_msgs::msg::dds_::DiagnosticArray_";
    const HASH: &'static str = "RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e";
}

impl Message for DiagnosticArray {
    const DEFINITION: &'static str = concat!(
        "std_msgs/Header header
diagnostic_msgs/DiagnosticStatus[] status
",
        header!(),
        "================================================================================
MSG: diagnostic_msgs/DiagnosticStatus
byte OK=0
byte WARN=1
byte ERROR=2
byte STALE=3
byte level
string name
string message
string hardware_id
diagnostic_msgs/KeyValue[] values
================================================================================
MSG: diagnostic_msgs/KeyValue
string key
string value
"
    );
}

impl Named for FluidPressure {
    const TYPE: &'static str = "sensor_msgs/msg/FluidPressure";
    const DDS_TYPE: &'static str = "sensor_msgs::msg::dds_::FluidPressure_";
    const HASH: &'static str = "RIHS01_22dfb2b145a0bd5a31a1ac3882a1b32148b51d9b2f3bab250290d66f3595bc32";
}

impl Message for FluidPressure {
    const DEFINITION: &'static str = concat!(
        "std_msgs/Header header
float64 fluid_pressure
float64 variance
",
        header!()
    );
}

impl Named for Trigger {
    const TYPE: &'static str = "std_srvs/srv/Trigger";
    const DDS_TYPE: &'static str = "std_srvs::srv::dds_::Trigger_";
    const HASH: &'static str = "RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f";
}
