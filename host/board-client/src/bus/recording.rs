//! The recording of one muscle by a board on the bus: its rows, and where it goes on after an
//! interruption.
//!
//! # Going on
//! An interruption vents the muscle, and what it did before matters for what it does after. So a
//! recording goes on from the last moment at which the excitation was at its lowest command, where
//! a vented muscle is anyway; what was recorded after that is played again.

use super::play::{POINTS_PER_S, Tick};
use crate::growing::{Reached, Seam};

/// The columns of a recording.
pub const COLUMNS: &str = "time_s,command_bar,pressure_bar,contraction_mm";
/// How far from the lowest point of an excitation is still lowest. Unit: bar.
const LOWEST_BAR: f32 = 1e-3;

/// Ticks as rows, `from_s` (s) later.
pub fn rows(ticks: &[Tick], from_s: f64) -> String {
    let mut rows = String::new();
    for Tick { time_s, pressure_bar, contraction_mm, command_bar, .. } in ticks {
        // Six digits of a second, as the ticks have.
        let time_s = ((time_s + from_s) * 1e6).round() / 1e6;
        rows += &format!("{time_s},{command_bar},{pressure_bar},{contraction_mm}\n");
    }
    rows
}

/// Where a recording of an excitation with these points (bar) goes on. Its times are those of the
/// excitation.
pub fn seam(points: &[f32], reached: &Reached) -> Seam {
    let from_s = rest_before(points, reached.last_s);
    Seam { cut_s: from_s, from_s }
}

/// Number of the point at which a recording goes on that does so at `from_s` (s).
pub fn from_point(from_s: f64) -> usize {
    (from_s * POINTS_PER_S).round() as usize
}

/// The last time up to which an excitation has been played and at which it was lowest. Unit: s.
fn rest_before(points: &[f32], reached_s: f64) -> f64 {
    let lowest = points.iter().copied().fold(f32::INFINITY, f32::min) + LOWEST_BAR;
    let reached = points.iter().take((reached_s * POINTS_PER_S) as usize + 1);
    reached.into_iter().rposition(|&point| point <= lowest).map_or(0.0, |place| place as f64 / POINTS_PER_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_goes_on_from_its_last_rest() {
        let mut points = vec![0.0; 100];
        points.extend((0..100).map(|point| point as f32 / 50.0));
        points.extend([0.0; 100]);
        for (last_s, from_s) in [(0.0, 0.0), (0.5, 0.5), (1.7, 1.0), (2.0, 2.0), (2.5, 2.5), (9.0, 2.99)] {
            let seam = seam(&points, &Reached { last_s, ..Reached::default() });
            assert_eq!(seam, Seam { cut_s: from_s, from_s }, "after {last_s} s");
        }
        assert_eq!(rest_before(&[1.0, 2.0], 0.01), 0.0);
        assert_eq!(from_point(0.5), 50);
    }

    #[test]
    fn rows_have_the_time_of_the_excitation() {
        let tick = Tick { time_s: 0.01, command_bar: 1.0, ..Tick::default() };
        assert_eq!(rows(&[tick], 0.5), "0.51,1,0,0\n");
    }
}
