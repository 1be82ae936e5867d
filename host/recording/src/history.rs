//! From when on a recording tells what the muscle has been through.
//!
//! What an operator answers depends on what the input did before. A recording that begins at an end
//! of the input's range leaves no doubt: the muscle has come there from rest, or from its whole
//! range, and both are tried. One that begins within the range may be anywhere between the two
//! branches of the loop, until the input has been at both ends: by then it has wiped out whatever
//! came before. What it is scored on until then would teach the model a past that it has not had.
//!
//! A recording that begins in the moment of a step has an input at its place and a muscle still on
//! its way there, most often from rest behind a regulator of which only the command is recorded.
//! Until it has come there it follows a step that is not in the recording.
//!
//! # Limits
//! Where that would take more than `MOST` of the scored samples, all stay: a doubtful past is worth
//! less than many samples.

use crate::numbers::{NORMAL_MEDIAN, median, range};

/// So near an end of the range the input is at it, as a share of the range: what lies beyond wipes
/// out next to nothing.
const NEAR: f64 = 0.05;
/// The largest noise in standard deviations: one of 16,000 normal samples is farther off.
const LARGEST: f64 = 4.0;
/// A muscle that takes so long to come within [`NEAR`] of its place is taken to be there after this
/// many times as long: a first-order lag then has a hundredth of a percent of its way to go.
const SETTLED: usize = 3;
/// The largest share of the scored samples whose past may be unknown.
const MOST: f64 = 0.25;

/// Which of the first samples are history of the input only.
///
/// ```
/// use recording::history::UnknownPast;
///
/// // An input that begins at an end of its range leaves no doubt about what was before.
/// let (time_s, input, output) = ([0.0, 1.0, 2.0], [0.0, 6.0, 0.0], [0.0, 30.0, 2.0]);
/// assert_eq!(UnknownPast::take_out(&time_s, &input, &output, &mut [true; 3]), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnknownPast {
    /// How many.
    pub samples: usize,
    /// The time of the first one after them. Unit: s.
    pub until_s: f64,
    /// Why.
    pub since: Since,
}

/// Why the past of first samples is not known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Since {
    /// The recording begins within the range of the input.
    WithinRange,
    /// The muscle is on its way to where the input is.
    OnItsWay,
}

impl UnknownPast {
    /// Takes them out of the scored samples, as many as there are reasons for; None where there are
    /// none, or too many.
    pub fn take_out(time_s: &[f64], input: &[f64], output: &[f64], scored: &mut [bool]) -> Option<Self> {
        let within = known_from(input).map(|samples| (samples, Since::WithinRange));
        let way = settled_from(input, output).map(|samples| (samples, Since::OnItsWay));
        let count = |scored: &[bool]| scored.iter().filter(|&&scored| scored).count();
        let all = count(scored);
        let is_taken = |&(samples, _): &(usize, Since)| {
            let unknown = count(&scored[..samples]);
            unknown > 0 && unknown as f64 <= MOST * all as f64
        };
        let known = within.into_iter().chain(way).filter(is_taken);
        let (samples, since) = known.max_by_key(|&(samples, _)| samples)?;
        scored[..samples].fill(false);
        Some(Self { samples, until_s: time_s[samples], since })
    }

    /// A sentence without its full stop.
    pub fn in_words(&self) -> String {
        let (until, since) = match self.since {
            Since::WithinRange => (
                format!("{:.1} s", self.until_s),
                "the recording begins within the range of the input, and until that has been at both ends its past is \
                 unknown",
            ),
            Since::OnItsWay => (
                format!("{:.3} s", self.until_s),
                "the recording begins while the muscle is still on its way to where the input is already",
            ),
        };
        format!(
            "what lies before {until}: the first {} samples are history of the input only, since {since}",
            self.samples
        )
    }
}

/// The first sample whose past is known; None where that of all samples is.
fn known_from(input: &[f64]) -> Option<usize> {
    let (low, high) = range(input);
    // The ends of the range lie beyond those that the input has been at by the largest noise, and a
    // sample there is off by as much the other way.
    let near = NEAR * (high - low) + 2.0 * LARGEST * noise(input);
    let first = |is_there: &dyn Fn(&f64) -> bool| input.iter().position(is_there);
    let (at_low, at_high) = (first(&|&x| x <= low + near)?, first(&|&x| x >= high - near)?);
    (at_low.min(at_high) > 0).then(|| at_low.max(at_high))
}

/// The first sample at which the muscle has come to where the first hold of the input takes it;
/// None where it begins there.
fn settled_from(input: &[f64], output: &[f64]) -> Option<usize> {
    let stays = 2.0 * LARGEST * noise(input);
    let held = input.iter().take_while(|&x| (x - input[0]).abs() <= stays).count();
    let place = median(&mut output.get(held - held.div_ceil(4)..held)?.to_vec());
    let (low, high) = range(output);
    let near = NEAR * (high - low) + LARGEST * noise(output);
    let there = output[..held].iter().position(|y| (y - place).abs() <= near)?;
    (there > 0).then(|| (SETTLED * there).min(held))
}

