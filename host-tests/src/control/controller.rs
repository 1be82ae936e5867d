//! The controllers that are compared.

use anyhow::{Context, Result};
use board_client::pil::slew;
use model_core::pid::PidParameters;
use model_core::{Mode, ObserverParameters, TrackingParameters};
use recording::model_file::ModelFile;
use recording::model_file::control::Tuning;
use wire::BoardParameters;

use crate::PERIOD_S;

/// The feedback that is tuned for a model, in both forms.
#[derive(Clone, Debug)]
pub struct Tunings {
    /// With the same gains everywhere.
    pub alone: Tuning,
    /// With the disturbance observer.
    pub observed: Tuning,
}

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
    /// What `mgpi` does without a tuning: the inverse, and 0.05 bar/mm and 0.1 bar/(mm s) for every
    /// muscle.
    Fixed,
    /// The inverse, and the gains and leads of `mgpi tune`.
    Tuned,
    /// The inverse, and the gains, leads and observer of `mgpi tune --observer`.
    Observed,
}

impl Controller {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::PaperPid, Self::RulePid, Self::Inverse, Self::Paper, Self::Fixed, Self::Tuned, Self::Observed];

    /// Its name in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::PaperPid => "paper's PID alone",
            Self::RulePid => "PI by SIMC alone",
            Self::Inverse => "inverse alone",
            Self::Paper => "inverse, paper's PID",
            Self::Fixed => "inverse, fixed gains",
            Self::Tuned => "inverse, tuned",
            Self::Observed => "inverse, observer",
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

    /// What it goes by of a model's tunings.
    pub fn tuning(self, tunings: &Tunings) -> &Tuning {
        if self == Self::Observed { &tunings.observed } else { &tunings.alone }
    }

    /// A board's parameters for a model.
    ///
    /// # Errors
    /// The model does not fit the board.
    pub fn parameters(self, model: &ModelFile, tunings: &Tunings) -> Result<BoardParameters> {
        let tuning = self.tuning(tunings);
        let (low, high) = model.parameters.input();
        let paper = PidParameters::<f32>::paper();
        let pid = match self {
            Self::PaperPid | Self::Paper | Self::Inverse => paper,
            Self::Fixed => PidParameters { ki: 0.1, ..paper },
            Self::RulePid => rule(model),
            Self::Tuned | Self::Observed => tuning.pid(),
        };
        let is_tuned = matches!(self, Self::Tuned | Self::Observed);
        let extensions = if is_tuned { tuning.extended(&model.extensions) } else { model.extensions.clone() };
        let tuned_slew = tuning.slew_per_s.filter(|_| is_tuned);
        Ok(TrackingParameters {
            model: model.parameters.convert().context("the model does not fit the board")?,
            extensions: extensions.convert().context("the extensions do not fit the board")?,
            pid,
            observer: if is_tuned { tuning.observer() } else { ObserverParameters::default() },
            command_min: low.max(0.0) as f32,
            command_max: high as f32,
            slew_bar_per_s: slew(tuned_slew),
            period_s: PERIOD_S as f32,
        })
    }
}

/// Skogestad's rule for a first-order lag with a dead time: Kc = τ/(2 K θ), Ti = min(τ, 8 θ).
fn rule(model: &ModelFile) -> PidParameters<f32> {
    let (low, high) = model.parameters.input();
    let slope = model.stroke() / (high - low);
    let seen = model.recorded.and_then(|recorded| recorded.valve).map(|valve| valve.late.mean_s.max(0.0));
    let lag_s = model.extensions.valve_lag.map(|lag| lag.time_constant_s).or(seen).unwrap_or(0.05).max(0.01);
    let late_s = model.extensions.transport_delay.map_or(0.0, |delay| delay.delay_s) + 0.01;
    let kp = lag_s / (2.0 * slope * late_s);
    PidParameters { kp: kp as f32, ki: (kp / lag_s.min(8.0 * late_s)) as f32, ..PidParameters::paper() }
}
