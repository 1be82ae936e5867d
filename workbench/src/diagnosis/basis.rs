//! The baseline of the search: a rate-independent map of the input with memory, linear in its weights.
//!
//! A static curve of tents over the input, and stops of it over logarithmically spaced radii, each times a few tents.
//! Any Prandtl-Ishlinskii model with an envelope and dead zones is near such a sum; more columns fit better and
//! validate worse. The stops see the input through an envelope, as generalized operators do: where the muscle is soft a
//! radius is small in the input's unit. Without it the misfit grows with whatever changes the loop's width. The envelope
//! lies between a straight line (bend 0) and the static curve of a first fit (bend 1).

use super::signals::Row;

/// Tents of the static curve.
const CURVE: usize = 11;
/// Tents that a stop is multiplied by.
const FEW: usize = 3;
/// Radii of the stops.
const RADII: usize = 6;
/// The smallest radius as a share of the input's span, and the ratio of one to the next.
const SMALLEST: f64 = 0.012;
const RATIO: f64 = 2.0;
/// The least slope of an envelope, as a share of the mean one.
const FLATTEST: f64 = 0.2;
/// Columns of the baseline.
pub const COLUMNS: usize = CURVE + RADII * FEW;
/// Those of a row that are not zero.
pub const ENTRIES: usize = 2 + 2 * RADII;

/// A row of the baseline: which columns are not zero, and their values.
#[derive(Clone, Copy, Debug)]
pub struct Entries {
    /// Columns.
    pub columns: [u8; ENTRIES],
    /// Their values.
    pub values: [f64; ENTRIES],
}

impl Entries {
    /// The row's value with these weights.
    pub fn sum(&self, weights: &[f64]) -> f64 {
        self.columns.iter().zip(&self.values).map(|(&column, value)| weights[column as usize] * value).sum()
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

impl Seen {
    fn wider(&self, at: usize) -> f64 {
        self.wider.get(at).copied().unwrap_or(1.0)
    }
}

/// The memory of the baseline on its way through an input.
#[derive(Clone, Copy, Debug)]
pub struct Walk {
    stops: [f64; RADII],
    /// The input, and what the stops saw of it.
    last: f64,
    last_place: f64,
    bend: f64,
}

/// The baseline's fixed parts.
#[derive(Clone, Debug)]
pub struct Basis {
    /// The lowest input, and the knots of the curve an input unit.
    low: f64,
    knots: f64,
    /// What the stops see at the knots, as a share of the range, under a bend of 1.
    bent: [f64; CURVE],
    radii: [f64; RADII],
    /// Whether the muscle has been through its range before.
    preconditioned: bool,
}

impl Basis {
    /// A baseline for inputs of this range.
    pub fn new(low: f64, high: f64, preconditioned: bool) -> Self {
        let span = (high - low).max(1e-9);
        Self {
            low,
            knots: (CURVE - 1) as f64 / span,
            bent: std::array::from_fn(straight),
            radii: std::array::from_fn(|i| SMALLEST * RATIO.powi(i as i32)),
            preconditioned,
        }
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

    /// A walk from the start of a recording.
    pub fn walk(&self, first: f64, bend: f64) -> Walk {
        let stops = if self.preconditioned { self.radii.map(|radius| -radius) } else { [0.0; RADII] };
        Walk { stops, last: first, last_place: self.place(first, bend), bend }
    }

    /// What the stops see of an input.
    fn place(&self, u: f64, bend: f64) -> f64 {
        let (left, share) = hat::<CURVE>((u - self.low) * self.knots);
        let at = |knot: usize| straight(knot) + bend * (self.bent[knot] - straight(knot));
        at(left) + (at(left + 1) - at(left)) * share
    }

    /// The columns of the next row of a walk, the radii times `wider`.
    pub fn step(&self, walk: &mut Walk, u: f64, wider: f64) -> Entries {
        self.advance(walk, u, wider);
        self.entries(walk)
    }

    fn advance(&self, walk: &mut Walk, u: f64, wider: f64) {
        let place = self.place(u, walk.bend);
        let change = place - walk.last_place;
        (walk.last, walk.last_place) = (u, place);
        for (stop, radius) in walk.stops.iter_mut().zip(&self.radii) {
            // Comparisons, not `clamp`: these run side by side in a register.
            let (moved, range) = (*stop + change, radius * wider);
            let below = if moved > range { range } else { moved };
            *stop = if below < -range { -range } else { below };
        }
    }

    /// Goes through the whole input and hands the scored rows to `take`, with their place in `rows`.
    pub fn run(&self, seen: &Seen, rows: &[Row], mut take: impl FnMut(usize, Entries)) {
        self.visit(seen, rows, |row, walk| take(row, self.entries(walk)));
    }

    /// The sum with these weights, a value a row of the recording.
    pub fn simulate(&self, seen: &Seen, weights: &[f64]) -> Vec<f64> {
        let mut walk = self.walk(seen.input.first().copied().unwrap_or(0.0), seen.bend);
        let row = |(at, &u): (usize, &f64)| self.step(&mut walk, u, seen.wider(at)).sum(weights);
        seen.input.iter().enumerate().map(row).collect()
    }

    /// The state of every scored row: input as a share of its span, and the stops from -1 to 1.
    pub fn states(&self, seen: &Seen, rows: &[Row]) -> Vec<[f64; RADII + 1]> {
        let per_unit = self.knots / (CURVE - 1) as f64;
        let mut states = Vec::with_capacity(rows.len());
        self.visit(seen, rows, |_, walk| {
            let mut state = [walk.last * per_unit; RADII + 1];
            for (place, (stop, radius)) in state[1..].iter_mut().zip(walk.stops.iter().zip(&self.radii)) {
                *place = stop / radius;
            }
            states.push(state);
        });
        states
    }

    fn visit(&self, seen: &Seen, rows: &[Row], mut take: impl FnMut(usize, &Walk)) {
        let mut walk = self.walk(seen.input.first().copied().unwrap_or(0.0), seen.bend);
        let mut next = 0;
        for (at, &u) in seen.input.iter().enumerate() {
            self.advance(&mut walk, u, seen.wider(at));
            if rows.get(next).is_some_and(|row| row.at == at) {
                take(next, &walk);
                next += 1;
            }
        }
    }

    /// The columns of a row.
    fn entries(&self, walk: &Walk) -> Entries {
        let mut entries = Entries { columns: [0; ENTRIES], values: [0.0; ENTRIES] };
        let mut put = |place: usize, column: usize, value: f64| {
            entries.columns[place] = column as u8;
            entries.values[place] = value;
        };
        let (left, share) = hat::<CURVE>((walk.last - self.low) * self.knots);
        put(0, left, 1.0 - share);
        put(1, left + 1, share);
        let (left, share) = hat::<FEW>(walk.last_place * (FEW - 1) as f64);
        for (i, (stop, radius)) in walk.stops.iter().zip(&self.radii).enumerate() {
            let column = CURVE + i * FEW + left;
            let value = stop / radius;
            put(2 + 2 * i, column, value * (1.0 - share));
            put(3 + 2 * i, column + 1, value * share);
        }
        entries
    }
}

/// A knot's place in the range, as a share of it.
fn straight(knot: usize) -> f64 {
    knot as f64 / (CURVE - 1) as f64
}

/// The hat to the left of a value in units of the knots' distance, and the weight of the one to its right; straight on
/// outside.
fn hat<const K: usize>(place: f64) -> (usize, f64) {
    let left = (place.max(0.0) as usize).min(K - 2);
    (left, place - left as f64)
}
