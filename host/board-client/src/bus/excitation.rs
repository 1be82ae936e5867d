//! What `mgpi capture` plays where nobody says what: slow triangles of falling height, two fast
//! swings, holds.

use recording::course::{Course, Limits};

/// Peaks of the triangles, as shares of the range: the loop and its inner loops, as in Fig. 8 of
/// the paper.
const PEAKS: [f64; 6] = [1.0, 5.0 / 6.0, 4.0 / 6.0, 3.0 / 6.0, 2.0 / 6.0, 1.0 / 6.0];
/// The time that the triangles take. Unit: share.
const TRIANGLES: f64 = 0.55;
/// Swings over the whole range, and how much faster they are than the triangles: what depends on
/// speed shows.
const SWINGS: f64 = 2.0;
const FASTER: f64 = 3.0;
/// Levels that are held, in the time that is left: what goes on where nothing moves.
const HOLDS: [f64; 5] = [1.0 / 3.0, 2.0 / 3.0, 1.0, 2.0 / 3.0, 1.0 / 3.0];
/// A rest before, and after. Unit: share.
const REST: f64 = 0.02;

/// A command that begins and ends at 0 bar, and takes `duration_s` (above 0).
pub fn triangles_and_holds(max_bar: f64, duration_s: f64) -> Course {
    let mut course = Course::new(Limits { min_bar: 0.0, max_bar, slew_bar_per_s: None });
    course.hold(REST * duration_s);
    // From 0 to the highest command.
    let slow_s = TRIANGLES * duration_s / (2.0 * PEAKS.iter().sum::<f64>());
    for peak in PEAKS {
        course.swing(0.0, peak, peak * slow_s);
    }
    for _ in 0..SWINGS as usize {
        course.swing(0.0, 1.0, slow_s / FASTER);
    }
    let left_s = (1.0 - REST) * duration_s - course.duration_s();
    let hold_s = left_s / HOLDS.len() as f64;
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
