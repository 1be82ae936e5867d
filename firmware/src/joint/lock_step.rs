//! A joint's board whose samples come from a host, one tick at a time.

use wire::Protection;
use wire::joint::{
    BoardJointParameters, JointAim, JointRequest, JointResponse, JointTickReply, JointTickRequest,
};

use super::{JointBoard, JointNode, JointSamples, JointTask, carry_out};
use crate::board::{AcquisitionError, AdcCode, DacCode};
use crate::lock_step::AROUND;
use crate::store::{JointParameters, SaveError, Set};

/// Samples in.
#[derive(Debug)]
struct Samples(JointSamples);

impl JointBoard for Samples {
    fn read(&mut self) -> Result<JointSamples, AcquisitionError> {
        Ok(self.0)
    }

    fn drive(&mut self, _: [DacCode; 2]) {}
}

/// Before the first: what a simulation has no part in is as it should be.
const QUIET: JointSamples = JointSamples {
    pressures: [AdcCode(0); 2],
    angle: AdcCode(0),
    supply: AROUND.supply,
    temperature: AROUND.temperature,
    outputs: None,
    reference: None,
};

/// A task with the samples that a host lays in.
#[derive(Debug)]
pub struct LockStepJoint {
    task: JointTask,
    samples: Samples,
    /// What it was given, until power is lost.
    parameters: JointParameters,
}

impl LockStepJoint {
    /// A task without a joint.
    pub fn new(protection: Protection) -> Self {
        Self { task: JointTask::new(protection), samples: Samples(QUIET), parameters: JointParameters::NEW }
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
            other => carry_out(self, other),
        }
    }

    /// Lays the samples of the next tick in, and gives the task its target, if it comes with them.
    pub fn feed(&mut self, request: &JointTickRequest) {
        let JointTickRequest { target, pressure_codes, angle_code } = *request;
        self.samples.0 =
            JointSamples { pressures: pressure_codes.map(AdcCode), angle: AdcCode(angle_code), ..QUIET };
        if let Some(target) = target {
            self.task.aim(JointAim { target, by_tick: 0 });
        }
    }

    /// The tick on what was laid in.
    pub fn tick(&mut self) -> JointTickReply {
        self.task.tick(&mut self.samples);
        self.task.reply()
    }
}

impl JointNode for LockStepJoint {
    fn task<R>(&mut self, work: impl FnOnce(&mut JointTask) -> R) -> R {
        work(&mut self.task)
    }

    /// There is no store.
    fn keep(&mut self, request: &JointRequest) -> Result<(), SaveError> {
        if let Some(changed) = self.parameters.changed_by(request) {
            self.parameters = changed;
        }
        Ok(())
    }

    fn control(&self) -> Option<&BoardJointParameters> {
        self.parameters.control.as_ref()
    }
}
