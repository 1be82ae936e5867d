//! What a recording shows of time where it turns round or begins to move.
//!
//! What a wrong model of the hysteresis leaves depends on the place and the branch, and changes
//! slowly beside a dead time: a loop that is too wide is off by the same before and behind a
//! moment. What comes late is off just where the speed changes. So the residual is compared with
//! its own mean over a short while around, and a lateness is the shift of the simulation that makes
//! the least of what is left.

use crate::model_file::control::Late;
use crate::noise;

/// Blocks of time, over which standard errors are taken. A choice: some turns are in each.
pub(crate) const BLOCKS: usize = 12;
/// To either side of a moment the mean is taken over so long: longer than an ordinary valve
/// (0.07 s) and a line of 15 m (0.045 s) are late together, and short beside the swings of a
/// recording, which take seconds. Unit: s.
const AROUND_S: f64 = 0.2;
/// The latenesses that are tried first, and how far they are apart: up to 0.12 s, a valve and a
/// line as above together, and half as far the other way, for a model that is itself too late. They
/// are refined below. Unit: s.
const SOONEST_S: f64 = -0.06;
const APART_S: f64 = 0.02;
const TRIED: usize = 10;
/// Halvings of that distance.
const HALVINGS: usize = 4;

/// A recording, a value a row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Transients<'a> {
    /// Unit: s.
    pub(crate) time_s: &'a [f64],
    /// Which rows count.
    pub(crate) scored: &'a [bool],
    /// As measured. Output unit.
    pub(crate) output: &'a [f64],
}

/// Squared errors, a sum a block.
pub(crate) type Errors = [f64; BLOCKS];

impl Transients<'_> {
    /// Squares of what is left of a simulation that comes so much later (s).
    pub(crate) fn errors(&self, simulated: &[f64], late_s: f64) -> Errors {
        let (rows, mut before) = (self.time_s.len(), 0);
        let mut sums = vec![0.0; rows + 1];
        for row in 0..rows {
            let then_s = self.time_s[row] - late_s;
            while before + 2 < rows && self.time_s[before + 1] < then_s {
                before += 1;
            }
            while before > 0 && self.time_s[before] > then_s {
                before -= 1;
            }
            let after = (before + 1).min(rows - 1);
            let step_s = self.time_s[after] - self.time_s[before];
            let share =
                if step_s > 0.0 { ((then_s - self.time_s[before]) / step_s).clamp(0.0, 1.0) } else { 0.0 };
            let answer = simulated[before] + share * (simulated[after] - simulated[before]);
            sums[row + 1] = sums[row] + self.output[row] - answer;
        }
        let around = ((AROUND_S / noise::steps(self.time_s).0).round() as usize).max(1);
        let mut left = [0.0; BLOCKS];
        let mut counted_from = 0;
        let (first_s, last_s) = (
            self.time_s.first().copied().unwrap_or_default(),
            self.time_s.last().copied().unwrap_or_default(),
        );
        // What a simulation was before its first row is not known.
        let is_inside = |time_s: f64| (time_s - first_s).min(last_s - time_s) >= AROUND_S;
        for row in 0..rows {
            if !self.scored[row] || !is_inside(self.time_s[row]) {
                counted_from = row + 1;
            } else if row >= counted_from + 2 * around {
                let at = row - around;
                let mean = (sums[row + 1] - sums[row - 2 * around]) / (2 * around + 1) as f64;
                left[at * BLOCKS / rows] += (sums[at + 1] - sums[at] - mean).powi(2);
            }
        }
        left
    }

    /// How late a simulation is shown to be. None where nothing shows it.
    ///
    /// Its standard error is that of the jackknife over the blocks. But a model that is wrong just
    /// behind a turn is wrong there at each turn, and blocks that are off alike say nothing of
    /// that. So it is at least half of what the lateness would be if as much of the misfit as is
    /// left, less the sensor's noise (standard deviation, output unit), were taken for one: two
    /// standard errors are all of it.
    pub(crate) fn late(&self, simulated: &[f64], noise: f64) -> Option<Late> {
        let of = |late_s: f64| (late_s, self.errors(simulated, late_s));
        let mut tried: Vec<(f64, Errors)> = (0..TRIED).map(|k| of(SOONEST_S + APART_S * k as f64)).collect();
        let mut apart_s = APART_S;
        for _ in 0..HALVINGS {
            let (best_s, _) = least(&tried, None)?;
            apart_s *= 0.5;
            tried.extend([best_s - apart_s, best_s + apart_s].map(of));
        }
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mean_s = vertex(&tried, None)?;
        let others: Option<Vec<f64>> = (0..BLOCKS).map(|block| vertex(&tried, Some(block))).collect();
        let others = others?;
        let middle = others.iter().sum::<f64>() / BLOCKS as f64;
        let squares: f64 = others.iter().map(|one| (one - middle).powi(2)).sum();
        let drawn_s = (squares * (BLOCKS - 1) as f64 / BLOCKS as f64).sqrt();
        let left = total(&self.errors(simulated, mean_s), None);
        let [sooner, later] =
            [-APART_S, APART_S].map(|by_s| total(&self.errors(simulated, mean_s + by_s), None));
        let rise = (0.5 * (sooner + later) - left) / APART_S.powi(2);
        // Two standard errors of the noise's own squares more than what is seen beside them.
        let rows = self.scored.iter().filter(|scored| **scored).count() as f64;
        let misfit = (left - (rows - 2.0 * (2.0 * rows).sqrt()) * noise * noise).max(0.0);
        (rise > 0.0).then(|| Late { mean_s, error_s: drawn_s.max(0.5 * (misfit / rise).sqrt()) })
    }
}

