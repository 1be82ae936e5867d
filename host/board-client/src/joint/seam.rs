//! Where the recording of a joint goes on that was interrupted.
//!
//! An interruption vents both muscles, and a vented joint has no state to go on from: its friction
//! is anywhere. So it is filled and swung again, as at the begin, goes to where it was, and plays
//! what is left; rows until then do not count. A gap in the times says that it was not recorded in
//! one go, a second, longer than any that a link leaves whose board has not vented.

use super::excitation::Excitation;
use super::run::PERIOD_S;
use crate::growing::{Reached, Seam};

/// From the last row before a seam to the first one behind it: twice the half second after which a
/// board that hears nothing vents, and after which `JointRecording` takes a gap for one. Unit: s.
const GAP_S: f64 = 1.0;

/// Where a recording goes on, and the tick of its excitation that is next.
pub fn seam(excitation: &Excitation, reached: &Reached) -> (Seam, usize) {
    let ticks = |s: f64| (s / PERIOD_S).round() as usize;
    // Six digits of a second, as the rows have.
    let seconds = |ticks: usize| (ticks as f64 * PERIOD_S * 1e6).round() / 1e6;
    let (gap, lead, last) = (ticks(GAP_S), excitation.lead(), ticks(reached.last_s));
    // The tick of the excitation that is the first one behind the lead of the last seam, and where
    // that is in the file.
    let (mut next, mut begin) = (0, 0);
    for seam in reached.seams_s.iter().map(|seam_s| ticks(*seam_s)) {
        next += seam.saturating_sub(gap + begin) + 1;
        begin = seam + lead;
        if last < begin {
            // Interrupted while it was filled again.
            let seam_s = seconds(seam);
            return (Seam { cut_s: seam_s, from_s: seam_s }, next);
        }
    }
    next += last - begin + 1;
    if next <= excitation.filled() {
        return (Seam { cut_s: 0.0, from_s: 0.0 }, 0);
    }
    let seam = Seam { cut_s: seconds(last + 1), from_s: seconds(last + gap) };
    (seam, next)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Filled for 2 s, then 8 s that count.
    fn excitation() -> Excitation {
        let counts: Vec<bool> = (0..=10_000).map(|tick| tick >= 2000).collect();
        Excitation { pressures_bar: vec![[1.0; 2]; 10_001], counts, torque_nm: 0.0, every: 10 }
    }

    fn of(last_s: f64, seams_s: &[f64]) -> (Seam, usize) {
        seam(&excitation(), &Reached { last_s, seams_s: seams_s.to_vec() })
    }

    #[test]
    fn a_recording_goes_on_a_gap_behind_its_last_row_with_the_next_tick() {
        assert_eq!(of(5.0, &[]), (Seam { cut_s: 5.001, from_s: 6.0 }, 5001));
        // Again, half a second behind the 6 s that filling and way take.
        assert_eq!(of(12.5, &[6.0]), (Seam { cut_s: 12.501, from_s: 13.5 }, 5502));
        // And a third time.
        assert_eq!(of(20.0, &[6.0, 13.5]), (Seam { cut_s: 20.001, from_s: 21.0 }, 6003));
    }

    #[test]
    fn what_was_filled_alone_is_done_again() {
        assert_eq!(of(0.0, &[]), (Seam { cut_s: 0.0, from_s: 0.0 }, 0));
        assert_eq!(of(1.9, &[]), (Seam { cut_s: 0.0, from_s: 0.0 }, 0));
        assert_eq!(of(7.0, &[6.0]), (Seam { cut_s: 6.0, from_s: 6.0 }, 5001));
        assert_eq!(of(5.0, &[6.0]), (Seam { cut_s: 6.0, from_s: 6.0 }, 5001), "no row since");
    }
}
