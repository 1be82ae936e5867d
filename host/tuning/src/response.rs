//! The loop in the frequency domain: what the muscle makes of a small command, what the inverse
//! model leads, and the feedback around both.
//!
//! At a place of the loop the muscle is a slope times a linear system: valve (of first or second order), dead time, creep,
//! viscosity and mass. The feedback does not go through the inverse, so its loop is the slope times
//! all of that, or with an observer, whose gains grow where the model is flatter, the ratio of the
//! muscle's slope to the model's. The feed-forward does: what the model has of the linear system is led, what it does
//! not have stays.

use std::f64::consts::{PI, SQRT_2};

use model_core::ParameterError;
use model_core::extension::profile::{Profile, ProfileParameters};
use model_core::extension::{ExtensionParameters, Site};
use num_complex::Complex;

use crate::rates;
use crate::slopes::Slope;

/// The PID, as the board has it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Feedback {
    /// Unit: input unit/output unit.
    pub kp: f64,
    /// Unit: input unit/(output unit s).
    pub ki: f64,
    /// Unit: input unit s/output unit.
    pub kd: f64,
    /// Time constant of the derivative's filter. Unit: s.
    pub filter_s: f64,
    /// What makes the gains grow.
    pub observer: Option<Growth>,
}

/// How gains grow where the model is flatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// The slope that they are for. Unit: output unit/input unit.
    pub slope: f64,
    /// How many times as large they may become.
    pub reach: f64,
}

impl Growth {
    /// How many times as large they are in one way in which the plant may be, whose model has the
    /// same memory.
    fn factor(growth: Option<Self>, corner: &Corner) -> f64 {
        growth.map_or(1.0, |Self { slope, reach }| (slope * corner.ratio / corner.slope).clamp(1.0, reach))
    }
}

impl Feedback {
    /// From the error to the command. `omega`: rad/s, above 0.
    pub fn response(&self, omega: f64) -> Complex<f64> {
        let s = Complex::new(0.0, omega);
        self.kp + self.ki / s + self.kd * s / (1.0 + self.filter_s * s)
    }
}

/// The linear part of muscle and valve, and what the inverse leads of it.
#[derive(Clone, Debug)]
pub struct Dynamics {
    /// Lag of the valve that the inverse leads. Unit: s.
    pub led_lag_s: f64,
    /// Lag of the valve beside that, which the inverse does not lead. Unit: s.
    pub behind_s: f64,
    /// How far ahead of the delay the reference is given for it. Unit: s.
    pub ahead_s: f64,
    /// Lag of the valve that it does not know of. Unit: s.
    pub unled_lag_s: f64,
    /// Dead time, ahead of which the reference is given. Unit: s.
    pub delay_s: f64,
    /// Elements of creep: share, and time constant (s).
    pub creep: Vec<(f64, f64)>,
    viscosity: Option<(Profile<f64>, Site)>,
    mass: Option<(Profile<f64>, Site)>,
    /// Filter of the rate that the width depends on; 0 where it does not. Unit: s.
    rate_filter_s: f64,
    /// From tick to tick. Unit: s.
    pub period_s: f64,
}

/// One way in which the plant may be.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    /// Where, and how steep.
    pub contraction: f64,
    /// The muscle's slope. Output unit/input unit.
    pub slope: f64,
    /// The muscle's slope over that of the inverse.
    pub ratio: f64,
    /// Dead time that nobody has seen. Unit: s.
    pub late_s: f64,
    /// The valve's lag over the known one, led or not.
    pub lag: f64,
    /// The valve's lag that nobody has seen, over the longest that is allowed for.
    pub unseen_lag: f64,
    /// The share q that makes the valve of second order ([`recording::valve_order`]).
    pub order: f64,
    /// The muscle's natural frequency over the known one.
    pub frequency: f64,
    /// Its viscosity over the known one.
    pub viscosity: f64,
    /// The share of the viscosity that is there at all.
    pub motion: f64,
    /// Its lag at a speed, where its width depends on the rate. Unit: s.
    pub sliding_s: f64,
}

