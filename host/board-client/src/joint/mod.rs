//! A joint of two muscles, controlled on the host by the control code of [`model_core::joint`], in
//! single precision, in lock-step with a plant.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | [`start`] | fills the muscles, finds out whether the joint is the model's, and brings its friction to a known state |
//! | [`fault`] | why a joint is not started |
//! | [`log`] | the log of a run and its figures |
//!
//! # Limits
//! There is no firmware for two channels yet: this is the same control code without a board.

pub mod fault;
pub mod log;
pub mod start;

use std::f64::consts::PI;

use model_core::ParameterError;
use model_core::joint::{Joint, JointCommand, JointControl, JointControlParameters, JointState, JointTarget};
use model_core::pid::PidParameters;
use recording::joint::{HostJointParameters, STOPS};

use crate::pil::{PilError, SLEW_BAR_PER_S};
use crate::stop::Stop;

/// Integral gain times the slower regulator's lag: at a joint that is two and a half times as soft
/// as asked for, as one that slips is, the phase margin of the loop is still above 50 degrees.
/// Unit: 1.
const INTEGRAL: f64 = 0.4;
/// Proportional gain, as a share of the stiffness. Small, for the sake of the sensor's noise.
const PROPORTIONAL: f64 = 0.1;
/// Time constant of the anti-windup: several times the lag of a regulator, so that a short limit
/// does not empty the integral. Unit: s.
const TRACKING_S: f64 = 0.2;
/// Times from one end of the angles, and of the stiffness, to the other. Unit: s.
const TURN_S: f64 = 0.5;
const STIFFEN_S: f64 = 1.5;

/// The controller of a joint, as on a board.
type BoardControl = JointControl<f32, STOPS>;

/// What the sensors of a joint say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointMeasured {
    /// Unit: bar.
    pub pressures_bar: [f64; 2],
    /// Unit: degrees.
    pub angle_deg: f64,
}

/// A joint with its regulators.
pub trait JointPlant {
    /// Holds the commands (bar) until `time_s`, then measures. The first call finds it vented.
    ///
    /// # Errors
    /// It does not answer, or not sensibly.
    fn advance(&mut self, time_s: f64, commands_bar: [f32; 2]) -> Result<JointMeasured, PilError>;
}

/// What a joint is to do at a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointWanted {
    /// Unit: degrees.
    pub angle_deg: f64,
    /// Unit: N m/rad.
    pub stiffness: f64,
}

/// A tick of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointSample {
    /// From the first tick behind the start. Unit: s.
    pub time_s: f64,
    /// What was wanted.
    pub wanted: JointWanted,
    /// What was measured before the tick.
    pub measured: JointMeasured,
    /// What the controller made of it.
    pub command: JointCommand<f32>,
}

/// A joint in a loop with its controller.
pub struct Loop<'a, P> {
    control: BoardControl,
    /// The same without feedback.
    open: BoardControl,
    state: JointState<f32, STOPS>,
    plant: &'a mut P,
    period_s: f64,
    ticks: u64,
    measured: JointMeasured,
    stop: Stop,
}

/// The usual controller of a joint, at a period (s).
///
/// # Errors
/// The parameters are not valid in single precision.
pub fn parameters(
    joint: &HostJointParameters,
    period_s: f64,
) -> Result<JointControlParameters<f32, STOPS>, ParameterError> {
    let valid = Joint::try_new(joint)?;
    let (lowest, highest) = joint.angles;
    let (soft, stiff) = valid.stiffness_range(0.5 * (lowest + highest));
    let [a, b] = &joint.muscles;
    let lag_s = a.valve_lag_s.max(b.valve_lag_s);
    let pid = PidParameters {
        kp: PROPORTIONAL as f32,
        ki: (INTEGRAL / lag_s) as f32,
        kd: 0.0,
        derivative_filter_s: 0.02,
        tracking_time_s: TRACKING_S as f32,
    };
    Ok(JointControlParameters {
        joint: joint.convert()?,
        pid,
        turn_rad_per_s: ((highest - lowest) / TURN_S) as f32,
        stiffen_per_s: ((stiff - soft) / STIFFEN_S) as f32,
        slew_bar_per_s: SLEW_BAR_PER_S,
        period_s: period_s as f32,
    })
}

impl<'a, P: JointPlant> Loop<'a, P> {
    /// A vented joint.
    ///
    /// # Errors
    /// There is no controller of the parameters, or the plant does not answer.
    pub fn new(
        parameters: &JointControlParameters<f32, STOPS>,
        plant: &'a mut P,
        stop: Stop,
    ) -> Result<Self, PilError> {
        let none = PidParameters { kp: 0.0, ki: 0.0, kd: 0.0, ..parameters.pid };
        let open = JointControl::try_new(&JointControlParameters { pid: none, ..parameters.clone() })?;
        let control = JointControl::try_new(parameters)?;
        let (lowest, highest) = parameters.joint.angles;
        let measured = plant.advance(0.0, [0.0; 2])?;
        Ok(Self {
            state: control.rest_state(0.5 * (lowest + highest)),
            control,
            open,
            plant,
            period_s: f64::from(parameters.period_s),
            ticks: 0,
            measured,
            stop,
        })
    }

    /// A tick: what is measured now, and what the controller makes of it, held until the next.
    fn tick(&mut self, wanted: &JointWanted, has_feedback: bool) -> Result<JointSample, PilError> {
        if self.stop.is_requested() {
            return Err(PilError::Stopped);
        }
        let measured = self.measured;
        let target =
            JointTarget { angle: radians(wanted.angle_deg), stiffness: wanted.stiffness as f32, load: 0.0 };
        let control = if has_feedback { &self.control } else { &self.open };
        let angle = radians(measured.angle_deg);
        // What is wanted is finite, and so is what a plant answers.
        let command = control.step(&mut self.state, &target, angle).map_err(|_| PilError::OutOfTurn)?;
        self.ticks += 1;
        self.measured = self.plant.advance(self.ticks as f64 * self.period_s, command.commands)?;
        Ok(JointSample { time_s: 0.0, wanted: *wanted, measured, command })
    }

    /// Follows what is wanted, a tick each, behind the start ([`start`]). `look` sees the plant
    /// before each tick.
    ///
    /// # Errors
    /// The plant does not answer, or is stopped.
    pub fn follow(
        &mut self,
        wanted: impl Iterator<Item = JointWanted>,
        mut look: impl FnMut(&JointSample, &P),
    ) -> Result<Vec<JointSample>, PilError> {
        let mut samples = Vec::new();
        for (tick, wanted) in wanted.enumerate() {
            let before = self.tick(&wanted, true)?;
            let sample = JointSample { time_s: tick as f64 * self.period_s, ..before };
            look(&sample, self.plant);
            samples.push(sample);
        }
        Ok(samples)
    }
}

/// Degrees in radians, in single precision.
fn radians(degrees: f64) -> f32 {
    (degrees * PI / 180.0) as f32
}
