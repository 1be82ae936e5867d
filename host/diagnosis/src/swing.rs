//! What acts by the measured motion, brought to where the model that runs free is nearest to the measured contraction.
//!
//! A measured acceleration is mostly noise where the muscle hardly moves, and a regression on it finds too little mass and
//! too much damping; a delay beside them then takes the place of what they lack. How a free run swings shows all of them. A
//! factor for each of the two, and the delay if it is a cause, are searched by Gauss-Newton with differences; then all is
//! fitted anew with the rates of the free run, which are without noise.

use nalgebra::{DMatrix, DVector};

use super::basis::Basis;
use super::effect::{Driver, Effect, Form};
use super::fit::{Fit, fit, squares};
use super::free_run::{FreeRun, free_run};
use super::series::{self, Series};
use super::signals::{Signals, TENTS};
use super::states;

/// Steps at most.
const STEPS: usize = 3;
/// The difference of a logarithm that derivatives are taken by.
const DIFFERENCE: f64 = 0.05;
/// The largest step of a logarithm.
const FARTHEST: f64 = 0.7;
/// The change of a delay that counts as one of a logarithm. Unit: s.
const DELAY_S: f64 = 0.1;
/// The same of a lag before a mass. Unit: s.
const LAG_S: f64 = 0.1;
/// A step that gains less than this share of the sum of squares is the last.
const ENOUGH: f64 = 5e-3;

/// What is brought to where the free run is nearest.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Knob {
    /// The logarithm of all masses.
    Mass,
    /// The logarithm of all dampings.
    Damping,
    /// A delay that is a cause.
    Delay,
    /// The small delay of every recording.
    SmallDelay,
    /// A lag before the mass.
    Lag,
}

/// What of a fit is to be tuned: nothing without a mass or a lag.
fn knobs(fit: &Fit) -> Vec<Knob> {
    let has = |is: fn(&Effect) -> bool| fit.effects.iter().any(is);
    let mut knobs = match (has(is_mass), has(is_lag)) {
        (true, _) => vec![Knob::Mass, Knob::Damping],
        (false, true) => vec![Knob::Damping],
        (false, false) => return Vec::new(),
    };
    if has(is_delay) {
        knobs.push(Knob::Delay);
    }
    if has(|effect| effect.form == Form::LagBefore) {
        // Of two lags and a delay a regression finds the sum.
        knobs.extend([Knob::Lag, Knob::SmallDelay]);
    }
    knobs
}

fn is_mass(effect: &Effect) -> bool {
    matches!(effect.form, Form::Inertia | Form::OutputInertia)
}

/// Whether it is one that goes by the measured rate alone.
fn is_lag(effect: &Effect) -> bool {
    matches!(effect.form, Form::OutputLag | Form::Driven(Driver::Rate))
}

/// Whether an effect is a delay that is a cause, not the small one of every recording.
fn is_delay(effect: &Effect) -> bool {
    effect.form == Form::Delay && effect.parameters.iter().all(|delay| delay.low >= 0.0)
}

fn small_delay_s(fit: &Fit) -> f64 {
    let small = fit.effects.iter().find(|effect| effect.form == Form::Delay && !is_delay(effect));
    small.and_then(|delay| delay.parameters.first()).map_or(0.0, |delay| delay.value)
}

/// A fit, and how it runs free.
pub struct Running {
    /// The fit.
    pub fit: Fit,
    /// Measured less simulated, a value a scored row. Output unit.
    pub errors: Vec<f64>,
    /// The simulated contraction, a value a row; none where no measured rate stands in the effects, and the fit is a free run
    /// itself. Output unit.
    all: Option<Vec<f64>>,
    /// See [`Self::squares`].
    squares: f64,
}

impl Running {
    /// As the fit stands.
    pub fn of(signals: &Signals, basis: &Basis, fit: Fit) -> Self {
        let is_fed_back = fit.effects.iter().any(|effect| effect.form.is_fed_back());
        let run = is_fed_back.then(|| free_run(signals, basis, &fit));
        let errors = run.as_ref().map_or_else(|| fit.residual.clone(), |run| of_run(signals, run));
        let squares = squares(states::late(signals, basis, &fit.effects).as_deref(), &errors);
        Self { fit, errors, all: run.map(|run| run.all), squares }
    }

    /// Sum of the squares of the errors, less what is repeated at every visit to a state.
    pub fn squares(&self) -> f64 {
        self.squares
    }

    /// The same running free as well as it can: tuned, fitted anew with the motion of that run in the place of the measured
    /// one, and tuned again.
    pub fn tuned(self, signals: &Signals, basis: &Basis) -> Self {
        let knobs = knobs(&self.fit);
        // A tone is none of the muscle's motion, but in what is measured it is.
        let shakes = self.fit.effects.iter().any(|effect| effect.form == Form::Tone);
        if knobs.is_empty() && !shakes {
            return self;
        }
        let first = self.turned(signals, basis, &knobs);
        let Some(all) = &first.all else { return first };
        let again = fit(&signals.moving_as(all), basis, &first.fit.effects)
            .map(|fit| Self::of(signals, basis, fit).turned(signals, basis, &knobs))
            .filter(|again| again.squares() < first.squares());
        again.unwrap_or(first)
    }

