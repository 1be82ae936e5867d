//! Whether a valve answers as one lag or as two: a pilot stage before the main one, or a controller
//! with an integral, makes it of second order.
//!
//! ```text
//! pressure = command / (1 + T s + q T² s²)
//! ```
//!
//! T is how far the pressure is behind a ramp, whatever the order; the share q is 0 for one lag,
//! 1/4 for two equal ones, and 1/2 where the answer to tones is as flat as it can be without a
//! resonance ([`FLAT`]). Slow movements show T alone, and a loop that is fast beside T swings by q:
//! a valve of q = 1/2 turns the phase by half a turn where one lag turns it by a quarter.
//!
//! So stretches of the recording are simulated with several shares, each with the T and the offset
//! and gain of the sensor that fit it best. What is not excluded is told: the shares whose squared
//! error is not larger than the least one by more than two standard errors of the difference, over
//! the stretches. Noise, rows that are far apart, and a command that never jumps exclude nothing.

use crate::numbers::{is_within_chance, range};

/// The largest share without a resonance: two poles of Butterworth's kind.
pub const FLAT: f64 = 0.5;
/// The shares that are tried; at the last one, of a damping ratio of 1/2, a jump overshoots by a
/// sixth.
const SHARES: [f64; 7] = [0.0, 0.06, 0.12, 0.25, FLAT, 0.75, 1.0];
/// Stretches, evenly over the recording, and the most rows of one.
const STRETCHES: usize = 12;
const MOST_ROWS: usize = 3000;
/// The beginning of a stretch, in which the simulated valve forgets where it began: of a jump less
/// than 2 % is left then, whatever the share. Unit: the longest T that is tried.
const FORGOTTEN: f64 = 8.0;
/// Fewest rows of a stretch that count.
const LEAST_ROWS: usize = 20;
/// The best T is looked for within this factor of the one that is known: a convention, far beyond
/// the 15 % by which they are expected to differ.
const FACTOR: f64 = 2.5;
/// How far apart the places are between which it is looked for, for the first share, and for the
/// next ones beside that of the one before. Unit: 1, of the logarithm.
const FIRST: [f64; 5] = [0.5, 0.3, 0.15, 0.05, 0.01];
const NEXT: [f64; 2] = [0.1, 0.01];

/// A valve that moves towards a command.
struct Valve {
    lag_s: f64,
    share: f64,
    /// Pressure less command, and the pressure's rate.
    off: f64,
    rate: f64,
    command: f64,
}

impl Valve {
    /// Holds a command for a time (s); the pressure then. Exact for any time.
    fn hold(&mut self, command: f64, dt_s: f64) -> f64 {
        let Self { lag_s, share, .. } = *self;
        let before = self.off + self.command - command;
        self.command = command;
        if share == 0.0 {
            self.off = before * (-dt_s / lag_s).exp();
            return command + self.off;
        }
        let damping = 0.5 / (share * lag_s);
        let natural = 1.0 / (share * lag_s * lag_s);
        let square = damping * damping - natural;
        // e^(-damping t) times cosh and sinh, or cos and sin, of the root of the square.
        let root = square.abs().sqrt();
        let (even, odd) = if root * dt_s < 1e-6 {
            let fallen = (-damping * dt_s).exp();
            (fallen, fallen * dt_s)
        } else if square > 0.0 {
            let (slow, fast) = (((root - damping) * dt_s).exp(), ((-root - damping) * dt_s).exp());
            (0.5 * (slow + fast), 0.5 * (slow - fast) / root)
        } else {
            let fallen = (-damping * dt_s).exp();
            (fallen * (root * dt_s).cos(), fallen * (root * dt_s).sin() / root)
        };
        let rate = self.rate;
        self.off = (even + damping * odd) * before + odd * rate;
        self.rate = (even - damping * odd) * rate - natural * odd * before;
        command + self.off
    }
}

