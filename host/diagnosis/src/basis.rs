//! The baseline of the search: a rate-independent map of the input with memory, linear in its weights.
//!
//! A static curve of tents over the input, and stops of it over logarithmically spaced radii, each times a few tents.
//! Any Prandtl-Ishlinskii model with an envelope and dead zones is near such a sum. A smoothness prior holds the second
//! differences of neighbouring weights down; its strength is the one that predicts held-out blocks best, so that a
//! recording of few cycles is not fitted with more freedom than it supports.
//!
//! The stops see the input through an envelope, as generalized operators do: where the muscle is soft a radius is small
//! in the input's unit. Without it the misfit grows with whatever changes the loop's width. The envelope lies between a
//! straight line (bend 0) and the static curve of a first fit (bend 1).

use pulp::Arch;

use super::row::Row;

/// Tents of the static curve: 6 % of the input's span apart.
const CURVE: usize = 17;
/// Tents that a stop is multiplied by.
const FEW: usize = 3;
/// Radii of the stops.
pub const RADII: usize = 8;
/// Smallest radius as a share of the input's span: a fifth of the distance of two tents. Each radius is this ratio times the one
/// before, so that the largest is half of the span. A stop with a larger radius would never slide.
const SMALLEST: f64 = 0.012;
const RATIO: f64 = 1.7;
/// The least slope of an envelope, as a share of the mean one.
const FLATTEST: f64 = 0.2;
/// Columns of the baseline.
pub const COLUMNS: usize = CURVE + RADII * FEW;
/// Those of a row that are not zero.
pub const ENTRIES: usize = 2 + 2 * RADII;
/// The sets of columns that may be those.
pub const GROUPS: usize = (CURVE - 1) * (FEW - 1);

/// A row of the baseline: which columns are not zero, and their values.
#[derive(Clone, Copy, Debug)]
pub struct Entries {
    /// The set of columns.
    pub group: usize,
    /// Their values, in the order of [`columns`].
    pub values: [f64; ENTRIES],
}

/// The columns of a group, in rising order.
pub fn columns(group: usize) -> [usize; ENTRIES] {
    let (knot, few) = (group / (FEW - 1), group % (FEW - 1));
    std::array::from_fn(|i| if i < 2 { knot + i } else { CURVE + (i / 2 - 1) * FEW + few + i % 2 })
}

impl Entries {
    /// The row's value with these weights.
    pub fn sum(&self, weights: &[f64]) -> f64 {
        columns(self.group).iter().zip(&self.values).map(|(&column, value)| weights[column] * value).sum()
    }
}

/// What the operators see, a value a row of the recording.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    /// Their input.
    pub input: Vec<f64>,
    /// What the radii are multiplied by; empty for 1.
    pub wider: Vec<f64>,
    /// How far the envelope is bent.
    pub bend: f64,
}

/// The memory of the baseline on its way through an input.
#[derive(Clone, Copy, Debug)]
pub struct Walk {
    /// Each over its radius.
    stops: [f64; RADII],
    /// The knot to the left of the input, and the weight of the one to its right.
    knot: usize,
    share: f64,
    /// What the stops see of the input.
    place: f64,
}

/// The baseline's fixed parts.
#[derive(Clone, Debug)]
pub struct Basis {
    /// The lowest input, and the knots of the curve an input unit.
    low: f64,
    knots: f64,
    /// What the stops see at the knots, as a share of the range, under a bend of 1.
    bent: [f64; CURVE],
    /// One over each radius.
    per_radius: [f64; RADII],
    /// Whether the muscle has been through its range before.
    preconditioned: bool,
    /// What a bend between neighbouring weights costs, as a share of the sum of squares of their columns.
    smoothness: f64,
}

/// The neighbouring weights whose second differences the prior of smoothness holds down: of the static curve, and of each stop.
pub fn neighbours() -> impl Iterator<Item = [usize; 3]> {
    let three = |first: usize| [first, first + 1, first + 2];
    let curve = (0..CURVE - 2).map(three);
    curve.chain((0..RADII).flat_map(move |i| (0..FEW - 2).map(move |few| three(CURVE + i * FEW + few))))
}

