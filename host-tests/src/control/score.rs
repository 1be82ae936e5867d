//! How well a run went.

use recording::numbers::range;

use super::course::Tick;
use crate::PERIOD_S;

/// A contraction has settled, as the benchmark's load step asks, when it stays within this share of the stroke.
const SETTLED: f64 = 0.01;
/// Over so many ticks a mean is taken for it, so that no sensor's noise counts.
const MEAN_TICKS: usize = 20;
/// A run is unstable when the contraction swings about its reference for its last seconds by more
/// than this share of the stroke, peak to peak (five times the band of settling), and this many
/// times faster than the reference does, or than once in the seconds that are looked at: halfway
/// between following it and an own swing at twice its frequency. A convention, not measured.
const SWING: f64 = 0.05;
const FASTER: f64 = 1.5;
/// A swing lasts if it is at least this share as large in the second half of those seconds as in
/// the first; one that dies away faster is the ringing after a jump. A convention, not measured: it
/// halves in half of `LAST`. Unit: 1.
const LASTING: f64 = 0.5;
/// Samples of which the median is looked at, so that outliers of the sensor are no swing: of five in
/// a row, where one in a hundred is off, three are in one window of 100,000. A swing faster than
/// a period of twice as many ticks would be lost; loops of valve and muscle have none.
const MEDIAN: usize = 5;
/// Unit: tick.
const LAST: usize = 2900;

/// Error and effort of a run. Shares of the stroke in percent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// Root mean square of the error.
    pub rmse: f64,
    /// The largest.
    pub largest: f64,
    /// Root mean square of the command's rate. Unit: bar/s.
    pub effort_bar_per_s: f64,
    /// How long the error of the last disturbance took back into 1 % of the stroke, where there was
    /// one. Unit: s.
    pub settling_s: Option<f64>,
    /// Whether it swings.
    pub is_stable: bool,
}

/// The score of a run from a tick on. `disturbed`: ticks at which a load or the reference jumps;
/// `highest_hz`: the fastest that the reference moves.
pub fn score(ticks: &[Tick], from: usize, stroke_mm: f64, disturbed: &[usize], highest_hz: f64) -> Score {
    let error = |tick: &Tick| tick.contraction_mm - tick.reference_mm;
    let scored = &ticks[from.min(ticks.len() - 1)..];
    let squares: f64 = scored.iter().map(|tick| error(tick).powi(2)).sum();
    let rates: f64 =
        scored.windows(2).map(|pair| ((pair[1].command_bar - pair[0].command_bar) / PERIOD_S).powi(2)).sum();
    let settling = disturbed.iter().enumerate().map(|(k, &at)| {
        let end = disturbed.get(k + 1).copied().unwrap_or(ticks.len());
        settling_s(&ticks[at.min(end)..end], SETTLED * stroke_mm)
    });
    Score {
        rmse: 100.0 * (squares / scored.len() as f64).sqrt() / stroke_mm,
        largest: 100.0 * scored.iter().map(|tick| error(tick).abs()).fold(0.0, f64::max) / stroke_mm,
        effort_bar_per_s: (rates / scored.len() as f64).sqrt(),
        settling_s: settling.reduce(f64::max),
        is_stable: !swings(ticks, SWING * stroke_mm, highest_hz),
    }
}

/// How long it takes until the error stays within a bound. Unit: s.
fn settling_s(ticks: &[Tick], within_mm: f64) -> f64 {
    let mean = |window: &[Tick]| {
        let sum: f64 = window.iter().map(|tick| tick.contraction_mm - tick.reference_mm).sum();
        (sum / window.len() as f64).abs()
    };
    let outside = ticks.windows(MEAN_TICKS).rposition(|window| mean(window) > within_mm);
    outside.map_or(0.0, |last| (last + MEAN_TICKS) as f64 * PERIOD_S)
}

