//! What a recording excites: swings, speeds, holds, repeats, travel, and the columns beside the input.
//!
//! # Design
//! A swing goes from one turning point of the input to the next, by at least a twentieth of the span; its speed is its height
//! over the time in which the input moved. Two swings go over the same range when what they have in common is at least
//! two thirds of what they cover together; they are alike when it is nine tenths. Speeds are compared on such pairs only: where each speed has a height of its
//! own, no effect of the speed can be told from one of the height.

use serde::Serialize;

use super::Residual;
use super::axis::follows_time;
use super::motion::{LEAST_SWING, Motion, since_elsewhere};
use recording::noise::{floor, steps};
use recording::numbers::range;

/// The shortest hold that counts. Unit: s.
const LEAST_HOLD_S: f64 = 1.0;
/// A hold at the end of a way that has lasted at most so long ends a jump. Unit: s.
const JUMP_S: f64 = 0.5;
/// A plateau stays within this share of the input's span, and comes after a jump over this one.
const PLATEAU: f64 = 0.05;
const JUMP: f64 = 0.25;
/// What two swings over the same range have in common, of what they cover together.
const SAME_RANGE: f64 = 2.0 / 3.0;
/// The same for swings that are alike.
const ALIKE: f64 = 0.9;
/// The most swings whose pairs are looked at.
const MOST_SWINGS: usize = 2000;
/// A column varies when its span is that many times its noise.
const VARIES: f64 = 8.0;

/// What a recording excites. Input and output in their units.
#[derive(Clone, Debug, Serialize)]
pub struct Excitation {
    /// From the first row to the last. Unit: s.
    pub duration_s: f64,
    /// Median step of time. Unit: s.
    pub step_s: f64,
    /// Highest less lowest input.
    pub input_span: f64,
    /// Number of swings.
    pub swings: usize,
    /// Height of the smallest swing, as a share of the input's span.
    pub smallest_swing: f64,
    /// Number of different heights of swings, a tenth of the span apart.
    pub heights: usize,
    /// The slowest swing. Unit: input unit/s.
    pub slowest: f64,
    /// The fastest swing. Unit: input unit/s.
    pub fastest: f64,
    /// The largest ratio of the speeds of two swings over the same range; 1 where there are no two.
    pub speed_ratio: f64,
    /// Holds, from the first to the last.
    pub holds: Vec<Hold>,
    /// Holds after a jump.
    pub jumps: usize,
    /// Lengths of the stretches after a jump, of a second at least, in which the input moves by little: what is called a hold moves
    /// not at all. Unit: s.
    pub plateaus_s: Vec<f64>,
    /// The longest time between two swings that are alike, in the same direction. Unit: s.
    pub repeated_over_s: f64,
    /// Most swings that are alike, in the same direction.
    pub repeats: usize,
    /// Way of the output, in strokes.
    pub travel_strokes: f64,
    /// The load, if there is such a column.
    pub load: Option<Variation>,
    /// The temperature, if there is such a column.
    pub temperature: Option<Variation>,
}

/// A stretch in which the input is held.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Hold {
    /// Its begin. Unit: s.
    pub from_s: f64,
    /// How long it lasts. Unit: s.
    pub length_s: f64,
    /// Mean input.
    pub level: f64,
    /// Whether the input jumped there.
    pub after_jump: bool,
}

/// How a column varies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Variation {
    /// Lowest value. Unit of the column.
    pub low: f64,
    /// Highest value. Unit of the column.
    pub high: f64,
    /// Whether it varies by more than its noise.
    pub varies: bool,
    /// Whether it goes up or down steadily with time, so that it cannot be told from a drift.
    pub follows_time: bool,
}

/// From one turning point to the next.
#[derive(Clone, Copy, Debug)]
struct Swing {
    from: f64,
    to: f64,
    from_s: f64,
    /// Unit: input unit/s.
    speed: f64,
}