/// A recording, a value a row.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a> {
    /// Unit: s.
    pub time_s: &'a [f64],
    /// Which rows count.
    pub scored: &'a [bool],
    /// Held since the row before.
    pub command: &'a [f64],
    /// As measured.
    pub pressure: &'a [f64],
}

impl Rows<'_> {
    /// Squared errors of each stretch with a lag and a share, behind what is forgotten (s).
    fn errors(&self, stretches: &[(usize, usize)], forgotten_s: f64, lag_s: f64, share: f64) -> Vec<f64> {
        let pairs = stretches.iter().map(|&(from, to)| {
            let (time_s, command) = (self.time_s, self.command);
            let off = self.pressure[from] - command[from];
            let mut valve = Valve { lag_s, share, off, rate: 0.0, command: command[from] };
            let counts_from_s = time_s[from] + forgotten_s;
            (from + 1..to)
                .filter_map(|row| {
                    let answer = valve.hold(command[row], time_s[row] - time_s[row - 1]);
                    (time_s[row] >= counts_from_s).then_some((answer, self.pressure[row]))
                })
                .collect::<Vec<_>>()
        });
        let pairs: Vec<Vec<(f64, f64)>> = pairs.collect();
        // The sensor's offset and gain.
        let all = || pairs.iter().flatten();
        let count = all().count().max(1) as f64;
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| all().map(of).sum::<f64>() / count;
        let (answer, measured) = (mean(&|pair| pair.0), mean(&|pair| pair.1));
        let spread = mean(&|pair| (pair.0 - answer).powi(2));
        let together = mean(&|pair| (pair.0 - answer) * (pair.1 - measured));
        let gain = if spread > 0.0 { together / spread } else { 1.0 };
        let of = |(simulated, seen): &(f64, f64)| (seen - measured - gain * (simulated - answer)).powi(2);
        pairs.iter().map(|stretch| stretch.iter().map(of).sum()).collect()
    }

    /// Where the stretches are.
    fn stretches(&self, lag_s: f64) -> Vec<(usize, usize)> {
        let rows = self.time_s.len();
        let of = |place: usize| place * rows / STRETCHES;
        let has_enough = |&(from, to): &(usize, usize)| {
            let counts_from_s = self.time_s[from] + FORGOTTEN * FACTOR * lag_s;
            self.time_s[from..to].iter().filter(|time_s| **time_s >= counts_from_s).count() >= LEAST_ROWS
                && !self.scored[from..to].contains(&false)
        };
        (0..STRETCHES)
            .map(|place| (of(place), of(place + 1).min(of(place) + MOST_ROWS)))
            .filter(|(from, to)| to > from)
            .filter(has_enough)
            .collect()
    }

    /// The least and the largest share q of a valve that is some T (s) behind a ramp, which the
    /// recording does not exclude; up to [`FLAT`] where nothing shows more.
    pub fn shares(&self, lag_s: f64) -> (f64, f64) {
        let open = (0.0, FLAT);
        let stretches = self.stretches(lag_s);
        let (low, high) = range(self.command);
        if lag_s <= 0.0 || stretches.len() < 2 || high <= low {
            return open;
        }
        let (mut log, mut apart, mut fitted) = (0.0, FIRST.as_slice(), Vec::new());
        for share in SHARES {
            let (best, errors) = self.fitted(&stretches, lag_s, share, (log, apart));
            (log, apart) = (best, &NEXT);
            fitted.push(errors);
        }
        let total = |errors: &[f64]| errors.iter().sum::<f64>();
        let Some(best) = (0..SHARES.len()).min_by(|a, b| total(&fitted[*a]).total_cmp(&total(&fitted[*b])))
        else {
            return open;
        };
        let is_open = |place: &usize| {
            let differences: Vec<f64> =
                fitted[*place].iter().zip(&fitted[best]).map(|(other, best)| other - best).collect();
            is_within_chance(&differences)
        };
        let left: Vec<f64> = (0..SHARES.len()).filter(is_open).map(|place| SHARES[place]).collect();
        // A resonance is assumed only where the recording rules out every valve without one.
        let believed = if left.iter().any(|share| *share <= FLAT) { FLAT } else { f64::INFINITY };
        let left = || left.iter().copied().filter(|share| *share <= believed);
        (left().fold(believed, f64::min), left().fold(0.0, f64::max))
    }

    /// The logarithm of T over the known one that fits a share best, near `from`, with the squared
    /// errors there: by parabolas through three places that come nearer to each other.
    fn fitted(
        &self,
        stretches: &[(usize, usize)],
        lag_s: f64,
        share: f64,
        (from, apart): (f64, &[f64]),
    ) -> (f64, Vec<f64>) {
        let forgotten_s = FORGOTTEN * FACTOR * lag_s;
        let at = |log: f64| self.errors(stretches, forgotten_s, lag_s * log.exp(), share);
        let total = |errors: &[f64]| errors.iter().sum::<f64>();
        let (mut log, mut there) = (from, at(from));
        for apart in apart {
            let [below, above] = [-apart, *apart].map(|by| total(&at(log + by)));
            let middle = total(&there);
            let bent = below + above - 2.0 * middle;
            let by = if bent > 0.0 { 0.5 * (below - above) / bent } else { (below - above).signum() };
            let next = (log + by.clamp(-1.0, 1.0) * apart).clamp(-FACTOR.ln(), FACTOR.ln());
            let errors = at(next);
            if total(&errors) < middle {
                (log, there) = (next, errors);
            }
        }
        (log, there)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A minute of a command that jumps, or moves slowly, behind a valve; with even noise.
    fn shares(share: f64, step_s: f64, noise: f64, jumps: bool) -> (f64, f64) {
        let rows = (60.0 / step_s) as usize;
        let time_s: Vec<f64> = (0..rows).map(|row| row as f64 * step_s).collect();
        let level = |time_s: f64| (2.3 * (time_s / 1.5).floor()).sin();
        let command: Vec<f64> = (time_s.iter())
            .map(|time_s| 3.0 + if jumps { level(*time_s) } else { (0.3 * time_s).sin() })
            .collect();
        let mut valve = Valve { lag_s: 0.04, share, off: 0.0, rate: 0.0, command: command[0] };
        let mut seed = 1_u64;
        let pressure: Vec<f64> = (command.iter())
            .map(|command| {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let even = (seed >> 33) as f64 / f64::from(1_u32 << 30) - 1.0;
                0.03 + 1.01 * valve.hold(*command, step_s) + noise * even
            })
            .collect();
        let rows = Rows {
            time_s: &time_s,
            scored: &vec![true; time_s.len()],
            command: &command,
            pressure: &pressure,
        };
        rows.shares(0.05)
    }

    #[test]
    fn a_command_that_jumps_shows_of_which_order_the_valve_is() {
        for share in [0.0, 0.25, 0.5, 1.0] {
            let (low, high) = shares(share, 0.005, 0.01, true);
            assert!(low <= share && share <= high && high - low <= 0.13, "{share}: {low} to {high}");
        }
    }

    #[test]
    fn what_does_not_show_it_excludes_nothing() {
        assert_eq!(shares(0.0, 0.005, 0.05, false), (0.0, FLAT), "a slow command");
        let (_, high) = shares(0.0, 0.5, 0.02, true);
        assert_eq!(high, FLAT, "rows that are twelve lags apart");
    }

    #[test]
    fn steps_of_a_valve_do_not_depend_on_where_they_are_cut() {
        for share in [0.0, 0.1, 0.25, 0.6] {
            let valve = || Valve { lag_s: 0.04, share, off: -2.0, rate: 0.0, command: 3.0 };
            let (mut one, mut many) = (valve(), valve());
            let whole = one.hold(3.0, 0.1);
            let cut = (0..1000).map(|_| many.hold(3.0, 1e-4)).last().expect("a step");
            assert!((whole - cut).abs() < 1e-9, "{share}: {whole}, {cut}");
        }
    }
}
