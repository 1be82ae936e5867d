//! From an effect of the search to the nearest extension of a model: what causes need on the way.
//!
//! What the search has on either side of the hysteresis the model has too.

use model_core::ExtensionParameters;
use model_core::extension::profile::{PROFILE_KNOTS, Profile};
use model_core::extension::{ProfileParameters, ScheduleParameters, Site};

use super::Columns;
use super::effect::{Form, Rate};
use super::fitted::Fitted;
use super::signals::{TENTS, hats};

/// The least slope of the loop that an output is divided by, as a share of the mean one: it keeps an equivalent input below ten times
/// what it is on a straight line. A guard against division by next to nothing, at the flat ends of the curve.
pub const LEAST_SLOPE: f64 = 0.1;
/// Where the knots of a profile lie between the ends of the contraction.
const KNOTS: [f64; PROFILE_KNOTS] = [0.0, 0.2, 0.8, 1.0];

/// An effect, and the recording that it was fitted to.
pub struct Carrier<'a> {
    /// The recording.
    pub columns: &'a Columns,
    /// The effect; of a lag before a mass with the weights of the polynomial that they are together.
    pub fitted: Fitted<'a>,
}

impl Carrier<'_> {
    /// A profile through its knots: near either end, where a muscle's curve is flat and an equivalent input of the same
    /// effect much larger, they lie closer than between.
    pub fn profile(&self, value: impl Fn(f64) -> f64) -> ProfileParameters<f64> {
        let tents = &self.fitted.signals.knots;
        let (low, high) = (tents[0], tents[TENTS - 1]);
        let knots = KNOTS.map(|share| low + share * (high - low));
        ProfileParameters {
            knots: knots.into_iter().collect(),
            values: knots.map(value).into_iter().collect(),
        }
    }

    /// The profile of the parameters from the `first` on, one a tent.
    pub fn through(&self, first: usize) -> ProfileParameters<f64> {
        self.profile(|y| self.between(y, |tent| self.fitted.parameter(first + tent)))
    }

    /// The same of weights on the output, none below 0.
    pub fn behind(&self, first: usize) -> ProfileParameters<f64> {
        self.profile(|y| self.between(y, |tent| self.fitted.weight(first + tent)).max(0.0))
    }

    /// What is taken off per unit of what drives it, and where.
    pub fn offset(&self) -> (ProfileParameters<f64>, Site) {
        let Fitted { signals, effect, .. } = self.fitted;
        match effect.form {
            Form::Added(_) => {
                let offset = ProfileParameters {
                    knots: signals.knots.into_iter().collect(),
                    values: (0..TENTS).map(|tent| -self.fitted.weight(tent)).collect(),
                };
                (offset, Site::Contraction)
            }
            _ => (self.through(effect.parameters.len() - TENTS), Site::Pressure),
        }
    }

    /// The same for a column, from its mean on, by which the search takes it.
    pub fn schedule(&self, column: &Option<Vec<f64>>) -> (ScheduleParameters<f64>, Site) {
        let mean = |values: &Vec<f64>| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let (offset, site) = self.offset();
        (ScheduleParameters { reference: column.as_ref().map_or(0.0, mean), offset }, site)
    }

    /// Adds viscosity; where there is one already, more of that.
    pub fn add_viscosity(
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

    /// The typical speed of the contraction, where that is at `y`. Unit: output unit/s.
    pub fn typical_at(&self, rate: Rate, y: f64) -> f64 {
        let typical = self.fitted.signals.typical_speed(rate);
        match rate {
            Rate::Input => typical / self.per_slope(y),
            Rate::Contraction => typical,
        }
    }

    /// The typical speed of the operators' input. Unit: input unit/s.
    pub fn typical(&self, rate: Rate) -> f64 {
        let signals = self.fitted.signals;
        let per_input = match rate {
            Rate::Input => 1.0,
            Rate::Contraction => self.fitted.turn().slope(signals.knots[TENTS / 2]).max(1e-9),
        };
        signals.typical_speed(rate) / per_input
    }

    /// What the search's tents are at a contraction.
    fn between(&self, at: f64, strength: impl Fn(usize) -> f64) -> f64 {
        let hats = hats(&self.fitted.signals.knots, at);
        hats.iter().enumerate().map(|(tent, hat)| hat * strength(tent)).sum()
    }

    /// How far the input has to move at a contraction for the output to move by 1.
    fn per_slope(&self, at: f64) -> f64 {
        let signals = self.fitted.signals;
        let mean = (signals.knots[TENTS - 1] - signals.knots[0]) / signals.input_span;
        1.0 / self.fitted.turn().slope(at).max(LEAST_SLOPE * mean)
    }
}
