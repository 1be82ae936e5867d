//! The start of a joint, which its board does by itself ([`JointRequest::Start`]): filled, tried
//! with a small motion, swung through its range, all without feedback. What is wrong with it the
//! board says by a fault.

use std::f64::consts::PI;

use wire::joint::{JointBoardState, JointRequest};

use super::{JointBoard, JointPlant, JointWanted, Loop, demand};
use crate::pil::PilError;

/// How long the way to the first point takes: as long as a swing of the start. Unit: s.
pub(super) const APPROACH_S: f64 = 4.0;
/// A start takes 10 s; a board that has not started after six times that never does. Unit: s.
pub(super) const LONGEST_S: f64 = 60.0;

impl<B: JointBoard, P: JointPlant> Loop<'_, B, P> {
    /// Starts the joint at the stiffness that is wanted first, under the torque that is known then.
    ///
    /// # Errors
    /// The joint is not that of the model ([`PilError::Joint`]), or board or plant do not answer as
    /// they should.
    pub fn start(&mut self, first: &JointWanted) -> Result<(), PilError> {
        demand(self.board, &JointRequest::Arm)?;
        demand(self.board, &JointRequest::Start(first.stiffness as f32))?;
        let wanted = JointWanted { angle_deg: self.due_deg, ..*first };
        let most = (LONGEST_S / self.period_s) as u64;
        for _ in 0..most {
            if self.tick(&wanted)?.reply.state == JointBoardState::Tracking {
                return Ok(());
            }
        }
        Err(PilError::OutOfTurn)
    }

    /// Goes from where it is to what is wanted first, with feedback, within 4 s.
    ///
    /// # Errors
    /// Board or plant do not answer as they should.
    pub fn approach(&mut self, first: &JointWanted) -> Result<(), PilError> {
        let from = self.due_deg;
        let ticks = (APPROACH_S / self.period_s).round() as u64;
        for tick in 1..=ticks {
            let angle_deg = approach(from, first.angle_deg, tick as f64 / ticks as f64);
            self.tick(&JointWanted { angle_deg, ..*first })?;
        }
        Ok(())
    }
}

/// Where on the way from one angle to another a joint is to be after this share of the time.
pub(super) fn approach(from: f64, to: f64, time: f64) -> f64 {
    // Half of it is on the way, without a kick at either end; the rest is to settle.
    let way = (2.0 * time).min(1.0);
    from + (0.5 - 0.5 * (PI * way).cos()) * (to - from)
}
