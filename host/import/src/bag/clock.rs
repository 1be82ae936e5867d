//! Topics of different rates on one clock.
//!
//! # How
//! The clock is that of the output (`contraction`, `length`, `position`, `force`), whose samples
//! stay as they were measured, else that of the topic with most messages; `--clock` names another.
//! What is measured is brought to it by straight lines between its neighbours. A command is held:
//! it is what was sent last. Before a topic's first message, behind its last, and in gaps that are
//! longer than [`GAP`] of its usual steps nothing is known: the number is missing.
//!
//! # Limits
//! A topic that is faster than the clock is not smoothed.

use std::collections::BTreeMap;

use recording::numbers::{legible, median};

use super::{NANOSECONDS, Options, Problem, Variable, belongs};
use crate::TIME_COLUMN;

/// What the recording is of: the names that a command's `--map` gives an output.
const OUTPUTS: [&str; 4] = ["contraction", "length", "position", "force"];
/// What is sent and then holds.
const HELD: &str = "command";
/// How many usual steps a straight line bridges at most: two messages lost one after the other.
const GAP: f64 = 3.0;

/// The numbers of a field, each with the place of its message.
pub type Series = Vec<(usize, f64)>;

/// The messages of a topic.
#[derive(Debug, Default)]
pub struct Topic {
    pub name: String,
    /// The type of its messages.
    kind: String,
    /// When each was recorded. Unit: ns.
    pub log_ns: Vec<i64>,
    /// What each is stamped with, if every one is. Unit: ns.
    pub stamp_ns: Vec<i64>,
    /// By their paths.
    pub fields: BTreeMap<String, Series>,
}

impl Topic {
    pub fn new(name: &str, kind: String) -> Self {
        Self { name: name.to_owned(), kind, ..Self::default() }
    }

    /// Counts a message that was recorded at a time, ns.
    pub fn count(&mut self, log_ns: u64) {
        self.log_ns.push(i64::try_from(log_ns).unwrap_or(i64::MAX));
    }

    /// What it is.
    pub fn in_words(&self) -> String {
        let Self { name, kind, log_ns, .. } = self;
        let rate = match usual_step_s(log_ns) {
            Some(step_s) => format!(", {} Hz", legible(1.0 / step_s, 1)),
            None => String::new(),
        };
        format!("{name} ({kind}): {} messages{rate}", log_ns.len())
    }

    /// The names of its variables.
    pub fn variables(&self) -> Vec<String> {
        self.fields.keys().map(|path| self.variable(path)).collect()
    }

    /// A variable's name: that of the topic, if there is but one number in its messages.
    fn variable(&self, path: &str) -> String {
        let Self { name, fields, .. } = self;
        if fields.len() == 1 && path == "data" { name.clone() } else { format!("{name}.{path}") }
    }

    fn is_stamped(&self) -> bool {
        self.stamp_ns.len() == self.log_ns.len() && self.stamp_ns.iter().all(|stamp| *stamp != 0)
    }
}

/// The usual step of times that need not be in order. Units: ns, s.
fn usual_step_s(times_ns: &[i64]) -> Option<f64> {
    let mut sorted = times_ns.to_vec();
    sorted.sort_unstable();
    let mut steps: Vec<f64> = sorted
        .windows(2)
        .map(|pair| (pair[1] - pair[0]) as f64 / NANOSECONDS)
        .filter(|step| *step > 0.0)
        .collect();
    (!steps.is_empty()).then(|| median(&mut steps))
}

