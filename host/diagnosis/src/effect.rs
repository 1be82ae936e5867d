//! The effects of the search: what each cause may add to the baseline, and where.
//!
//! | place | effects |
//! |---|---|
//! | on the way of the input | `transport_delay`, `creep`; where only the command is known `valve_lag`, `supply_saturation` |
//! | before the operators, as an equivalent input | `load`, `temperature`, `warm_up`, `viscous_lag`, `inertia`, `rate_dependent_width` |
//! | on the output | `load`, `temperature`, `warm_up`, `viscous_lag`, `inertia`, `creep`, `drift`, `periodic_disturbance`, `zero_step` |
//!
//! Nobody knows beforehand whether a cause acts on the balance of forces or on the length: where both are sensible both
//! are tried, and the better one stands for the cause. An equivalent input is `u = p(t - delay) - sum of h(y) d(t)`: a
//! force that acts on the muscle, over its area. `h` is made of a few tents over the contraction.

pub use super::rates::Rate;
use super::signals::{Signals, TENTS};

/// A nonlinear parameter with its bounds.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// The value.
    pub value: f64,
    /// Its least value.
    pub low: f64,
    /// Its greatest value.
    pub high: f64,
    /// A step that changes something.
    pub step: f64,
}

impl Parameter {
    /// A value within bounds.
    pub fn new(value: f64, low: f64, high: f64, step: f64) -> Self {
        Self { value: value.clamp(low, high), low, high, step }
    }

    /// Changes the value, within its bounds.
    pub fn add(&mut self, change: f64) {
        self.value = (self.value + change).clamp(self.low, self.high);
    }

    /// A parameter that is searched for by its logarithm.
    pub fn logarithm(value: f64, low: f64, high: f64) -> Self {
        Self::new(value.ln(), low.ln(), high.ln(), 1e-3)
    }

    /// Strengths from `low` on, one a tent, whose step moves the input by a thousandth of its span at a typical value of what drives it.
    pub fn strengths(signals: &Signals, typical: f64, low: f64) -> [Self; TENTS] {
        [Self::new(0.0, low, f64::INFINITY, 1e-3 * signals.input_span / typical.max(1e-9)); TENTS]
    }
}

/// What an effect does. Parameters come in the order that is said; strengths are three, one a tent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// Input later by the parameter. Unit: s.
    Delay,
    /// Input through a lag of the second order; parameters: logarithms of how late it is on a ramp, and of the damping ratio.
    SecondOrder,
    /// Input as air that flows through an orifice; parameters: logarithm of the time constant, and the absolute pressures before it and
    /// outside. Unit of the pressures: input unit.
    Orifice,
    /// Input never above the parameter, before all lags and delays. Input unit.
    Ceiling,
    /// Low-passes of the input, less the input, each with a parameter for its weight.
    CreepOfInput,
    /// Equivalent input: strengths times the column.
    Driven(Driver),
    /// Equivalent input: strengths times the acceleration, then strengths times the rate, where the muscle is and by how much
    /// more input a change takes there.
    Inertia,
    /// The bend of the envelope is the parameter.
    Envelope,
    /// The thresholds of all operators wider with a rate: times 1 + gain rate^power; first the power, then the gain, for
    /// the rate over its root mean square.
    Thresholds(Rate),
    /// Equivalent input: strengths times a stop; the parameters are those of [`Form::Friction`], the power 0.
    Width,
    /// Equivalent input: strengths times a stop whose range is a rate to a power; first the power, then the logarithm of
    /// the range at the root mean square of the rate.
    Friction(Rate),
    /// On the output: tents times the column, linear.
    Added(Driver),
    /// On the output: less tents times the rate, linear.
    OutputLag,
    /// On the output, before the mass that is there too: less tents times the jerk, linear.
    LagBefore,
    /// On the output: less tents times the acceleration, then less tents times the rate, linear.
    OutputInertia,
    /// On the output: low-passes of it, less itself, each with a weight of one sign.
    Creep,
    /// On the output: time.
    Drift,
    /// On the output: sine and cosine; the parameter is the frequency. Unit: Hz.
    Tone,
    /// On the output: a step; the parameter is its time. Unit: s.
    Step,
}

/// A column that drives an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Driver {
    /// The recorded load.
    Load,
    /// The recorded temperature.
    Temperature,
    /// exp(-travel/lambda); the effect's first parameter is the logarithm of lambda.
    WarmUp,
    /// The rate of the contraction.
    Rate,
}

impl Form {
    /// Whether the measured contraction enters by its rate, which a model that runs free has to make itself.
    pub fn is_fed_back(self) -> bool {
        matches!(
            self,
            Self::Driven(Driver::Rate)
                | Self::Inertia
                | Self::OutputLag
                | Self::LagBefore
                | Self::OutputInertia
                | Self::Thresholds(Rate::Contraction)
                | Self::Friction(Rate::Contraction)
        )
    }
}

/// An effect with its parameters.
#[derive(Clone, Debug)]
pub struct Effect {
    /// What it does.
    pub form: Form,
    /// Shapes first, then strengths.
    pub parameters: Vec<Parameter>,
}

impl Effect {
    /// With its parameters, in the order that its form says.
    pub fn new(form: Form, parameters: impl IntoIterator<Item = Parameter>) -> Self {
        Self { form, parameters: parameters.into_iter().collect() }
    }

    /// A delay of the input. Unit: s.
    pub fn delay(delay_s: f64) -> Self {
        Self::new(Form::Delay, [Parameter::new(delay_s, delay_s, delay_s, 1.0)])
    }

    /// By how much it makes the input late. Unit: s.
    pub fn late_s(&self) -> f64 {
        match (self.form, self.parameters.first()) {
            (Form::Delay, Some(delay)) => delay.value,
            (Form::SecondOrder | Form::Orifice, Some(lag)) => lag.value.exp(),
            _ => 0.0,
        }
    }

    /// The level that the input never exceeds under these effects; infinite where none of them is a ceiling. Input unit.
    pub fn ceiling(effects: &[Self]) -> f64 {
        let of = |effect: &Self| (effect.form == Form::Ceiling).then(|| effect.parameters[0].value);
        effects.iter().filter_map(of).fold(f64::INFINITY, f64::min)
    }

    /// What belongs to the baseline: its envelope, a small delay, a width that does not depend on the rate, its radius a share of the
    /// input's span, and this regulator, if there is one.
    pub fn nuisances(signals: &Signals, radius: f64, regulator: Option<&Self>) -> Vec<Self> {
        let envelope = Self::new(Form::Envelope, [Parameter::new(0.5, 0.0, 1.2, 1e-3)]);
        let all = [envelope, Self::small_delay(signals), Self::static_width(signals, radius)];
        all.into_iter().chain(regulator.cloned()).collect()
    }

    /// A delay of at most half a row, which no recording is free of.
    pub fn small_delay(signals: &Signals) -> Self {
        let half_s = 0.5 * signals.step_s;
        Self::new(Form::Delay, [Parameter::new(0.0, -half_s, half_s, 0.1 * signals.step_s)])
    }

    /// A width that does not depend on the rate, its radius a share of the input's span.
    pub fn static_width(signals: &Signals, radius: f64) -> Self {
        let span = signals.input_span;
        // A factor of the stop, whatever the input's unit.
        let strength = Parameter::new(0.0, 0.0, f64::INFINITY, 1e-3);
        let radius = Parameter::logarithm(radius * span, 0.01 * span, 0.4 * span);
        let shapes = [Parameter::new(0.0, 0.0, 0.0, 1.0), radius];
        Self::new(Form::Width, shapes.into_iter().chain([strength; TENTS]))
    }
}
