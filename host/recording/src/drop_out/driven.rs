//! Which steps of a signal are explained by what drives it, or by what it drives.
//!
//! A step of the input explains a step of the output by its share of the input's range, then and
//! shortly after. The other way round a step of the input is explained if the output answers: by
//! its way, as a share of its range, then and shortly after. So a spike of the input has to be
//! larger than what the output's way in a second amounts to.

use std::collections::VecDeque;

use super::find::{OUTER, steps, usual_step_s};
use crate::numbers::quantiles;

/// A step explains one that has up to so many times its share of the range: loops are that much
/// steeper at places than on average.
const STEEP: f64 = 3.0;
/// An effect comes so long after its cause at most (a valve, a long hose). Unit: s.
const LATE_S: f64 = 1.0;
/// And at least so many samples after it, where these are farther apart.
const LATE_SAMPLES: f64 = 3.0;

/// The step of the output that the input explains, after each sample but the last. Output unit.
pub fn by_input(time_s: &[f64], input: &[f64], output: &[f64]) -> Vec<f64> {
    let steps = steps(time_s, input, usual_step_s(time_s));
    let sizes: Vec<f64> = steps.iter().map(|step| step.abs()).collect();
    let scale = STEEP * span(output) / span(input);
    largest_lately(time_s, &sizes).into_iter().map(|size| scale * size).collect()
}

/// The step of the input that the output's answer explains, after each sample but the last. Input
/// unit.
pub fn by_answer(time_s: &[f64], input: &[f64], output: &[f64]) -> Vec<f64> {
    // What comes after is what has been, backwards.
    let backwards =
        |values: &[f64], sign: f64| values.iter().rev().map(|value| sign * value).collect::<Vec<f64>>();
    let time_s = backwards(time_s, -1.0);
    let [highest, lowest] = [1.0, -1.0].map(|sign| largest_lately(&time_s, &backwards(output, sign)));
    let scale = STEEP * span(input) / span(output);
    let ways = highest.iter().zip(&lowest).rev().map(|(high, low)| scale * (high + low));
    ways.take(input.len() - 1).collect()
}

/// The range of nearly all values.
fn span(values: &[f64]) -> f64 {
    let (low, high) = quantiles(values, OUTER);
    (high - low).max(f64::MIN_POSITIVE)
}

/// For each value the largest one, of it and those that came shortly before.
fn largest_lately(time_s: &[f64], values: &[f64]) -> Vec<f64> {
    let late_s = LATE_S.max(LATE_SAMPLES * usual_step_s(time_s));
    // Those that no later one exceeds, so that the first is the largest.
    let mut recent: VecDeque<usize> = VecDeque::new();
    let mut largest = |at: usize| {
        while recent.back().is_some_and(|&before| values[before] <= values[at]) {
            recent.pop_back();
        }
        recent.push_back(at);
        while recent.front().is_some_and(|&before| time_s[before] < time_s[at] - late_s) {
            recent.pop_front();
        }
        recent.front().map_or(0.0, |&at| values[at])
    };
    (0..values.len()).map(&mut largest).collect()
}
