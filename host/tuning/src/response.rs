//! The loop in the frequency domain: what the muscle makes of a small command, what the inverse
//! model leads, and both with the feedback around them.
//!
//! At a place of the loop the muscle is a slope times a linear system: valve, delay, viscosity and
//! mass. The controller's inverse has the reciprocal of the model's slope, and leads what of the
//! linear system the model has; what it does not have stays. So with the disturbance observer,
//! which works through the inverse, the loop is the ratio of the two slopes times what is not led,
//! and with a PID, which does not, the slope itself times all of it.

use std::f64::consts::SQRT_2;

use model_core::ParameterError;
use model_core::extension::profile::{Profile, ProfileParameters};
use model_core::extension::{ExtensionParameters, Site};
use model_core::observer::FILTER;
use num_complex::Complex;

use crate::slopes::Slope;

/// What acts back.
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
    /// Rate of the observer. Unit: 1/s.
    pub rate_per_s: f64,
}

/// The linear part of muscle and valve, and what the inverse leads of it.
#[derive(Clone, Debug)]
pub struct Dynamics {
    /// Lag of the valve that the inverse leads. Unit: s.
    pub led_lag_s: f64,
    /// Lag of the valve that it does not know of. Unit: s.
    pub unled_lag_s: f64,
    /// Dead time, which nothing can lead in a loop. Unit: s.
    pub delay_s: f64,
    viscosity: Option<(Profile<f64>, Site)>,
    mass: Option<(Profile<f64>, Site)>,
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
    /// Dead time that nobody has seen; below 0 where what was taken for one is a swing. Unit: s.
    pub late_s: f64,
    /// Lateness of a mass that nobody has seen. Unit: s.
    pub swing_s: f64,
    /// The valve's lag over the known one.
    pub lag: f64,
    /// The muscle's natural frequency over the known one.
    pub frequency: f64,
}

/// Damping ratio of a mass that nobody has seen: a lateness of θ is then a natural frequency of
/// 2 ζ/θ. Braided muscles are reported from 0.2 on.
const UNSEEN_DAMPING: f64 = 0.2;
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
        Ok(Self {
            led_lag_s: extensions.valve_lag.map_or(0.0, |lag| lag.time_constant_s),
            unled_lag_s: 0.0,
            delay_s: extensions.transport_delay.map_or(0.0, |delay| delay.delay_s),
            viscosity: profile(&extensions.viscous_lag, extensions.sites.viscous_lag, "viscous_lag")?,
            mass: profile(&extensions.inertia, extensions.sites.inertia, "inertia")?,
            period_s,
        })
    }

    /// Whether the contraction can swing.
    pub fn has_mass(&self) -> bool {
        self.mass.is_some()
    }

    fn smoothed_s(&self) -> f64 {
        SMOOTHED_S.max(SMOOTHED_PERIODS * self.period_s)
    }

    /// How far ahead the reference is given. Unit: s.
    fn preview_s(&self) -> f64 {
        self.delay_s + if self.has_mass() { SQRT_2 * self.smoothed_s() } else { 0.0 }
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

    /// From a command to the contraction, over the slope. `omega`: rad/s.
    fn plant(&self, corner: &Corner, omega: f64) -> Complex<f64> {
        let s = Complex::new(0.0, omega);
        let (viscous, mass) = self.motion(corner.contraction, corner.slope);
        let slower = corner.frequency;
        let motion = 1.0 + viscous / slower * s + mass / (slower * slower) * s * s;
        // A command is held until the next one.
        let late_s = self.delay_s + corner.late_s + 0.5 * self.period_s;
        let whole = corner.swing_s / (2.0 * UNSEEN_DAMPING);
        let swing = 1.0 + corner.swing_s * s + whole * whole * s * s;
        (-s * late_s).exp()
            / (swing
                * (1.0 + s * self.led_lag_s * corner.lag)
                * (1.0 + s * self.unled_lag_s * corner.lag)
                * motion)
    }

    /// What the inverse leads, and what it smooths before.
    fn lead(&self, corner: &Corner, omega: f64) -> Complex<f64> {
        let s = Complex::new(0.0, omega);
        let (viscous, mass) = self.motion(corner.contraction, corner.slope / corner.ratio);
        let smoothed_s = if self.has_mass() { self.smoothed_s() } else { 0.0 };
        let smoother = 1.0 + SQRT_2 * smoothed_s * s + smoothed_s * smoothed_s * s * s;
        (1.0 + s * self.led_lag_s) * (1.0 + viscous * s + mass * s * s) / smoother
    }

    /// The PID, from the error to the command.
    fn pid(feedback: &Feedback, omega: f64) -> Complex<f64> {
        let s = Complex::new(0.0, omega);
        feedback.kp + feedback.ki / s + feedback.kd * s / (1.0 + feedback.filter_s * s)
    }

    /// From the error to the command, the controller alone.
    pub fn controller(&self, corner: &Corner, feedback: &Feedback, omega: f64) -> Complex<f64> {
        let s = Complex::new(0.0, omega);
        // The estimate of a tick goes into the next one.
        let rate = feedback.rate_per_s;
        // Without an observer there is nothing to filter.
        let observer = match rate > 0.0 {
            true => rate / s * (-s * self.period_s).exp() / (1.0 + s * FILTER / rate),
            false => Complex::new(0.0, 0.0),
        };
        let slope = corner.slope / corner.ratio;
        observer * self.lead(corner, omega) / slope + Self::pid(feedback, omega)
    }

    /// The open loop.
    pub fn open_loop(&self, corner: &Corner, feedback: &Feedback, omega: f64) -> Complex<f64> {
        corner.slope * self.plant(corner, omega) * self.controller(corner, feedback, omega)
    }

    /// From the reference to the contraction, relative to the reference when it is due.
    pub fn tracking(&self, corner: &Corner, feedback: &Feedback, omega: f64) -> Complex<f64> {
        let ahead = Complex::new(0.0, omega * self.preview_s()).exp();
        let forward = corner.ratio * self.plant(corner, omega) * self.lead(corner, omega) * ahead;
        let open = self.open_loop(corner, feedback, omega);
        (forward + open) / (1.0 + open)
    }
}

