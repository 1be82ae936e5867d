//! The effects of the search: what each cause may add to the baseline, and where.
//!
//! | place | effects |
//! |---|---|
//! | on the way of the input | `transport_delay`, `valve_lag` (where only the command is known), `creep` |
//! | before the operators, as an equivalent input | `load`, `temperature`, `warm_up`, `viscous_lag`, `inertia`, `rate_dependent_width` |
//! | on the output | `load`, `temperature`, `warm_up`, `viscous_lag`, `inertia`, `creep`, `drift`, `periodic_disturbance` |
//!
//! Nobody knows beforehand whether a cause acts on the balance of forces or on the length: where both are sensible both
//! are tried, and the better one stands for the cause. An equivalent input is `u = p(t - delay) - sum of h(y) d(t)`: a
//! force that acts on the muscle, over its area. `h` is made of a few tents over the contraction.

use super::anatomy::spectrum::LEAST_PERIODS;
use super::cause::Cause;
pub use super::rates::Rate;
use super::signals::{Signals, TENTS};
use recording::numbers::root_mean_square;

/// Lags and a delay up to here, together, are those of any proportional regulator, and not named. Unit: s.
pub const ORDINARY_LAG_S: f64 = 0.07;
/// The shortest lag of a valve that is looked for, in steps of the recording: a shorter one is over before the next sample.
const LEAST_LAG: f64 = 0.2;

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
    fn new(value: f64, low: f64, high: f64, step: f64) -> Self {
        Self { value: value.clamp(low, high), low, high, step }
    }

    /// Changes the value, within its bounds.
    pub fn add(&mut self, change: f64) {
        self.value = (self.value + change).clamp(self.low, self.high);
    }

    /// A parameter that is searched for by its logarithm.
    fn logarithm(value: f64, low: f64, high: f64) -> Self {
        Self::new(value.ln(), low.ln(), high.ln(), 1e-3)
    }
}

