//! What a search needs of a recording at a point of its coordinates, summed up in one pass over the
//! rows.
//!
//! In a segment of the memoryless stage the model's output and its derivatives by all unknowns are
//! straight lines in a few entries a row: the derivatives of u, the added functions, 1, and the way
//! gone in the segment. So the sums of the products of these entries, segment by segment, are all
//! that least squares needs, before offset and slopes are known; no row is kept, however many there
//! are.
//!
//! The measured output enters as its distance from a `reference`, the model of nearly the same
//! offset and slopes: sums of squares of small numbers lose no digits where little is left to
//! explain.
//!
//! `K` is the capacity for entries: a few sizes are compiled, and loops over entries have fixed
//! lengths.

use nalgebra::{DMatrix, DVector};
use pulp::Arch;

use super::data::Data;
use super::inner::{Inner, Sample};
use super::projection::{Grid, Linear};
use super::starts::Start;

/// Sums of products of the entries of rows that count, by segment.
pub struct Sums<const K: usize> {
    segments: Vec<[[f64; K]; K]>,
    places: Places,
    width: f64,
}

/// Where the entries of a row stand: the derivatives of u by the coordinates, the added functions,
/// then these.
#[derive(Clone, Copy)]
pub struct Places {
    /// Number of coordinates: place of the first added function.
    pub added: usize,
    /// Place of the 1.
    pub one: usize,
    /// Place of the way gone in the segment.
    pub way: usize,
    /// Place of the measured output less the reference.
    pub rest: usize,
}

impl Places {
    /// Those of a recording's rows.
    pub fn of(data: &Data) -> Self {
        let (added, one) = (data.coordinates.len(), data.coordinates.len() + data.structure.added());
        Self { added, one, way: one + 1, rest: one + 2 }
    }
}

/// A quantity that every row has, by segment a straight line in one entry.
#[derive(Clone)]
pub struct Line {
    /// Place of the entry.
    pub place: usize,
    /// What it is multiplied by in each segment.
    pub slopes: Vec<f64>,
    /// What is added in each segment.
    pub levels: Vec<f64>,
}

impl<const K: usize> Sums<K> {
    /// The sums over a recording.
    pub fn of((data, at): (&Data, &Start), inner: &Inner, (grid, reference): (Grid, &Linear)) -> Self {
        let mut segments = vec![[[0.0; K]; K]; grid.count];
        let add = |segment: usize, entries: &[f64; K], weight: f64| {
            for (sums, entry) in segments[segment].iter_mut().zip(entries) {
                let weighted = weight * entry;
                for (sum, other) in sums.iter_mut().zip(entries) {
                    *sum += weighted * other;
                }
            }
        };
        each((data, at), inner, (grid, reference), add);
        Self { segments, places: Places::of(data), width: grid.width }
    }

    /// Where the entries stand.
    pub fn places(&self) -> Places {
        self.places
    }

    /// The line that is an entry itself.
    pub fn entry(&self, place: usize) -> Line {
        let count = self.segments.len();
        Line { place, slopes: vec![1.0; count], levels: vec![0.0; count] }
    }

    /// The linear columns Φ: 1, the ways gone inside each segment, the added functions.
    pub fn columns(&self) -> impl Iterator<Item = Line> {
        let count = self.segments.len();
        let share = |is: bool, of: f64| if is { of } else { 0.0 };
        let way_inside = move |segment: usize| Line {
            place: self.places.way,
            slopes: (0..count).map(|of| share(of == segment, 1.0)).collect(),
            levels: (0..count).map(|of| share(of > segment, self.width)).collect(),
        };
        let added = (self.places.added..self.places.one).map(|place| self.entry(place));
        [self.entry(self.places.one)].into_iter().chain((0..count).map(way_inside)).chain(added)
    }

    /// The sum of the products of two lines.
    pub fn product(&self, one: &Line, other: &Line) -> f64 {
        let (i, j, plain) = (one.place, other.place, self.places.one);
        let of = |(segment, sums): (usize, &[[f64; K]; K])| {
            let (slope, level) = (one.slopes[segment], one.levels[segment]);
            let (with, with_1) = (
                slope * sums[i][j] + level * sums[plain][j],
                slope * sums[i][plain] + level * sums[plain][plain],
            );
            other.slopes[segment] * with + other.levels[segment] * with_1
        };
        self.segments.iter().enumerate().map(of).sum()
    }

    /// The sums of the products of a line with each of Φ: a row has gone its own segment in part,
    /// and those before it whole, so that the sums of a segment serve all before it.
    pub fn moments(&self, line: &Line) -> DVector<f64> {
        let (place, Places { added, one, way, .. }) = (line.place, self.places);
        let segments = self.segments.len();
        let mut moments = DVector::zeros(1 + segments + one - added);
        let mut beyond = 0.0;
        for (segment, sums) in self.segments.iter().enumerate().rev() {
            let with = |entry: usize| {
                line.slopes[segment] * sums[place][entry] + line.levels[segment] * sums[one][entry]
            };
            moments[segment + 1] = with(way) + self.width * beyond;
            beyond += with(one);
            for k in added..one {
                moments[1 + segments + k - added] += with(k);
            }
        }
        moments[0] = beyond;
        moments
    }

    /// ΦᵀΦ.
    pub fn gram(&self) -> DMatrix<f64> {
        DMatrix::from_columns(&self.columns().map(|column| self.moments(&column)).collect::<Vec<_>>())
    }
}

/// Calls `take` with segment, entries and weight of each row that counts.
///
/// In the widest registers that the processor has: the order of the sums, and so every bit, stays.
pub fn each<const K: usize>(
    recording: (&Data, &Start),
    inner: &Inner,
    model: (Grid, &Linear),
    take: impl FnMut(usize, &[f64; K], f64),
) {
    Arch::new().dispatch(|| go(recording, inner, model, take));
}

#[inline(always)]
fn go<const K: usize>(
    (data, at): (&Data, &Start),
    inner: &Inner,
    (grid, reference): (Grid, &Linear),
    mut take: impl FnMut(usize, &[f64; K], f64),
) {
    let places = Places::of(data);
    let begin = reference.at_knots(grid.width);
    let mut muscle = inner.at_rest::<K>(at.preconditioned);
    for row in &data.rows {
        let Sample { u, by: mut entries } = muscle.step(row);
        if row.weight == 0.0 {
            continue;
        }
        let (segment, way) = grid.place(u);
        let mut output = begin[segment] + reference.slopes[segment] * way;
        if let Some(added) = &data.added {
            for (k, (value, rise)) in added.basis(row.input).iter().zip(&reference.rises).enumerate() {
                entries[places.added + k] = *value;
                output += rise * value;
            }
        }
        entries[places.one] = 1.0;
        entries[places.way] = way;
        entries[places.rest] = row.output - output;
        take(segment, &entries, f64::from(row.weight));
    }
}
