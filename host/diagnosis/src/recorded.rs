//! All rows of a recording, for what is quicker than the kept ones show: delays of the input, tones, single rows far off.

use super::anatomy::spectrum::{amplitude, tones};
use super::signals::{Recorded, Signals};

/// Peaks of a residual that are looked at, and what each has to have in the scored rows of its amplitude in all.
const PEAKS: usize = 12;
const STANDS: f64 = 0.5;

impl Signals {
    /// Frequencies of the strongest tones of a residual of the scored rows, `most` of them at most. Unit: Hz.
    ///
    /// Of all that was recorded: in scored rows alone what is quicker than these are apart looks like something slower. But it
    /// has to be in these too: between them the fit is straight, and what bends there is none of the residual. And it may not be one that
    /// a periodic input drives.
    pub fn tones(&self, residual: &[f64], most: usize) -> Vec<f64> {
        let scored_s: Vec<f64> = self.rows.iter().map(|row| self.time_s[row.at]).collect();
        let (all_s, all) = (&self.recorded.scored_s, self.residual_of_all(residual));
        let stands = |&hz: &f64| amplitude(&scored_s, residual, hz) >= STANDS * amplitude(all_s, &all, hz);
        let is_free = |hz: &f64| !self.recorded.input_lines.have(*hz);
        tones(all_s, &all, PEAKS).into_iter().filter(is_free).filter(stands).take(most).collect()
    }

    /// A residual of the scored rows at all that may be: what was recorded less what was fitted, straight from one scored row
    /// to the next. Output unit.
    pub(super) fn residual_of_all(&self, residual: &[f64]) -> Vec<f64> {
        let fitted = |place: usize| {
            let at = self.rows[place].at;
            (self.time_s[at], self.output[at] - residual[place])
        };
        let Recorded { scored_s, scored, .. } = &*self.recorded;
        let mut place = 0;
        let left = |(&time_s, output): (&f64, &f64)| {
            while place + 2 < self.rows.len() && fitted(place + 1).0 <= time_s {
                place += 1;
            }
            let (from, to) = (fitted(place), fitted((place + 1).min(self.rows.len() - 1)));
            let share =
                if to.0 > from.0 { ((time_s - from.0) / (to.0 - from.0)).clamp(0.0, 1.0) } else { 0.0 };
            output - (from.1 + share * (to.1 - from.1))
        };
        scored_s.iter().zip(scored).map(left).collect()
    }
}
