//! Slow relaxation over decades of time after each change: a sum of lags, two a decade.

use model_core::ExtensionParameters;
use model_core::extension::{CreepParameters, Site};

use super::kind::{About, Kind, Stage};
use super::needs::{CREEP_HOLD_S, Judge, Judged, Lack};
use crate::carrier::Carrier;
use crate::effect::{Effect, Form, Parameter};
use crate::fitted::{Doubt, Fitted, Parameters};
use crate::plan::part::Part;
use crate::signals::Signals;
use crate::simulated::Simulated;

/// So many plateaus after a jump do as well as a hold, but that creep is not told from a lag.
const PLATEAUS: usize = 4;
/// An element has ended after so many of its time constants: exp(-5), less than a hundredth, is left.
const OVER: f64 = 5.0;
/// The least share of a creep that has not ended with the longest hold. Tails of lags came to 0.01 at most
/// (the written models of four simulated recordings); of a creep that is even over the decades at least a sixth is in the slowest of its
/// elements. No error level is calibrated for it.
const GOES_ON: f64 = 0.1;
/// The largest sum of the shares that a refinement begins with: the model's bound is 1, and a tenth of the way is left to move at once.
/// The refinement may come nearer to the bound.
const MOST_LATE: f64 = 0.9;

/// The cause.
pub struct Creep;

/// Whether elements of these shares and time constants still go on when a hold ends. Units: s.
fn goes_on(fractions: &[f64], time_constants_s: &[f64], hold_s: f64) -> bool {
    // A hold may be longer than what the slowest element is given to last.
    let slowest_s = time_constants_s.last().copied().unwrap_or(0.0);
    let from_s = (hold_s / OVER).min(slowest_s);
    let slow = fractions.iter().zip(time_constants_s).filter(|(_, tau_s)| **tau_s >= from_s);
    slow.map(|(fraction, _)| fraction).sum::<f64>() > GOES_ON * fractions.iter().sum::<f64>()
}

/// The shares of its elements.
fn fractions(fitted: &Fitted<'_>) -> Vec<f64> {
    match fitted.form() {
        Form::Creep => {
            let sum: f64 = fitted.weights.iter().sum();
            fitted.weights.iter().map(|weight| weight / (1.0 + sum)).collect()
        }
        _ => fitted.effect.parameters.iter().map(|parameter| parameter.value).collect(),
    }
}

/// The factor that brings the sum of the shares below 1: the model has that bound, the search has not.
fn below_the_whole(fractions: &[f64]) -> f64 {
    let sum: f64 = fractions.iter().sum();
    if sum > MOST_LATE { MOST_LATE / sum } else { 1.0 }
}

fn of_elements(fractions: &[f64], time_constants_s: &[f64]) -> Parameters {
    let active: Vec<usize> = (0..fractions.len()).filter(|&i| fractions[i] > 1e-4).collect();
    // Two elements a decade.
    let decades =
        active.last().zip(active.first()).map_or(0.5, |(last, first)| 0.5 * (last - first + 1) as f64);
    let sum: f64 = fractions.iter().sum();
    let mut all = vec![("fraction_per_decade", sum / decades.max(1.0))];
    all.extend(active.iter().map(|&i| ("time_constants_s", time_constants_s[i])));
    all
}

