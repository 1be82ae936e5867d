//! What is wrong, but none of the causes: then nothing is named, and what is seen is said.
//!
//! - A pure error that stays large: visits to the same state still differ by much of the residual, half of them by more than
//!   states ever do, and naming the causes has removed less than half of that. Beside a warm-up that takes strokes away all of
//!   it has to be gone: a muscle that loses pressure, say, does so as well, but does not settle.
//! - Rows far off their neighbours, in several places: one drop-out of a sensor is left out and said, but one that drops
//!   out again and again is not to be trusted between.
//! - A reading that hangs while the muscle goes on, or sticks and jumps.
//! - Causes that gain next to nothing where a model with them runs free, or with which none does.
//! - A model that is written and describes nothing (`poor`).
//!
//! They do not take part in the search: a free curve also beats each single cause of a true pair.

use super::basis::Seen;
use super::candidate::Candidate;
use super::extend::Extended;
use super::fitted::Doubt;
use super::poor::Poor;
use super::pure_error::pure_error;
use super::search::Search;
use super::signals::Signals;
use super::slips::{Slips, slips};
use super::stuck::{Stuck, stuck};
use recording::numbers::root_mean_square;

/// A pure error above the first share of the held-out error is large: then the second share of its square has to have
/// been removed by the causes; the more the larger it is, up to the other pair.
const LARGE: [(f64, f64); 2] = [(0.45, 0.5), (0.65, 0.8)];
/// And it has to be above so many times the least error that there could be: states are never quite the same. Sound muscles come to 1.9,
/// what is named but not quite of our form to 2.7 (a weak warm-up of the rig, a viscous force beside a supply), weak outsiders to 2.8 at
/// least, nearly all to 4 and more.
const SEEN: f64 = 2.8;
/// Where no cause is named, one above so many times that is not by chance, however small a share of the error it is.
const UNMISTAKABLE: f64 = 1.5 * SEEN;
/// Without noise states are as near as the baseline is to the muscle: at least this share of its error counts as the least.
const NEAREST: f64 = 0.06;
/// Where no cause is named, few visits that differ by so many times what most do are not by chance either: something acts now and then.
/// Sound muscles come to 6.3, a sensor that hangs at times to 7 to 50.
const NOW_AND_THEN: f64 = 7.0;
/// A row is far off beyond so many times the noise, and so many places with such rows are too many.
const FAR: f64 = 10.0;
const MOVES: f64 = 4.0;
const TOO_MANY: usize = 4;

/// Something that is seen and not explained.
#[derive(Clone, Debug, PartialEq)]
pub enum Unexplained {
    /// Visits to the same state differ. Output unit.
    NotRepeatable {
        /// The pure error beside the causes that fit best.
        pure_error: f64,
        /// Frequencies of its strongest tones. Unit: Hz.
        tones_hz: Vec<f64>,
    },
    /// Single rows far off their neighbours.
    Outliers {
        /// How many.
        rows: usize,
        /// The largest distance. Output unit.
        largest: f64,
    },
    /// One value is read while the muscle goes on.
    Stuck(Stuck),
    /// The reading sticks and jumps.
    Slips(Slips),
    /// The model that is written does not describe the recording.
    Poor(Poor),
    /// No model with the causes that fit best can be simulated.
    NotSimulated,
    /// The causes that fit best gain nothing where a model with them runs free. Root mean square errors, output unit.
    NoGain {
        /// Of the model without them, over the scored rows.
        before: f64,
        /// Of the model with them.
        after: f64,
    },
}

/// What a set of causes leaves unexplained, if that is too much.
pub fn unexplained(search: &Search<'_>, set: &Candidate) -> Option<Unexplained> {
    outliers(search.signals)
        .or_else(|| stuck(search.signals, &search.baseline.fit.residual).map(Unexplained::Stuck))
        .or_else(|| slips(search.signals).map(Unexplained::Slips))
        .or_else(|| not_repeatable(search, set))
}

/// That a simulated model with the named causes is no better than one without.
pub fn no_gain(extended: &Extended) -> Option<Unexplained> {
    let (before, after) = (extended.baseline_rmse, extended.extended_rmse);
    (!extended.heldout.is_clear(before, after)).then_some(Unexplained::NoGain { before, after })
}

fn outliers(signals: &Signals) -> Option<Unexplained> {
    let far: Vec<f64> = signals
        .recorded
        .scored
        .windows(5)
        .filter_map(|w| {
            // Off its neighbours by far more than these move themselves.
            let off = (w[2] - 0.5 * (w[1] + w[3])).abs();
            let moves = (w[1] - w[0]).abs().max((w[4] - w[3]).abs()).max((w[3] - w[1]).abs());
            (off > FAR * signals.noise && off > MOVES * moves).then_some(off)
        })
        .collect();
    let places = far.len() + signals.drop_outs.len();
    let rows = far.len() + signals.drop_outs.iter().map(|drop_out| drop_out.samples.len()).sum::<usize>();
    let left_out = signals.drop_outs.iter().map(|drop_out| drop_out.distance);
    let largest = far.iter().copied().chain(left_out).fold(0.0, f64::max);
    (places >= TOO_MANY).then_some(Unexplained::Outliers { rows, largest })
}

