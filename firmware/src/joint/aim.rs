//! Where a joint is to be in each tick: straight lines between the targets of its host.
//!
//! A message takes milliseconds, and its target would be a step: the lead of the regulators makes a
//! spike of that, which the slew rate cuts off. So a host says by which tick its target is due.

use model_core::joint::JointTarget;
use wire::joint::JointAim;

/// What a joint is to do now, and at last.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aimed {
    now: JointTarget<f32>,
    aim: JointAim,
}

impl Aimed {
    /// This, and no change.
    pub(super) fn still(target: JointTarget<f32>) -> Self {
        Self { now: target, aim: JointAim { target, by_tick: 0 } }
    }

    /// Goes there from what it is to do now.
    pub(super) fn take(&mut self, aim: JointAim) {
        self.aim = aim;
    }

    /// The torque from outside that it is to reckon with at last. Unit: N m.
    pub(super) fn load(&self) -> f32 {
        self.aim.target.load
    }

    /// What it is to do in this tick; called once in each.
    pub(super) fn at(&mut self, tick: u32) -> JointTarget<f32> {
        let JointAim { target, by_tick } = self.aim;
        // As far as the counter of ticks goes half round, what is not ahead is over.
        let left = by_tick.wrapping_sub(tick).cast_signed();
        self.now = if left > 0 {
            // So that in `left` ticks more it is there: equal steps, whenever they began.
            let share = 1.0 / (left as f32 + 1.0);
            let toward = |from: f32, to: f32| from + share * (to - from);
            JointTarget {
                angle: toward(self.now.angle, target.angle),
                stiffness: toward(self.now.stiffness, target.stiffness),
                load: toward(self.now.load, target.load),
            }
        } else {
            target
        };
        self.now
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REST: JointTarget<f32> = JointTarget { angle: 0.0, stiffness: 40.0, load: 0.0 };
    const THERE: JointTarget<f32> = JointTarget { angle: 1.0, stiffness: 50.0, load: -2.0 };

    #[test]
    fn a_target_is_reached_in_its_tick_by_equal_steps_and_then_held() {
        for begin in [0, 1000, u32::MAX - 2] {
            let mut aimed = Aimed::still(REST);
            let tick = |ticks: u32| begin.wrapping_add(ticks);
            aimed.at(tick(0));
            aimed.take(JointAim { target: THERE, by_tick: tick(4) });
            for (ticks, share) in [(1, 0.25), (2, 0.5), (3, 0.75), (4, 1.0), (5, 1.0), (60_000, 1.0)] {
                let JointTarget { angle, stiffness, load } = aimed.at(tick(ticks));
                let found = [angle, (stiffness - 40.0) / 10.0, load / -2.0];
                assert!(
                    found.iter().all(|found| (found - share).abs() < 1e-6),
                    "{begin}, {ticks}: {found:?}"
                );
            }
        }
    }

    #[test]
    fn a_target_that_is_over_acts_at_once_and_a_later_one_goes_on_from_where_it_is() {
        let mut aimed = Aimed::still(REST);
        aimed.take(JointAim { target: THERE, by_tick: 7 });
        assert_eq!(aimed.at(1000), THERE);
        aimed.take(JointAim { target: REST, by_tick: 1010 });
        assert!((aimed.at(1001).angle - 0.9).abs() < 1e-6);
        aimed.take(JointAim { target: THERE, by_tick: 1002 });
        assert_eq!(aimed.at(1002), THERE);
    }
}
