//! The controllers that are compared.

use anyhow::{Context, Result};
use model_core::pid::PidParameters;
use model_core::{Mode, ObserverParameters, TrackingParameters};
use recording::model_file::ModelFile;
use recording::model_file::control::Tuning;
use wire::BoardParameters;

use crate::PERIOD_S;

/// A way to control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Controller {
    /// The paper's PID without its inverse.
    PaperPid,
    /// A PI by Skogestad's rule (SIMC) for the mean slope, without an inverse.
    RulePid,
    /// The inverse alone.
    Inverse,
    /// The paper's: inverse and PID.
    Paper,
    /// What `mgpi` did before it tuned: the inverse, and 0.05 bar/mm and 0.1 bar/(mm s) for every
    /// muscle.
    Fixed,
    /// Tuned gains, without an observer.
    Gains,
    /// Tuned gains and the observer.
    Observer,
}

impl Controller {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::PaperPid, Self::RulePid, Self::Inverse, Self::Paper, Self::Fixed, Self::Gains, Self::Observer];

    /// Its name in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::PaperPid => "paper's PID alone",
            Self::RulePid => "PI by SIMC alone",
            Self::Inverse => "inverse alone",
            Self::Paper => "inverse, paper's PID",
            Self::Fixed => "inverse, fixed gains",
            Self::Gains => "inverse, tuned gains",
            Self::Observer => "inverse, observer",
        }
    }

    /// What acts.
    pub fn mode(self) -> Mode {
        match self {
            Self::PaperPid | Self::RulePid => Mode::FeedbackOnly,
            Self::Inverse => Mode::FeedforwardOnly,
            _ => Mode::Both,
        }
    }

    /// A board's parameters for a model.
    ///
    /// # Errors
    /// The model does not fit the board.
    pub fn parameters(self, model: &ModelFile, tuning: &Tuning) -> Result<BoardParameters> {
        let (low, high) = model.parameters.input();
        let paper = PidParameters::<f32>::paper();
        let (pid, rate) = match self {
            Self::PaperPid | Self::Paper | Self::Inverse => (paper, 0.0),
            Self::Fixed => (PidParameters { ki: 0.1, ..paper }, 0.0),
            Self::RulePid => (rule(model), 0.0),
            Self::Gains => (tuned(tuning), 0.0),
            Self::Observer => (tuned(tuning), tuning.observer_rate_per_s),
        };
        let is_tuned = matches!(self, Self::Gains | Self::Observer);
        let extensions = if is_tuned { tuning.extended(&model.extensions) } else { model.extensions.clone() };
        Ok(TrackingParameters {
            model: model.parameters.convert().context("the model does not fit the board")?,
            extensions: extensions.convert().context("the extensions do not fit the board")?,
            pid,
            observer: ObserverParameters { rate_per_s: rate as f32 },
            command_min: low.max(0.0) as f32,
            command_max: high as f32,
            slew_bar_per_s: if is_tuned { tuning.slew_per_s as f32 } else { 50.0 },
            period_s: PERIOD_S as f32,
        })
    }
}

fn tuned(tuning: &Tuning) -> PidParameters<f32> {
    PidParameters {
        kp: tuning.kp as f32,
        ki: tuning.ki as f32,
        kd: tuning.kd as f32,
        derivative_filter_s: tuning.derivative_filter_s as f32,
        tracking_time_s: tuning.tracking_time_s as f32,
    }
}

/// Skogestad's rule for a first-order lag with a dead time: Kc = τ/(2 K θ), Ti = min(τ, 8 θ).
fn rule(model: &ModelFile) -> PidParameters<f32> {
    let (low, high) = model.parameters.input();
    let slope = model.stroke() / (high - low);
    let seen = model.recorded.and_then(|recorded| recorded.valve).map(|late| late.mean_s.max(0.0));
    let lag_s = model.extensions.valve_lag.map(|lag| lag.time_constant_s).or(seen).unwrap_or(0.05).max(0.01);
    let late_s = model.extensions.transport_delay.map_or(0.0, |delay| delay.delay_s) + 0.01;
    let kp = lag_s / (2.0 * slope * late_s);
    PidParameters { kp: kp as f32, ki: (kp / lag_s.min(8.0 * late_s)) as f32, ..PidParameters::paper() }
}