/// That visits to the same state differ by more than what a set of causes leaves room for.
pub fn not_repeatable(search: &Search<'_>, set: &Candidate) -> Option<Unexplained> {
    let (before, after) = (search.baseline.pure_error?, set.pure_error?);
    let removed = (!set.causes.is_empty()).then(|| 1.0 - (after / before).powi(2));
    let left = Left {
        removed,
        fades: set.doubts.contains(&Doubt::Fading),
        ..Left::of(search, &set.fit.seen, &set.residual)?
    };
    let tones_hz = search.signals.tones(&set.residual, 3);
    let pure_error = if left.acts_now_and_then() { left.rare.1 } else { left.pure_error };
    left.is_too_much().then_some(Unexplained::NotRepeatable { pure_error, tones_hz })
}

/// Whether visits to the same state are alike after all by a model without causes, whose errors at the scored rows these are: it may know
/// better than the search's baseline what a state is.
pub fn is_repeatable(search: &Search<'_>, errors: &[f64]) -> bool {
    Left::of(search, &search.baseline.fit.seen, errors).is_some_and(|left| !left.is_too_much())
}

/// What a set of causes leaves. Errors in the output's unit.
struct Left {
    /// What visits to the same state differ by in the mean.
    pure_error: f64,
    /// What half of them speak of.
    typical: f64,
    /// The share of the mean's square that the causes have removed; None where none is named.
    removed: Option<f64>,
    /// What most visits differ by less than, and what all but few do.
    rare: (f64, f64),
    /// The error as a model that is simulated.
    simulated: f64,
    /// The least error that there could be.
    least: f64,
    /// Whether strokes fade, see [`Doubt::Fading`].
    fades: bool,
}

impl Left {
    /// What these errors of what saw this input leave, no cause being named.
    fn of(search: &Search<'_>, seen: &Seen, errors: &[f64]) -> Option<Self> {
        let pure = pure_error(search.signals, &search.basis, seen, errors)?;
        Some(Self {
            pure_error: pure.square.sqrt(),
            typical: pure.typical,
            removed: None,
            rare: (pure.usual, pure.rare),
            simulated: root_mean_square(errors),
            least: search.signals.least_error,
            fades: false,
        })
    }

    fn is_too_much(&self) -> bool {
        let times = self.pure_error / self.least().max(1e-12);
        let is_unmistakable = self.removed.is_none() && times > UNMISTAKABLE;
        let [(large, least), (larger, most)] = LARGE;
        let size = (self.pure_error / self.simulated.max(1e-12) - large) / (larger - large);
        let needed = least + (most - least) * size.min(1.0);
        let is_large = size > 0.0 && self.removed.unwrap_or(0.0) < needed;
        let is_seen = self.pure_error.min(self.typical) > SEEN * self.least();
        is_seen && (self.fades || is_unmistakable || is_large) || self.acts_now_and_then()
    }

    /// Whether few visits differ by far more than the others, no cause being named.
    fn acts_now_and_then(&self) -> bool {
        let (usual, rare) = self.rare;
        self.removed.is_none() && rare > NOW_AND_THEN * usual.max(self.least())
    }

    /// What states differ by at least.
    fn least(&self) -> f64 {
        self.least.max(NEAREST * self.simulated)
    }
}

#[cfg(test)]
mod tests {
    use super::Left;

    fn left(pure_error: f64, removed: Option<f64>) -> Left {
        let typical = pure_error;
        Left { pure_error, typical, removed, rare: (0.2, 0.5), simulated: 1.0, least: 0.07, fades: false }
    }

    #[test]
    fn states_that_differ_by_far_more_than_noise_are_too_much_beside_any_misfit_of_shape() {
        assert!(left(0.30, None).is_too_much());
        assert!(!left(0.25, None).is_too_much());
        assert!(!left(0.30, Some(0.9)).is_too_much());
    }

    #[test]
    fn few_visits_that_differ_by_far_more_than_the_others_are_too_much_where_no_cause_is_named() {
        assert!(Left { rare: (0.2, 1.5), ..left(0.1, None) }.is_too_much());
        assert!(!Left { rare: (0.2, 1.3), ..left(0.1, None) }.is_too_much());
        assert!(!Left { rare: (0.2, 1.5), ..left(0.1, Some(0.9)) }.is_too_much());
    }

    #[test]
    fn without_noise_states_may_differ_by_a_share_of_the_error() {
        let noiseless = |pure_error, rare| Left { least: 1e-6, rare, ..left(pure_error, None) };
        assert!(!noiseless(0.06, (0.1, 0.4)).is_too_much());
        assert!(noiseless(0.30, (0.1, 0.3)).is_too_much());
    }

    #[test]
    fn a_minority_of_visits_that_differ_tells_of_a_memory_that_is_not_quite_the_muscles() {
        assert!(!Left { typical: 0.15, ..left(0.7, None) }.is_too_much());
        assert!(Left { typical: 0.25, ..left(0.7, None) }.is_too_much());
    }

    #[test]
    fn what_causes_leave_is_too_much_where_it_is_most_of_the_error_and_they_have_removed_little() {
        assert!(left(0.7, Some(0.7)).is_too_much());
        assert!(!left(0.7, Some(0.9)).is_too_much());
        assert!(!Left { least: 0.3, ..left(0.7, Some(0.7)) }.is_too_much());
    }
}
