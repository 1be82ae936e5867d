//! What a joint is recorded with: both commands as what they have in common and what they differ
//! by, and a torque from outside.
//!
//! It begins with a full swing, which the friction's memory of what was before does not survive;
//! until it is over rows do not count. Then come triangles of falling height at five levels of the
//! common pressure, small swings at three angles of each, random ramps of both, and weights at the
//! joint: without a known torque a recording does not tell how strong a joint is. A real joint has
//! no weight that comes and goes: it is recorded once without and once with it
//! ([`JointProtocol::without_weights`]).

use crate::draw::{Draw, Stream};
use crate::protocol::Protocol;

/// Levels of the common pressure, bar.
const LEVELS_BAR: [f64; 5] = [2.3, 2.9, 3.5, 4.2, 4.9];

/// Largest difference to the common pressure, as a share of it: some 25 degrees.
const SWING: f64 = 0.22;

/// Small swings as a share of the largest: some 3 degrees, of which a stiffness is told.
const SMALL: f64 = 0.12;

/// Torque of the weight, N m. Assumed: 1 kg at 0.4 m.
const WEIGHT_NM: f64 = 4.0;

/// Random ramps.
const RAMPS: usize = 24;

/// Between which commands a joint swings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointRange {
    /// Lowest command, bar.
    pub min_bar: f64,
    /// Highest command, bar.
    pub max_bar: f64,
    /// Largest difference to the common pressure, as a share of it.
    pub swing: f64,
}

impl JointRange {
    /// The levels of the common pressure at which the whole swing is within the range, bar; none
    /// where there are no two.
    fn levels_bar(&self) -> Option<[f64; 5]> {
        let Self { min_bar, max_bar, swing } = self;
        let (lowest, highest) = (min_bar / (1.0 - swing), max_bar / (1.0 + swing));
        (lowest < highest)
            .then(|| [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| lowest + share * (highest - lowest)))
    }
}

/// The commands and the load over time.
#[derive(Debug, Clone)]
pub struct JointProtocol {
    common: Protocol,
    difference: Protocol,
    load: Protocol,
    counts_from_s: f64,
}

impl JointProtocol {
    /// The protocol of a seed.
    pub fn new(seed: u64) -> Self {
        let mut legs = Legs::default();
        let counts_from_s = legs.begin(&LEVELS_BAR, SWING);
        legs.all_through(&LEVELS_BAR, SWING, seed);
        for (level, weight_nm) in
            [2.6, 3.6, 4.6].into_iter().flat_map(|level| [(level, WEIGHT_NM), (level, -WEIGHT_NM)])
        {
            legs.to(level, 0.0, weight_nm, 2.0);
            for share in [0.7, -0.7, 0.4, 0.0] {
                legs.to(level, share * SWING, weight_nm, 2.0);
            }
        }
        legs.to(LEVELS_BAR[1], 0.0, 0.0, 2.0);
        legs.protocol(counts_from_s)
    }

    /// The same within a range of commands and without weights, in so many seconds [as slow as the
    /// one with them]; none where no common pressure leaves room for the swing.
    pub fn without_weights(range: &JointRange, duration_s: Option<f64>) -> Option<Self> {
        let levels_bar = range.levels_bar()?;
        let mut legs = Legs::default();
        let counts_from_s = legs.begin(&levels_bar, range.swing);
        legs.all_through(&levels_bar, range.swing, 1);
        let protocol = legs.protocol(counts_from_s);
        let factor = duration_s.map_or(1.0, |duration_s| duration_s / protocol.duration_s());
        let Self { common, difference, load, counts_from_s } = protocol;
        let [common, difference, load] = [common, difference, load].map(|course| course.stretched(factor));
        Some(Self { common, difference, load, counts_from_s: factor * counts_from_s })
    }

    /// From when on rows count, s.
    pub fn counts_from_s(&self) -> f64 {
        self.counts_from_s
    }

    /// Its end, s.
    pub fn duration_s(&self) -> f64 {
        self.common.duration_s()
    }

    /// Whether a row at `time_s` counts.
    pub fn counts(&self, time_s: f64) -> bool {
        time_s >= self.counts_from_s
    }

