//! What `mgpi capture` plays where nobody says what: triangles of falling height, then holds.

use crate::plan::course::{Course, Limits};

/// Peaks of the triangles, as shares of the range: the loop and its inner loops, as in Fig. 8 of the paper.
const PEAKS: [f64; 6] = [1.0, 5.0 / 6.0, 4.0 / 6.0, 3.0 / 6.0, 2.0 / 6.0, 1.0 / 6.0];
/// Levels that are held, up and down: what goes on where nothing moves.
const HOLDS: [f64; 7] = [0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25];
/// The time that the triangles take, and a rest before and after; the holds take what is left. Unit: share.
const TRIANGLES: f64 = 0.75;
const REST: f64 = 0.02;

/// A command that begins and ends at the lowest one. The triangles rise and fall at one speed.
pub fn triangles_and_holds(max_bar: f64, duration_s: f64) -> Course {
    let mut course = Course::new(Limits { min_bar: 0.0, max_bar, slew_bar_per_s: None });
    course.hold(REST * duration_s);
    let half_s = TRIANGLES * duration_s / (2.0 * PEAKS.iter().sum::<f64>());
    for peak in PEAKS {
        course.swing(0.0, peak, peak * half_s);
    }
    let hold_s = (1.0 - TRIANGLES - 2.0 * REST) * duration_s / HOLDS.len() as f64;
    for level in HOLDS {
        // A ramp rather than a jump: a regulator takes some tenths of a second anyway.
        course.ramp(level, 0.2 * hold_s);
        course.hold(0.8 * hold_s);
    }
    course.ramp(0.0, 0.5 * REST * duration_s);
    course.hold(0.5 * REST * duration_s);
    course
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_covers_the_range_takes_its_time_and_ends_vented() {
        let course = triangles_and_holds(4.0, 60.0);
        assert!((course.duration_s() - 60.0).abs() < 1e-9, "{}", course.duration_s());
        let samples: Vec<f64> = course.samples((0..=6000).map(|row| f64::from(row) / 100.0)).collect();
        let highest = samples.iter().copied().fold(0.0, f64::max);
        assert!((highest - 4.0).abs() < 0.02, "{highest}");
        assert_eq!((samples[0], samples[6000]), (0.0, 0.0));
        assert!(samples.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.05), "nothing jumps");
    }
}
