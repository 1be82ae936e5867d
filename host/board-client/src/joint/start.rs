//! The start of a joint: filled, tried with a small motion, swung through its range.
//!
//! All of it is without feedback: with the wrong sign that would drive a joint to its end. The
//! small motion tells whether the joint turns as it should, the pressures whether they follow their
//! own commands; the swing whether the joint is the model's, and leaves its friction in a state
//! that no longer depends on what was before.

use std::f64::consts::{PI, TAU};

use super::fault::JointFault;
use super::{JointPlant, JointSample, JointWanted, Loop};
use crate::pil::PilError;

/// For how long the muscles are filled. Unit: s.
const FILL_S: f64 = 2.0;
/// A whole swing. Unit: s.
const SWING_S: f64 = 4.0;
/// The small and the large swing, to either side, as shares of the range of angles.
const SMALL: f64 = 0.1;
const LARGE: f64 = 0.4;
/// Of what is asked for a joint turns at least this share in a small swing: friction takes some.
const LEAST: f64 = 0.3;
/// In a large one it turns between these shares.
const SHARES: (f64, f64) = (0.7, 1.4);
/// And is no farther from what is asked for in the mean, as a share of the range.
const FARTHEST: f64 = 0.15;

impl<P: JointPlant> Loop<'_, P> {
    /// Starts the joint at a stiffness (N m/rad).
    ///
    /// # Errors
    /// The joint is not that of the model ([`JointFault`]), or the plant does not answer.
    pub fn start(&mut self, stiffness: f64) -> Result<(), PilError> {
        let angles = self.control.joint().angles();
        let degrees = |angle: f32| f64::from(angle) * 180.0 / PI;
        let (lowest, highest) = (degrees(angles.min()), degrees(angles.max()));
        let (middle, range) = (0.5 * (lowest + highest), highest - lowest);
        self.swing(middle, 0.0, stiffness, FILL_S)?;
        let small = Swing::of(&self.swing(middle, SMALL * range, stiffness, SWING_S)?);
        if small.are_crossed {
            return Err(JointFault::Crossed.into());
        }
        let (asked_deg, turned_deg) = (small.asked_deg, small.asked_deg * small.share);
        if small.share < -LEAST {
            return Err(JointFault::WrongWay { asked_deg, turned_deg }.into());
        }
        if small.share < LEAST {
            return Err(JointFault::Still { asked_deg, turned_deg }.into());
        }
        let Swing { asked_deg, share, offset_deg, .. } =
            Swing::of(&self.swing(middle, LARGE * range, stiffness, SWING_S)?);
        let (least, most) = SHARES;
        if !(least..=most).contains(&share) || offset_deg.abs() > FARTHEST * range {
            let turned_deg = asked_deg * share;
            return Err(JointFault::Another { asked_deg, turned_deg, offset_deg }.into());
        }
        Ok(())
    }

    /// Goes from where it is to what is wanted first, with feedback, within `SWING_S`.
    ///
    /// # Errors
    /// The plant does not answer.
    pub fn approach(&mut self, first: &JointWanted) -> Result<(), PilError> {
        let from = f64::from(self.state.due()) * 180.0 / PI;
        let ticks = (SWING_S / self.period_s).round() as u64;
        for tick in 1..=ticks {
            // Half of it is on the way, without a kick at either end; the rest is to settle.
            let way = (2.0 * tick as f64 / ticks as f64).min(1.0);
            let share = 0.5 - 0.5 * (PI * way).cos();
            let angle_deg = from + share * (first.angle_deg - from);
            self.tick(&JointWanted { angle_deg, ..*first }, true)?;
        }
        Ok(())
    }

    /// Swings once around an angle by so much to either side (both degrees), without feedback.
    fn swing(
        &mut self,
        middle: f64,
        by: f64,
        stiffness: f64,
        duration_s: f64,
    ) -> Result<Vec<JointSample>, PilError> {
        let ticks = (duration_s / self.period_s).round() as u64;
        let angle = |tick: u64| middle + by * (TAU * tick as f64 / ticks as f64).sin();
        let wanted = |tick| JointWanted { angle_deg: angle(tick), stiffness };
        (0..ticks).map(|tick| self.tick(&wanted(tick), false)).collect()
    }
}

/// What a swing has shown.
struct Swing {
    /// From one end to the other. Unit: degrees.
    asked_deg: f64,
    /// Which share of that the joint has turned.
    share: f64,
    /// Where it was from what was asked for, in the mean. Unit: degrees.
    offset_deg: f64,
    /// Whether each pressure goes with the other one's command.
    are_crossed: bool,
}

impl Swing {
    fn of(samples: &[JointSample]) -> Self {
        let list = |of: &dyn Fn(&JointSample) -> f64| -> Vec<f64> { samples.iter().map(of).collect() };
        let (asked, turned) = (list(&|at| at.wanted.angle_deg), list(&|at| at.measured.angle_deg));
        let along = |a: &[f64], b: &[f64]| {
            let (mean_a, mean_b) = (mean(a), mean(b));
            a.iter().zip(b).map(|(a, b)| (a - mean_a) * (b - mean_b)).sum::<f64>()
        };
        let command = |muscle: usize| list(&move |at| f64::from(at.command.commands[muscle]));
        let pressure = |muscle: usize| list(&move |at| at.measured.pressures_bar[muscle]);
        let crossed = |muscle: usize| along(&pressure(muscle), &command(muscle)) < 0.0;
        let (low, high) =
            asked.iter().fold((f64::MAX, f64::MIN), |(low, high), angle| (low.min(*angle), high.max(*angle)));
        Self {
            asked_deg: high - low,
            share: along(&turned, &asked) / along(&asked, &asked),
            offset_deg: mean(&turned) - mean(&asked),
            are_crossed: crossed(0) && crossed(1),
        }
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