    /// With the factors that let it run best.
    fn turned(self, signals: &Signals, basis: &Basis, knobs: &[Knob]) -> Self {
        let at = |changes: &[f64]| Self::of(signals, basis, changed(signals, &self.fit, knobs, changes));
        let mut changes = vec![0.0; knobs.len()];
        let mut best: Option<Self> = None;
        for _ in 0..STEPS {
            let here = best.as_ref().unwrap_or(&self);
            let step = step(&here.errors, changes.len(), |place| {
                let mut moved = changes.clone();
                // A small delay is moved away from its end.
                let is_late = knobs[place] == Knob::SmallDelay && small_delay_s(&here.fit) > 0.0;
                let difference = if is_late { -DIFFERENCE } else { DIFFERENCE };
                moved[place] += difference;
                (at(&moved).errors, difference)
            });
            let Some(step) = step else { break };
            let next_changes: Vec<f64> =
                changes.iter().zip(&step).map(|(change, step)| change + step).collect();
            let next = at(&next_changes);
            let (before, after) = (here.squares(), next.squares());
            if after >= before {
                break;
            }
            (changes, best) = (next_changes, Some(next));
            if before - after < ENOUGH * before {
                break;
            }
        }
        best.unwrap_or(self)
    }
}

/// Measured less simulated, a value a scored row. Output unit.
fn of_run(signals: &Signals, run: &FreeRun) -> Vec<f64> {
    let rows = signals.rows.iter().zip(&run.scored);
    rows.map(|(row, simulated)| signals.output[row.at] - simulated).collect()
}

/// The Gauss-Newton step of so many changes. `moved`: the errors with one of them made, and how far.
fn step(errors: &[f64], count: usize, moved: impl Fn(usize) -> (Vec<f64>, f64)) -> Option<Vec<f64>> {
    let mut slopes = DMatrix::zeros(errors.len(), count);
    for (place, mut slope) in slopes.column_iter_mut().enumerate() {
        let (there, difference) = moved(place);
        slope.iter_mut().zip(there.iter().zip(errors)).for_each(|(s, (t, e))| *s = (t - e) / difference);
    }
    let mut normal = slopes.tr_mul(&slopes);
    // A change that makes no difference is not made.
    let floor = 1e-6 * normal.trace() + 1e-12;
    (0..count).for_each(|i| normal[(i, i)] += floor);
    let right = -slopes.tr_mul(&DVector::from_column_slice(errors));
    let step = normal.cholesky()?.solve(&right);
    step.iter().all(|s| s.is_finite()).then(|| step.iter().map(|s| s.clamp(-FARTHEST, FARTHEST)).collect())
}

/// The fit with its knobs turned by these changes.
fn changed(signals: &Signals, fit: &Fit, knobs: &[Knob], changes: &[f64]) -> Fit {
    let change =
        |knob: Knob| knobs.iter().zip(changes).find(|(other, _)| **other == knob).map_or(0.0, |(_, c)| *c);
    let (mass, damping) = (change(Knob::Mass).exp(), change(Knob::Damping).exp());
    let mut changed = fit.clone();
    let is_series = knobs.contains(&Knob::Lag);
    series::change(&mut changed, signals, |series| Series {
        lag_s: (series.lag_s + LAG_S * change(Knob::Lag)).max(0.0),
        damping_s: series.damping_s * damping,
        mass_s2: series.mass_s2 * mass,
    });
    let places = changed.output_places(signals);
    for (effect, place) in changed.effects.iter_mut().zip(places) {
        let weights = &mut changed.weights[place];
        if effect.form == Form::Delay {
            let knob = if is_delay(effect) { Knob::Delay } else { Knob::SmallDelay };
            effect.parameters.iter_mut().for_each(|delay| delay.add(DELAY_S * change(knob)));
        }
        match (effect.form, weights) {
            (Form::Inertia, _) => {
                let (masses, dampings) = effect.parameters.split_at_mut(TENTS);
                masses.iter_mut().for_each(|strength| strength.value *= mass);
                dampings.iter_mut().for_each(|strength| strength.value *= damping);
            }
            (Form::Driven(Driver::Rate), _) => {
                effect.parameters.iter_mut().for_each(|strength| strength.value *= damping);
            }
            (Form::OutputInertia, weights) if !is_series => {
                let (masses, dampings) = weights.split_at_mut(TENTS);
                masses.iter_mut().for_each(|weight| *weight *= mass);
                dampings.iter_mut().for_each(|weight| *weight *= damping);
            }
            (Form::OutputLag, weights) => weights.iter_mut().for_each(|weight| *weight *= damping),
            _ => {}
        }
    }
    changed
}