/// Time constant of the smoother that goes before a mass (`model_core::extension`). Unit: s.
const SMOOTHED_S: f64 = 0.01;
const SMOOTHED_PERIODS: f64 = 2.0;

impl Dynamics {
    /// Those of a model's extensions, at a period (s).
    ///
    /// # Errors
    /// A profile that is none.
    pub fn of(extensions: &ExtensionParameters<f64>, period_s: f64) -> Result<Self, ParameterError> {
        let profile = |parameters: &Option<ProfileParameters<f64>>, site: Site, name: &'static str| {
            let made = parameters.as_ref().map(|parameters| Profile::try_new(parameters, name, ""));
            made.transpose().map(|profile| profile.map(|profile| (profile, site)))
        };
        let creep = extensions
            .creep
            .iter()
            .flat_map(|creep| creep.fractions.iter().copied().zip(creep.time_constants_s.iter().copied()));
        Ok(Self {
            led_lag_s: extensions.valve_lag.map_or(0.0, |lag| lag.time_constant_s),
            behind_s: 0.0,
            ahead_s: 0.0,
            unled_lag_s: 0.0,
            delay_s: extensions.transport_delay.map_or(0.0, |delay| delay.delay_s),
            creep: creep.collect(),
            viscosity: profile(&extensions.viscous_lag, extensions.sites.viscous_lag, "viscous_lag")?,
            mass: profile(&extensions.inertia, extensions.sites.inertia, "inertia")?,
            rate_filter_s: rates::filter_s(extensions).unwrap_or(0.0),
            period_s,
        })
    }

    /// Whether the contraction can swing.
    pub fn has_mass(&self) -> bool {
        self.mass.is_some()
    }

    /// The lag of the valve that is known. Unit: s.
    pub fn known_lag_s(&self) -> f64 {
        self.led_lag_s + self.behind_s
    }

    fn smoothed_s(&self) -> f64 {
        SMOOTHED_S.max(SMOOTHED_PERIODS * self.period_s)
    }

    /// How far ahead the reference is given. Unit: s.
    fn preview_s(&self) -> f64 {
        self.delay_s + self.ahead_s + if self.has_mass() { SQRT_2 * self.smoothed_s() } else { 0.0 }
    }

    /// Coefficients of s and s² that the balance of forces has at a slope. Unit: s, s².
    fn motion(&self, contraction: f64, slope: f64) -> (f64, f64) {
        let at = |effect: &Option<(Profile<f64>, Site)>| match effect {
            Some((profile, Site::Pressure)) => slope * profile.value(contraction),
            Some((profile, Site::Contraction)) => profile.value(contraction),
            None => 0.0,
        };
        (at(&self.viscosity), at(&self.mass))
    }

    /// What creep leaves of a move.
    fn crept(&self, s: Complex<f64>) -> Complex<f64> {
        let late = self.creep.iter().map(|(share, time_s)| share * time_s * s / (1.0 + time_s * s));
        1.0 - late.sum::<Complex<f64>>()
    }

    /// The pressure that a move needs where the width depends on the rate, over that without.
    fn slid(&self, corner: &Corner, s: Complex<f64>) -> Complex<f64> {
        1.0 + corner.sliding_s * s / (1.0 + self.rate_filter_s * s)
    }

    /// From a command to the contraction. Unit: output unit/input unit; `omega`: rad/s.
    pub fn plant(&self, corner: &Corner, omega: f64) -> Complex<f64> {
        let s = Complex::new(0.0, omega);
        let (viscous, mass) = self.motion(corner.contraction, corner.slope);
        let faster = corner.frequency;
        let motion = viscous * corner.viscosity / faster * s + mass / (faster * faster) * s * s;
        let motion = 1.0 + corner.motion * motion;
        // A command is held until the next one.
        let late_s = self.delay_s + corner.late_s + 0.5 * self.period_s;
        let lag = |lag_s: f64| 1.0 + s * lag_s + corner.order * lag_s * lag_s * s * s;
        let lags = lag(self.known_lag_s() * corner.lag) * lag(self.unled_lag_s * corner.unseen_lag);
        corner.slope * (-s * late_s).exp() * self.crept(s) / (lags * motion * self.slid(corner, s))
    }

    /// From the reference to the feed-forward, which is what the inverse leads, and what is
    /// smoothed before it; relative to the reference when it is due. Unit: input unit/output
    /// unit.
    fn forward(&self, corner: &Corner, omega: f64) -> Complex<f64> {
        let s = Complex::new(0.0, omega);
        let slope = corner.slope / corner.ratio;
        let (viscous, mass) = self.motion(corner.contraction, slope);
        let smoothed_s = if self.has_mass() { self.smoothed_s() } else { 0.0 };
        let smoother = 1.0 + SQRT_2 * smoothed_s * s + smoothed_s * smoothed_s * s * s;
        let ahead = (s * self.preview_s()).exp();
        ahead * (1.0 + s * self.led_lag_s) * (1.0 + viscous * s + mass * s * s) * self.slid(corner, s)
            / (smoother * slope * self.crept(s))
    }

    /// From the reference to the contraction, relative to the reference when it is due.
    pub fn tracking(&self, corner: &Corner, feedback: &Feedback, omega: f64) -> Complex<f64> {
        let plant = self.plant(corner, omega);
        let open = plant * Growth::factor(feedback.observer, corner) * feedback.response(omega);
        (plant * self.forward(corner, omega) + open) / (1.0 + open)
    }
}