/// Whether the error of the last seconds goes to and fro quickly and far, and does not die away.
fn swings(ticks: &[Tick], far_mm: f64, highest_hz: f64) -> bool {
    let last = &ticks[ticks.len().saturating_sub(LAST)..];
    let errors: Vec<f64> = last
        .windows(MEDIAN)
        .map(|window| {
            let mut errors: Vec<f64> =
                window.iter().map(|tick| tick.contraction_mm - tick.reference_mm).collect();
            errors.sort_by(f64::total_cmp);
            errors[MEDIAN / 2]
        })
        .collect();
    let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
    // Crossings of a band, so that no noise counts: half of what is called far.
    let (mut side, mut turns) = (0.0, 0);
    for error in &errors {
        let off = error - mean;
        if off.abs() > 0.5 * far_mm && off.signum() != side {
            side = off.signum();
            turns += 1;
        }
    }
    let whole_s = LAST as f64 * PERIOD_S;
    let is_quick = f64::from(turns) > 2.0 * FASTER * highest_hz.max(whole_s.recip()) * whole_s;
    let (first, second) = errors.split_at(errors.len() / 2);
    let way = |errors: &[f64]| {
        let (low, high) = range(errors);
        high - low
    };
    is_quick && way(second) >= LASTING * way(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ticks(error_mm: impl Fn(f64) -> f64) -> Vec<Tick> {
        let tick = |k: u32| Tick {
            reference_mm: 50.0,
            measured_mm: 0.0,
            contraction_mm: 50.0 + error_mm(f64::from(k) * PERIOD_S),
            command_bar: 2.0,
        };
        (0..6000).map(tick).collect()
    }

    #[test]
    fn an_error_that_dies_away_settles_when_it_is_small() {
        let run = ticks(|time_s| if time_s < 1.0 { 0.0 } else { 10.0 * (-(time_s - 1.0) / 0.1).exp() });
        let score = score(&run, 0, 100.0, &[1000], 0.0);
        assert!((score.settling_s.expect("disturbed") - 0.1 * 10.0_f64.ln()).abs() < 0.03, "{score:?}");
        assert!(score.is_stable && score.largest > 9.9);
    }

    #[test]
    fn what_rings_of_a_jump_and_dies_away_is_no_swing_and_what_grows_or_lasts_is_one() {
        // A mass of 2.8 Hz whose reference jumps a tenth of a second before the last seconds.
        let ringing = |damping_ratio: f64| {
            ticks(move |time_s| {
                let (since_s, omega) = (time_s - 3.0, std::f64::consts::TAU * 2.8);
                if since_s < 0.0 {
                    0.0
                } else {
                    30.0 * (-damping_ratio * omega * since_s).exp() * (omega * since_s).cos()
                }
            })
        };
        assert!(score(&ringing(0.1), 0, 100.0, &[], 0.0).is_stable);
        assert!(!score(&ringing(0.0), 0, 100.0, &[], 0.0).is_stable);
        assert!(!score(&ringing(-0.02), 0, 100.0, &[], 0.0).is_stable);
    }

    #[test]
    fn a_swing_is_told_and_a_slow_or_small_one_is_none() {
        let swing = |hz: f64, mm: f64| ticks(move |time_s| mm * (std::f64::consts::TAU * hz * time_s).sin());
        assert!(!score(&swing(6.0, 5.0), 0, 100.0, &[], 2.0).is_stable);
        assert!(!score(&swing(1.0, 5.0), 0, 100.0, &[], 0.05).is_stable);
        assert!(score(&swing(1.0, 5.0), 0, 100.0, &[], 1.0).is_stable);
        assert!(score(&swing(6.0, 1.0), 0, 100.0, &[], 2.0).is_stable);
    }

    #[test]
    fn outliers_are_no_swing_and_hide_none() {
        // One sample in a hundred, to either side in turn.
        let outlier = |time_s: f64| match (time_s / PERIOD_S).round() as usize % 200 {
            50 => 20.0,
            150 => -20.0,
            _ => 0.0,
        };
        assert!(score(&ticks(outlier), 0, 100.0, &[], 0.0).is_stable);
        let swing = |time_s: f64| 5.0 * (std::f64::consts::TAU * 6.0 * time_s).sin() + outlier(time_s);
        assert!(!score(&ticks(swing), 0, 100.0, &[], 0.0).is_stable);
    }
}
