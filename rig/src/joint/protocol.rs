//! What a joint is recorded with: both commands as what they have in common and what they differ
//! by, and a torque from outside.
//!
//! It begins with a full swing, which the friction's memory of what was before does not survive;
//! until it is over rows do not count. Then come triangles of falling height at five levels of the
//! common pressure, small swings at three angles of each, random ramps of both, and weights at the
//! joint: without a known torque a recording does not tell how strong a joint is.

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
        let mut draw = Draw::new(seed, Stream::Protocol);
        let mut legs = Legs::default();
        let first = LEVELS_BAR[1];
        legs.to(first, 0.0, 0.0, 2.0);
        for share in [1.0, -1.0, 0.0] {
            legs.to(first, share * SWING, 0.0, 3.0);
        }
        let counts_from_s = legs.common.duration_s();
        for level in LEVELS_BAR {
            legs.to(level, 0.0, 0.0, 2.0);
            for share in
                [1.0, 0.5, 0.75, -1.0, -0.4, -0.65, 0.7, 0.4, 0.55, -0.5, -0.2, -0.35, 0.2, -0.1, 0.0]
            {
                legs.to(level, share * SWING, 0.0, 2.0);
            }
            for middle in [0.6, 0.0, -0.6] {
                legs.to(level, middle * SWING, 0.0, 2.0);
                for share in [SMALL, -SMALL, SMALL, -SMALL] {
                    legs.to(level, (middle + share) * SWING, 0.0, 1.0);
                }
            }
        }
        for _ in 0..24 {
            let level = draw.uniform(LEVELS_BAR[0], LEVELS_BAR[4]);
            legs.to(level, draw.uniform(-SWING, SWING), 0.0, draw.uniform(1.0, 3.0));
        }
        for (level, weight_nm) in
            [2.6, 3.6, 4.6].into_iter().flat_map(|level| [(level, WEIGHT_NM), (level, -WEIGHT_NM)])
        {
            legs.to(level, 0.0, weight_nm, 2.0);
            for share in [0.7, -0.7, 0.4, 0.0] {
                legs.to(level, share * SWING, weight_nm, 2.0);
            }
        }
        legs.to(first, 0.0, 0.0, 2.0);
        let Legs { common, difference, load } = legs;
        Self { common, difference, load, counts_from_s }
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
    /// Goes to a common pressure (bar), a difference as a share of it and a load (N m) in so long.
    fn to(&mut self, common_bar: f64, share: f64, load_nm: f64, duration_s: f64) {
        let go = |course: &mut Protocol, value: f64| *course = course.clone().ramp(value, duration_s);
        go(&mut self.common, common_bar);
        go(&mut self.difference, share * common_bar);
        go(&mut self.load, load_nm);
    }
}
