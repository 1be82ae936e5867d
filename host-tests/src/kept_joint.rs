//! A board of a joint on the host that keeps its settings and its joint, as the image for a board
//! does: in a flash that outlives it.

use firmware::joint::lock_step::LockStepJoint;
use firmware::joint::{JointNode, JointTask, carry_out, recall};
use firmware::store::{JointParameters, ParameterStore, SaveError, Set};
use wire::Protection;
use wire::joint::{BoardJointParameters, JointRequest, JointResponse};

use crate::flash::MockFlash;

/// Unit: byte.
pub const SECTOR: usize = 4096;

/// A board of a joint with a flash.
pub struct KeptJoint {
    /// Its samples come from a host.
    pub board: LockStepJoint,
    store: ParameterStore<MockFlash<SECTOR>, JointParameters>,
    parameters: JointParameters,
}

impl KeptJoint {
    /// A board that starts with what stands in its flash.
    pub fn start(flash: MockFlash<SECTOR>) -> Self {
        let mut store = ParameterStore::new(flash);
        let mut board = LockStepJoint::new(Protection::STANDARD);
        let parameters = store.load().unwrap_or_else(|error| {
            JointNode::task(&mut board, |task| task.report_of_board(error.fault()));
            JointParameters::NEW
        });
        // As in the image: the next save tells whether it can be stored.
        let _ = store.save(board.task().state(), &parameters);
        let mut started = Self { board, store, parameters };
        let kept = started.parameters.clone();
        recall(&mut started, &kept);
        started
    }

    /// The same board behind a restart with power.
    pub fn restarted(self) -> Self {
        let mut flash = self.store.into_flash();
        flash.power_up();
        Self::start(flash)
    }

    /// Its flash.
    pub fn flash(&mut self) -> &mut MockFlash<SECTOR> {
        self.store.flash_mut()
    }

    /// What it would have kept.
    pub fn parameters(&self) -> &JointParameters {
        &self.parameters
    }

    /// Carries a request out, but no tick.
    pub fn answer(&mut self, request: &JointRequest) -> JointResponse {
        carry_out(self, request)
    }
}

impl JointNode for KeptJoint {
    fn task<R>(&mut self, work: impl FnOnce(&mut JointTask) -> R) -> R {
        JointNode::task(&mut self.board, work)
    }

    fn keep(&mut self, request: &JointRequest) -> Result<(), SaveError> {
        let Some(changed) = self.parameters.changed_by(request) else { return Ok(()) };
        self.parameters = changed;
        self.store.save(self.board.task().state(), &self.parameters)
    }

    fn control(&self) -> Option<&BoardJointParameters> {
        self.parameters.control.as_ref()
    }
}