/// The plant at all frequencies in all ways in which it may be, as the PID with its gains for the
/// steepest slope finds it.
#[derive(Clone, Debug)]
pub struct Plants {
    /// Unit: rad/s.
    pub omegas: Vec<f64>,
    /// A row for each corner, a value for each frequency, the observer's factor in it. Unit: output
    /// unit/input unit.
    pub responses: Vec<Vec<Complex<f64>>>,
    /// What that is, for each corner.
    pub factors: Vec<f64>,
    /// The slope of each corner times it. Unit: output unit/input unit.
    pub slopes: Vec<f64>,
}

/// How many frequencies are looked at: 28 in a decade, so that between two of them the open loop of
/// a mass of damping ratio 0.1 turns by less than a quarter.
const FREQUENCIES: usize = 144;
/// The lowest of them. Unit: rad/s; a period of five minutes.
const LOWEST: f64 = 0.02;

/// The frequencies at which loops are looked at, up to half the rate of ticks. Unit: rad/s.
pub fn frequencies(period_s: f64) -> Vec<f64> {
    let highest = PI / period_s;
    let ratio = (highest / LOWEST).powf(1.0 / (FREQUENCIES - 1) as f64);
    (0..FREQUENCIES).map(|k| LOWEST * ratio.powi(k as i32)).collect()
}

impl Plants {
    /// Of all corners.
    pub fn of(dynamics: &Dynamics, corners: &[Corner], growth: Option<Growth>) -> Self {
        let omegas = frequencies(dynamics.period_s);
        let factors: Vec<f64> = corners.iter().map(|corner| Growth::factor(growth, corner)).collect();
        let row = |(corner, factor): (&Corner, &f64)| {
            omegas.iter().map(|&omega| dynamics.plant(corner, omega) * factor).collect()
        };
        Self {
            responses: corners.iter().zip(&factors).map(row).collect(),
            slopes: corners.iter().zip(&factors).map(|(corner, factor)| corner.slope * factor).collect(),
            factors,
            omegas,
        }
    }
}

