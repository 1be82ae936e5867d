//! How much work an identification is, part by part.
//!
//! A unit is the time that the sums over one row take for a model of few coordinates. Searches that
//! go to their end are planned with as many evaluations as they have mostly taken (the project's
//! recordings, all models).

use super::structure::Structure;
use super::{Loss, Options, Weights};
use crate::progress::Planned;

/// Rows that count of the thinned recording: many for each of a few dozen parameters.
pub const ROWS: usize = 4000;
/// Each recording after the thinned one has so many times the rows of the one before; one that
/// would have a quarter of all rows or more is left out, and all rows follow.
const LEVEL: usize = 4;
/// How many ends with exponential weights free ones go on from.
pub const FREED: usize = 3;
/// One more search goes to its end on the thinned recording for so many rows: all together take
/// less time than the few on all rows do (million rows, 24 starts: 1 s of 4).
const ROWS_A_SEARCH: usize = 2 * ROWS;
/// Evaluations per coordinate that every start gets, and then the better half of them once more.
pub const SCREENING: usize = 2;
/// Evaluations per coordinate of a search to its end from a screened start, and of one from an end
/// on fewer rows.
const TO_THE_END: usize = 3;
const ONWARDS: usize = 2;
/// Rows of a thinned recording for each that counts: the turns of the input lie between.
const WITH_TURNS: usize = 2;
/// Ends that are searched from on all rows: mostly, no more are nearly as good as the best.
const MOSTLY_POLISHED: usize = 2;
/// Rounds of a robust fit.
const ROUNDS: usize = 8;
/// Passes over all rows that the standard errors take.
const UNCERTAINTY: usize = 6;

/// The starts that are screened once more, of a number of starts for so many rows that count.
pub fn better(starts: usize, rows: usize) -> usize {
    starts.div_ceil(2).max(best(starts, rows))
}

/// The starts that go on to their ends, of a number of starts for so many rows that count: a
/// quarter, of a long recording all.
pub fn best(starts: usize, rows: usize) -> usize {
    (rows / ROWS_A_SEARCH).clamp(starts.div_ceil(4), starts)
}

/// Rows that count of the recordings between the thinned one and all rows.
pub fn levels(rows: usize) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(ROWS * LEVEL), |level| Some(level * LEVEL))
        .take_while(move |level| 4 * level < rows)
}

/// The parts of an identification.
pub struct Plan {
    /// The screening of all starts.
    pub screening: Planned,
    /// The searches to their ends on the thinned recording.
    pub converging: Planned,
    /// Those of free weights.
    pub freeing: Planned,
    /// The rounds of a robust fit on the thinned recording.
    pub robust: Planned,
    /// Those on less thinned recordings.
    pub levels: Planned,
    /// Those on all rows.
    pub polishing: Planned,
    /// The standard errors.
    pub uncertainty: Planned,
}

impl Plan {
    /// For so many rows that count.
    pub fn new(rows: usize, options: &Options) -> Self {
        let exponential = Structure::new(options);
        let last = Structure { weights: options.weights, ..exponential };
        let threads = match options.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            threads => threads,
        };
        // Evaluations of searches side by side, on a number of rows.
        let part = |structure: &Structure, searches: usize, per_coordinate: usize, rows: usize| {
            let side_by_side = searches.clamp(1, threads) as f64;
            Planned {
                step: rows as f64 * row(structure) / side_by_side,
                steps: searches * per_coordinate * (structure.coordinates().len() + 1),
            }
        };
        let thinned = rows.min(WITH_TURNS * ROWS);
        let starts = options.starts;
        let freed = if options.weights == Weights::Free { FREED } else { 0 };
        let searches = best(starts, rows) + 1;
        let polished = MOSTLY_POLISHED.min(searches);
        // A robust fit goes on from one end of each kind, in rounds, and knows no levels.
        let (thinned_rounds, rounds, level) = match options.loss {
            Loss::Squares => (0, 1, WITH_TURNS * levels(rows).sum::<usize>()),
            Loss::Huber => (ROUNDS, ROUNDS, 0),
        };
        Self {
            screening: part(&exponential, starts + better(starts, rows), SCREENING, thinned),
            converging: part(&exponential, searches, TO_THE_END, thinned),
            freeing: part(&last, freed, TO_THE_END, thinned),
            robust: part(&last, thinned_rounds, ONWARDS, thinned),
            levels: part(&last, polished, ONWARDS, level),
            polishing: part(&last, polished * rounds, ONWARDS, rows),
            uncertainty: Planned { step: rows as f64 * row(&last), steps: UNCERTAINTY },
        }
    }

    /// All parts together.
    pub fn units(&self) -> f64 {
        let Self { screening, converging, freeing, robust, levels, polishing, uncertainty } = self;
        [screening, converging, freeing, robust, levels, polishing, uncertainty]
            .into_iter()
            .map(Planned::units)
            .sum()
    }
}

/// Units of a row: the sums grow with the square of the entries.
fn row(structure: &Structure) -> f64 {
    1.0 + (structure.entries() as f64 / 8.0).powi(2)
}
