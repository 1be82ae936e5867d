//! From the effects of the search to the nearest extensions of the model.
//!
//! What the search has on either side of the hysteresis the model has too, and thresholds follow the rate that they follow
//! there; a stop that does is the width before the operator.

use model_core::ExtensionParameters;
use model_core::extension::profile::{PROFILE_KNOTS, Profile};
use model_core::extension::{
    CreepParameters, DeadbandForm, DriftParameters, PeriodicDisturbanceParameters, PressureRateParameters,
    ProfileParameters, RateDependentThresholdsParameters, RateDependentWidthParameters, ScheduleParameters,
    Site, SupplySaturationParameters, TransportDelayParameters, ValveDeadbandParameters, ValveLagParameters,
    WarmUpParameters,
};

use crate::Columns;
use crate::candidate::Candidate;
use crate::effect::{Driver, Effect, Form, Rate};
use crate::search::Search;
use crate::signals::{Signals, TENTS, hats};
use crate::turn::Loop;
use crate::valve::{BandForm, ValveFit};

/// So many standard deviations of its noise a pressure may move by unseen.
const UNSEEN: f64 = 2.0;
/// Time constant of the speed of a width; of that of the pressure only to begin with. Unit: s.
const FILTER_S: f64 = 0.01;
const PRESSURE_FILTER_S: f64 = 0.02;
/// The least slope of the loop that an output is divided by, as a share of the mean one.
pub(super) const LEAST_SLOPE: f64 = 0.1;
/// The largest sum of the shares of a creep that a refinement begins with: the model's bound is 1, and a tenth of the way is left to
/// move at once. The refinement may come nearer to the bound.
const MOST_LATE: f64 = 0.9;
/// The least half width of a loop, as a share of the input's span.
const LEAST_WIDTH: f64 = 0.01;
/// Where the knots of a profile lie between the ends of the contraction.
const KNOTS: [f64; PROFILE_KNOTS] = [0.0, 0.2, 0.8, 1.0];

/// The extensions of the muscle.
pub fn extensions(columns: &Columns, search: &Search<'_>, set: &Candidate) -> ExtensionParameters<f64> {
    let signals = search.signals;
    let carrier = Carrier { columns, signals, turn: Loop::of(search.signals, &search.basis, &set.fit) };
    let first = set.fit.effects.len() - set.causes.len();
    let mut all = ExtensionParameters::default();
    for (place, effect) in set.fit.effects.iter().enumerate().skip(first) {
        carrier.add(&mut all, effect, set.fit.output_weights(signals, place));
    }
    all
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
    // One lag for both: as late on a ramp, if not quite after a jump.
    all.valve_lag = Some(ValveLagParameters::new(valve.lag_s));
    all.valve_deadband = valve.band.map(|(form, band)| match form {
        BandForm::Hold => ValveDeadbandParameters { band, form: DeadbandForm::Hold },
        BandForm::Backlash => ValveDeadbandParameters { band: 0.5 * band, form: DeadbandForm::Backlash },
    });
    all.supply_saturation = valve.supply_bar.map(|supply| SupplySaturationParameters { supply });
}

/// The mean that the search takes a column from.
fn mean(column: &Option<Vec<f64>>) -> f64 {
    column.as_ref().map_or(0.0, |values| values.iter().sum::<f64>() / values.len().max(1) as f64)
}

struct Carrier<'a> {
    columns: &'a Columns,
    signals: &'a Signals,
    turn: Loop,
}