/// What an effect does. Parameters come in the order that is said; strengths are three, one a tent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// Input later by the parameter. Unit: s.
    Delay,
    /// Input through a first-order lag; parameter: logarithm of the time constant.
    Lag,
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
    /// On the output: a free curve over time.
    Wander,
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
    fn new(form: Form, parameters: impl IntoIterator<Item = Parameter>) -> Self {
        Self { form, parameters: parameters.into_iter().collect() }
    }

    /// A valve's lag no longer than any regulator's; None where the samples are too far apart for one.
    pub fn ordinary_lag(signals: &Signals) -> Option<Self> {
        let low_s = LEAST_LAG * signals.step_s;
        let lag = |lag_s| Self::new(Form::Lag, [Parameter::logarithm(lag_s, low_s, ORDINARY_LAG_S)]);
        (low_s < 0.5 * ORDINARY_LAG_S).then(|| lag(0.5 * ORDINARY_LAG_S))
    }

    /// The effects to try for a cause, from their several starts; none where the recording has not what it takes.
    pub fn starts(cause: Cause, signals: &Signals) -> Vec<Self> {
        let duration_s = signals.duration_s();
        let span = signals.input_span;
        let longest_s = duration_s / 3.0;
        // A strength that moves the input by a thousandth of its span at a typical value of what drives it.
        let strengths = |unit: f64, low: f64| {
            (0..TENTS).map(move |_| Parameter::new(0.0, low, f64::INFINITY, 1e-3 * span / unit.max(1e-9)))
        };
        let free = f64::NEG_INFINITY;
        match cause {
            Cause::TransportDelay => [0.015, 0.04, 0.1, 0.25, 0.6]
                .map(|delay_s| {
                    let delay = Parameter::new(delay_s, 0.0, longest_s.min(3.0), 0.1 * signals.step_s);
                    Self::new(Form::Delay, [delay])
                })
                .to_vec(),
            Cause::ValveLag => [0.03, 0.1, 0.4]
                .map(|lag_s| {
                    let low_s = LEAST_LAG * signals.step_s;
                    Self::new(Form::Lag, [Parameter::logarithm(lag_s, low_s, longest_s.clamp(low_s, 10.0))])
                })
                .to_vec(),
            Cause::Load | Cause::Temperature => {
                let (driver, column) = match cause {
                    Cause::Load => (Driver::Load, &signals.load),
                    _ => (Driver::Temperature, &signals.temperature),
                };
                let Some(column) = column else { return Vec::new() };
                let strengths = strengths(root_mean_square(column), free);
                vec![Self::new(Form::Driven(driver), strengths), Self::new(Form::Added(driver), [])]
            }
            Cause::WarmUp => {
                let way = signals.travel.last().copied().unwrap_or(0.0).max(1e-9);
                [0.03, 0.12]
                    .into_iter()
                    .flat_map(|share| {
                        let lambda = Parameter::logarithm(share * way, 0.01 * way, way / 3.0);
                        let strengths = std::iter::once(lambda).chain(strengths(1.0, free));
                        [
                            Self::new(Form::Driven(Driver::WarmUp), strengths),
                            Self::new(Form::Added(Driver::WarmUp), [lambda]),
                        ]
                    })
                    .collect()
            }
            Cause::ViscousLag => {
                let strengths = strengths(root_mean_square(&signals.rate), 0.0);
                vec![Self::new(Form::Driven(Driver::Rate), strengths), Self::new(Form::OutputLag, [])]
            }
            Cause::Inertia => {
                let masses = strengths(root_mean_square(&signals.acceleration), 0.0);
                let viscosities = strengths(root_mean_square(&signals.rate), 0.0);
                let both = masses.chain(viscosities);
                vec![Self::new(Form::Inertia, both), Self::new(Form::OutputInertia, [])]
            }
            Cause::RateDependentWidth => {
                // A width that grows nearly as the speed is viscosity.
                let power = Parameter::new(0.5, 0.2, 0.75, 1e-3);
                let gain = Parameter::new(0.0, 0.0, 10.0, 1e-2);
                let range = Parameter::logarithm(0.05 * span, 0.005 * span, 0.4 * span);
                let friction = [power, range].into_iter().chain(strengths(0.05 * span, 0.0));
                vec![
                    Self::new(Form::Thresholds(Rate::Input), [power, gain]),
                    Self::new(Form::Thresholds(Rate::Contraction), [power, gain]),
                    Self::new(Form::Friction(Rate::Contraction), friction),
                ]
            }
            Cause::Creep => {
                let weights = signals.creep_s.iter().map(|_| Parameter::new(0.0, 0.0, 0.9, 1e-3));
                vec![Self::new(Form::Creep, []), Self::new(Form::CreepOfInput, weights)]
            }
            Cause::Drift => vec![Self::new(Form::Drift, [])],
            // A tone's starts come from the residual's spectrum; the valve and the shape are examined elsewhere.
            Cause::PeriodicDisturbance
            | Cause::ValveDeadband
            | Cause::SupplySaturation
            | Cause::HysteresisShape => Vec::new(),
        }
    }

    /// A tone of this frequency. Unit: Hz.
    pub fn tone(frequency_hz: f64, signals: &Signals) -> Self {
        let width_hz = 1.0 / signals.duration_s();
        let low_hz = (frequency_hz - 2.0 * width_hz).max(LEAST_PERIODS * width_hz);
        let high_hz = frequency_hz + 2.0 * width_hz;
        Self::new(Form::Tone, [Parameter::new(frequency_hz, low_hz, high_hz, 1e-3 * width_hz)])
    }

    /// A delay of the input. Unit: s.
    pub fn delay(delay_s: f64) -> Self {
        Self::new(Form::Delay, [Parameter::new(delay_s, delay_s, delay_s, 1.0)])
    }

    /// By how much it makes the input late. Unit: s.
    pub fn late_s(&self) -> f64 {
        match (self.form, self.parameters.first()) {
            (Form::Delay, Some(delay)) => delay.value,
            (Form::Lag, Some(lag)) => lag.value.exp(),
            _ => 0.0,
        }
    }

    /// A step of the zero at this time. Unit: s.
    pub fn step(time_s: f64) -> Self {
        Self::new(Form::Step, [Parameter::new(time_s, time_s, time_s, 1.0)])
    }

    /// A free curve over time.
    pub fn wander() -> Self {
        Self::new(Form::Wander, [])
    }

    /// What belongs to the baseline: its envelope, a small delay, and a width that does not depend on the rate, its radius
    /// a share of the input's span.
    pub fn nuisances(signals: &Signals, radius: f64) -> [Self; 3] {
        let envelope = Self::new(Form::Envelope, [Parameter::new(0.5, 0.0, 1.2, 1e-3)]);
        [envelope, Self::small_delay(signals), Self::static_width(signals, radius)]
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
