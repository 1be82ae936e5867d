//! What only the pair shows: an angle that stands still while both pressures would turn the joint,
//! and a feedback that has to do more than it may.
//!
//! # Angle
//! One muscle's command tells what its sensor has to follow; at a joint either pressure alone says
//! nothing, since both rise together where the joint is to be stiffer. So two quantities have to
//! have moved since the angle stands still:
//!
//! | | quantity | by more than |
//! |---|---|---|
//! | tracking | the angle that is due | the swing that the stiffness is for |
//! | and | what both measured pressures turn with, and the torque that is known | what swings the joint so far where it is stiffest |
//! | service | one pressure less the other: either has to have been the higher one | `stuck_command_bar` |
//!
//! The first keeps a joint from being taken for stuck that holds its angle against a torque that
//! grows, the second one that a bound keeps from turning. A joint that something blocks shows the
//! same as a sensor that is stuck, and is vented, too. In service a joint may be at its end for as
//! long as the same muscle is the stronger one.
//!
//! # Feedback
//! It may put no more than `authority_bar` on either pressure for good, as that of one muscle; and
//! where a bound of the pressures keeps back what it asks for, the joint may not stand off what is
//! due by more than 0.15 of its range.
//!
//! # Limits
//! A sensor that is stuck while the joint is to stay where it is shows by the authority alone.

use model_core::joint::JointCommand;
use wire::Protection;
use wire::joint::{BoardJointControl, JointFault};

use super::watch::Measured;
use crate::monitors::authority::Authority;
use crate::monitors::stuck::Stuck;

/// How far a joint may stand off what is due, for good, while a bound keeps its muscles from
/// turning it there, as a share of its range: what its start takes for another joint, too.
pub(super) const FARTHEST: f32 = 0.15;
/// How much of what a difference of pressures has to move by counts for either side: above a half,
/// so that both have to have been the stronger one, by four fifths as much as each other at least.
const SIDE: f32 = 0.55;

/// What a joint's model says of its motion.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    /// Half the swing that the stiffness is for. Unit: rad.
    swing: f32,
    /// What swings the joint so far where it is stiffest. Unit: N m.
    torque: f32,
    /// How far it may stand off for good. Unit: rad.
    farthest: f32,
}

impl Moved {
    /// Of a joint.
    pub fn new(control: &BoardJointControl) -> Self {
        let joint = control.joint();
        let (angles, swing) = (joint.angles(), joint.swing());
        Self { swing, torque: joint.stiffest() * swing, farthest: FARTHEST * (angles.max() - angles.min()) }
    }
}

/// The monitors of the pair with what they remember.
#[derive(Clone, Debug)]
pub struct Pair {
    /// Unit: bar.
    stuck_bar: f32,
    authority_bar: f32,
    /// Against the angle that is due and the torque.
    tracked: Stuck<f32, 2>,
    /// Against the difference of both pressures.
    served: Stuck<f32, 1>,
    authority: Authority,
}

impl Pair {
    /// Monitors with these limits.
    pub fn new(protection: &Protection) -> Self {
        Self {
            stuck_bar: protection.stuck_command_bar,
            authority_bar: protection.authority_bar,
            tracked: Stuck::default(),
            served: Stuck::default(),
            authority: Authority::default(),
        }
    }

    /// Takes a tick of service.
    ///
    /// # Errors
    /// The angle stands still.
    pub fn serve(&mut self, measured: &Measured) -> Result<(), JointFault> {
        let [a, b] = measured.pressures;
        let side = SIDE * self.stuck_bar;
        let stronger = (a - b).max(-side).min(side);
        self.served.take(measured.angle_code, [stronger], [self.stuck_bar], JointFault::AngleStuck)
    }

    /// Takes a tick of tracking: what the controller has made of it, and the torque from outside
    /// that is known (N m).
    ///
    /// # Errors
    /// The angle stands still, or the feedback contradicts the feed-forward.
    pub fn track(
        &mut self,
        control: &BoardJointControl,
        moved: &Moved,
        measured: &Measured,
        (command, load): (&JointCommand<f32>, f32),
    ) -> Result<(), JointFault> {
        let JointCommand { pressures, forward, withheld, due, .. } = *command;
        let is_beyond = pressures
            .iter()
            .zip(forward)
            .any(|(pressure, forward)| (pressure - forward).abs() > self.authority_bar);
        let is_withheld = withheld != 0.0 && (due - measured.angle).abs() > moved.farthest;
        let is_watched = self.authority_bar.is_finite();
        self.authority.take(is_watched && (is_beyond || is_withheld)).map_err(JointFault::OfBoard)?;
        if !self.stuck_bar.is_finite() {
            return Ok(());
        }
        let torque = control.joint().pull_of(measured.angle, measured.pressures) + load;
        let needed = [moved.swing, moved.torque];
        self.tracked.take(measured.angle_code, [due, torque], needed, JointFault::AngleStuck)
    }

    /// Forgets the past, with a start or a fault.
    pub fn restart(&mut self) {
        self.tracked = Stuck::default();
        self.served = Stuck::default();
        self.authority = Authority::default();
    }
}
