//! From what the search found to a verdict.

use std::f64::consts::PI;

use super::candidate::Candidate;
use super::causes::{Cause, Law};
use super::extend::Given;
use super::extend::start::knots;
use super::fitted::{Parameters, value};
use super::physical;
use super::poor::Poor;
use super::reject::Unexplained;
use super::search::Search;
use super::second_order::{DAMPED, DAMPING_RATIO, damped, damping, has_mass_and_viscosity_in_balance};
use super::valve::{ValveFit, ValvePart};
use identification::HostParameters;
use recording::numbers::legible;
use recording::unit::Unit;

/// What a diagnosis comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The operator model describes the recording.
    Adequate,
    /// The named causes explain what it gets wrong.
    Explained,
    /// Several sets of causes explain it, and the recording does not tell them apart.
    Confounded,
    /// Something is wrong that none of the causes explains.
    Unexplained,
}

impl Verdict {
    /// The word in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Adequate => "adequate",
            Self::Explained => "explained",
            Self::Confounded => "confounded",
            Self::Unexplained => "unexplained",
        }
    }
}

/// A named cause.
#[derive(Clone, Debug)]
pub struct Named {
    /// Which.
    pub cause: Cause,
    /// Its parameters.
    pub parameters: Parameters,
    /// The share of the square of the baseline's error, on blocks that no fit has seen, that goes if this cause is added to
    /// the others; where they are worse than none, to none. At most 1.
    pub share: f64,
    /// Why it is named, in words with figures.
    pub evidence: Vec<String>,
    /// The others without it; None for a cause of the valve, and for the shape.
    pub without: Option<Tried>,
}

impl Named {
    /// The parameter of this name, if it has one.
    pub fn parameter(&self, wanted: &str) -> Option<f64> {
        value(&self.parameters, wanted)
    }

    /// That the form of the model that is written leaves most of its error. `unit`: of the output.
    pub fn shape(form: &Poor, unit: Unit) -> Option<Self> {
        let any = form.better.map_or(f64::NAN, |(_, rmse)| rmse);
        Some(Self {
            cause: Cause::of_law(Law::Form)?,
            parameters: Vec::new(),
            share: 1.0 - (any / form.rmse).powi(2),
            evidence: vec![format!(
                "a hysteresis of any form, without a cause, is off by {} {unit} instead of {} {unit}",
                legible(any, 3),
                legible(form.rmse, 3)
            )],
            without: None,
        })
    }

    /// That the form of a given operator model is too poor; the parameters are the sizes of the richer one. `unit`: of the output.
    pub fn given_shape(given: &Given, richer: &HostParameters, unit: Unit) -> Option<Self> {
        let evidence = format!(
            "fitted to the recording, the form of the given model is off by {} {unit}, a richer one by {} {unit}",
            legible(given.refitted_rmse, 3),
            legible(given.richer_rmse, 3)
        );
        Some(Self {
            cause: Cause::of_law(Law::Form)?,
            parameters: sizes(richer),
            share: given.share(),
            evidence: vec![evidence],
            without: None,
        })
    }
}

/// How many of what an operator has; no knots where its envelope is none of straight lines.
fn sizes(parameters: &HostParameters) -> Parameters {
    let (envelope, plays, dead_zones) = match parameters {
        HostParameters::Cascade(cascade) => {
            (&cascade.envelope, &cascade.plays, Some(cascade.dead_zones.thresholds.len()))
        }
        HostParameters::Agpi(agpi) => (&agpi.rising, &agpi.plays, None),
        HostParameters::Egpi(egpi) => (&egpi.agpi.rising, &egpi.agpi.plays, None),
    };
    [("envelope_knots", knots(envelope)), ("plays", Some(plays.thresholds.len())), ("dead_zones", dead_zones)]
        .into_iter()
        .filter_map(|(name, size)| Some((name, size? as f64)))
        .collect()
}

/// A set of causes that was looked at.
#[derive(Clone, Debug)]
pub struct Tried {
    /// Which.
    pub causes: Vec<Cause>,
    /// Error on blocks that no fit has seen. Output unit.
    pub heldout: f64,
    /// Logarithm of the ratio of that error without any cause to this one, and its standard error.
    pub gain: (f64, f64),
    /// What visits to the same state differ by. Output unit.
    pub pure_error: Option<f64>,
}

impl Tried {
    fn of(search: &Search<'_>, set: &Candidate) -> Self {
        let none = &search.baseline.score;
        Self {
            causes: set.causes.clone(),
            heldout: set.score.mean(),
            gain: (none.gain(&set.score), none.gain_error(&set.score)),
            pure_error: set.pure_error,
        }
    }
}

/// All sets that were looked at, by size, the best first.
pub fn tried(search: &Search<'_>, sizes: &[Vec<Candidate>]) -> Vec<Tried> {
    sizes.iter().flatten().map(|set| Tried::of(search, set)).collect()
}

/// The causes of the best set and of the valve, with what speaks for them.
pub fn named(
    search: &Search<'_>,
    best: &Candidate,
    sizes: &[Vec<Candidate>],
    valve: Option<&ValveFit>,
    unit: Unit,
) -> Vec<Named> {
    let square = |set: &Candidate| set.score.mean().powi(2);
    let before = square(&search.baseline).max(1e-300);
    let mut all: Vec<Named> = physical::parameters(search.signals, &search.basis, &best.causes, &best.fit)
        .into_iter()
        .map(|(cause, parameters)| {
            let without = search.without(best, cause, sizes);
            let share = without.as_ref().map_or(0.0, |set| (square(set).min(before) - square(best)) / before);
            let evidence = without.as_ref().map_or_else(Vec::new, |set| evidence(set, best, unit));
            let without = without.map(|set| Tried::of(search, &set));
            Named { cause, parameters, share, evidence, without }
        })
        .collect();
    if has_mass_and_viscosity_in_balance(&best.fit) {
        join(&mut all);
    }
    all.extend(damping_beside(&all));
    for of_valve in valve.map_or_else(Vec::new, at_the_valve) {
        if all.iter().all(|named| named.cause != of_valve.cause) {
            all.push(of_valve);
        }
    }
    all
}

