//! What a search over sets of causes works on: the recording, the baseline, and how a set is judged.

use rayon::prelude::*;

use super::basis::{Basis, Weights};
use super::candidate::Candidate;
use super::causes::Cause;
use super::effect::Effect;
use super::fit::{Fit, fit, leverage, squares};
use super::gain::{Score, mask};
use super::physical::doubts;
use super::pure_error::{PureError, pure_error};
use super::regulator::ordinary;
use super::second_order::damping_ratio;
use super::signals::Signals;
use super::states;
use super::swing::Running;
use super::turn::Loop;
use recording::numbers::range;

/// Radii of the baseline's width that are started from, as shares of the input's span.
pub(super) const WIDTHS: [f64; 3] = [0.1, 0.03, 0.25];
/// Priors of smoothness of the baseline that are tried, see [`Basis::smoothness`]: the one is taken that predicts held-out blocks best.
const SMOOTHNESS: [f64; 3] = [0.0, 0.01, 1.0];
/// Causes of the largest set.
pub(super) const LARGEST: usize = 3;

/// What is searched.
#[derive(Clone)]
pub struct Search<'a> {
    /// The recording.
    pub signals: &'a Signals,
    /// The same thinned, for what only ranks.
    pub thinned: Signals,
    /// The baseline.
    pub basis: Basis,
    /// The causes that it can show.
    pub examinable: Vec<Cause>,
    /// The longest hold of the recording. Unit: s.
    pub longest_hold_s: f64,
    /// The rows that are scored.
    pub mask: Vec<bool>,
    /// The regulator that belongs to the baseline where the command alone was recorded, from where its search begins; None where it does no
    /// more than is by chance.
    pub regulator: Option<Effect>,
    /// The set without causes.
    pub baseline: Candidate,
    /// The baseline of a muscle with the other past: fresh, or not.
    pub other: Option<Box<(Basis, Candidate)>>,
    /// Causes of the largest set.
    pub largest: usize,
    /// What visits to the same state differ by without causes, if there are enough.
    pub pure: Option<PureError>,
}

impl<'a> Search<'a> {
    /// Fits the baseline, for a fresh and for a preconditioned muscle, from several starts.
    pub fn new(signals: &'a mut Signals, examinable: Vec<Cause>, longest_hold_s: f64) -> Option<Self> {
        let (low, high) = range(&signals.input);
        let basis = Basis::new(low, high, true);
        signals.set_misfit([&Basis::new(low, high, false), &basis]);
        let first = fit(signals, &basis, &[])?;
        signals.set_simulated(&basis.simulate(
            &first.seen.input,
            first.seen.bend,
            &Weights::new(&first.weights),
        ));
        let turn = Loop::new((low, high), |input| {
            basis.simulate(input, first.seen.bend, &Weights::new(&first.weights))
        });
        signals.set_slope(|y| turn.slope(y));
        let signals = &*signals;
        let regulator = regulator(signals, &basis);
        let tried: Vec<(Basis, Fit, Vec<bool>)> = WIDTHS
            .into_par_iter()
            .flat_map(|radius| [(radius, true), (radius, false)])
            .flat_map(|(radius, preconditioned)| {
                SMOOTHNESS.map(|smoothness| (radius, preconditioned, smoothness))
            })
            .filter_map(|(radius, preconditioned, smoothness)| {
                let basis = Basis::new(low, high, preconditioned).smooth(smoothness).bent(&first.weights);
                let nuisances = Effect::nuisances(signals, radius, regulator.as_ref());
                let fit = fit(signals, &basis, &nuisances)?;
                let mask = mask(&leverage(signals, &basis, &fit.effects)?);
                Some((basis, fit, mask))
            })
            .collect();
        let nearest =
            tried.iter().min_by(|one, other| heldout(signals, one).total_cmp(&heldout(signals, other)))?;
        let preconditioned = nearest.0.is_preconditioned();
        let (own, others): (Vec<_>, Vec<_>) =
            tried.into_iter().partition(|(basis, ..)| basis.is_preconditioned() == preconditioned);
        let (basis, baseline, mask) = baseline_of(signals, own)?;
        let other = baseline_of(signals, others).map(|(basis, baseline, _)| Box::new((basis, baseline)));
        let pure = pure_error(signals, &basis, &baseline.fit.seen, &baseline.residual);
        Some(Self {
            signals,
            thinned: signals.thinned(),
            basis,
            examinable,
            longest_hold_s,
            mask,
            regulator,
            baseline,
            other,
            largest: LARGEST,
            pure,
        })
    }

