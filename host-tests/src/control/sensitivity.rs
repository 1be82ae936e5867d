//! The largest sensitivity of a loop, measured: small tones on the sensor while the muscle is
//! driven slowly up and down, so that its plays are driven and the tones do not turn it round.
//!
//! Two runs, with the tones and without, differ by what the loop makes of them. Sensors and
//! converter are exact here, since the tones are far below their steps.

use std::f64::consts::TAU;

use model_core::Tracking;
use wire::BoardParameters;

use super::course::{Converter, Setting, run};
use super::reference::Course;
use super::subject::Subject;
use crate::PERIOD_S;

/// Tones, multiples of one over [`WINDOW_S`]. Unit: Hz.
const TONES_HZ: [f64; 14] = [0.3, 0.5, 0.8, 1.2, 1.7, 2.4, 3.3, 4.6, 6.4, 8.8, 12.1, 16.6, 22.9, 31.7];
/// How long a branch is looked at: three periods of the slowest tone. Unit: s.
const WINDOW_S: f64 = 10.0;
/// Behind each turn. Unit: s.
const SETTLE_S: f64 = 3.0;
/// The branch's ends, shares of the stroke.
const ENDS: (f64, f64) = (0.3, 0.7);

/// The largest sensitivity of a plant with a controller, over tones and both branches.
pub fn largest(subject: &Subject, parameters: &BoardParameters, range_mm: (f64, f64)) -> f64 {
    let Ok(tracking) = Tracking::try_new(parameters) else { return f64::INFINITY };
    let stroke_mm = range_mm.1 - range_mm.0;
    let branch_s = SETTLE_S + WINDOW_S;
    let speed_mm_per_s = (ENDS.1 - ENDS.0) * stroke_mm / branch_s;
    let at = |share: f64| range_mm.0 + share * stroke_mm;
    let ticks = |s: f64| (s / PERIOD_S).round() as usize;
    let reference_mm: Vec<f64> = (0..ticks(SETTLE_S + 2.0 * branch_s))
        .map(|tick| {
            let time_s = tick as f64 * PERIOD_S;
            let up = at(ENDS.0) + speed_mm_per_s * (time_s - SETTLE_S);
            let down = at(ENDS.1) - speed_mm_per_s * (time_s - SETTLE_S - branch_s);
            if time_s < SETTLE_S { at(ENDS.0) * time_s / SETTLE_S } else { up.min(down) }
        })
        .collect();
    // All together move by half the speed at most.
    let amplitude_mm = |hz: f64| 0.5 * speed_mm_per_s / (TAU * hz * TONES_HZ.len() as f64);
    let tones = |tick: usize| {
        let time_s = tick as f64 * PERIOD_S;
        TONES_HZ
            .iter()
            .enumerate()
            .map(|(k, hz)| amplitude_mm(*hz) * (TAU * hz * time_s + (k * k) as f64).sin())
            .sum::<f64>()
    };
    let setting = Setting {
        tracking: &tracking,
        mode: model_core::Mode::Both,
        preview_s: f64::from(parameters.extensions.preview_s(parameters.period_s)),
        reference_mm: &reference_mm,
        correction_mm: &[],
        course: Course::Paper,
        blocked_n: 0.0,
        converter: Converter::Exact,
    };
    let with = run(&setting, &mut subject.plant(false), |tick, mm| mm + tones(tick));
    let without = run(&setting, &mut subject.plant(false), |_, mm| mm);
    let differ: Vec<f64> = with.iter().zip(&without).map(|(a, b)| a.measured_mm - b.measured_mm).collect();
    let from = |branch: usize| ticks(2.0 * SETTLE_S + branch as f64 * branch_s);
    let of = |branch: usize, hz: f64| {
        let window = from(branch)..from(branch) + ticks(WINDOW_S);
        let (mut cosine, mut sine) = (0.0, 0.0);
        for tick in window {
            let phase = TAU * hz * tick as f64 * PERIOD_S;
            cosine += differ[tick] * phase.cos();
            sine += differ[tick] * phase.sin();
        }
        2.0 * cosine.hypot(sine) * PERIOD_S / WINDOW_S / amplitude_mm(hz)
    };
    (0..2).flat_map(|branch| TONES_HZ.map(|hz| of(branch, hz))).fold(0.0, f64::max)
}