/// The causes between command and pressure.
fn at_the_valve(fit: &ValveFit) -> Vec<Named> {
    let named = |&(part, gain): &(ValvePart, f64)| {
        let (cause, name) = Cause::of_valve(part)?;
        Some(Named {
            cause,
            parameters: fit.valve.value(part).map(|value| (name, value)).into_iter().collect(),
            share: 1.0 - (-2.0 * gain).exp(),
            evidence: vec![format!(
                "between command and pressure: without it the error is {:.1} times as large as {} {}",
                gain.exp(),
                legible(fit.rmse_bar, 4),
                fit.unit
            )],
            without: None,
        })
    };
    fit.named.iter().filter_map(named).collect()
}

/// A mass and a viscous force in the balance are one equation of second order: the viscosity damps the mass, and is a cause of
/// its own only where the mass then hardly overshoots.
fn join(named: &mut Vec<Named>) {
    let of = |law: Law| named.iter().find(|named| named.cause.law() == law);
    let Some((own, frequency_hz)) = of(Law::Mass).and_then(|mass| damping(&mass.parameters)) else { return };
    let lag_s = of(Law::Viscosity).and_then(|viscosity| viscosity.parameters.first());
    let Some(&(_, lag_s)) = lag_s else { return };
    let whole = damped(own, frequency_hz, lag_s);
    if whole < DAMPED {
        named.retain(|named| named.cause.law() != Law::Viscosity);
        let parameters = named.iter_mut().flat_map(|named| &mut named.parameters);
        parameters.filter(|(name, _)| *name == DAMPING_RATIO).for_each(|(_, ratio)| *ratio = whole);
    }
}

/// The viscosity beside a mass that hardly overshoots. In the balance of forces a mass and a viscous force are one
/// equation of second order: alone a mass rings, and what takes the ringing away is named too.
fn damping_beside(named: &[Named]) -> Option<Named> {
    let mass = named.iter().find(|named| named.cause.law() == Law::Mass)?;
    let (ratio, frequency_hz) = damping(&mass.parameters).filter(|(ratio, _)| *ratio >= DAMPED)?;
    let viscosity = Cause::of_law(Law::Viscosity)?;
    let is_alone = named.iter().all(|named| named.cause != viscosity);
    is_alone.then(|| Named {
        cause: viscosity,
        parameters: vec![("time_constant_s", ratio / (PI * frequency_hz))],
        share: mass.share,
        evidence: vec![format!(
            "a mass alone rings, this one is damped by {ratio:.2} of what stops all overshoot: damping is named beside it"
        )],
        without: None,
    })
}

/// What a set is better by than without one of its causes, in words. `unit`: of the output.
fn evidence(without: &Candidate, with: &Candidate, unit: Unit) -> Vec<String> {
    let (gain, error) = (without.score.gain(&with.score), without.score.gain_error(&with.score));
    let mut words = vec![format!(
        "held-out error {} instead of {} {unit} without it (logarithm of the ratio {gain:.2} +- {error:.2})",
        legible(with.score.mean(), 3),
        legible(without.score.mean(), 3)
    )];
    if without.has_viscous_width() && !with.has_viscous_width() {
        words.push("without it the width grows with as high a power of the speed as it may".into());
    }
    if let (Some(before), Some(after)) = (without.pure_error, with.pure_error) {
        words.push(format!(
            "visits to the same state differ by {} instead of {} {unit}",
            legible(after, 3),
            legible(before, 3)
        ));
    }
    words
}

/// What it comes to.
pub fn verdict(causes: &[Named], unexplained: Option<&Unexplained>, alternatives: &[Vec<Cause>]) -> Verdict {
    match (unexplained, causes.is_empty()) {
        (Some(_), _) => Verdict::Unexplained,
        (None, true) => Verdict::Adequate,
        (None, false) if alternatives.is_empty() => Verdict::Explained,
        (None, false) => Verdict::Confounded,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::causes::cause;

    /// A mass of 3.6 Hz, hardly damped by itself, and a viscous lag.
    fn mass_and_lag(lag_s: f64) -> Vec<Named> {
        let of =
            |cause, parameters| Named { cause, parameters, share: 0.5, evidence: Vec::new(), without: None };
        let mass = vec![("natural_frequency_hz", 3.6), ("damping_ratio", 0.2)];
        vec![of(cause("inertia"), mass), of(cause("viscous_lag"), vec![("time_constant_s", lag_s)])]
    }

    #[test]
    fn a_viscous_force_beside_a_mass_that_rings_is_its_damping() {
        let mut named = mass_and_lag(0.02);
        join(&mut named);
        assert_eq!(named.iter().map(|named| named.cause).collect::<Vec<_>>(), [cause("inertia")]);
        let whole = named[0].parameter("damping_ratio").expect("a damping ratio");
        assert!((whole - 0.426).abs() < 1e-3, "{whole}");
    }

    #[test]
    fn one_that_stops_the_ringing_is_a_cause() {
        let mut named = mass_and_lag(0.06);
        join(&mut named);
        assert_eq!(named.len(), 2);
        assert_eq!(named[0].parameter("damping_ratio"), Some(0.2));
    }
}
