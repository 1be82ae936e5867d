//! The first cycles differ and settle with travel.

use model_core::ExtensionParameters;
use model_core::extension::WarmUpParameters;

use super::kind::{About, Kind, Law, Stage};
use super::needs::{Judge, Judged};
use crate::carrier::Carrier;
use crate::effect::{Driver, Effect, Form, Parameter};
use crate::fitted::{Doubt, Fitted, Parameters};
use crate::plan::part::Part;
use crate::signals::Signals;
use crate::simulated::Simulated;
use recording::numbers::apart;

/// The least travel in which running in is seen. Unit: strokes.
const STROKES: f64 = 4.0;

/// The cause.
pub struct WarmUp;

/// The share of the stroke that the first strokes lack, of changes at these knots: positive where they are too short, as is usual. What
/// they lack is of the stroke that comes to be.
fn fraction(knots: &[f64], changes: &[f64]) -> f64 {
    let stroke = knots[knots.len() - 1] - knots[0];
    let largest = changes.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0);
    let lacking = -largest / stroke.max(1e-9);
    lacking / (1.0 + lacking.max(0.0))
}

fn of_fitted(fitted: &Fitted<'_>) -> f64 {
    fraction(&fitted.signals.knots, &fitted.changes())
}

/// `travel`: output unit.
fn named(fraction: f64, travel: f64) -> Parameters {
    vec![("fraction", fraction), ("travel_mm", travel)]
}

impl Kind for WarmUp {
    fn about(&self) -> &'static About {
        &About {
            name: "warm_up",
            meaning: "The first cycles differ, and settle with the way that the muscle has gone",
            law: Law::Progress,
            stage: Stage::Offset,
            complexity: 0.02,
            taken_for: &["creep", "drift"],
            told_from: &[(
                "temperature",
                "let the temperature rise and fall in the rest too, where there is no travel",
            )],
            parts: &[Part::Again],
            note: Some("begin with a muscle that has rested for an hour: the first cycles show it"),
            ..About::PLAIN
        }
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        let strokes = judge.excitation.travel_strokes;
        let repeats = judge.repeats()?;
        if strokes >= STROKES {
            Ok(format!("{repeats}; a travel of {strokes:.1} strokes"))
        } else {
            let strokes = apart(strokes, STROKES, 1);
            Err(format!("a travel of {strokes} strokes, and {STROKES} are needed"))
        }
    }

    fn starts(&self, signals: &Signals) -> Vec<Effect> {
        let way = signals.travel.last().copied().unwrap_or(0.0).max(1e-9);
        let of_share = |share: f64| {
            let lambda = Parameter::logarithm(share * way, 0.01 * way, way / 3.0);
            let strengths = Parameter::strengths(signals, 1.0, f64::NEG_INFINITY);
            [
                Effect::new(Form::Driven(Driver::WarmUp), std::iter::once(lambda).chain(strengths)),
                Effect::new(Form::Added(Driver::WarmUp), [lambda]),
            ]
        };
        [0.03, 0.12].into_iter().flat_map(of_share).collect()
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        named(of_fitted(fitted), fitted.parameter(0).exp())
    }

    fn doubt(&self, fitted: &Fitted<'_>, _longest_hold_s: f64) -> Option<Doubt> {
        (of_fitted(fitted) < 0.0).then_some(Doubt::Fading)
    }

    fn extend(&self, carrier: &Carrier<'_>, all: &mut ExtensionParameters<f64>) {
        let (offset, site) = carrier.offset();
        all.warm_up = Some(WarmUpParameters { travel: carrier.fitted.parameter(0).exp(), offset });
        all.sites.warm_up = site;
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        let all = model.extensions;
        let warm_up = all.warm_up.as_ref()?;
        let changes = model.changes(&warm_up.offset, all.sites.warm_up);
        Some(named(fraction(&warm_up.offset.knots, &changes), warm_up.travel))
    }
}

#[cfg(test)]
mod tests {
    use super::fraction;

    #[test]
    fn what_the_first_strokes_lack_is_a_share_of_the_stroke_that_comes_to_be() {
        // 80 mm of 100: at each contraction a quarter of it.
        let fraction = fraction(&[0.0, 50.0, 100.0], &[0.0, -12.5, -25.0]);
        assert!((fraction - 0.2).abs() < 1e-12, "{fraction}");
    }
}
