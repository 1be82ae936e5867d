//! The parts of an excitation: what each is for, and how it is drawn.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use recording::course::Course;

/// A part of an excitation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// Two swings over the whole range.
    Begin,
    /// Slow triangles of falling height.
    SlowLoops,
    /// Slowly to the highest command, and a hold there.
    Top,
    /// Small steps, ever larger.
    SmallSteps,
    /// One swing at several speeds.
    Speeds,
    /// Jumps with short holds.
    Jumps,
    /// Jumps with long holds.
    LongHolds,
    /// The same swings, with rests to change the load in.
    Loads,
    /// Random ramps.
    Ramps,
    /// The first swings again, a rest, and again.
    Again,
}

impl Part {
    /// All of them, in the order in which they are played.
    pub const ALL: [Self; 10] = [
        Self::Begin,
        Self::SlowLoops,
        Self::Top,
        Self::SmallSteps,
        Self::Speeds,
        Self::Jumps,
        Self::LongHolds,
        Self::Loads,
        Self::Ramps,
        Self::Again,
    ];

    /// Whether every excitation has it.
    pub fn is_always(self) -> bool {
        matches!(self, Self::Begin | Self::SlowLoops)
    }

    /// What it is for.
    pub fn purpose(self) -> &'static str {
        match self {
            Self::Begin => "two swings over the whole range: the loop itself, and what the first cycles do",
            Self::SlowLoops => "slow triangles of falling height: the loop without any effect of speed",
            Self::Top => {
                "slowly to the highest command, and a hold: where the pressure stays behind, the supply ends"
            }
            Self::SmallSteps => {
                "steps that grow from 0.1 % of the range: those that nothing follows are in the dead band"
            }
            Self::Speeds => {
                "one swing at several speeds: what grows with the speed, and whether it shifts, widens or rings"
            }
            Self::Jumps => {
                "jumps with short holds: a delay leaves all still, a lag begins at once, a mass overshoots"
            }
            Self::LongHolds => "long holds: what still moves is creep, drift or a tone",
            Self::Loads => "the same swings three times: change the load in the rests between",
            Self::Ramps => "random ramps: no period that a tone could hide in, and data to try a model on",
            Self::Again => {
                "the first swings again, a rest, and again: what went on in the rest goes with time, else with travel"
            }
        }
    }

    /// Draws it, from the lowest command and back to it. Slow pieces and holds are `stretch` times as long as they would be.
    pub fn draw(self, course: &mut Course, stretch: f64, random: &mut ChaCha8Rng) {
        let slow = |seconds: f64| seconds * stretch;
        match self {
            Self::Begin => {
                course.hold(1.0);
                whole_swings(course, stretch);
            }
            Self::SlowLoops => {
                for (height, half_s) in [(1.0, 6.0), (0.7, 5.0), (0.45, 4.0), (0.2, 3.0)] {
                    course.swing(0.0, height, slow(half_s));
                }
            }
            Self::Top => {
                course.ramp(0.75, 1.0);
                course.ramp(1.0, slow(4.0));
                course.hold(slow(2.0));
                course.ramp(0.0, 1.0);
            }
            Self::SmallSteps => {
                course.ramp(0.4, 2.0);
                for step in [0.001, 0.002, 0.005, 0.01, 0.02, 0.05] {
                    course.jump(0.4 + step, slow(1.2));
                    course.jump(0.4, slow(1.2));
                }
                course.ramp(0.0, 2.0);
            }
            Self::Speeds => {
                course.ramp(0.1, 1.0);
                for half_s in [slow(4.0), 1.5, 0.6, 0.3] {
                    for _ in 0..3 {
                        course.swing(0.1, 0.9, half_s);
                    }
                    course.hold(1.5);
                }
                course.ramp(0.0, 1.0);
            }
            Self::Jumps => {
                for level in [0.5, 0.9, 0.3, 0.7, 0.1, 0.6, 0.4, 0.0] {
                    course.jump(level, slow(2.5));
                }
            }
            Self::LongHolds => {
                for (level, hold_s) in [(0.7, 20.0), (0.3, 15.0), (0.9, 10.0), (0.0, 10.0)] {
                    course.jump(level, slow(hold_s));
                }
            }
            Self::Loads => {
                for _ in 0..3 {
                    whole_swings(course, stretch);
                    course.ramp(0.4, 1.0);
                    course.hold(3.0);
                    course.ramp(0.0, 1.0);
                    course.hold(slow(10.0));
                }
            }
            Self::Ramps => {
                for _ in 0..12 {
                    course.ramp(random.random_range(0.0..1.0), random.random_range(0.5..2.5));
                }
                course.ramp(0.0, 1.0);
            }
            Self::Again => {
                whole_swings(course, stretch);
                course.hold(slow(20.0));
                whole_swings(course, stretch);
            }
        }
    }
}

/// Two swings over the whole range, alike wherever they stand.
fn whole_swings(course: &mut Course, stretch: f64) {
    for _ in 0..2 {
        course.swing(0.0, 1.0, 3.0 * stretch);
    }
}