impl Kind for Creep {
    fn about(&self) -> &'static About {
        &About {
            name: "creep",
            meaning: "After each change the contraction goes on slowly, over decades of time",
            stage: Stage::Output,
            alike_without: &[Lack::LongHolds],
            complexity: 0.02,
            taken_for: &["rate_dependent_width", "warm_up", "drift"],
            told_from: &[
                (
                    "drift",
                    "after each jump creep starts again, in the direction of the jump; a drift never turns",
                ),
                ("warm_up", "in a long hold there is no travel: what moves is creep"),
            ],
            parts: &[Part::LongHolds],
            ..About::PLAIN
        }
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        let (holds, longest_s) = (judge.excitation.holds.len(), judge.excitation.longest_hold_s());
        let words = match holds {
            0 => "there is no hold of 1 s or more".to_owned(),
            _ => format!("{holds} holds, the longest {longest_s:.1} s"),
        };
        let plateaus_s = &judge.excitation.plateaus_s;
        if longest_s >= CREEP_HOLD_S {
            Ok(words)
        } else if plateaus_s.len() >= PLATEAUS {
            let longest_s = plateaus_s.iter().fold(0.0_f64, |longest, length| longest.max(*length));
            Ok(format!(
                "{words}; but after {} jumps the input moves by little, for {longest_s:.1} s at most",
                plateaus_s.len()
            ))
        } else {
            Err(format!("{words}; creep needs one of {CREEP_HOLD_S} s at least"))
        }
    }

    fn starts(&self, signals: &Signals) -> Vec<Effect> {
        let weights = signals.creep_s.iter().map(|_| Parameter::new(0.0, 0.0, 0.9, 1e-3));
        vec![Effect::new(Form::Creep, []), Effect::new(Form::CreepOfInput, weights)]
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        of_elements(&fractions(fitted), &fitted.signals.creep_s)
    }

    fn doubt(&self, fitted: &Fitted<'_>, longest_hold_s: f64) -> Option<Doubt> {
        let goes_on = goes_on(&fractions(fitted), &fitted.signals.creep_s, longest_hold_s);
        (!goes_on).then_some(Doubt::Over)
    }

    fn extend(&self, carrier: &Carrier<'_>, all: &mut ExtensionParameters<f64>) {
        let Carrier { fitted, .. } = carrier;
        // y (1 + w) - w slow = y0: the share 1/(1 + w) at once, the rest later by 1 + w.
        let later = |weight: Option<&f64>| 1.0 + weight.copied().unwrap_or(0.0);
        let taus_s = fitted.signals.creep_s.iter().enumerate();
        let shares: Vec<f64> = fractions(fitted).into_iter().map(|share| share.max(0.0)).collect();
        let within = below_the_whole(&shares);
        // The search has no more elements than the model has room for.
        all.creep = Some(CreepParameters {
            time_constants_s: taus_s.map(|(i, tau_s)| tau_s * later(fitted.weights.get(i))).collect(),
            fractions: shares.into_iter().map(|share| within * share).collect(),
        });
        if fitted.form() == Form::CreepOfInput {
            all.sites.creep = Site::Pressure;
        }
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        let creep = model.extensions.creep.as_ref()?;
        Some(of_elements(&creep.fractions, &creep.time_constants_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TAU_S: [f64; 5] = [0.1, 0.316, 1.0, 3.16, 10.0];

    #[test]
    fn a_creep_that_is_over_long_before_the_hold_ends_does_not_go_on() {
        assert!(!goes_on(&[0.1, 0.2, 0.1, 0.0, 0.0], &TAU_S, 9.0));
        assert!(goes_on(&[0.1, 0.1, 0.1, 0.1, 0.1], &TAU_S, 9.0));
        assert!(goes_on(&[0.1, 0.2, 0.1, 0.0, 0.0], &TAU_S, 3.0));
    }

    #[test]
    fn behind_a_hold_that_is_longer_than_any_element_lasts_the_slowest_decides() {
        assert!(goes_on(&[0.1; 5], &TAU_S, 300.0));
        assert!(!goes_on(&[0.1, 0.1, 0.1, 0.1, 0.0], &TAU_S, 300.0));
    }

    #[test]
    fn a_creep_of_more_than_the_whole_is_begun_below_it() {
        assert_eq!(below_the_whole(&[0.2, 0.3]), 1.0);
        let fractions = [0.6, 0.5];
        let within = below_the_whole(&fractions);
        assert!((fractions.iter().map(|fraction| within * fraction).sum::<f64>() - MOST_LATE).abs() < 1e-12);
    }
}