/// The sum of all blocks, but one if that is left out.
pub(crate) fn total(errors: &Errors, left_out: Option<usize>) -> f64 {
    errors.iter().enumerate().filter(|(block, _)| Some(*block) != left_out).map(|(_, error)| error).sum()
}

/// The lateness of the least error, with its place.
fn least(tried: &[(f64, Errors)], left_out: Option<usize>) -> Option<(f64, usize)> {
    let of = |place: &usize| total(&tried[*place].1, left_out);
    let place = (0..tried.len()).min_by(|a, b| of(a).total_cmp(&of(b)))?;
    Some((tried[place].0, place))
}

/// The vertex of the parabola through the least error and its neighbours. None at the end of what
/// was tried, which are in order.
fn vertex(tried: &[(f64, Errors)], left_out: Option<usize>) -> Option<f64> {
    let (_, place) = least(tried, left_out)?;
    let [(x0, e0), (x1, e1), (x2, e2)] = tried.get(place.checked_sub(1)?..place + 2)? else { return None };
    let [y0, y1, y2] = [e0, e1, e2].map(|errors| total(errors, left_out));
    let (rise, fall) = ((y2 - y1) / (x2 - x1), (y1 - y0) / (x1 - x0));
    let bent = (rise - fall) / (x2 - x0);
    if bent > 0.0 { Some(0.5 * (x0 + x1) - 0.5 * fall / bent) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{Noise, times, triangles};

    /// Standard deviation. Output unit.
    const NOISE: f64 = 0.03;
    /// Of all triangles. Unit: s.
    const PERIOD_S: f64 = 8.0;

    /// What a minute of triangles of one speed shows of a muscle that answers so much later (s)
    /// than a model with plays of the same weight, one of which is so much wider in the muscle.
    fn seen(late_s: f64, wider: f64) -> Late {
        let time_s = times(6000, 0.01);
        let answer = |late_s: f64, wider: f64| -> Vec<f64> {
            let (mut narrow, mut wide) = (0.0_f64, 0.0_f64);
            let mut at = |time_s: f64| {
                let input = triangles((time_s - late_s).max(0.0), PERIOD_S);
                narrow = narrow.clamp(input - 0.1, input + 0.1);
                wide = wide.clamp(input - 0.5 - wider, input + 0.5 + wider);
                6.0 * input + 2.0 * narrow + 2.0 * wide
            };
            time_s.iter().map(|&time_s| at(time_s)).collect()
        };
        let mut noise = Noise::new(7);
        let output: Vec<f64> = answer(late_s, wider).iter().map(|value| value + noise.white(NOISE)).collect();
        let transients = Transients { time_s: &time_s, scored: &vec![true; time_s.len()], output: &output };
        transients.late(&answer(0.0, 0.0), NOISE).expect("it turns")
    }

    #[test]
    fn at_one_speed_turns_show_a_dead_time() {
        for late_s in [-0.01, 0.0, 0.023, 0.05] {
            let found = seen(late_s, 0.0);
            assert!((found.mean_s - late_s).abs() < 0.002 && found.error_s < 0.002, "{late_s}: {found:?}");
        }
    }

    #[test]
    fn what_a_model_gets_wrong_behind_turns_is_in_the_error_of_a_dead_time() {
        for wider in [-0.3, -0.1, -0.05, -0.02, 0.02, 0.05, 0.1, 0.3] {
            let found = seen(0.02, wider);
            assert!((found.mean_s - 0.02).abs() < 2.0 * found.error_s, "{wider}: {found:?}");
        }
        let (sound, wide) = (seen(0.02, 0.0), seen(0.02, 0.3));
        assert!(wide.error_s > 5.0 * sound.error_s, "{wide:?}, {sound:?}");
    }

    #[test]
    fn of_what_never_turns_nothing_is_known() {
        let (time_s, mut noise) = (times(1000, 0.01), Noise::new(7));
        let output: Vec<f64> = time_s.iter().map(|time_s| time_s + noise.white(NOISE)).collect();
        let transients = Transients { time_s: &time_s, scored: &vec![true; 1000], output: &output };
        let found = transients.late(&time_s, NOISE);
        assert!(found.is_none_or(|late| late.error_s > 0.1), "{found:?}");
    }
}
