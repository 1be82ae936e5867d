//! A recording thinned for the searches: few rows stand for all that count, and the plays at them
//! are where the whole recording brings them.
//!
//! Of the rows that count so many are kept from every stretch of time, and so many from every
//! stretch of the input's way: a recording of long holds and short moves is thinned in the holds.
//! Which row of a stretch it is differs from stretch to stretch, so that no cycle is always met at
//! the same place. Its weight is how many rows it stands for: one over the share of its stretch.
//!
//! Before it come the rows at which the input has turned since the last one kept, but for those
//! that it has wiped out since (Madelung's rules): what is wiped out has left nothing in the plays.
//! Noise on the input costs a few rows more, no error. Of several recordings the first row of each
//! is kept too.
//!
//! Operators of two envelopes jump as the input turns, so that the row after each turn is kept too.
//! Even so a turn that was wiped out may have left a trace in their plays, of the height of the gap
//! between the envelopes.

use std::borrow::Cow;

use super::data::Data;
use super::envelope::Shape;
use super::row::Row;
use recording::numbers::travel;

/// The golden ratio less 1: its multiples less their whole part cover 0 … 1 evenly, however many
/// they are.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// What the input moves to and fro adds nothing to its way, as a share of its span: noise.
const BAND: f64 = 0.01;

impl Data {
    /// The recording with about `count` rows that count, no more, if it has more.
    pub fn thinned(&self, count: usize) -> Cow<'_, Self> {
        let all = self.count();
        if all <= count {
            return Cow::Borrowed(self);
        }
        let inputs: Vec<f64> = self.rows.iter().map(|row| row.input).collect();
        let way = travel(&inputs, BAND);
        let all_way = way[way.len() - 1].max(f64::MIN_POSITIVE);
        let after_turn = usize::from(self.structure.shape == Shape::TwoTanh);
        // Half of the stretches by time, half by way.
        let width = 2.0 / count as f64;
        let mut points = (0..).map(|i| (f64::from(i) + (f64::from(i) * GOLDEN).fract()) * width).peekable();
        let mut memory = Memory::new();
        let mut kept: Vec<(usize, f64)> = Vec::new();
        let (mut measure, mut way_before, mut from) = (0.0, 0.0, 0);
        for (place, (row, way)) in self.rows.iter().zip(way).enumerate() {
            // With the first row of a further recording the muscle comes from rest.
            if row.begins && place > 0 {
                (memory, from) = (Memory::new(), place);
                kept.push((place, 0.0));
            }
            memory.take(place, row.input);
            if row.weight == 0.0 {
                continue;
            }
            let step = 1.0 / all as f64 + (way - way_before) / all_way;
            (measure, way_before) = (measure + step, way);
            if points.next_if(|&point| point < measure).is_none() {
                continue;
            }
            while points.next_if(|&point| point < measure).is_some() {}
            let turns = memory.since(from).flat_map(|turn| turn..=turn + after_turn);
            kept.extend(turns.filter(|&turn| turn < place).map(|turn| (turn, 0.0)));
            kept.push((place, (width / step).max(1.0)));
            from = place + 1;
        }
        kept.dedup_by(|(place, weight), (before, kept_weight)| {
            let is_repeated = place == before;
            if is_repeated {
                *kept_weight = kept_weight.max(*weight);
            }
            is_repeated
        });
        let row = |(place, weight): (usize, f64)| Row { weight: weight as f32, ..self.rows[place] };
        let rows = kept.into_iter().map(row).collect();
        Cow::Owned(Self { rows, coordinates: self.coordinates.clone(), ..*self })
    }
}

/// Where the input has turned without having wiped it out: peaks and troughs in turn, each nearer
/// to the input than the one before.
struct Memory {
    /// Row and input of each, the last where the input is. The first stands for the past, of which
    /// a fresh muscle keeps everything: no input is below it.
    turns: Vec<(usize, f64)>,
}

impl Memory {
    fn new() -> Self {
        Self { turns: vec![(0, f64::NEG_INFINITY)] }
    }

    /// Takes the next row.
    fn take(&mut self, row: usize, input: f64) {
        if let [.., (_, before), (_, last)] = self.turns[..]
            && (input == last || (last > before) == (input > last))
        {
            self.turns.pop();
        }
        // A loop that the input closes leaves nothing.
        while let [.., (_, from), (_, turn)] = self.turns[..]
            && (if turn > from { input <= from } else { input >= from })
        {
            self.turns.truncate(self.turns.len() - 2);
        }
        self.turns.push((row, input));
    }

    /// The rows of the turns from a row on, without that where the input is.
    fn since(&self, row: usize) -> impl Iterator<Item = usize> {
        let turns = &self.turns[1..self.turns.len() - 1];
        turns[turns.partition_point(|&(turn, _)| turn < row)..].iter().map(|&(turn, _)| turn)
    }
}
