//! The start of a joint: filled, tried with a small motion, swung through its range.
//!
//! All of it is without feedback: with the wrong sign that would drive a joint to its end. The
//! small motion tells whether the joint turns as it should, the pressures whether they follow their
//! own commands; the swing whether the joint is the model's, and leaves its friction in a state
//! that no longer depends on what was before.

use model_core::joint::JointTarget;
use wire::joint::{JointFault, Motion};

use super::pair::FARTHEST;
use super::watch::Measured;

/// For how long the muscles are filled. Unit: s.
const FILL_S: f32 = 2.0;
/// A whole swing. Unit: s.
const SWING_S: f32 = 4.0;
/// The small and the large swing, to either side, as shares of the range of angles.
const SMALL: f32 = 0.1;
const LARGE: f32 = 0.4;
/// Of what is asked for a joint turns at least this share in a small swing: friction takes some.
const LEAST: f32 = 0.3;
/// In a large one it turns between these shares.
const SHARES: (f32, f32) = (0.7, 1.4);

/// The start, tick by tick.
#[derive(Clone, Debug)]
pub struct Start {
    middle: f32,
    range: f32,
    stiffness: f32,
    period_s: f32,
    part: Part,
    /// Within the part.
    ticks: u32,
    seen: Seen,
}

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    Fill,
    Small,
    Large,
}

impl Part {
    const fn duration_s(self) -> f32 {
        match self {
            Self::Fill => FILL_S,
            Self::Small | Self::Large => SWING_S,
        }
    }

    const fn share(self) -> f32 {
        match self {
            Self::Fill => 0.0,
            Self::Small => SMALL,
            Self::Large => LARGE,
        }
    }
}

impl Start {
    /// A start within a range of angles (rad), at a stiffness (N m/rad).
    pub fn new((lowest, highest): (f32, f32), stiffness: f32, period_s: f32) -> Self {
        Self {
            middle: 0.5 * (lowest + highest),
            range: highest - lowest,
            stiffness,
            period_s,
            part: Part::Fill,
            ticks: 0,
            seen: Seen::default(),
        }
    }

    /// What the joint is to do in this tick.
    pub fn target(&self) -> JointTarget<f32> {
        let angle = self.middle + self.part.share() * self.range * wave(self.elapsed());
        JointTarget { angle, stiffness: self.stiffness, load: 0.0 }
    }

    /// Takes what was measured in the tick, and the commands (bar) that it led to; answers whether
    /// the joint has been tried, and is that of the model.
    ///
    /// # Errors
    /// It is not.
    pub fn take(&mut self, measured: &Measured, commands: [f32; 2]) -> Result<bool, JointFault> {
        let asked = self.target().angle - self.middle;
        self.seen.take(asked, measured.angle - self.middle, commands, measured.pressures);
        self.ticks = self.ticks.saturating_add(1);
        if self.elapsed() < 1.0 {
            return Ok(false);
        }
        let seen = core::mem::take(&mut self.seen);
        self.ticks = 0;
        match self.part {
            Part::Fill => self.part = Part::Small,
            Part::Small => {
                seen.is_as_wired(SMALL * self.range)?;
                self.part = Part::Large;
            }
            Part::Large => {
                seen.is_the_models(LARGE * self.range, self.range)?;
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Which share of the part is over.
    fn elapsed(&self) -> f32 {
        self.ticks as f32 * self.period_s / self.part.duration_s()
    }
}

/// A whole swing of two parabolas, from 0 by 1 and -1 back to 0, over a time of 1.
fn wave(time: f32) -> f32 {
    if time < 0.5 { 16.0 * time * (0.5 - time) } else { -16.0 * (time - 0.5) * (1.0 - time) }
}

/// What a swing has shown, in sums that need no list of it.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    /// Of what was asked for with itself, and with what was.
    asked: Together,
    turned: Together,
    /// Of each command and its pressure.
    pressures: [Together; 2],
}

impl Seen {
    fn take(&mut self, asked: f32, turned: f32, commands: [f32; 2], pressures: [f32; 2]) {
        self.asked.take(asked, asked);
        self.turned.take(asked, turned);
        for ((together, command), pressure) in self.pressures.iter_mut().zip(commands).zip(pressures) {
            together.take(command, pressure);
        }
    }

    /// Which share of what was asked for the joint has turned.
    fn share(&self) -> f32 {
        self.turned.sum / self.asked.sum
    }

    fn motion(&self, amplitude: f32) -> Motion {
        let asked = 2.0 * amplitude;
        let [_, offset] = self.turned.means;
        let [was_asked, _] = self.turned.means;
        Motion { asked, turned: self.share() * asked, offset: offset - was_asked }
    }

    fn is_as_wired(&self, amplitude: f32) -> Result<(), JointFault> {
        let motion = self.motion(amplitude);
        if self.pressures.iter().all(|together| together.sum < 0.0) {
            return Err(JointFault::Crossed);
        }
        if self.share() < -LEAST {
            return Err(JointFault::WrongWay(motion));
        }
        if self.share() >= LEAST { Ok(()) } else { Err(JointFault::Still(motion)) }
    }

    /// In the mean it is no farther from what was asked for than [`FARTHEST`].
    fn is_the_models(&self, amplitude: f32, range: f32) -> Result<(), JointFault> {
        let motion = self.motion(amplitude);
        let (least, most) = SHARES;
        let is_near = motion.offset.abs() <= FARTHEST * range;
        if is_near && self.share() >= least && self.share() <= most {
            Ok(())
        } else {
            Err(JointFault::Another(motion))
        }
    }
}

/// How two quantities go together: the sum of the products of what they differ from their means by,
/// and the means, all so far (Welford).
#[derive(Clone, Copy, Debug, Default)]
struct Together {
    count: f32,
    means: [f32; 2],
    sum: f32,
}

impl Together {
    fn take(&mut self, one: f32, other: f32) {
        self.count += 1.0;
        let [mean_one, mean_other] = &mut self.means;
        let from_before = one - *mean_one;
        *mean_one += from_before / self.count;
        *mean_other += (other - *mean_other) / self.count;
        self.sum += from_before * (other - *mean_other);
    }
}
