//! From the effects of the search, and the valve, to the extensions of the model.

use model_core::ExtensionParameters;
use model_core::extension::{
    DeadbandForm, RateDependentThresholdsParameters, RateDependentWidthParameters,
    SupplySaturationParameters, ValveDeadbandParameters,
};

use super::jump::Jump;
use crate::Columns;
use crate::candidate::Candidate;
use crate::carrier::Carrier;
use crate::fitted::FittedSet;
use crate::regulator;
use crate::search::Search;
use crate::signals::TENTS;
use crate::turn::Loop;
use crate::valve::{BandForm, ValveFit};

/// The least half width of a loop, as a share of the input's span.
const LEAST_WIDTH: f64 = 0.01;

/// The extensions of the muscle, and of the regulator before it where the command alone is known.
pub fn extensions(columns: &Columns, search: &Search<'_>, set: &Candidate) -> ExtensionParameters<f64> {
    let fitted = FittedSet::new(search.signals, &search.basis, &set.fit);
    let first = set.fit.effects.len() - set.causes.len();
    // Where the valve is a cause, that takes the place of the ordinary regulator.
    let valve_lag = regulator::of(&set.fit.effects[..first]).map(|regulator| regulator.lag());
    let mut all = ExtensionParameters { valve_lag, ..ExtensionParameters::default() };
    for (i, cause) in set.causes.iter().enumerate() {
        cause.extend(&Carrier { columns, fitted: fitted.as_fitted(first + i) }, &mut all);
    }
    all
}

/// What the causes of a set have done to the sensor's zero.
pub fn jump(columns: &Columns, search: &Search<'_>, set: &Candidate) -> Option<Jump> {
    let fitted = FittedSet::new(search.signals, &search.basis, &set.fit);
    let first = set.fit.effects.len() - set.causes.len();
    let mut causes = set.causes.iter().enumerate();
    causes.find_map(|(i, cause)| cause.jump(&Carrier { columns, fitted: fitted.as_fitted(first + i) }))
}

/// The same extensions for an operator whose thresholds cannot change: what they do with the rate is a width before it.
pub fn before_operator(
    all: &ExtensionParameters<f64>,
    search: &Search<'_>,
    set: &Candidate,
) -> ExtensionParameters<f64> {
    let signals = search.signals;
    let turn = Loop::of(search.signals, &search.basis, &set.fit);
    let rate_dependent_width = all.rate_dependent_thresholds.as_ref().map(|thresholds| {
        let RateDependentThresholdsParameters { exponent, filter_s, gain, .. } = thresholds;
        let radius = turn.half_width(signals.knots[TENTS / 2]).max(LEAST_WIDTH * signals.input_span);
        // At the speed of the contraction for one of the input of 1.
        let mut width = gain.clone();
        for (&knot, value) in gain.knots.iter().zip(&mut width.values) {
            *value *= radius * turn.slope(knot).max(0.0).powf(*exponent);
        }
        RateDependentWidthParameters { radius, exponent: *exponent, filter_s: *filter_s, width }
    });
    ExtensionParameters {
        rate_dependent_width: rate_dependent_width.or_else(|| all.rate_dependent_width.clone()),
        rate_dependent_thresholds: None,
        ..all.clone()
    }
}

/// Adds what stands between command and pressure.
pub fn add_valve(all: &mut ExtensionParameters<f64>, valve: Option<&ValveFit>) {
    let Some(ValveFit { valve, .. }) = valve else { return };
    all.valve_lag = Some(valve.lag());
    all.valve_deadband = valve.band.map(|(form, band)| match form {
        BandForm::Hold | BandForm::HoldBetween => ValveDeadbandParameters { band, form: DeadbandForm::Hold },
        BandForm::Backlash => ValveDeadbandParameters { band: 0.5 * band, form: DeadbandForm::Backlash },
    });
    all.supply_saturation = valve.supply_bar.map(|supply| SupplySaturationParameters { supply });
}
