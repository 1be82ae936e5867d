//! The start of a joint, which its board does by itself ([`JointRequest::Start`]): filled, tried
//! with a small motion, swung through its range, all without feedback. What is wrong with it the
//! board says by a fault.

use std::f64::consts::PI;

use wire::joint::{JointBoardState, JointRequest};

use super::{JointBoard, JointPlant, JointWanted, Loop, demand};
use crate::pil::PilError;

/// How long the way to the first point takes: as long as a swing of the start. Unit: s.
const APPROACH_S: f64 = 4.0;
/// A start takes 10 s; a board that has not started after six times that never does. Unit: s.
const LONGEST_S: f64 = 60.0;

impl<B: JointBoard, P: JointPlant> Loop<'_, B, P> {
    /// Starts the joint at a stiffness (N m/rad).
    ///
    /// # Errors
    /// The joint is not that of the model ([`PilError::Joint`]), or board or plant do not answer as
    /// they should.
    pub fn start(&mut self, stiffness: f64) -> Result<(), PilError> {
        demand(self.board, &JointRequest::Arm)?;
        demand(self.board, &JointRequest::Start(stiffness as f32))?;
        let wanted = JointWanted { angle_deg: self.due_deg, stiffness };
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
            // Half of it is on the way, without a kick at either end; the rest is to settle.
            let way = (2.0 * tick as f64 / ticks as f64).min(1.0);
            let share = 0.5 - 0.5 * (PI * way).cos();
            let angle_deg = from + share * (first.angle_deg - from);
            self.tick(&JointWanted { angle_deg, ..*first })?;
        }
        Ok(())
    }
}
