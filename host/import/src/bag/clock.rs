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
//! A topic that is faster than the clock is not smoothed. No numbers are held, but those of topics
//! whose messages are out of order.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::sync::Arc;

use recording::numbers::legible;

use super::list::{List, Store, Word};
use super::{NANOSECONDS, Options, Problem, belongs};
use crate::array::Array;
use crate::number::Kind;
use crate::{TIME_COLUMN, scratch};

/// What the recording is of: the names that a command's `--map` gives an output.
const OUTPUTS: [&str; 4] = ["contraction", "length", "position", "force"];
/// What is sent and then holds.
const HELD: &str = "command";
/// How many usual steps a straight line bridges at most: two messages lost one after the other.
const GAP: f64 = 3.0;

/// How a column on the clock is written.
const WRITTEN: Kind = Kind { letter: 'f', width: 8, is_big_endian: false };

/// The messages of a topic.
#[derive(Debug, Default)]
pub struct Topic {
    pub name: String,
    /// The type of its messages.
    kind: String,
    /// When each was recorded, and what it is stamped with; 0 if with nothing. Unit: ns.
    times: List<i64>,
    /// By their paths; each number with the place of its message.
    pub fields: BTreeMap<String, List<f64>>,
    is_stamped: bool,
    /// Whether the times when they were recorded, and the stamps, come in order.
    in_order: [bool; 2],
    /// Those of the last message.
    last_ns: [i64; 2],
}

impl Topic {
    pub fn new(name: &str, kind: String) -> Self {
        Self {
            name: name.to_owned(),
            kind,
            is_stamped: true,
            in_order: [true; 2],
            last_ns: [i64::MIN; 2],
            ..Self::default()
        }
    }

    /// How many messages there are.
    pub fn messages(&self) -> usize {
        self.times.len()
    }

    /// Counts a message that was recorded at a time, and may have a stamp. Unit: ns.
    ///
    /// # Errors
    /// The store takes no more.
    pub fn count(&mut self, store: &mut Store, log_ns: u64, stamp_ns: Option<i64>) -> io::Result<()> {
        let times_ns = [i64::try_from(log_ns).unwrap_or(i64::MAX), stamp_ns.unwrap_or(0)];
        for (place, time_ns) in times_ns.into_iter().enumerate() {
            self.in_order[place] &= self.last_ns[place] <= time_ns;
        }
        self.is_stamped &= times_ns[1] != 0;
        self.last_ns = times_ns;
        store.push(&mut self.times, times_ns.into())
    }