/// What is not known of a plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unknown {
    /// How many times steeper or flatter than the model the muscle may be.
    pub slope: f64,
    /// Dead time that may be there. Unit: s.
    pub late_s: f64,
    /// The muscle's part of the lateness, known and unknown, that may be a mass. Unit: s.
    pub swing_s: f64,
    /// What of the known dead time is then none. Unit: s.
    pub in_place_of_s: f64,
    /// By which share the valve's lag may be longer or shorter.
    pub lag: f64,
    /// By which share the natural frequency may be higher or lower.
    pub frequency: f64,
}

/// All ways in which a plant with these slopes may be.
pub fn corners(slopes: &[Slope], unknown: &Unknown, has_mass: bool) -> Vec<Corner> {
    let both = |share: f64, is_needed: bool| {
        if is_needed && share > 0.0 { vec![1.0 - share, 1.0 + share] } else { vec![1.0] }
    };
    let Unknown { late_s, swing_s, in_place_of_s, .. } = *unknown;
    let mut lates = vec![(0.0, 0.0)];
    if late_s > 0.0 {
        lates.push((late_s, 0.0));
    }
    if swing_s > 0.0 {
        lates.push((-in_place_of_s, swing_s));
    }
    let mut all = Vec::new();
    for at in slopes {
        for (slope, ratio) in [
            (at.driven, 1.0),
            (at.turned, 1.0),
            (at.driven * unknown.slope.sqrt(), unknown.slope),
            (at.turned / unknown.slope.sqrt(), 1.0 / unknown.slope),
        ] {
            for &(late_s, swing_s) in &lates {
                for lag in both(unknown.lag, true) {
                    for frequency in both(unknown.frequency, has_mass) {
                        all.push(Corner {
                            contraction: at.contraction,
                            slope,
                            ratio,
                            late_s,
                            swing_s,
                            lag,
                            frequency,
                        });
                    }
                }
            }
        }
    }
    all
}
