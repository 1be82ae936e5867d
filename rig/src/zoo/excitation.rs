//! Experiments: what is commanded, by the seed, for a stated time.

use std::f64::consts::TAU;

use crate::draw::Draw;
use crate::protocol::Protocol;

/// Which experiment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Excitation {
    /// Triangles of many heights and speeds.
    Triangles,
    /// Jumps and short ramps with holds.
    Stairs,
    /// A sum of sines.
    Multisine,
    /// Ramps to random pressures in random times.
    Ramps,
    /// Triangles of many heights at one rate of pressure.
    OneSpeed,
    /// The same cycle of ramps and holds, nearly.
    Production,
    /// Some of everything.
    Mix,
}

impl Excitation {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Triangles,
        Self::Stairs,
        Self::Multisine,
        Self::Ramps,
        Self::OneSpeed,
        Self::Production,
        Self::Mix,
    ];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Triangles => "triangles",
            Self::Stairs => "stairs",
            Self::Multisine => "multisine",
            Self::Ramps => "ramps",
            Self::OneSpeed => "one_speed",
            Self::Production => "production",
            Self::Mix => "mix",
        }
    }

    /// One for the seed: a mix as often as three others together.
    pub(crate) fn drawn(draw: &mut Draw) -> Self {
        Self::ALL[draw.index(9).min(6)]
    }

    /// A command of at least `duration_s` from 0 bar to `range_bar`.
    pub(crate) fn protocol(self, draw: &mut Draw, range_bar: f64, duration_s: f64) -> Protocol {
        self.added(Protocol::vented(), draw, range_bar, duration_s)
    }

    fn added(self, mut protocol: Protocol, draw: &mut Draw, range_bar: f64, until_s: f64) -> Protocol {
        let from_s = protocol.duration_s();
        match self {
            Self::Triangles => {
                while protocol.duration_s() < until_s {
                    let (half_s, repeats) = (draw.log_uniform(0.5, 10.0), 1 + draw.index(3));
                    let (low, high) = levels(draw, range_bar);
                    for _ in 0..repeats {
                        protocol = protocol.ramp(high, half_s).ramp(low, half_s);
                    }
                }
            }
            Self::Stairs => {
                let ramp_s = [0.0, 0.3][draw.index(2)];
                while protocol.duration_s() < until_s {
                    let level = draw.uniform(0.0, range_bar);
                    protocol = protocol.ramp(level, ramp_s).hold(draw.log_uniform(2.0, 15.0));
                }
            }
            Self::Multisine => protocol = multisine(protocol, draw, range_bar, until_s),
            Self::Ramps => {
                while protocol.duration_s() < until_s {
                    protocol = protocol.ramp(draw.uniform(0.0, range_bar), draw.log_uniform(0.4, 5.0));
                }
            }
            Self::OneSpeed => {
                let rate = draw.log_uniform(0.4, 4.0);
                let mut at = 0.0;
                while protocol.duration_s() < until_s {
                    let (low, high) = levels(draw, range_bar);
                    protocol = protocol.ramp(high, (high - at) / rate).ramp(low, (high - low) / rate);
                    at = low;
                }
            }
            Self::Production => {
                let (low, high) = (draw.uniform(0.0, 0.5), draw.uniform(0.7, 1.0) * range_bar);
                let [rise_s, up_s, fall_s, down_s] =
                    [(0.3, 2.0), (0.5, 4.0), (0.3, 2.0), (0.5, 4.0)].map(|(a, b)| draw.log_uniform(a, b));
                while protocol.duration_s() < until_s {
                    let top = (high * draw.uniform(0.93, 1.07)).min(range_bar);
                    let pause_s = if draw.index(15) == 0 { draw.uniform(5.0, 20.0) } else { 0.0 };
                    protocol = protocol.ramp(top, rise_s).hold(up_s).ramp(low, fall_s).hold(down_s + pause_s);
                }
            }
            Self::Mix => {
                let mut parts =
                    [Self::Triangles, Self::Stairs, Self::Ramps, Self::Multisine, Self::Triangles];
                draw.shuffle(&mut parts);
                let part_s = (until_s - from_s) / parts.len() as f64;
                for (index, part) in parts.into_iter().enumerate() {
                    let until_s = from_s + part_s * (index + 1) as f64;
                    protocol = part.added(protocol, draw, range_bar, until_s);
                }
            }
        }
        protocol
    }
}

/// Two levels of a triangle, the upper one at least a tenth of the range above.
fn levels(draw: &mut Draw, range_bar: f64) -> (f64, f64) {
    if draw.index(3) == 0 {
        return (0.0, range_bar);
    }
    let low = draw.uniform(0.0, 0.7);
    (low * range_bar, draw.uniform(low + 0.1, 1.0) * range_bar)
}

/// Six to twelve sines of 0.02 to 1 Hz, sampled every 20 ms, scaled to the range.
fn multisine(mut protocol: Protocol, draw: &mut Draw, range_bar: f64, until_s: f64) -> Protocol {
    let count = 6 + draw.index(7);
    let highest_hz = draw.log_uniform(0.3, 1.5);
    let sines: Vec<_> = (0..count)
        .map(|_| (TAU * draw.log_uniform(0.02, highest_hz), draw.uniform(0.0, TAU), draw.uniform(0.4, 1.0)))
        .collect();
    let of =
        |time_s: f64| sines.iter().map(|(rate, phase, a)| a * (rate * time_s + phase).sin()).sum::<f64>();
    let from_s = protocol.duration_s() + 1.0;
    let instants = ((until_s - from_s).max(0.0) / 0.02).ceil() as usize + 1;
    let values: Vec<_> = (0..instants).map(|index| of(0.02 * index as f64)).collect();
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
    let scaled = |value: f64| range_bar * ((value - low) / (high - low).max(1e-9)).clamp(0.0, 1.0);
    protocol = protocol.ramp(scaled(values[0]), 1.0);
    for value in &values[1..] {
        protocol = protocol.ramp(scaled(*value), 0.02);
    }
    protocol
}