    /// What it is.
    ///
    /// # Errors
    /// The store cannot be read, or takes no more.
    pub fn in_words(&self, store: &mut Store) -> io::Result<String> {
        let Self { name, kind, .. } = self;
        let sorted = self.sorted(store, false)?;
        let rate = match usual_step_s(store, &sorted)? {
            Some(step_s) => format!(", {} Hz", legible(1.0 / step_s, 1)),
            None => String::new(),
        };
        Ok(format!("{name} ({kind}): {} messages{rate}", self.messages()))
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

    /// The times of its messages in order: their stamps, or when they were recorded.
    fn sorted(&self, store: &mut Store, by_stamps: bool) -> io::Result<List<i64>> {
        let one = |times: io::Result<(i64, i64)>| times.map(|times| (time(times, by_stamps), 0));
        let times = store.items(&self.times).map(one);
        store.sorted(times, self.in_order[usize::from(by_stamps)])
    }

    /// The numbers of a field in order, each with the time of its message.
    fn points(&self, store: &mut Store, field: &List<f64>, by_stamps: bool) -> io::Result<List<f64>> {
        let mut times = store.items(&self.times);
        let (mut message, mut times_ns) = (-1, (0, 0));
        let points = store.items(field).map(|number| {
            let (place, value) = number?;
            while message < place {
                times_ns = times.next().unwrap_or(Err(io::ErrorKind::UnexpectedEof.into()))?;
                message += 1;
            }
            Ok((time(times_ns, by_stamps), value))
        });
        store.sorted(points, self.in_order[usize::from(by_stamps)])
    }
}

fn time((log_ns, stamp_ns): (i64, i64), by_stamps: bool) -> i64 {
    if by_stamps { stamp_ns } else { log_ns }
}

/// The usual step of times that are in order: the middle one of those that are no 0. It is found
/// two bytes at a time, since there may be too many to be held.
fn usual_step_s<W: Word>(store: &Store, times_ns: &List<W>) -> io::Result<Option<f64>> {
    let (mut known, mut rank) = (0_u64, None);
    for shift in [48, 32, 16, 0] {
        let mut counts = vec![0_usize; 1 << 16];
        let mut before = None;
        for time in store.items(times_ns) {
            let (time, _) = time?;
            let step = before.map_or(0, |before| time.abs_diff(before));
            before = Some(time);
            // The bytes above these; of the first ones there are none.
            if step > 0 && (step >> shift) >> 16 == known {
                counts[(step >> shift) as usize & 0xffff] += 1;
            }
        }
        let mut rest = rank.unwrap_or(counts.iter().sum::<usize>() / 2);
        let here = counts.iter().position(|&count| match rest.checked_sub(count) {
            Some(less) => {
                rest = less;
                false
            }
            None => true,
        });
        let Some(here) = here else { return Ok(None) };
        (known, rank) = ((known << 16) | here as u64, Some(rest));
    }
    Ok(Some(known as f64 / NANOSECONDS))
}

/// The variables on one clock, their times first, and how they got there.
///
/// # Errors
/// There is no number, or no such topic for a clock.
pub fn on_one(
    topics: Vec<Topic>,
    store: &mut Store,
    options: &Options,
) -> Result<(Vec<Array>, Vec<String>), Problem> {
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
    let fastest = topics.iter().max_by_key(|topic| topic.messages());
    let clock = chosen.or(fastest).ok_or(Problem::Nothing)?;
    let by_stamps = topics.iter().all(|topic| topic.is_stamped);
    let clock_ns = clock.sorted(store, by_stamps)?;
    let mut notes = Vec::new();
    // The names of the columns, which stand in the file one behind the other.
    let mut names = vec![TIME_COLUMN.to_owned()];
    let mut rows = 0;
    let file = scratch::file(options.scratch, |target| {
        rows = seconds(store, &clock_ns, target)?;
        notes.push(format!(
            "clock: {}, {rows} samples, by {}",
            clock.name,
            if by_stamps { "the stamps of the messages" } else { "when messages were recorded" }
        ));
        for topic in &topics {
            for (path, field) in &topic.fields {
                let name = topic.variable(path);
                let renamed = options.columns.iter().find(|renamed| renamed.column == name);
                if !options.columns.is_empty() && renamed.is_none() {
                    continue;
                }
                let is_held = renamed.is_some_and(|renamed| renamed.name == HELD);
                let points = topic.points(store, field, by_stamps)?;
                let missing = resampled(store, &points, &clock_ns, is_held, target)?;
                if topic.name != clock.name || missing > 0 {
                    let how = match (topic.name == clock.name, is_held) {
                        (true, _) => "as recorded",
                        (_, true) => "held from message to message",
                        _ => "straight lines between messages",
                    };
                    notes.push(format!("{name}: {how}, {missing} samples missing"));
                }
                names.push(name);
            }
        }
        Ok(())
    })?;
    let file = Arc::new(file);
    let column = |(place, name): (usize, String)| Array {
        file: Arc::clone(&file),
        begins: (place * rows * WRITTEN.width) as u64,
        fields: vec![(name.clone(), WRITTEN)],
        name,
        rows,
        width: 1,
        is_by_columns: true,
    };
    Ok((names.into_iter().enumerate().map(column).collect(), notes))
}

/// The times of a clock, each once.
fn distinct(store: &Store, clock_ns: &List<i64>) -> impl Iterator<Item = io::Result<i64>> {
    let mut before = None;
    store.items(clock_ns).filter_map(move |time| match time {
        Ok((time, _)) => (before.replace(time) != Some(time)).then_some(Ok(time)),
        Err(error) => Some(Err(error)),
    })
}

/// Writes the times of a clock since the first one, s; answers how many.
fn seconds(store: &Store, clock_ns: &List<i64>, target: &mut dyn Write) -> io::Result<usize> {
    let (mut first_ns, mut count) = (None, 0);
    for time_ns in distinct(store, clock_ns) {
        let time_ns = time_ns?;
        let since_ns = time_ns - *first_ns.get_or_insert(time_ns);
        target.write_all(&(since_ns as f64 / NANOSECONDS).to_le_bytes())?;
        count += 1;
    }
    Ok(count)
}

/// Writes a series at the times of a clock; answers how many are missing. Of messages of one time
/// the last counts.
fn resampled(
    store: &Store,
    points: &List<f64>,
    clock_ns: &List<i64>,
    is_held: bool,
    target: &mut dyn Write,
) -> io::Result<usize> {
    let longest_ns = usual_step_s(store, points)?.map_or(0.0, |step_s| GAP * step_s * NANOSECONDS);
    let mut ahead = store.items(points);
    let (mut before, mut after) = (None, ahead.next().transpose()?);
    let mut missing = 0;
    for time in distinct(store, clock_ns) {
        let time = time?;
        while let Some((at, _)) = after.filter(|(at, _)| *at <= time) {
            before = after;
            after = ahead.next().transpose()?;
            debug_assert!(after.is_none_or(|(next, _)| at <= next), "points are in order");
        }
        let value = match (before, after) {
            (None, _) => f64::NAN,
            (Some((at, value)), _) if at == time || is_held => value,
            (Some((at, value)), Some((then, next))) if (then - at) as f64 <= longest_ns => {
                value + (next - value) * ((time - at) as f64 / (then - at) as f64)
            }
            _ => f64::NAN,
        };
        missing += usize::from(value.is_nan());
        target.write_all(&value.to_le_bytes())?;
    }
    Ok(missing)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The list of items that come in any order.
    fn list<W: Word>(store: &mut Store, items: impl Iterator<Item = (i64, W)>) -> List<W> {
        store.sorted(items.map(Ok), false).expect("it is written")
    }

    fn at(times_ns: &[i64], values: &[f64], clock_ns: &[i64], is_held: bool) -> Vec<f64> {
        let mut store = Store::new(None).expect("a file");
        let points = list(&mut store, times_ns.iter().copied().zip(values.iter().copied()));
        let clock_ns = list(&mut store, clock_ns.iter().map(|time| (*time, 0)));
        let mut written = Vec::new();
        resampled(&store, &points, &clock_ns, is_held, &mut written).expect("in memory");
        written.chunks(8).map(|bytes| f64::from_le_bytes(bytes.try_into().expect("8 bytes"))).collect()
    }

    #[test]
    fn the_usual_step_is_the_middle_one_of_those_that_are_no_zero() {
        let mut store = Store::new(None).expect("a file");
        for times_ns in [
            vec![],
            vec![7],
            vec![5, 5, 5],
            vec![0, 10, 10, 30, 60],
            (0..3000).map(|place: i64| place * 1_000_003 + place * place % 977).collect(),
            vec![i64::MIN / 4, -1, 0, 1 << 20, 1 << 40, i64::MAX / 4],
        ] {
            let mut steps: Vec<i64> = times_ns.windows(2).map(|pair| pair[1] - pair[0]).collect();
            steps.retain(|step| *step > 0);
            steps.sort_unstable();
            let expected = steps.get(steps.len() / 2).map(|step| *step as f64 / NANOSECONDS);
            let times = list(&mut store, times_ns.iter().map(|time| (*time, 0)));
            assert_eq!(usual_step_s(&store, &times).expect("it is read"), expected, "{times_ns:?}");
        }
    }

    #[test]
    fn numbers_keep_the_time_of_their_message_however_many_of_them_it_has() {
        let mut store = Store::new(None).expect("a file");
        let mut topic = Topic::new("/p", "number".to_owned());
        for log_ns in [10, 30, 20] {
            topic.count(&mut store, log_ns, None).expect("it is written");
        }
        let field = list(&mut store, [(0, 1.0), (0, 2.0), (2, 3.0)].into_iter());
        let points = topic.points(&mut store, &field, false).expect("it is read");
        let found: Vec<(i64, f64)> = store.items(&points).collect::<io::Result<_>>().expect("it is read");
        assert_eq!(found, [(10, 1.0), (10, 2.0), (20, 3.0)]);
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