/// The variables on one clock, their times first, and how they got there.
///
/// # Errors
/// There is no number, or no such topic for a clock.
pub fn on_one(topics: Vec<Topic>, options: &Options) -> Result<(Vec<Variable>, Vec<String>), Problem> {
    let topic_of = |variable: &str| topics.iter().find(|topic| belongs(variable, &topic.name));
    let mut outputs = options.columns.iter().filter(|renamed| OUTPUTS.contains(&renamed.name.as_str()));
    let chosen = match (options.clock, outputs.next()) {
        (Some(name), _) => Some(topic_of(name).ok_or_else(|| Problem::NoTopic {
            wanted: name.to_owned(),
            present: topics.iter().map(|topic| topic.name.as_str()).collect::<Vec<_>>().join(", "),
        })?),
        (None, Some(output)) => topic_of(&output.column),
        (None, None) => None,
    };
    let fastest = topics.iter().max_by_key(|topic| topic.log_ns.len());
    let clock = chosen.or(fastest).ok_or(Problem::Nothing)?;
    let is_stamped = topics.iter().all(Topic::is_stamped);
    let times_of = |topic: &Topic| if is_stamped { topic.stamp_ns.clone() } else { topic.log_ns.clone() };
    let mut clock_ns = times_of(clock);
    clock_ns.sort_unstable();
    clock_ns.dedup();
    let first_ns = clock_ns.first().copied().unwrap_or(0);
    let seconds = |ns: &i64| (ns - first_ns) as f64 / NANOSECONDS;
    let mut notes = vec![format!(
        "clock: {}, {} samples, by {}",
        clock.name,
        clock_ns.len(),
        if is_stamped { "the stamps of the messages" } else { "when messages were recorded" }
    )];
    let mut variables = vec![(TIME_COLUMN.to_owned(), clock_ns.iter().map(seconds).collect())];
    for topic in &topics {
        let times_ns = times_of(topic);
        for (path, series) in &topic.fields {
            let name = topic.variable(path);
            let renamed = options.columns.iter().find(|renamed| renamed.column == name);
            if !options.columns.is_empty() && renamed.is_none() {
                continue;
            }
            let is_held = renamed.is_some_and(|renamed| renamed.name == HELD);
            let values = resampled(&times_ns, series, &clock_ns, is_held);
            let missing = values.iter().filter(|value| value.is_nan()).count();
            if topic.name != clock.name || missing > 0 {
                let how = match (topic.name == clock.name, is_held) {
                    (true, _) => "as recorded",
                    (_, true) => "held from message to message",
                    _ => "straight lines between messages",
                };
                notes.push(format!("{name}: {how}, {missing} samples missing"));
            }
            variables.push((name, values));
        }
    }
    Ok((variables, notes))
}

/// A series at the times of a clock, which rise. Of messages of one time the last counts.
fn resampled(times_ns: &[i64], series: &Series, clock_ns: &[i64], is_held: bool) -> Vec<f64> {
    let mut points: Vec<(i64, f64)> =
        series.iter().map(|(message, value)| (times_ns[*message], *value)).collect();
    points.sort_by_key(|(time, _)| *time);
    let times: Vec<i64> = points.iter().map(|(time, _)| *time).collect();
    let longest_ns = usual_step_s(&times).map_or(0.0, |step_s| GAP * step_s * NANOSECONDS);
    let at = |time: &i64| {
        let behind = points.partition_point(|(point, _)| point <= time);
        let Some(&(before, value)) = behind.checked_sub(1).map(|place| &points[place]) else {
            return f64::NAN;
        };
        if before == *time || is_held {
            return value;
        }
        match points.get(behind) {
            Some(&(after, next)) if (after - before) as f64 <= longest_ns => {
                value + (next - value) * ((time - before) as f64 / (after - before) as f64)
            }
            _ => f64::NAN,
        }
    };
    clock_ns.iter().map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(times_ns: &[i64], values: &[f64], clock_ns: &[i64], is_held: bool) -> Vec<f64> {
        let series = values.iter().copied().enumerate().collect();
        resampled(times_ns, &series, clock_ns, is_held)
    }

    #[test]
    fn what_is_measured_is_bridged_what_is_sent_is_held_and_nothing_is_made_up() {
        let (times, values) = ([10, 20, 30, 100, 110], [1.0, 2.0, 4.0, 9.0, 9.0]);
        let clock = [5, 10, 15, 25, 30, 60, 100, 115];
        let nan = f64::NAN;
        let same = |found: Vec<f64>, wanted: [f64; 8]| {
            let is_same = found.iter().zip(&wanted).all(|(a, b)| a == b || a.is_nan() && b.is_nan());
            assert!(is_same && found.len() == wanted.len(), "{found:?}");
        };
        same(at(&times, &values, &clock, false), [nan, 1.0, 1.5, 3.0, 4.0, nan, 9.0, nan]);
        same(at(&times, &values, &clock, true), [nan, 1.0, 1.0, 2.0, 4.0, 4.0, 9.0, 9.0]);
    }

    #[test]
    fn messages_out_of_order_are_put_in_order_and_of_two_at_a_time_the_last_counts() {
        assert_eq!(
            at(&[30, 10, 20, 20], &[3.0, 1.0, 7.0, 2.0], &[10, 20, 25, 30], false),
            [1.0, 2.0, 2.5, 3.0]
        );
    }
}
