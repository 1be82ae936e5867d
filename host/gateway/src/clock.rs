//! A board's ticks against this machine's clock, with a bound that holds.
//!
//! # Method
//! A question goes out at `t0`, its answer with the board's time `b` is complete at `t1`: so the
//! board read its clock between both. Each exchange is an interval that contains the host's time of
//! `b`. Between exchanges the interval grows by what is not known of the board's rate, at the next
//! one the two are cut with each other (K. Marzullo, S. Owicki: Maintaining the time in a
//! distributed system, 1983). The rate itself is bounded by two intervals that lie far apart, and
//! so gets sharper with time.
//!
//! # Limits
//! A crystal's rate is taken as constant to `WANDER` within `SPAN_S`. Intervals that have
//! nothing in common mean a board that has restarted, or a clock of this machine that was set: the
//! estimate then starts again from the next exchange.

/// The most by which a board's rate may be off: ten times a crystal's tolerance and ageing together,
/// below the error of the oscillator that takes over when the crystal fails. Unit: share.
const LARGEST_DRIFT: f64 = 1e-3;
/// By how much a crystal's rate may change within `SPAN_S`, by temperature (AT cut: 0.04 ppm/K²
/// off its turning point, some ppm over 10 K). Unit: share.
const WANDER: f64 = 5e-6;
/// The rate is measured from an exchange that is at most this old: long enough for intervals of
/// some milliseconds to bound it within 10 ppm, short beside changes of temperature. Unit: s.
const SPAN_S: f64 = 600.0;

/// What is known of a board's clock: host's time of the board's. Unit: s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Board's time of the last exchange.
    board_s: f64,
    /// Host's time then: from, to.
    host_s: [f64; 2],
    /// Seconds of the host for one of the board: from, to.
    rate: [f64; 2],
    /// What the rate is counted from: board's time, and host's.
    anchor: (f64, [f64; 2]),
}

impl Clock {
    /// From the first exchange: the board's time was `board_s` between two times of the host. Unit:
    /// s.
    pub fn new(board_s: f64, host_s: [f64; 2]) -> Self {
        let rate = [1.0 - LARGEST_DRIFT, 1.0 + LARGEST_DRIFT];
        Self { board_s, host_s, rate, anchor: (board_s, host_s) }
    }

    /// Takes in one more exchange. Answers whether it agrees with those before; if not, the estimate
    /// starts again from this one.
    pub fn exchange(&mut self, board_s: f64, host_s: [f64; 2]) -> bool {
        let known = self.host_s(board_s);
        let both = [known[0].max(host_s[0]), known[1].min(host_s[1])];
        if board_s <= self.board_s || both[0] > both[1] {
            *self = Self::new(board_s, host_s);
            return false;
        }
        let (anchor_board_s, anchor_host_s) = self.anchor;
        let since = board_s - anchor_board_s;
        let seen = [(both[0] - anchor_host_s[1]) / since, (both[1] - anchor_host_s[0]) / since];
        let rate = [self.rate[0].max(seen[0]), self.rate[1].min(seen[1])];
        *self = Self { board_s, host_s: both, rate, ..*self };
        if since > SPAN_S {
            self.anchor = (board_s, both);
            self.rate = [self.rate[0] - WANDER, self.rate[1] + WANDER];
        }
        true
    }

    /// The host's time of a time of the board, from the last exchange on: from, to. Unit: s.
    pub fn host_s(&self, board_s: f64) -> [f64; 2] {
        let since = board_s - self.board_s;
        [self.host_s[0] + since * self.rate[0], self.host_s[1] + since * self.rate[1]]
    }

    /// The middle of these, and half of their distance: the bound. Unit: s.
    pub fn at(&self, board_s: f64) -> (f64, f64) {
        let [from, to] = self.host_s(board_s);
        (f64::midpoint(from, to), 0.5 * (to - from))
    }

    /// How fast the board's clock is: share by which it gains on the host's, and the bound of that.
    pub fn drift(&self) -> (f64, f64) {
        let [from, to] = self.rate.map(|rate| 1.0 / rate - 1.0);
        (f64::midpoint(from, to), 0.5 * (from - to))
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// An hour of exchanges at 50 Hz with a board whose clock gains by `drift(time)`; answers of
    /// each whether the truth is within the bound, and the bound.
    fn hour(seed: u64, drift: impl Fn(f64) -> f64) -> Vec<(bool, f64)> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut clock: Option<Clock> = None;
        let (mut board_s, mut before) = (12.345, 0.0);
        let exchange = |k: u32| {
            let sent = f64::from(k) * 0.02 + random.random_range(0.0..0.004);
            let read = sent + random.random_range(0.0005..0.004);
            // Now and then this machine is late.
            let late = if random.random_range(0..100) == 0 { 0.05 } else { 0.0 };
            let received = read + random.random_range(0.0005..0.004) + late;
            board_s += (read - before) * (1.0 + drift(read));
            before = read;
            // The board tells whole ticks; what is behind its last one is part of the exchange.
            let ticks_s = (board_s * 1e3).floor() * 1e-3;
            let interval = [sent - 1e-3, received];
            let clock = match &mut clock {
                Some(clock) => {
                    assert!(clock.exchange(ticks_s, interval), "exchange {k} goes with those before");
                    clock
                }
                none => none.insert(Clock::new(ticks_s, interval)),
            };
            let truth = read - (board_s - ticks_s) / (1.0 + drift(read));
            let (at, bound) = clock.at(ticks_s);
            ((at - truth).abs() <= bound, bound)
        };
        (0..180_000).map(exchange).collect()
    }

    #[test]
    fn over_an_hour_of_a_clock_that_gains_50_ppm_the_truth_is_within_the_bound() {
        for (seed, ppm) in [(1, 50.0), (2, -50.0), (3, 0.0)] {
            let seen = hour(seed, |_| 1e-6 * ppm);
            assert!(seen.iter().all(|(is_within, _)| *is_within));
            // The shortest exchange takes 1 ms, a tick another one.
            let late = &seen[seen.len() / 2..];
            let longest = late.iter().map(|(_, bound)| *bound).fold(0.0, f64::max);
            assert!((0.2e-3..1.5e-3).contains(&longest), "{longest} s");
        }
    }

    #[test]
    fn a_crystal_that_gets_warm_stays_within_the_bound() {
        let seen = hour(4, |time_s| 1e-6 * (20.0 + 10.0 * (time_s / 3600.0)));
        assert!(seen.iter().all(|(is_within, _)| *is_within));
    }

    #[test]
    fn the_drift_is_told_with_its_bound_and_after_a_restart_the_estimate_starts_again() {
        let mut clock = Clock::new(5.0, [100.0, 100.002]);
        for k in 1..=3000 {
            let host_s = 100.001 + 0.1 * f64::from(k);
            assert!(clock.exchange(5.0 + 0.1 * f64::from(k) * (1.0 + 50e-6), [host_s - 1e-3, host_s + 1e-3]));
        }
        let (drift, bound) = clock.drift();
        assert!((drift - 50e-6).abs() <= bound && bound < 10e-6, "{drift} +- {bound}");
        assert!(!clock.exchange(0.5, [500.0, 500.002]), "a restart is told");
        assert_eq!(clock, Clock::new(0.5, [500.0, 500.002]));
    }
}
