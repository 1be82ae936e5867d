//! A joint's board whose samples come from a host, one tick at a time.

use wire::Protection;
use wire::joint::{JointRequest, JointResponse, JointTickReply, JointTickRequest};

use super::{JointBoard, JointOutcome, JointSamples, JointTask};
use crate::board::{AcquisitionError, AdcCode, DacCode};

/// Samples in.
#[derive(Debug, Default)]
struct Samples(JointSamples);

impl JointBoard for Samples {
    fn read(&mut self) -> Result<JointSamples, AcquisitionError> {
        Ok(self.0)
    }

    fn drive(&mut self, _: [DacCode; 2]) {}
}

/// A task with the samples that a host lays in.
#[derive(Debug)]
pub struct LockStepJoint {
    task: JointTask,
    samples: Samples,
}

impl LockStepJoint {
    /// A task without a joint.
    pub fn new(protection: Protection) -> Self {
        Self { task: JointTask::new(protection), samples: Samples::default() }
    }

    /// The task.
    pub fn task(&self) -> &JointTask {
        &self.task
    }

    /// Carries a request out, a tick too.
    pub fn answer(&mut self, request: &JointRequest) -> JointResponse {
        match request {
            JointRequest::Tick(request) => {
                self.feed(request);
                JointResponse::Tick(self.tick())
            }
            other => self.task.carry_out(other),
        }
    }

    /// Lays the samples of the next tick in, and gives the task its target, if it comes with them.
    pub fn feed(&mut self, request: &JointTickRequest) {
        let JointTickRequest { target, pressure_codes, angle_code } = *request;
        self.samples.0 = JointSamples { pressures: pressure_codes.map(AdcCode), angle: AdcCode(angle_code) };
        if let Some(target) = target {
            self.task.aim(target);
        }
    }

    /// The tick on what was laid in.
    pub fn tick(&mut self) -> JointTickReply {
        let JointOutcome { codes, command, is_limited } = self.task.tick(&mut self.samples);
        JointTickReply {
            dac_codes: codes.map(|code| code.0),
            state: self.task.state(),
            fault: self.task.fault(),
            due_rad: command.map_or(0.0, |command| command.due),
            stiffness: command.map_or(0.0, |command| command.stiffness),
            feedback_nm: command.map_or(0.0, |command| command.feedback),
            is_limited,
            is_as_stiff: command.is_none_or(|command| command.is_as_stiff),
        }
    }
}
