//! Runs of samples that nothing but the sensor can have made.
//!
//! # Design
//! A muscle that is moved goes there and back through what lies between; a sensor that drops out
//! jumps away in one step, and back in one. A run of samples is a drop-out where all of these hold:
//!
//! 1. *It jumps*: both ends are steps of more than [`FAR`] times the largest step that the
//!    recording makes elsewhere, its largest few excepted. The steps at the ends of drop-outs do
//!    not count as elsewhere: the limit is raised until nothing changes.
//! 2. *It returns*: from the sample before the run to the one after it the muscle can have gone by
//!    its own steps, and the run is on one side of that way.
//! 3. *Nothing drives it*: no step of the driving signal explains it ([`Signal::driven`]).
//! 4. *It bears the mark of a sensor* ([`Search::is_marked`]): at most [`BRIEF`] samples, or one
//!    value for longer than the sensor shows any elsewhere, or a range of its own, or jumps within,
//!    or jumps that no muscle or hand is fast enough for.
//!
//! At the beginning and at the end of a recording there is only one jump: there the mark has to be
//! one value, or a range far outside that of the other samples.
//!
//! # Limits
//! A drop-out that is no larger than the muscle's own steps (a recording of one sample a second),
//! or that begins or ends where the driving signal jumps or where rows are missing, is not told
//! from the muscle. An unrecorded load that is taken off and put back within two samples is called
//! one.

use std::ops::Range;

use crate::numbers::{median, quantiles, range};

/// Fewer steps tell nothing about what is usual.
const LEAST_STEPS: usize = 20;
/// A jump is so many times the largest step that the recording makes elsewhere.
const FAR: f64 = 4.0;
/// The share of steps that may be larger: what is rare and not a drop-out (a load that is put on).
const RARE: f64 = 1e-3;
/// The search for the limit begins at the steps that this share is above.
const ORDINARY: f64 = 1e-2;
/// A step of so many times the range of nine tenths of the samples leads out of all that the signal
/// does, however often it is made.
const BEYOND: f64 = 2.0;
/// The share of samples below, or above, those nine tenths.
const TENTH: f64 = 0.05;
/// Samples that are off on their own, without any other mark.
const BRIEF: usize = 2;
/// A movement goes on: its next step is more than this share of the last.
const GOES_ON: f64 = 0.25;
/// The share of samples below, or above, which a run has a range of its own.
pub const OUTER: f64 = 0.01;
/// A drop-out ends so many jumps on at most: more are a signal that jumps by itself.
const JUMPS: usize = 64;
/// A run of more samples than this may be the muscle with another zero, whatever the acceleration
/// of its jumps.
const LONG: usize = 50;
/// A load is not put on and taken off again in less time. Unit: s.
const BY_HAND_S: f64 = 2.0;
/// What happens in less time is a sensor's if its jumps are so many times the largest step
/// elsewhere.
const SUDDEN: f64 = 10.0;

/// A signal that may have drop-outs.
pub struct Signal<'a> {
    /// Strictly increasing. Unit: s.
    pub time_s: &'a [f64],
    /// A value for each time.
    pub values: &'a [f64],
    /// The size of the step after each sample but the last that is explained by what drives the
    /// signal.
    pub driven: Vec<f64>,
    /// The largest acceleration that it can have, where that is known. Unit: that of the values/s².
    pub acceleration: Option<f64>,
}

impl Signal<'_> {
    /// The drop-outs, from first to last.
    pub fn drop_outs(&self) -> Vec<Range<usize>> {
        Search::new(self).map(|mut search| search.run()).unwrap_or_default()
    }
}

/// What the search knows about a signal.
struct Search<'a> {
    signal: &'a Signal<'a>,
    /// Usual time from sample to sample. Unit: s.
    step_s: f64,
    /// The step from each sample to the next; across a gap, as much of it as is made in a usual
    /// time.
    steps: Vec<f64>,
    /// The range of nearly all samples.
    outer: (f64, f64),
    /// A larger step is a jump.
    limit: f64,
}

