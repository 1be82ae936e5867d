//! The loop widens with speed, without a lag at rest.

use model_core::ExtensionParameters;
use model_core::extension::{
    PressureRateParameters, RateDependentThresholdsParameters, RateDependentWidthParameters,
};

use super::kind::{About, Kind, Law, Stage};
use super::needs::{Judge, Judged};
use crate::carrier::Carrier;
use crate::effect::{Effect, Form, Parameter, Rate};
use crate::fitted::{Fitted, Parameters, value};
use crate::plan::part::Part;
use crate::signals::Signals;
use crate::simulated::{Simulated, at_middle};

/// Bounds of the power of the rate that it grows with: one that grows nearly as the speed is viscosity.
const POWERS: (f64, f64) = (0.2, 0.75);
/// So many standard deviations of its noise a pressure may move by unseen.
const UNSEEN: f64 = 2.0;
/// Time constant of the speed of a width; of that of the pressure only to begin with. Unit: s.
const FILTER_S: f64 = 0.01;
const PRESSURE_FILTER_S: f64 = 0.02;

/// The cause.
pub struct RateDependentWidth;

/// The gain and the exponent of thresholds that follow a rate.
fn width(gain: f64, exponent: f64, rate: Rate) -> Parameters {
    let name = match rate {
        Rate::Input => "width_gain",
        Rate::Contraction => "width_gain_of_contraction_rate",
    };
    vec![(name, gain), ("rate_exponent", exponent)]
}

impl Kind for RateDependentWidth {
    fn about(&self) -> &'static About {
        &About {
            name: "rate_dependent_width",
            meaning: "The loop widens with speed, and there is no lag at rest",
            law: Law::Width,
            stage: Stage::Hysteresis,
            complexity: 0.04,
            taken_for: &["viscous_lag", "creep"],
            told_from: &[("creep", "in a long hold creep goes on, after slow swings too")],
            // Where the input stands still, friction that grew with the rate is gone and a lag comes after.
            parts: &[Part::Speeds, Part::Jumps],
            ..About::PLAIN
        }
    }

    fn needs(&self, judge: &Judge<'_>) -> Judged {
        judge.speeds()
    }

    fn starts(&self, signals: &Signals) -> Vec<Effect> {
        let span = signals.input_span;
        let power = Parameter::new(0.5, POWERS.0, POWERS.1, 1e-3);
        let gain = Parameter::new(0.0, 0.0, 10.0, 1e-2);
        let range = Parameter::logarithm(0.05 * span, 0.005 * span, 0.4 * span);
        let strengths = Parameter::strengths(signals, 0.05 * span, 0.0);
        let friction = [power, range].into_iter().chain(strengths);
        vec![
            Effect::new(Form::Thresholds(Rate::Input), [power, gain]),
            Effect::new(Form::Thresholds(Rate::Contraction), [power, gain]),
            Effect::new(Form::Friction(Rate::Contraction), friction),
        ]
    }

    fn parameters(&self, fitted: &Fitted<'_>) -> Parameters {
        let exponent = fitted.parameter(0);
        let of_typical = |rate| fitted.signals.typical_speed(rate).powf(exponent);
        match fitted.form() {
            Form::Thresholds(rate) => width(fitted.parameter(1) / of_typical(rate), exponent, rate),
            Form::Friction(rate) => {
                let range = fitted.parameter(1).exp() * fitted.at_middle(2) / of_typical(rate);
                width(range / fitted.half_width().max(1e-9), exponent, rate)
            }
            _ => Vec::new(),
        }
    }

    fn extend(&self, carrier: &Carrier<'_>, all: &mut ExtensionParameters<f64>) {
        let Carrier { fitted, .. } = carrier;
        let exponent = fitted.parameter(0);
        match fitted.form() {
            Form::Thresholds(rate) => {
                let gain =
                    carrier.profile(|y| fitted.parameter(1) / carrier.typical_at(rate, y).powf(exponent));
                let of_input = || PressureRateParameters {
                    gain: fitted.parameter(1) / fitted.signals.typical_speed(rate).powf(exponent),
                    resolution: UNSEEN * fitted.signals.input_noise,
                };
                all.rate_dependent_thresholds = Some(RateDependentThresholdsParameters {
                    exponent,
                    filter_s: if rate == Rate::Input { PRESSURE_FILTER_S } else { FILTER_S },
                    gain,
                    pressure: (rate == Rate::Input).then(of_input),
                });
            }
            Form::Friction(rate) => {
                let radius = fitted.parameter(1).exp();
                let times = radius / carrier.typical(rate).powf(exponent);
                let mut width = carrier.through(2);
                width.values.iter_mut().for_each(|value| *value *= times);
                all.rate_dependent_width =
                    Some(RateDependentWidthParameters { radius, exponent, filter_s: FILTER_S, width });
            }
            _ => {}
        }
    }

    fn written(&self, model: &Simulated<'_>) -> Option<Parameters> {
        let of_friction = || {
            let friction = model.extensions.rate_dependent_width.as_ref()?;
            let gain = at_middle(&friction.width)? / model.half_width().max(1e-9);
            Some(width(gain, friction.exponent, Rate::Contraction))
        };
        self.measured(model).or_else(of_friction)
    }

    /// Of thresholds alone: the width of the loop is the operator's and the friction's together, of which the search knows more.
    fn measured(&self, model: &Simulated<'_>) -> Option<Parameters> {
        let thresholds = model.extensions.rate_dependent_thresholds.as_ref()?;
        let (gain, rate) = match &thresholds.pressure {
            Some(pressure) => (pressure.gain, Rate::Input),
            None => (at_middle(&thresholds.gain)?, Rate::Contraction),
        };
        Some(width(gain, thresholds.exponent, rate))
    }

    /// Of those alone that it has: not every gain is of the same rate.
    fn take_over(&self, own: &mut Parameters, measured: Parameters) {
        for (name, own) in own {
            *own = value(&measured, name).unwrap_or(*own);
        }
    }
}

#[cfg(test)]
mod tests {
    use model_core::extension::ProfileParameters;

    use super::*;
    use crate::extend::tests::model;

    #[test]
    fn a_width_keeps_the_gain_that_it_has_and_takes_the_measured_exponent() {
        let mut own = vec![("width_gain", 0.4), ("rate_exponent", 0.4)];
        let measured = vec![("width_gain_of_contraction_rate", 0.05), ("rate_exponent", 0.5)];
        RateDependentWidth.take_over(&mut own, measured);
        assert_eq!(own, [("width_gain", 0.4), ("rate_exponent", 0.5)]);
    }

    #[test]
    fn friction_that_grows_with_the_rate_is_said_of_a_written_model_and_not_measured_by_it() {
        let mut written = model();
        written.extensions = ExtensionParameters {
            rate_dependent_width: Some(RateDependentWidthParameters {
                radius: 0.1,
                exponent: 0.5,
                filter_s: FILTER_S,
                width: ProfileParameters::constant(0.05),
            }),
            ..ExtensionParameters::default()
        };
        let model = written.simulated().expect("a loop");
        let said = RateDependentWidth.written(&model).expect("a width");
        // Half the width of its loop is some 0.15 bar: a play of 0.4 bar that weighs 0.4.
        let gain = value(&said, "width_gain_of_contraction_rate").expect("a gain");
        assert!((0.2..0.6).contains(&gain), "{gain}");
        assert_eq!(value(&said, "rate_exponent"), Some(0.5));
        assert_eq!(RateDependentWidth.measured(&model), None);
    }
}