/// The baseline under one bend of its envelope.
#[derive(Clone, Copy, Debug)]
pub struct Curved<'a> {
    basis: &'a Basis,
    /// What the stops see at the knots, as a share of the range.
    places: [f64; CURVE],
}

/// Weights of the baseline, those of the stops side by side.
#[derive(Clone, Copy, Debug)]
pub struct Weights {
    curve: [f64; CURVE],
    stops: [[f64; RADII]; FEW],
}

impl Weights {
    /// From a list that begins with those of the baseline.
    pub fn new(all: &[f64]) -> Self {
        Self {
            curve: std::array::from_fn(|knot| all[knot]),
            stops: std::array::from_fn(|few| std::array::from_fn(|i| all[CURVE + i * FEW + few])),
        }
    }

    /// The sum at a place of a walk.
    #[inline(always)]
    pub fn sum(&self, walk: &Walk) -> f64 {
        let (few, share) = walk.few();
        let (left, right) = (&self.stops[few], &self.stops[few + 1]);
        let mut products = [0.0; RADII];
        for i in 0..RADII {
            products[i] = walk.stops[i] * (left[i] + share * (right[i] - left[i]));
        }
        let left = self.curve[walk.knot];
        left + walk.share * (self.curve[walk.knot + 1] - left) + products.iter().sum::<f64>()
    }
}

impl Walk {
    /// The tent, of those that the stops are multiplied by, to the left of the place, and the weight of the right one.
    fn few(&self) -> (usize, f64) {
        hat::<FEW>(self.place * (FEW - 1) as f64)
    }

    /// The columns here.
    fn entries(&self) -> Entries {
        let (few, share) = self.few();
        let mut values = [0.0; ENTRIES];
        (values[0], values[1]) = (1.0 - self.share, self.share);
        for (pair, stop) in values[2..].chunks_exact_mut(2).zip(&self.stops) {
            (pair[0], pair[1]) = (stop * (1.0 - share), stop * share);
        }
        Entries { group: self.knot * (FEW - 1) + few, values }
    }
}

impl Basis {
    /// A baseline for inputs of this range.
    pub fn new(low: f64, high: f64, preconditioned: bool) -> Self {
        let span = (high - low).max(1e-9);
        Self {
            low,
            knots: (CURVE - 1) as f64 / span,
            bent: std::array::from_fn(straight),
            per_radius: std::array::from_fn(|i| 1.0 / (SMALLEST * RATIO.powi(i as i32))),
            preconditioned,
            smoothness: 0.0,
        }
    }

    /// Whether the muscle has been through its range before.
    pub fn is_preconditioned(&self) -> bool {
        self.preconditioned
    }

    /// The same under a prior of smoothness.
    pub fn smooth(self, smoothness: f64) -> Self {
        Self { smoothness, ..self }
    }

    /// What a bend between neighbouring weights costs, as a share of the sum of squares of their columns.
    pub fn smoothness(&self) -> f64 {
        self.smoothness
    }

    /// The same, its envelope bent toward the static curve of a fit with these weights.
    pub fn bent(self, weights: &[f64]) -> Self {
        let curve: [f64; CURVE] = std::array::from_fn(|knot| weights[knot]);
        let sign = (curve[CURVE - 1] - curve[0]).signum();
        let least = FLATTEST * (curve[CURVE - 1] - curve[0]).abs().max(1e-12) / (CURVE - 1) as f64;
        let mut bent = [0.0; CURVE];
        for knot in 1..CURVE {
            bent[knot] = bent[knot - 1] + (sign * (curve[knot] - curve[knot - 1])).max(least);
        }
        Self { bent: bent.map(|place| place / bent[CURVE - 1]), ..self }
    }

