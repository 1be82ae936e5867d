//! Gives a board at its link what it keeps: its joint, and limits and lines of its sensors.

use wire::fingerprint;
use wire::joint::{BoardJointParameters, JOINT_VERSION, JointConfiguration, JointRequest, JointSettings};

use super::error::JointBoardError;
use super::link::JointLink;
use super::settings;

/// Gives a board its joint, and settings, if there are others than it has; then looks whether it
/// has and keeps them. Broken off, it has the joint of before or this one, and moves nothing.
///
/// # Errors
/// It does not answer, refuses, has another one behind that, or its flash has not kept it.
pub fn deploy(
    link: &mut JointLink,
    control: &BoardJointParameters,
    settings: Option<&JointSettings>,
) -> Result<(), JointBoardError> {
    if let Some(settings) = settings {
        settings::give(link, settings)?;
    }
    configure(link, control)?;
    if link.installed()? != Some(fingerprint(control)) {
        return Err(JointBoardError::NotInstalled);
    }
    if link.has_kept() { Ok(()) } else { Err(JointBoardError::NotStored) }
}

/// Gives a board its joint.
///
/// # Errors
/// It does not answer, or refuses.
pub(super) fn configure(link: &mut JointLink, control: &BoardJointParameters) -> Result<(), JointBoardError> {
    let configuration = JointConfiguration { version: JOINT_VERSION, control: control.clone() };
    link.order(&JointRequest::Configure(configuration), &[])
}