impl<'a> Search<'a> {
    fn new(signal: &'a Signal<'a>) -> Option<Self> {
        let Signal { time_s, values, .. } = *signal;
        let step_s = usual_step_s(time_s);
        if values.len() <= LEAST_STEPS || step_s <= 0.0 {
            return None;
        }
        let steps = steps(time_s, values, step_s);
        let sizes = || steps.iter().map(|step| step.abs());
        // What a sensor resolves is no jump.
        let quantum = sizes().filter(|size| *size > 0.0).fold(f64::INFINITY, f64::min);
        let (low, high) = quantiles(values, TENTH);
        let ordinary = FAR * nth_largest(sizes(), ORDINARY).max(quantum);
        let limit = if high > low { ordinary.min(BEYOND * (high - low)) } else { ordinary };
        Some(Self { signal, step_s, steps, outer: quantiles(values, OUTER), limit })
    }

    /// Finds the drop-outs, and raises the limit until all steps elsewhere are well below it.
    fn run(&mut self) -> Vec<Range<usize>> {
        loop {
            let jumps: Vec<usize> = (0..self.steps.len()).filter(|&at| self.is_jump(at)).collect();
            let runs = self.pair(&jumps);
            let mut elsewhere: Vec<bool> = (0..self.steps.len()).map(|at| self.is_own_step(at)).collect();
            // The steps to, in and from a run.
            runs.iter().for_each(|run| {
                elsewhere[run.start.saturating_sub(1)..run.end.min(self.steps.len())].fill(false);
            });
            let own = self.steps.iter().zip(&elsewhere).filter(|(_, own)| **own).map(|(step, _)| step.abs());
            let limit = FAR * nth_largest(own, RARE);
            if limit <= self.limit {
                return runs;
            }
            self.limit = limit;
        }
    }

    /// Whether what drives the signal does not explain a step.
    fn is_own_step(&self, at: usize) -> bool {
        self.steps[at].abs() > self.signal.driven[at]
    }

    fn is_jump(&self, at: usize) -> bool {
        self.steps[at].abs() > self.limit && self.is_own_step(at)
    }

    /// The runs between jumps that are drop-outs.
    fn pair(&self, jumps: &[usize]) -> Vec<Range<usize>> {
        let (Some(&first), Some(&last)) = (jumps.first(), jumps.last()) else { return Vec::new() };
        let hold = self.longest_hold();
        let mut runs = Vec::new();
        if self.is_of_its_own(&(0..first + 1), hold) {
            runs.push(0..first + 1);
        }
        let mut at = runs.len();
        while at < jumps.len() {
            let ends = at + 1..jumps.len().min(at + 1 + JUMPS);
            match ends.into_iter().find(|&end| self.is_drop_out(&jumps[at..=end], hold)) {
                Some(end) => {
                    runs.push(run_between(&jumps[at..=end]));
                    at = end + 1;
                }
                None => at += 1,
            }
        }
        let rest = last + 1..self.signal.values.len();
        if runs.last().is_none_or(|run| run.end < rest.start) && self.is_of_its_own(&rest, hold) {
            runs.push(rest);
        }
        joined(runs)
    }

    /// Whether the run from the first to the last of a few jumps is a drop-out.
    fn is_drop_out(&self, jumps: &[usize], hold: usize) -> bool {
        let run = run_between(jumps);
        let Signal { time_s, values, .. } = *self.signal;
        let (before, after) = (run.start - 1, run.end);
        let way = values[after] - values[before];
        let usual_steps = (time_s[after] - time_s[before]) / self.step_s;
        let off = |row: usize| {
            let share = (time_s[row] - time_s[before]) / (time_s[after] - time_s[before]);
            values[row] - (values[before] + share * way)
        };
        let (first, last) = (off(run.start), off(run.end - 1));
        // A staircase has jumps on either side of its way as well, but none of them goes back.
        let goes_back = || jumps.len() > 2 && jumps.iter().any(|&at| self.steps[at] * way < 0.0);
        let is_off = first.abs().min(last.abs()) > self.limit && (first * last > 0.0 || goes_back());
        way.abs() <= usual_steps * self.limit / FAR && is_off && self.is_marked(&run, jumps.len() > 2, hold)
    }

