//! The inner output u over a recording, and its sensitivities to the coordinates.
//!
//! A play's output is the coordinate v of the moment that last drove it, minus or plus its
//! threshold; so its derivatives are those of v at that moment, minus or plus that of the
//! threshold, exactly, with no finite differences. The plays that a row drives are always the first
//! ones, and all of them stand on the same v: the bank is a staircase of a few such corners, and
//! prefix sums over the plays give what a corner adds. A row costs the same however many plays
//! there are.
//!
//! `K` is the capacity for coordinates; what is beyond their number stays 0.

use super::envelope::Envelope;
use super::plays::Plays;
use super::row::{Row, Span};
use super::structure::Structure;

/// Envelope and plays at a point of the coordinates.
#[derive(Clone, Debug)]
pub struct Inner {
    /// The normalised envelope.
    pub envelope: Envelope,
    /// The normalised plays.
    pub plays: Plays,
    /// Number of the envelope's coordinates; those of the plays follow.
    of_envelope: usize,
}

/// u at a row, and its derivatives by the coordinates.
#[derive(Clone, Copy)]
pub struct Sample<const K: usize> {
    /// u.
    pub u: f64,
    /// Its derivatives.
    pub by: [f64; K],
}

impl Inner {
    /// The inner model at a point; as many coordinates as the structure has.
    pub fn new(structure: &Structure, at: &[f64], span: Span) -> Self {
        let of_envelope = structure.shape.coordinates().len();
        Self {
            envelope: Envelope::new(structure.shape, &at[..of_envelope], span),
            plays: Plays::new(structure.weights, &at[of_envelope..], structure.plays),
            of_envelope,
        }
    }

    /// A muscle at rest before a recording, preconditioned or not.
    pub fn at_rest<const K: usize>(&self, preconditioned: bool) -> Muscle<'_, K> {
        let mut bank = Bank::at_rest(self);
        if preconditioned {
            bank.step(&self.driven(1.0, true));
            bank.step(&self.driven(0.0, false));
        }
        Muscle { inner: self, rest: bank.corners.clone(), bank, preconditioned }
    }

    /// What an input drives the plays with.
    #[inline(always)]
    fn driven<const K: usize>(&self, t: f64, rising: bool) -> Driven<K> {
        let mut by = [0.0; K];
        let v = self.envelope.sample(t, rising, &mut by[..self.of_envelope]);
        Driven { v, by, sign: if rising { 1.0 } else { -1.0 } }
    }
}

/// A muscle on its way through the recordings.
pub struct Muscle<'a, const K: usize> {
    inner: &'a Inner,
    bank: Bank<'a, K>,
    /// Where the plays are before a recording.
    rest: Vec<Corner<K>>,
    preconditioned: bool,
}

impl<const K: usize> Muscle<'_, K> {
    /// u and its derivatives at the next row.
    #[inline(always)]
    pub fn step(&mut self, row: &Row) -> Sample<K> {
        let Inner { plays, of_envelope, .. } = self.inner;
        if row.begins {
            self.bank.corners.clone_from(&self.rest);
        }
        let rising = if row.rests { !self.preconditioned } else { row.rising };
        let driven = self.inner.driven(row.input, rising);
        let part = self.bank.step(&driven);
        let mut by: [f64; K] = std::array::from_fn(|c| plays.q * driven.by[c] + part.by[c]);
        for (sum, q_by) in by[of_envelope + 1..].iter_mut().zip(&plays.by[0]) {
            *sum += q_by * driven.v;
        }
        Sample { u: plays.q * driven.v + part.sum, by }
    }
}

/// What drives the plays: v, its derivatives by the envelope's coordinates, and the direction.
#[derive(Clone, Copy)]
struct Driven<const K: usize> {
    v: f64,
    by: [f64; K],
    /// zᵢ = v - sign rᵢ of the plays that it drives: 1 rising, -1 falling, 0 at rest.
    sign: f64,
}

/// Σ pᵢ zᵢ over some plays, and its derivatives by the coordinates.
#[derive(Clone, Copy)]
struct Part<const K: usize> {
    sum: f64,
    by: [f64; K],
}