    /// Under a bend of the envelope.
    pub fn curved(&self, bend: f64) -> Curved<'_> {
        let place = |knot| straight(knot) + bend * (self.bent[knot] - straight(knot));
        Curved { basis: self, places: std::array::from_fn(place) }
    }

    /// The columns of the scored rows.
    pub fn entries(&self, seen: &Seen, rows: &[Row]) -> Vec<Entries> {
        self.visit(seen, rows, Walk::entries)
    }

    /// The sum with these weights, a value a scored row.
    pub fn sums(&self, seen: &Seen, rows: &[Row], weights: &Weights) -> Vec<f64> {
        self.visit(seen, rows, |walk| weights.sum(walk))
    }

    /// The sum with these weights at every value of an input that is all that the operators see.
    pub fn simulate(&self, input: &[f64], bend: f64, weights: &Weights) -> Vec<f64> {
        let curved = self.curved(bend);
        let mut walk = curved.start(input.first().copied().unwrap_or(0.0));
        let row = |&u| {
            curved.advance(&mut walk, u, 1.0);
            weights.sum(&walk)
        };
        input.iter().map(row).collect()
    }

    /// The state of every scored row: input as a share of its span, and the stops from -1 to 1.
    pub fn states(&self, seen: &Seen, rows: &[Row]) -> Vec<[f64; RADII + 1]> {
        self.visit(seen, rows, |walk| {
            let mut state = [(walk.knot as f64 + walk.share) / (CURVE - 1) as f64; RADII + 1];
            state[1..].copy_from_slice(&walk.stops);
            state
        })
    }

    /// What `take` says at each scored row on the way through the whole input.
    fn visit<T>(&self, seen: &Seen, rows: &[Row], take: impl Fn(&Walk) -> T) -> Vec<T> {
        // In the widest registers that the processor has: the order of the sums, and so every bit, stays.
        Arch::new().dispatch(
            #[inline(always)]
            || self.go(seen, rows, take),
        )
    }

    #[inline(always)]
    fn go<T>(&self, seen: &Seen, rows: &[Row], take: impl Fn(&Walk) -> T) -> Vec<T> {
        let curved = self.curved(seen.bend);
        let mut walk = curved.start(seen.input.first().copied().unwrap_or(0.0));
        let mut first = 0;
        let mut all = Vec::with_capacity(rows.len());
        for row in rows {
            let way = first..row.at + 1;
            first = way.end;
            match seen.wider.get(way.clone()) {
                Some(wider) => {
                    seen.input[way].iter().zip(wider).for_each(|(&u, &w)| curved.advance(&mut walk, u, w));
                }
                None => seen.input[way].iter().for_each(|&u| curved.advance(&mut walk, u, 1.0)),
            }
            all.push(take(&walk));
        }
        all
    }
}

impl Curved<'_> {
    /// A walk from the first input of a recording.
    pub fn start(&self, first: f64) -> Walk {
        let stop = if self.basis.preconditioned { -1.0 } else { 0.0 };
        let (knot, share, place) = self.place(first);
        Walk { stops: [stop; RADII], knot, share, place }
    }

    /// Where an input lies between the knots, and what the stops see of it.
    fn place(&self, u: f64) -> (usize, f64, f64) {
        let (knot, share) = hat::<CURVE>((u - self.basis.low) * self.basis.knots);
        let left = self.places[knot];
        (knot, share, left + (self.places[knot + 1] - left) * share)
    }

    /// Goes on to an input, the radii times `wider`.
    #[inline(always)]
    pub fn advance(&self, walk: &mut Walk, u: f64, wider: f64) {
        let (knot, share, place) = self.place(u);
        let change = place - walk.place;
        for (stop, per_radius) in walk.stops.iter_mut().zip(&self.basis.per_radius) {
            // Comparisons, not `clamp`: these run side by side in a register.
            let moved = *stop + change * per_radius;
            let below = if moved > wider { wider } else { moved };
            *stop = if below < -wider { -wider } else { below };
        }
        (walk.knot, walk.share, walk.place) = (knot, share, place);
    }
}

/// A knot's place in the range, as a share of it.
fn straight(knot: usize) -> f64 {
    knot as f64 / (CURVE - 1) as f64
}

/// The hat to the left of a value in units of the knots' distance, and the weight of the one to its right; straight on
/// outside.
fn hat<const K: usize>(place: f64) -> (usize, f64) {
    // By way of 32 bits, for which there is an instruction.
    let left = (place as i32).clamp(0, K as i32 - 2);
    (left as usize, place - f64::from(left))
}
