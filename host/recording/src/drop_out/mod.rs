//! Drop-outs: samples that a sensor or a logger has made, and no muscle.
//!
//! They are found before anything else is done with a recording: they have no part in the stroke,
//! in ranges, bounds and scales, they are not scored, and their values are replaced by a straight
//! line. What is said of the recording says where they were.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | `mod` | the drop-outs of a recording |
//! | `find` | those of a signal, and what makes a run of samples one |
//! | `driven` | which jumps are explained by what drives a signal |
//! | `words` | what is said of them, for people and programs |
//!
//! # Power
//! On recordings of measured and simulated muscles without drop-outs none is found. Of drop-outs of
//! 1 to 50 samples that are off by a tenth of the stroke at least, about 94 % of those of one value
//! are found; of those that scatter about a value 72 to 91 %, of those anywhere in the range 90 %
//! of single samples and 26 % of fifty. Where they begin and end in more than one of a hundred
//! samples, only values far outside the range are found; a drop-out that lasts to the end of a
//! short recording hides the others.

mod driven;
mod find;
#[cfg(test)]
mod tests;
mod words;

use std::ops::Range;

pub use words::{in_words, to_json};

use crate::Series;
use crate::numbers::range;
use crate::unit::{Channel, Unit};
use find::Signal;

/// The largest acceleration of a muscle. Unit: mm/s². Ten times that of gravity: fast valves and
/// light loads come to a few.
const ACCELERATION_MM_PER_S2: f64 = 1e5;

/// Samples in a row of one column that are no measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct DropOut {
    /// The column.
    pub channel: Channel,
    /// The samples, counted from 0.
    pub samples: Range<usize>,
    /// Times of the first and the last. Unit: s.
    pub time_s: (f64, f64),
    /// The file's lines of the first and the last.
    pub lines: (usize, usize),
    /// The lowest and the highest value. Unit of the column.
    pub values: (f64, f64),
    /// The largest distance from the straight line between the samples before and after. Unit of
    /// the column.
    pub distance: f64,
}

/// Finds the drop-outs of an input and an output, in the order of time, and puts straight lines in
/// their place. `line` is the file's line of a sample.
pub fn take_out(
    time_s: &[f64],
    input: &mut Series,
    output: &mut Series,
    line: impl Fn(usize) -> usize,
) -> Vec<DropOut> {
    if time_s.len() < 2 {
        return Vec::new();
    }
    let of_output = Signal {
        time_s,
        values: &output.values,
        driven: driven::by_input(time_s, &input.values, &output.values),
        acceleration: Unit::MM.convert(ACCELERATION_MM_PER_S2, output.channel.unit),
    }
    .drop_outs();
    let mut found = bridge_over(time_s, output, of_output, &line);
    // Whether the muscle answers a step of the input is seen in what is sound of the output.
    let of_input = Signal {
        time_s,
        values: &input.values,
        driven: driven::by_answer(time_s, &input.values, &output.values),
        acceleration: None,
    }
    .drop_outs();
    found.extend(bridge_over(time_s, input, of_input, &line));
    found.sort_by_key(|drop_out| drop_out.samples.start);
    found
}

/// Puts straight lines in the place of runs of samples, and tells what was there.
fn bridge_over(
    time_s: &[f64],
    series: &mut Series,
    runs: Vec<Range<usize>>,
    line: &impl Fn(usize) -> usize,
) -> Vec<DropOut> {
    let Series { channel, values } = series;
    let mut take = |samples: Range<usize>| {
        let (first, last) = (samples.start, samples.end - 1);
        let range = range(&values[samples.clone()]);
        let mut distance: f64 = 0.0;
        for at in samples.clone() {
            let bridged = bridge(time_s, values, &samples, at);
            distance = distance.max((values[at] - bridged).abs());
            values[at] = bridged;
        }
        DropOut {
            channel: channel.clone(),
            time_s: (time_s[first], time_s[last]),
            lines: (line(first), line(last)),
            values: range,
            distance,
            samples,
        }
    };
    runs.into_iter().map(&mut take).collect()
}

/// The value on the straight line over a run; on a level one at either end of the recording.
fn bridge(time_s: &[f64], values: &[f64], run: &Range<usize>, at: usize) -> f64 {
    match (run.start.checked_sub(1), Some(run.end).filter(|&end| end < values.len())) {
        (Some(before), Some(after)) => {
            // Neither the times nor the values may be so far apart that their difference is no
            // number.
            let share = (time_s[at] - time_s[before]) / (time_s[after] - time_s[before]);
            let share = if share.is_finite() { share } else { 0.0 };
            (1.0 - share) * values[before] + share * values[after]
        }
        (Some(side), None) | (None, Some(side)) => values[side],
        (None, None) => values[at],
    }
}