impl Excitation {
    /// Looks at a recording with at least two rows.
    pub fn of(residual: &Residual<'_>) -> Self {
        let Residual { time_s, input, output, load, temperature, .. } = *residual;
        let motion = Motion::of(residual);
        let (low, high) = range(input);
        let swings = swings(time_s, input, &motion);
        let speeds = || swings.iter().map(|swing| swing.speed);
        let holds = holds(time_s, input, &motion);
        let (repeats, repeated_over_s) = repeats(&swings);
        let (lowest, highest) = range(output);
        let way = motion.travel.last().copied().unwrap_or(0.0);
        Self {
            duration_s: time_s.last().unwrap_or(&0.0) - time_s.first().unwrap_or(&0.0),
            step_s: steps(time_s).0,
            input_span: high - low,
            swings: swings.len(),
            smallest_swing: swings.iter().map(|swing| swing.height() / (high - low)).fold(1.0, f64::min),
            heights: heights(&swings, high - low),
            slowest: speeds().fold(f64::INFINITY, f64::min),
            fastest: speeds().fold(0.0, f64::max),
            speed_ratio: speed_ratio(&swings),
            jumps: holds.iter().filter(|hold| hold.after_jump).count(),
            holds,
            plateaus_s: plateaus_s(time_s, input),
            repeated_over_s,
            repeats,
            travel_strokes: if highest > lowest { way / (highest - lowest) } else { 0.0 },
            load: load.map(|column| Variation::of(time_s, column)),
            temperature: temperature.map(|column| Variation::of(time_s, column)),
        }
    }

    /// The longest hold; 0 if there is none. Unit: s.
    pub fn longest_hold_s(&self) -> f64 {
        self.holds.iter().map(|hold| hold.length_s).fold(0.0, f64::max)
    }
}

impl Variation {
    fn of(time_s: &[f64], column: &[f64]) -> Self {
        let (low, high) = range(column);
        let noise = floor(time_s, column);
        // A step of the sensor is noise where the value goes to and fro, and none where it is changed in clean steps.
        let deviation = if has_clean_steps(time_s, column) { 0.0 } else { noise.deviation };
        Self {
            low,
            high,
            varies: high - low > VARIES * deviation,
            follows_time: follows_time(time_s, column),
        }
    }
}

/// Whether a column is held between any two changes, and so is not seen to flicker.
fn has_clean_steps(time_s: &[f64], column: &[f64]) -> bool {
    let changes_s: Vec<f64> =
        (1..column.len()).filter(|&row| column[row] != column[row - 1]).map(|row| time_s[row]).collect();
    changes_s.windows(2).all(|pair| pair[1] - pair[0] >= LEAST_HOLD_S)
}

impl Swing {
    fn height(&self) -> f64 {
        (self.to - self.from).abs()
    }

    /// What two swings have in common, of what they cover together; below 0 where they have nothing.
    fn common(&self, other: &Self) -> f64 {
        let ends = |swing: &Self| (swing.from.min(swing.to), swing.from.max(swing.to));
        let ((low, high), (other_low, other_high)) = (ends(self), ends(other));
        (high.min(other_high) - low.max(other_low)) / (high.max(other_high) - low.min(other_low))
    }

    fn is_like(&self, other: &Self) -> bool {
        (self.to > self.from) == (other.to > other.from) && self.common(other) >= ALIKE
    }
}

/// The swings of the input; what is smaller than the least, or has a gap in it, counts as none.
fn swings(time_s: &[f64], input: &[f64], motion: &Motion) -> Vec<Swing> {
    let (low, high) = range(input);
    let (_, gap_s) = steps(time_s);
    let swing = |ends: &[usize]| {
        let (from, to) = (ends[0], ends[1]);
        let has_gap = time_s[from..=to].windows(2).any(|pair| pair[1] - pair[0] > gap_s);
        let moved_s: f64 = (from..to)
            .filter(|&row| motion.direction[row] != 0.0)
            .map(|row| time_s[row + 1] - time_s[row])
            .sum();
        let height = (input[to] - input[from]).abs();
        let counts = !has_gap && height >= LEAST_SWING * (high - low) && moved_s > 0.0;
        counts.then_some(Swing {
            from: input[from],
            to: input[to],
            from_s: time_s[from],
            speed: height / moved_s,
        })
    };
    motion.ends.windows(2).filter_map(swing).collect()
}