/// What is not known of a plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unknown {
    /// How many times steeper or flatter than the model the muscle may be.
    pub slope: f64,
    /// Dead time that may be there. Unit: s.
    pub late_s: f64,
    /// The least share of the viscosity that may be there, and the dead time (s) that then is
    /// in the place of the rest.
    pub split: (f64, f64),
    /// The least and the largest share q of a valve of second order.
    pub orders: (f64, f64),
    /// By which share the valve's lag may be longer or shorter.
    pub lag: f64,
    /// By which share the natural frequency may be higher or lower.
    pub frequency: f64,
    /// By which share the viscosity may be less beside a mass, or more without one.
    pub viscosity: f64,
}

impl Unknown {
    /// All is known.
    pub const NOTHING: Self = Self {
        slope: 1.0,
        late_s: 0.0,
        split: (1.0, 0.0),
        orders: (0.0, 0.0),
        lag: 0.0,
        frequency: 0.0,
        viscosity: 0.0,
    };
}

/// All ways in which a plant with these slopes and dynamics may be.
pub fn corners(slopes: &[Slope], unknown: &Unknown, dynamics: &Dynamics) -> Vec<Corner> {
    let has_mass = dynamics.has_mass();
    let both = |share: f64, is_needed: bool| {
        if is_needed && share > 0.0 { vec![1.0 - share, 1.0 + share] } else { vec![1.0] }
    };
    // A valve that nobody has seen may be as quick as it likes.
    let unseen_lags = if dynamics.unled_lag_s > 0.0 { vec![0.0, 1.0] } else { vec![1.0] };
    let lates = if unknown.late_s > 0.0 { vec![0.0, unknown.late_s] } else { vec![0.0] };
    let (least, most) = unknown.orders;
    let known_lag_s = dynamics.known_lag_s();
    let has_lag = known_lag_s + dynamics.unled_lag_s > 0.0;
    // Small moves may be no later than the model's lag: what is beside it may belong to large ones.
    let quickest = if known_lag_s > 0.0 { dynamics.led_lag_s / known_lag_s } else { 1.0 };
    let lags = if known_lag_s > 0.0 && unknown.lag > 0.0 {
        vec![quickest * (1.0 - unknown.lag), 1.0 + unknown.lag]
    } else {
        vec![1.0]
    };
    let orders = if has_lag && most > least { vec![least, most] } else { vec![least] };
    let factor = unknown.slope;
    // Beside a mass the loop swings more with less viscosity; without one it is later with more.
    let viscosity = if has_mass { 1.0 - unknown.viscosity } else { 1.0 + unknown.viscosity };
    let mut lates: Vec<(f64, f64)> = lates.into_iter().map(|late_s| (late_s, 1.0)).collect();
    // What is less of the one is more of the other.
    let (share, split_s) = unknown.split;
    if share < 1.0 {
        lates.push((unknown.late_s + split_s, share));
    }
    let mut all = Vec::new();
    for at in slopes {
        let (driven, turned) = (at.driven, at.turned);
        // What has turned round does not slide; what is driven on may do so at any speed.
        let mut speeds = vec![0.0];
        speeds.extend(at.sliding_s.into_iter().filter(|late_s| *late_s > 0.0));
        let mut ways = vec![(turned, 1.0, 0.0)];
        if factor > 1.0 {
            ways.push((turned / factor, 1.0 / factor, 0.0));
        }
        for sliding_s in speeds {
            ways.push((driven, 1.0, sliding_s));
            if factor > 1.0 {
                ways.push((driven * factor, factor, sliding_s));
            }
        }
        for (slope, ratio, sliding_s) in ways {
            for &(late_s, motion) in &lates {
                for &lag in &lags {
                    for &unseen_lag in &unseen_lags {
                        for &order in &orders {
                            for frequency in both(unknown.frequency, has_mass) {
                                all.push(Corner {
                                    contraction: at.contraction,
                                    slope,
                                    ratio,
                                    late_s,
                                    lag,
                                    unseen_lag,
                                    order,
                                    frequency,
                                    viscosity,
                                    motion,
                                    sliding_s,
                                });
                            }
                        }
                    }
                }
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use model_core::extension::{TransportDelayParameters, ValveLagParameters};

    use super::*;

    #[test]
    fn a_muscle_that_is_as_its_model_says_follows_its_reference_without_feedback() {
        let extensions = ExtensionParameters {
            valve_lag: Some(ValveLagParameters::new(0.05)),
            transport_delay: Some(TransportDelayParameters { delay_s: 0.02 }),
            ..ExtensionParameters::default()
        };
        let dynamics = Dynamics::of(&extensions, 1e-3).expect("valid");
        let slope = Slope { contraction: 50.0, turned: 10.0, driven: 30.0, sliding_s: [0.0; 3] };
        for corner in corners(&[slope], &Unknown::NOTHING, &dynamics) {
            let follows = dynamics.tracking(&corner, &Feedback::default(), 20.0);
            // But for half a tick.
            assert!((follows - 1.0).norm() < 20.0 * 0.6e-3, "{follows}");
        }
        let wide = Unknown { slope: 2.0, ..Unknown::NOTHING };
        let steep = corners(&[slope], &wide, &dynamics)[3];
        assert_eq!((steep.slope, steep.ratio), (60.0, 2.0));
        let follows = dynamics.tracking(&steep, &Feedback::default(), 20.0);
        assert!((follows.norm() - 2.0).abs() < 0.01, "{follows}");
    }

    #[test]
    fn what_a_width_by_the_rate_makes_later_is_led_by_the_inverse_and_is_in_the_loop_of_what_slides() {
        let mut dynamics = Dynamics::of(&ExtensionParameters::default(), 1e-3).expect("valid");
        dynamics.rate_filter_s = 0.01;
        let slope = Slope { contraction: 50.0, turned: 10.0, driven: 30.0, sliding_s: [0.1, 0.2, 0.4] };
        let corners = corners(&[slope], &Unknown::NOTHING, &dynamics);
        let late = |corner: &&Corner| corner.sliding_s > 0.0;
        assert_eq!(corners.iter().filter(late).count(), 3);
        for corner in corners.iter().filter(late) {
            assert_eq!(corner.slope, 30.0);
            let follows = dynamics.tracking(corner, &Feedback::default(), 20.0);
            assert!((follows - 1.0).norm() < 20.0 * 0.6e-3, "{follows}");
            // 1 + c s/(1 + f s), by which a command's answer is less.
            let s = Complex::new(0.0, 20.0);
            let less = 30.0 / (1.0 + corner.sliding_s * s / (1.0 + 0.01 * s));
            assert!((dynamics.plant(corner, 20.0).norm() - less.norm()).abs() < 1e-9);
        }
    }

    #[test]
    fn a_valve_that_is_later_than_what_is_led_may_be_as_quick_as_that() {
        let extensions = ExtensionParameters {
            valve_lag: Some(ValveLagParameters::new(0.03)),
            ..ExtensionParameters::default()
        };
        let mut dynamics = Dynamics::of(&extensions, 1e-3).expect("valid");
        dynamics.behind_s = 0.03;
        let slope = Slope { contraction: 50.0, turned: 10.0, driven: 30.0, sliding_s: [0.0; 3] };
        let unknown = Unknown { lag: 0.1, ..Unknown::NOTHING };
        let lags_s = corners(&[slope], &unknown, &dynamics)
            .iter()
            .map(|corner| corner.lag * dynamics.known_lag_s())
            .fold((f64::INFINITY, 0.0_f64), |(least, most), lag_s| (least.min(lag_s), most.max(lag_s)));
        assert!((lags_s.0 - 0.027).abs() < 1e-9 && (lags_s.1 - 0.066).abs() < 1e-9, "{lags_s:?}");
    }
}
