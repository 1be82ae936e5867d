//! What a board with a joint keeps.

use serde::{Deserialize, Serialize};
use wire::Protection;
use wire::joint::{BoardJointParameters, JointCalibration, JointRequest, JointSettings};

use super::LoadError;
use super::sealed::Sealed;
use super::set::{Set, whole};

/// Number of the layout that is written: the first one of a joint.
pub const JOINT_LAYOUT: u16 = 0x0101;

/// A set of parameters of a joint, saved and loaded as a whole. Raw: validated each time that it is
/// taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointParameters {
    /// Limits of the plant.
    pub protection: Protection,
    /// What the sensors have shown; none before that.
    pub calibration: Option<Sealed<JointCalibration>>,
    /// Both muscles, geometry, gains and limits, as a host has configured them; none before that.
    pub control: Option<BoardJointParameters>,
}

impl JointParameters {
    /// The set after a request that the board has accepted; `None` if it leaves the set as it was.
    pub fn changed_by(&self, request: &JointRequest) -> Option<Self> {
        match request {
            JointRequest::Settings(Some(JointSettings { protection, calibration })) => Some(Self {
                protection: *protection,
                calibration: Some(Sealed::new(*calibration)),
                control: self.control.clone(),
            }),
            JointRequest::Configure(configuration) => {
                Some(Self { control: Some(configuration.control.clone()), ..*self })
            }
            _ => None,
        }
    }
}

impl Set for JointParameters {
    const LAYOUT: u16 = JOINT_LAYOUT;
    /// No joint, since one of other muscles would drive these wrongly.
    const NEW: Self = Self { protection: Protection::STANDARD, calibration: None, control: None };

    fn of_layout(layout: u16, bytes: &[u8]) -> Result<Self, LoadError> {
        match layout {
            JOINT_LAYOUT => whole(bytes),
            other => Err(LoadError::Layout(other)),
        }
    }
}