    /// The same search with the baseline of the other past: what is hidden may make a fresh muscle look like one that has been through
    /// its range.
    pub fn of_other_past(&self) -> Option<Self> {
        let (basis, baseline) = &**self.other.as_ref()?;
        let other = Some(Box::new((self.basis.clone(), self.baseline.clone())));
        let pure = pure_error(self.signals, basis, &baseline.fit.seen, &baseline.residual);
        Some(Self { basis: basis.clone(), baseline: baseline.clone(), other, pure, ..self.clone() })
    }

    /// What a set gains over one without some of its causes where both run free: the logarithm of the ratio of their sums of squares beside
    /// the misfit.
    pub fn gain(&self, less: &Candidate, set: &Candidate) -> f64 {
        let squares = |set: &Candidate| {
            let misfit = states::seen(self.signals, &self.basis, &set.fit.effects);
            squares(misfit.as_deref(), &set.residual).max(f64::MIN_POSITIVE)
        };
        (squares(less) / squares(set)).ln()
    }

    /// A set with its fit, judged.
    pub fn candidate(&self, causes: Vec<Cause>, fit: Fit) -> Candidate {
        self.judged(causes, Running::of(self.signals, &self.basis, fit))
    }

    /// A set with its fit, judged as it runs free, as well as it can.
    ///
    /// Where measured rates stand in its effects the output may explain a part of itself, and their noise goes into the
    /// residual: then it is judged as it runs free, and the fold's loss on unseen rows is added.
    pub fn judged(&self, causes: Vec<Cause>, running: Running) -> Candidate {
        let Running { fit, errors: free, .. } = running.tuned(self.signals, &self.basis);
        let lost = fit.unseen.iter().zip(&fit.residual).map(|(unseen, residual)| unseen - residual);
        let unseen: Vec<f64> = lost.zip(&free).map(|(lost, free)| lost + free).collect();
        let score = Score::of(self.signals, &unseen, &self.mask);
        let pure = self.pure.and_then(|_| pure_error(self.signals, &self.basis, &fit.seen, &free));
        let least = 1.5 * self.signals.noise;
        let pure_error = pure.map(|error| error.square.sqrt().max(least));
        let spread = self.pure.zip(pure).map(|(before, after)| after.beside(&before, &free).max(least));
        let (signals, basis) = (self.signals, &self.basis);
        let doubts = doubts(signals, basis, &causes, &fit, self.longest_hold_s);
        let damping_ratio = damping_ratio(signals, basis, &causes, &fit);
        Candidate { causes, fit, score, pure_error, spread, residual: free, doubts, damping_ratio }
    }
}

/// What the regulator does, of all forms that it may have the best on held-out blocks; None where it does no more than is by chance.
fn regulator(signals: &Signals, basis: &Basis) -> Option<Effect> {
    let scored = |regulator: Option<&Effect>| {
        let fit = fit(signals, basis, &Effect::nuisances(signals, WIDTHS[0], regulator))?;
        let mask = mask(&leverage(signals, basis, &fit.effects)?);
        Some(Score::of(signals, &fit.unseen, &mask))
    };
    let forms = ordinary(signals.command?, signals.step_s);
    let forms = forms.into_par_iter().filter_map(|form| Some((scored(Some(&form))?, form)));
    let by_error = |one: &(Score, Effect), other: &(Score, Effect)| one.0.mean().total_cmp(&other.0.mean());
    let (with, form) = forms.min_by(by_error)?;
    let without = scored(None)?;
    (without.gain(&with) > without.gain_error(&with)).then_some(form)
}

/// The error of a baseline on held-out blocks, without the rows in which it extrapolates. A fresh muscle passes the states of its first
/// stroke once: a baseline for a fresh muscle extrapolates there, so that these rows are left out; one for a muscle that has been
/// through its range does not, and its error there counts. Output unit.
fn heldout(signals: &Signals, (_, fit, mask): &(Basis, Fit, Vec<bool>)) -> f64 {
    Score::of(signals, &fit.unseen, mask).mean()
}

/// The baseline that errs least on held-out blocks, and which rows are scored with it.
fn baseline_of(
    signals: &Signals,
    tried: Vec<(Basis, Fit, Vec<bool>)>,
) -> Option<(Basis, Candidate, Vec<bool>)> {
    let (basis, fit, mask) =
        tried.into_iter().min_by(|one, other| heldout(signals, one).total_cmp(&heldout(signals, other)))?;
    let pure_error = pure_error(signals, &basis, &fit.seen, &fit.residual).map(|error| error.square.sqrt());
    let baseline = Candidate {
        causes: Vec::new(),
        score: Score::of(signals, &fit.unseen, &mask),
        residual: fit.residual.clone(),
        fit,
        pure_error,
        spread: pure_error,
        doubts: Vec::new(),
        damping_ratio: None,
    };
    Some((basis, baseline, mask))
}