    /// Whether a sensor's mark tells a run from a movement.
    fn is_marked(&self, run: &Range<usize>, has_jumps: bool, hold: usize) -> bool {
        let ends = [run.start - 1, run.end - 1];
        let is_still = || ends.into_iter().all(|at| !self.goes_on(at));
        let is_fast = || ends.into_iter().all(|at| self.is_too_fast(at));
        let sudden = self.limit * SUDDEN / FAR;
        let is_sudden = || ends.into_iter().all(|at| self.steps[at].abs() > sudden);
        let Signal { time_s, values, .. } = *self.signal;
        let (low, high) = range(&values[run.clone()]);
        let is_outside = high < self.outer.0 || low > self.outer.1;
        self.is_one_value(run, hold)
            || (run.len() <= BRIEF || is_outside) && is_still()
            || run.len() <= LONG && (has_jumps && is_still() || is_fast())
            || time_s[run.end] - time_s[run.start - 1] <= BY_HAND_S && is_still() && is_sudden()
    }

    /// Whether a run at the beginning or the end of the recording is a sensor that was not there.
    fn is_of_its_own(&self, run: &Range<usize>, hold: usize) -> bool {
        let (low, high) = range(&self.signal.values[run.clone()]);
        let span = self.outer.1 - self.outer.0;
        let is_far = high < self.outer.0 - span || low > self.outer.1 + span;
        run.len() <= self.signal.values.len() / 2 && (is_far || self.is_one_value(run, hold))
    }

    /// One value for longer than the sensor shows any elsewhere.
    fn is_one_value(&self, run: &Range<usize>, hold: usize) -> bool {
        let values = &self.signal.values[run.clone()];
        run.len() > hold.max(BRIEF) && values.iter().all(|value| *value == values[0])
    }

    /// The most samples in a row of one value, that do not jump at both ends.
    fn longest_hold(&self) -> usize {
        let mut longest = 0;
        let mut start = 0;
        for hold in self.signal.values.chunk_by(|one, other| one == other) {
            let end = start + hold.len();
            let jumps_in = start == 0 || self.is_jump(start - 1);
            let jumps_out = end > self.steps.len() || self.is_jump(end - 1);
            if !(jumps_in && jumps_out) {
                longest = longest.max(hold.len());
            }
            start = end;
        }
        longest
    }

    /// Whether a step is part of a movement: the one before it or after it goes the same way, and
    /// not much less far.
    fn goes_on(&self, at: usize) -> bool {
        let step = self.steps[at];
        let beside = [at.checked_sub(1), Some(at + 1)].into_iter().flatten();
        beside.filter_map(|at| self.steps.get(at)).any(|other| other / step > GOES_ON)
    }

    /// Whether a step takes more acceleration than there is, from rest to rest.
    fn is_too_fast(&self, at: usize) -> bool {
        let Signal { time_s, values, acceleration, .. } = *self.signal;
        let (way, time) = ((values[at + 1] - values[at]).abs(), time_s[at + 1] - time_s[at]);
        acceleration.is_some_and(|most| 4.0 * way / time.powi(2) > most)
    }
}

/// The samples from behind the first jump to the last.
fn run_between(jumps: &[usize]) -> Range<usize> {
    jumps[0] + 1..jumps[jumps.len() - 1] + 1
}

/// The runs, those joined that only a few samples are between: what comes between two drop-outs is
/// hardly sound.
fn joined(runs: Vec<Range<usize>>) -> Vec<Range<usize>> {
    let mut joined: Vec<Range<usize>> = Vec::new();
    for run in runs {
        match joined.last_mut() {
            Some(last) if run.start <= last.end + BRIEF => last.end = run.end,
            _ => joined.push(run),
        }
    }
    joined
}

/// Usual time from sample to sample. Unit: s.
pub fn usual_step_s(time_s: &[f64]) -> f64 {
    median(&mut time_s.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<f64>>())
}

/// The step from each sample to the next; across a gap, as much of it as is made in a usual time.
pub fn steps(time_s: &[f64], values: &[f64], step_s: f64) -> Vec<f64> {
    let usual = time_s.windows(2).map(|pair| ((pair[1] - pair[0]) / step_s).max(1.0));
    values.windows(2).zip(usual).map(|(pair, usual)| (pair[1] - pair[0]) / usual).collect()
}

/// The size that the given share of all sizes is above; 0 of none.
fn nth_largest(sizes: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut sizes: Vec<f64> = sizes.collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let place = (share * sizes.len() as f64) as usize;
    *sizes.select_nth_unstable_by(place, |one, other| other.total_cmp(one)).1
}
