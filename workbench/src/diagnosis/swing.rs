//! Mass and damping of a fit, brought to where the model that runs free is nearest to the measured contraction.
//!
//! A measured acceleration is mostly noise where the muscle hardly moves, and a regression on it finds too little mass and
//! too much damping. How a free run swings shows both. Two factors are searched, by Gauss-Newton with
//! differences; then all is fitted anew with the rates of the free run, which are without noise.

use super::basis::{Basis, COLUMNS};
use super::effect::{Driver, Form};
use super::fit::{Fit, fit};
use super::free_run::{FreeRun, free_run};
use super::output;
use super::signals::{Signals, TENTS};

/// Steps at most.
const STEPS: usize = 3;
/// The difference of a logarithm that derivatives are taken by.
const DIFFERENCE: f64 = 0.05;
/// The largest step of a logarithm.
const FARTHEST: f64 = 0.7;
/// A step that gains less than this share of the sum of squares is the last.
const ENOUGH: f64 = 5e-3;

/// Whether a fit has a mass.
pub fn has_mass(fit: &Fit) -> bool {
    fit.effects.iter().any(|effect| matches!(effect.form, Form::Inertia | Form::OutputInertia))
}

/// A fit, and how it runs free.
struct Tuned {
    fit: Fit,
    /// The simulated contraction, a value a row. Output unit.
    all: Vec<f64>,
    errors: Vec<f64>,
}

impl Tuned {
    fn of(signals: &Signals, basis: &Basis, fit: Fit) -> Self {
        let run = free_run(signals, basis, &fit);
        let errors = of_run(signals, &run);
        Self { fit, all: run.all, errors }
    }

    fn squares(&self) -> f64 {
        squares(&self.errors)
    }

    /// With the factors that let it run best.
    fn tuned(self, signals: &Signals, basis: &Basis) -> Self {
        let at = |factors: [f64; 2]| Self::of(signals, basis, scaled(signals, &self.fit, factors));
        let mut factors = [0.0; 2];
        let mut best: Option<Self> = None;
        for _ in 0..STEPS {
            let here = best.as_ref().unwrap_or(&self);
            let step = step(&here.errors, |place| {
                let mut moved = factors;
                moved[place] += DIFFERENCE;
                at(moved).errors
            });
            let Some(step) = step else { break };
            let next_factors = [factors[0] + step[0], factors[1] + step[1]];
            let next = at(next_factors);
            let (before, after) = (here.squares(), next.squares());
            if after >= before {
                break;
            }
            (factors, best) = (next_factors, Some(next));
            if before - after < ENOUGH * before {
                break;
            }
        }
        best.unwrap_or(self)
    }
}

/// Measured less simulated where a fit runs free, a value a scored row. Output unit.
pub fn errors(signals: &Signals, basis: &Basis, fit: &Fit) -> Vec<f64> {
    of_run(signals, &free_run(signals, basis, fit))
}

fn of_run(signals: &Signals, run: &FreeRun) -> Vec<f64> {
    let rows = signals.rows.iter().zip(&run.scored);
    rows.map(|(row, simulated)| signals.output[row.at] - simulated).collect()
}

/// A fit with mass that runs free as well as it can, and its errors then: tuned, fitted anew with the motion of that run in
/// the place of the measured one, and tuned again.
pub fn tuned(signals: &Signals, basis: &Basis, start: Fit) -> (Fit, Vec<f64>) {
    let first = Tuned::of(signals, basis, start).tuned(signals, basis);
    let quiet = signals.moving_as(&first.all);
    let again = fit(&quiet, basis, &first.fit.effects)
        .map(|fit| Tuned::of(signals, basis, fit).tuned(signals, basis))
        .filter(|again| again.squares() < first.squares());
    let Tuned { fit, errors, .. } = again.unwrap_or(first);
    (fit, errors)
}

fn squares(errors: &[f64]) -> f64 {
    errors.iter().map(|e| e * e).sum()
}

/// The Gauss-Newton step of both logarithms.
fn step(errors: &[f64], moved: impl Fn(usize) -> Vec<f64>) -> Option<[f64; 2]> {
    let slope = |place| -> Vec<f64> {
        moved(place).iter().zip(errors).map(|(there, here)| (there - here) / DIFFERENCE).collect()
    };
    let [mass, damping] = [slope(0), slope(1)];
    let dot = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
    // A factor that changes nothing stays.
    let floor = 1e-6 * (dot(&mass, &mass) + dot(&damping, &damping)) + 1e-12;
    let (mm, md, dd) = (dot(&mass, &mass) + floor, dot(&mass, &damping), dot(&damping, &damping) + floor);
    let (m, d) = (-dot(&mass, errors), -dot(&damping, errors));
    let determinant = mm * dd - md * md;
    let step = [(m * dd - d * md) / determinant, (d * mm - m * md) / determinant];
    step.iter().all(|s| s.is_finite()).then(|| step.map(|s| s.clamp(-FARTHEST, FARTHEST)))
}

/// The fit with mass and damping times the exponentials of these.
fn scaled(signals: &Signals, fit: &Fit, factors: [f64; 2]) -> Fit {
    let [mass, damping] = factors.map(f64::exp);
    let mut scaled = fit.clone();
    let mut place = COLUMNS;
    for effect in &mut scaled.effects {
        let count = output::count(effect, signals);
        let weights = &mut scaled.weights[place..place + count];
        place += count;
        match (effect.form, weights) {
            (Form::Inertia, _) => {
                let (masses, dampings) = effect.parameters.split_at_mut(TENTS);
                masses.iter_mut().for_each(|strength| strength.value *= mass);
                dampings.iter_mut().for_each(|strength| strength.value *= damping);
            }
            (Form::Driven(Driver::Rate), _) => {
                effect.parameters.iter_mut().for_each(|strength| strength.value *= damping);
            }
            (Form::OutputInertia, [first, second]) => (*first, *second) = (*first * mass, *second * damping),
            (Form::OutputLag, [first]) => *first *= damping,
            _ => {}
        }
    }
    scaled
}