impl Carrier<'_> {
    fn add(&self, all: &mut ExtensionParameters<f64>, effect: &Effect, weights: &[f64]) {
        let signals = self.signals;
        let parameter = |i: usize| effect.parameters.get(i).map_or(0.0, |parameter| parameter.value);
        let weight = |i: usize| weights.get(i).copied().unwrap_or(0.0);
        let through = |first: usize| {
            let strengths: [f64; TENTS] = std::array::from_fn(|i| parameter(first + i));
            self.profile(|y| self.between(strengths, y))
        };
        let moving = |first: usize| {
            let strengths: [f64; TENTS] = std::array::from_fn(|i| parameter(first + i));
            self.profile(|y| self.between(strengths, y) * signals.stiffer(y))
        };
        let behind = |first: usize| {
            let strengths: [f64; TENTS] = std::array::from_fn(|i| weight(first + i));
            self.profile(|y| self.between(strengths, y).max(0.0))
        };
        match effect.form {
            Form::Delay => {
                all.transport_delay = Some(TransportDelayParameters { delay_s: parameter(0).max(0.0) });
            }
            Form::Lag => all.valve_lag = Some(ValveLagParameters::new(parameter(0).exp())),
            Form::OutputLag => self.add_viscosity(all, Site::Contraction, behind(0)),
            Form::Inertia => {
                all.inertia = Some(moving(0));
                self.add_viscosity(all, Site::Pressure, moving(TENTS));
            }
            Form::OutputInertia => {
                all.inertia = Some(behind(0));
                all.sites.inertia = Site::Contraction;
                self.add_viscosity(all, Site::Contraction, behind(TENTS));
            }
            Form::Driven(driver) => {
                let offset = through(effect.parameters.len() - TENTS);
                self.add_driven(all, driver, parameter(0), (Site::Pressure, offset));
            }
            Form::Added(driver) => {
                let offset = ProfileParameters {
                    knots: signals.knots.into_iter().collect(),
                    values: (0..TENTS).map(|tent| -weight(tent)).collect(),
                };
                self.add_driven(all, driver, parameter(0), (Site::Contraction, offset));
            }
            Form::Thresholds(rate) => {
                let gain = self.profile(|y| parameter(1) / self.typical_at(rate, y).powf(parameter(0)));
                let of_input = || PressureRateParameters {
                    gain: parameter(1) / signals.typical_speed(rate).powf(parameter(0)),
                    resolution: UNSEEN * signals.input_noise,
                };
                all.rate_dependent_thresholds = Some(RateDependentThresholdsParameters {
                    exponent: parameter(0),
                    filter_s: if rate == Rate::Input { PRESSURE_FILTER_S } else { FILTER_S },
                    gain,
                    pressure: (rate == Rate::Input).then(of_input),
                });
            }
            Form::Friction(rate) => {
                let range = parameter(1).exp();
                let times = range / self.typical(rate).powf(parameter(0));
                let mut width = through(2);
                width.values.iter_mut().for_each(|value| *value *= times);
                self.add_width(all, range, width, parameter(0));
            }
            Form::Creep => {
                // y (1 + w) - w slow = y0: the share 1/(1 + w) at once, the rest later by 1 + w.
                let sum: f64 = weights.iter().sum();
                let late = |weight: f64| (weight / (1.0 + sum), 1.0 + weight);
                self.add_creep(all, weights.iter().map(|&weight| late(weight)));
            }
            Form::CreepOfInput => {
                self.add_creep(all, effect.parameters.iter().map(|weight| (weight.value, 1.0)));
                all.sites.creep = Site::Pressure;
            }
            Form::Drift => {
                let rate_per_s = weight(0) / signals.duration_s().max(1e-9);
                all.drift = Some(DriftParameters { rate_per_s, compensated: false });
            }
            Form::Tone => {
                all.periodic_disturbance = Some(PeriodicDisturbanceParameters {
                    amplitude: weight(0).hypot(weight(1)),
                    frequency_hz: parameter(0),
                    phase_rad: weight(1).atan2(weight(0)),
                    compensated: false,
                });
            }
            // The model has no third order: beside a mass its rate and acceleration have both.
            Form::LagBefore | Form::Envelope | Form::Width | Form::Step | Form::Wander => {}
        }
    }

    /// A profile through its knots: near either end, where a muscle's curve is flat and an equivalent input of the same
    /// effect much larger, they lie closer than between.
    fn profile(&self, value: impl Fn(f64) -> f64) -> ProfileParameters<f64> {
        let (low, high) = (self.signals.knots[0], self.signals.knots[TENTS - 1]);
        let knots = KNOTS.map(|share| low + share * (high - low));
        ProfileParameters {
            knots: knots.into_iter().collect(),
            values: knots.map(value).into_iter().collect(),
        }
    }

    /// What the search's tents are at a contraction.
    fn between(&self, strengths: [f64; TENTS], at: f64) -> f64 {
        hats(&self.signals.knots, at).iter().zip(strengths).map(|(hat, strength)| hat * strength).sum()
    }

    /// How far the input has to move at a contraction for the output to move by 1.
    fn per_slope(&self, at: f64) -> f64 {
        let knots = &self.signals.knots;
        let mean = (knots[TENTS - 1] - knots[0]) / self.signals.input_span;
        1.0 / self.turn.slope(at).max(LEAST_SLOPE * mean)
    }

    /// Viscosity; where there is one already, more of that.
    fn add_viscosity(
        &self,
        all: &mut ExtensionParameters<f64>,
        site: Site,
        viscosity: ProfileParameters<f64>,
    ) {
        let Some(sum) = &mut all.viscous_lag else {
            all.viscous_lag = Some(viscosity);
            all.sites.viscous_lag = site;
            return;
        };
        let Ok(more) = Profile::try_new(&viscosity, "profile", "") else { return };
        for (&knot, value) in sum.knots.iter().zip(&mut sum.values) {
            *value += more.value(knot)
                * match (site, all.sites.viscous_lag) {
                    (Site::Contraction, Site::Pressure) => self.per_slope(knot),
                    (Site::Pressure, Site::Contraction) => 1.0 / self.per_slope(knot),
                    _ => 1.0,
                };
        }
    }

    fn add_driven(
        &self,
        all: &mut ExtensionParameters<f64>,
        driver: Driver,
        lambda: f64,
        (site, offset): (Site, ProfileParameters<f64>),
    ) {
        match driver {
            Driver::WarmUp => {
                all.warm_up = Some(WarmUpParameters { travel: lambda.exp(), offset });
                all.sites.warm_up = site;
            }
            Driver::Load => {
                all.sites.load = site;
                all.load = Some(ScheduleParameters { reference: mean(&self.columns.load_n), offset });
            }
            Driver::Temperature => {
                all.sites.temperature = site;
                let reference = mean(&self.columns.temperature_c);
                all.temperature = Some(ScheduleParameters { reference, offset });
            }
            Driver::Rate => self.add_viscosity(all, site, offset),
        }
    }

    /// The typical speed of the contraction, where that is at `y`. Unit: output unit/s.
    fn typical_at(&self, rate: Rate, y: f64) -> f64 {
        let typical = self.signals.typical_speed(rate);
        match rate {
            Rate::Input => typical / self.per_slope(y),
            Rate::Contraction => typical,
        }
    }

    /// The typical speed of the operators' input. Unit: input unit/s.
    fn typical(&self, rate: Rate) -> f64 {
        let per_input = match rate {
            Rate::Input => 1.0,
            Rate::Contraction => self.turn.slope(self.signals.knots[TENTS / 2]).max(1e-9),
        };
        self.signals.typical_speed(rate) / per_input
    }

    fn add_width(
        &self,
        all: &mut ExtensionParameters<f64>,
        radius: f64,
        width: ProfileParameters<f64>,
        exponent: f64,
    ) {
        all.rate_dependent_width =
            Some(RateDependentWidthParameters { radius, exponent, filter_s: FILTER_S, width });
    }

    /// Elements of these fractions, each later than the search's time constant by a factor.
    fn add_creep(&self, all: &mut ExtensionParameters<f64>, elements: impl Iterator<Item = (f64, f64)>) {
        let elements = elements.zip(&self.signals.creep_s);
        let (time_constants_s, fractions): (Vec<f64>, Vec<f64>) =
            elements.map(|((fraction, later), tau_s)| (tau_s * later, fraction.max(0.0))).unzip();
        let within = below_the_whole(&fractions);
        // The search has no more elements than the model has room for.
        all.creep = Some(CreepParameters {
            time_constants_s: time_constants_s.into_iter().collect(),
            fractions: fractions.into_iter().map(|fraction| within * fraction).collect(),
        });
    }
}

/// The factor that brings the sum of a creep's shares below 1: the model has that bound, the search has not.
fn below_the_whole(fractions: &[f64]) -> f64 {
    let sum: f64 = fractions.iter().sum();
    if sum > MOST_LATE { MOST_LATE / sum } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::{MOST_LATE, below_the_whole};

    #[test]
    fn a_creep_of_more_than_the_whole_is_begun_below_it() {
        assert_eq!(below_the_whole(&[0.2, 0.3]), 1.0);
        let fractions = [0.6, 0.5];
        let within = below_the_whole(&fractions);
        assert!((fractions.iter().map(|fraction| within * fraction).sum::<f64>() - MOST_LATE).abs() < 1e-12);
    }
}