/// At most so many of the swings, evenly taken.
fn thinned(swings: &[Swing]) -> Vec<Swing> {
    swings.iter().step_by(swings.len().div_ceil(MOST_SWINGS).max(1)).copied().collect()
}

fn speed_ratio(swings: &[Swing]) -> f64 {
    let swings = thinned(swings);
    let pairs =
        swings.iter().enumerate().flat_map(|(i, one)| swings[i + 1..].iter().map(move |other| (one, other)));
    pairs
        .filter(|(one, other)| one.common(other) >= SAME_RANGE)
        .map(|(one, other)| (one.speed / other.speed).max(other.speed / one.speed))
        .fold(1.0, f64::max)
}

/// Most swings that are alike, and the longest time between two such. Unit of the latter: s.
fn repeats(swings: &[Swing]) -> (usize, f64) {
    let swings = thinned(swings);
    swings.iter().fold((0, 0.0_f64), |(most, longest_s), one| {
        let alike = || swings.iter().filter(|other| one.is_like(other));
        let last_s = alike().map(|other| other.from_s).fold(one.from_s, f64::max);
        (most.max(alike().count()), longest_s.max(last_s - one.from_s))
    })
}

/// How many heights there are, a tenth of the span apart.
fn heights(swings: &[Swing], span: f64) -> usize {
    let mut classes: Vec<i64> =
        swings.iter().map(|swing| (10.0 * swing.height() / span).round() as i64).collect();
    classes.sort_unstable();
    classes.dedup();
    classes.len()
}

fn holds(time_s: &[f64], input: &[f64], motion: &Motion) -> Vec<Hold> {
    let rows: Vec<usize> = (0..input.len()).collect();
    let is_held = |row: usize| motion.direction[row] == 0.0;
    let (_, gap_s) = steps(time_s);
    rows.chunk_by(|&one, &other| is_held(one) == is_held(other) && time_s[other] - time_s[one] <= gap_s)
        .filter(|rows| is_held(rows[0]))
        .filter_map(|rows| {
            let (first, last) = (rows[0], rows[rows.len() - 1]);
            let length_s = time_s[last] - time_s[first];
            let level = input[first..=last].iter().sum::<f64>() / rows.len() as f64;
            let stood = (0..first).rev().find(|&row| is_held(row));
            let after_jump =
                stood.is_some_and(|row| row + 1 < first && time_s[first] - time_s[row] <= JUMP_S);
            (length_s >= LEAST_HOLD_S).then_some(Hold { from_s: time_s[first], length_s, level, after_jump })
        })
        .collect()
}

/// Lengths of the plateaus that the input jumps to. Unit: s.
fn plateaus_s(time_s: &[f64], input: &[f64]) -> Vec<f64> {
    let (low, high) = range(input);
    let span = high - low;
    let since_s = since_elsewhere(time_s, input, PLATEAU * span);
    let from_s = |row: usize| time_s[row] - since_s[row];
    let jumps_to = |first: usize| {
        let before = (0..first).rev().take_while(|&row| time_s[first] - time_s[row] <= JUMP_S);
        before.into_iter().any(|row| (input[first] - input[row]).abs() >= JUMP * span)
    };
    let mut last_s = f64::NEG_INFINITY;
    let plateau = |row: usize| {
        // The longest of those that begin there.
        let ends = row + 1 == time_s.len() || from_s(row + 1) > from_s(row);
        let first = time_s.partition_point(|&time_s| time_s < from_s(row));
        let is_one = ends && since_s[row] >= LEAST_HOLD_S && from_s(row) > last_s && jumps_to(first);
        is_one.then(|| {
            last_s = time_s[row];
            since_s[row]
        })
    };
    (0..time_s.len()).filter_map(plateau).collect()
}