/// Sums over the first plays.
#[derive(Clone, Copy)]
struct Prefix<const K: usize> {
    /// Of p, and of p r.
    sums: [f64; 2],
    /// Of the derivatives of p, and of p r, by the coordinates of the weights, in their places.
    by: [[f64; K]; 2],
}

/// Plays whose outputs all stand on one v.
#[derive(Clone, Copy)]
struct Corner<const K: usize> {
    driven: Driven<K>,
    /// One past the last play of the corner; it begins where the corner above it ends.
    end: usize,
    /// What the plays from `end` on add.
    beyond: Part<K>,
}

/// The plays as a staircase.
struct Bank<'a, const K: usize> {
    thresholds: &'a [f64],
    prefixes: Vec<Prefix<K>>,
    of_envelope: usize,
    /// The corner of the largest thresholds first.
    corners: Vec<Corner<K>>,
}

impl<const K: usize> Driven<K> {
    /// Whether a play of threshold `r` that stands on this v is driven by the next.
    fn yields(&self, r: f64, next: &Self) -> bool {
        (1.0 - next.sign * self.sign) * r < next.sign * (next.v - self.v)
    }
}

impl<const K: usize> Part<K> {
    const NONE: Self = Self { sum: 0.0, by: [0.0; K] };

    fn plus(&self, other: &Self) -> Self {
        Self { sum: self.sum + other.sum, by: std::array::from_fn(|c| self.by[c] + other.by[c]) }
    }
}

impl<'a, const K: usize> Bank<'a, K> {
    /// Plays that rested at 0 and were then brought to the lowest input.
    fn at_rest(inner: &'a Inner) -> Self {
        let Plays { thresholds, weights, by, .. } = &inner.plays;
        let mut sums = Prefix { sums: [0.0; 2], by: [[0.0; K]; 2] };
        let mut prefixes = vec![sums];
        for ((r, p), by) in thresholds.iter().zip(weights).zip(&by[1..]) {
            sums.sums = [sums.sums[0] + p, sums.sums[1] + p * r];
            for (k, derivative) in by.iter().enumerate() {
                sums.by[0][inner.of_envelope + 1 + k] += derivative;
                sums.by[1][inner.of_envelope + 1 + k] += derivative * r;
            }
            prefixes.push(sums);
        }
        let rest = Driven { v: 0.0, by: [0.0; K], sign: 0.0 };
        let corner = Corner { driven: rest, end: thresholds.len(), beyond: Part::NONE };
        let mut bank = Self { thresholds, prefixes, of_envelope: inner.of_envelope, corners: vec![corner] };
        let (lowest, _) = inner.envelope.ends();
        bank.step(&Driven { v: lowest, sign: lowest.signum(), ..rest });
        bank
    }

    /// What the plays from `begin` to `end`, which stand on one v, add.
    #[inline(always)]
    fn part(&self, driven: &Driven<K>, begin: usize, end: usize) -> Part<K> {
        let (from, to) = (&self.prefixes[begin], &self.prefixes[end]);
        let [p, pr] = std::array::from_fn(|i| to.sums[i] - from.sums[i]);
        let mut by = std::array::from_fn(|c| {
            driven.by[c] * p + driven.v * (to.by[0][c] - from.by[0][c])
                - driven.sign * (to.by[1][c] - from.by[1][c])
        });
        // Thresholds are proportional to α.
        by[self.of_envelope] = -driven.sign * pr;
        Part { sum: driven.v * p - driven.sign * pr, by }
    }

    /// Moves the plays; what they add to u.
    #[inline(always)]
    fn step(&mut self, next: &Driven<K>) -> Part<K> {
        let mut count = 0;
        let mut beyond = Part::NONE;
        while let Some(corner) = self.corners.last() {
            while count < corner.end && corner.driven.yields(self.thresholds[count], next) {
                count += 1;
            }
            if count < corner.end {
                beyond = self.part(&corner.driven, count, corner.end).plus(&corner.beyond);
                break;
            }
            self.corners.pop();
        }
        if count == 0 {
            return beyond;
        }
        self.corners.push(Corner { driven: *next, end: count, beyond });
        self.part(next, 0, count).plus(&beyond)
    }
}