    /// Both commands at `time_s`, bar.
    pub fn commands_bar(&self, time_s: f64) -> [f64; 2] {
        let (common, difference) = (self.common.at(time_s), self.difference.at(time_s));
        [common + difference, common - difference]
    }

    /// The torque from outside at `time_s`, N m.
    pub fn load_nm(&self, time_s: f64) -> f64 {
        self.load.at(time_s)
    }
}

/// Three courses with their waypoints at the same times.
struct Legs {
    common: Protocol,
    difference: Protocol,
    load: Protocol,
}

impl Default for Legs {
    fn default() -> Self {
        let none = Protocol::vented;
        Self { common: none(), difference: none(), load: none() }
    }
}

impl Legs {
    /// Fills both muscles and swings the joint through its range, which is not to count; when that
    /// is over, s.
    fn begin(&mut self, levels_bar: &[f64; 5], swing: f64) -> f64 {
        let first = levels_bar[1];
        self.to(first, 0.0, 0.0, 2.0);
        for share in [1.0, -1.0, 0.0] {
            self.to(first, share * swing, 0.0, 3.0);
        }
        self.common.duration_s()
    }

    /// Triangles and small swings at each level, then ramps of a seed between them.
    fn all_through(&mut self, levels_bar: &[f64; 5], swing: f64, seed: u64) {
        for level in *levels_bar {
            self.to(level, 0.0, 0.0, 2.0);
            for share in
                [1.0, 0.5, 0.75, -1.0, -0.4, -0.65, 0.7, 0.4, 0.55, -0.5, -0.2, -0.35, 0.2, -0.1, 0.0]
            {
                self.to(level, share * swing, 0.0, 2.0);
            }
            for middle in [0.6, 0.0, -0.6] {
                self.to(level, middle * swing, 0.0, 2.0);
                for share in [SMALL, -SMALL, SMALL, -SMALL] {
                    self.to(level, (middle + share) * swing, 0.0, 1.0);
                }
            }
        }
        let mut draw = Draw::new(seed, Stream::Protocol);
        for _ in 0..RAMPS {
            let level = draw.uniform(levels_bar[0], levels_bar[4]);
            self.to(level, draw.uniform(-swing, swing), 0.0, draw.uniform(1.0, 3.0));
        }
    }

    fn protocol(self, counts_from_s: f64) -> JointProtocol {
        let Self { common, difference, load } = self;
        JointProtocol { common, difference, load, counts_from_s }
    }

    /// Goes to a common pressure (bar), a difference as a share of it and a load (N m) in so long.
    fn to(&mut self, common_bar: f64, share: f64, load_nm: f64, duration_s: f64) {
        let go = |course: &mut Protocol, value: f64| *course = course.clone().ramp(value, duration_s);
        go(&mut self.common, common_bar);
        go(&mut self.difference, share * common_bar);
        go(&mut self.load, load_nm);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_keep_to_their_range_reach_both_ends_and_take_their_time() {
        let range = JointRange { min_bar: 1.5, max_bar: 5.0, swing: 0.2 };
        let protocol = JointProtocol::without_weights(&range, Some(100.0)).expect("room for a swing");
        assert!((protocol.duration_s() - 100.0).abs() < 1e-9, "{} s", protocol.duration_s());
        let commands = (0..=10_000).map(|step| f64::from(step) / 100.0);
        let counted: Vec<f64> =
            commands.filter(|at| protocol.counts(*at)).flat_map(|at| protocol.commands_bar(at)).collect();
        let (least, most) =
            counted.iter().fold((f64::MAX, f64::MIN), |(least, most), bar| (least.min(*bar), most.max(*bar)));
        assert!(
            (1.5..1.52).contains(&least) && (4.98..=5.0 + 1e-12).contains(&most),
            "{least} to {most} bar"
        );
        assert_eq!(protocol.load_nm(50.0), 0.0);
        let narrow = JointRange { min_bar: 4.0, max_bar: 5.0, swing: 0.2 };
        assert!(JointProtocol::without_weights(&narrow, None).is_none());
    }
}