/// Standard deviation of white noise, by the median of the second differences: a ramp has none, and
/// few samples are corners of the course. Input unit.
fn noise(input: &[f64]) -> f64 {
    let mut bends: Vec<f64> = input.windows(3).map(|x| (x[0] - 2.0 * x[1] + x[2]).abs()).collect();
    if bends.is_empty() { 0.0 } else { median(&mut bends) / (NORMAL_MEDIAN * 6f64.sqrt()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{Noise, times, triangles};

    /// What is taken out of a sample a second of a triangle between 0 and 10, from a sample of it
    /// on.
    fn triangle(from: usize, samples: usize, unscored: usize) -> (Option<UnknownPast>, Vec<bool>) {
        let input: Vec<f64> =
            (from..from + samples).map(|sample| (sample as f64 % 20.0 - 10.0).abs()).collect();
        let time_s: Vec<f64> = (0..samples).map(|sample| sample as f64).collect();
        let mut scored: Vec<bool> = (0..samples).map(|sample| sample >= unscored).collect();
        (UnknownPast::take_out(&time_s, &input, &input, &mut scored), scored)
    }

    #[test]
    fn a_recording_that_begins_at_an_end_is_scored_from_its_first_sample_on() {
        for end in [0, 10] {
            let (past, scored) = triangle(end, 100, 0);
            assert_eq!(past, None);
            assert!(scored.iter().all(|&scored| scored));
        }
    }

    #[test]
    fn one_that_begins_within_the_range_is_scored_once_the_input_has_been_at_both_ends() {
        let (past, scored) = triangle(5, 100, 0);
        let since = Since::WithinRange;
        assert_eq!(past, Some(UnknownPast { samples: 15, until_s: 15.0, since }));
        assert_eq!(scored.iter().position(|&scored| scored), Some(15));
    }

    #[test]
    fn one_that_begins_at_an_end_does_so_beside_any_noise() {
        let mut noise = Noise::new(3);
        let input: Vec<f64> = times(1600, 1.0)
            .iter()
            .map(|&time_s| 0.5 * triangles(time_s, 400.0) + noise.white(0.05))
            .collect();
        assert_eq!(UnknownPast::take_out(&times(1600, 1.0), &input, &input, &mut [true; 1600]), None);
    }

    /// What is taken out of stairs of 100 samples between 4 and 0, whose output follows the first
    /// of them from there, with a lag of so many samples.
    fn stairs(from: f64, lag: f64) -> Option<UnknownPast> {
        let input: Vec<f64> = (0..1000).map(|sample| 4.0 - f64::from(sample / 100 % 5)).collect();
        let on_the_way = |sample: usize| (from - 40.0) * (-(sample as f64) / lag).exp();
        let mut noise = Noise::new(5);
        let output: Vec<f64> =
            (0..1000).map(|sample| 10.0 * input[sample] + on_the_way(sample) + noise.white(0.01)).collect();
        UnknownPast::take_out(&times(1000, 0.01), &input, &output, &mut [true; 1000])
    }

    #[test]
    fn one_that_begins_in_the_moment_of_a_step_is_scored_once_the_muscle_has_come_to_its_place() {
        let past = stairs(0.0, 2.0).expect("the muscle begins at rest");
        assert_eq!(past.since, Since::OnItsWay);
        assert!((13..=27).contains(&past.samples), "{past:?}");
        assert_eq!(stairs(40.0, 2.0), None);
    }

    #[test]
    fn it_is_so_too_where_the_input_is_at_both_ends_only_when_most_is_over() {
        let input: Vec<f64> =
            (0..1000).map(|sample| if sample < 600 { 3.0 } else { f64::from(sample / 100) - 5.0 }).collect();
        let output: Vec<f64> = (0..1000).map(|sample| if sample < 5 { 0.0 } else { input[sample] }).collect();
        let past = UnknownPast::take_out(&times(1000, 0.01), &input, &output, &mut [true; 1000]);
        assert_eq!(past.map(|past| (past.samples, past.since)), Some((15, Since::OnItsWay)));
    }

    #[test]
    fn a_slow_movement_within_the_first_hold_stays() {
        assert_eq!(stairs(39.0, 60.0), None);
    }

    #[test]
    fn samples_that_do_not_count_anyway_take_nothing_away() {
        assert_eq!(triangle(5, 100, 20).0, None);
    }

    #[test]
    fn all_samples_stay_where_too_many_would_go() {
        let (past, scored) = triangle(5, 40, 0);
        assert_eq!(past, None);
        assert!(scored.iter().all(|&scored| scored));
    }
}
