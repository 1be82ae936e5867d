//! A joint of two muscles: the firmware of two channels, in lock-step with a plant, or a board at a
//! serial port.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | this one | the loop in lock-step |
//! | [`start`] | starts a joint, which its board tries before it controls it, and goes to where it shall begin |
//! | [`link`] | a board at a serial port: requests and answers, lost ones and damaged ones |
//! | `run` | what a run over that link begins and ends with |
//! | [`settings`] | the file of limits and lines of the sensors that a board is given |
//! | [`deploy`](mod@deploy) | gives such a board what it keeps |
//! | [`restore`](mod@restore) | reads back what such a board has been told, and brings it back |
//! | [`status`] | what such a board says of itself |
//! | [`track`](mod@track) | such a board follows a reference |
//! | [`record`](mod@record) | such a board records a joint, without a model |
//! | [`excitation`] | what is played for that |
//! | [`seam`] | where a recording that was interrupted goes on |
//! | [`log`] | the log of a run and its figures |
//!
//! # Timing
//! At the time of a tick the plant, which has held the commands of the tick before until then, is
//! measured; the measurement goes to the board as ADC codes, with what is wanted in this tick, and
//! its DAC codes are the next commands.

pub mod deploy;
pub mod error;
pub mod excitation;
pub mod link;
pub mod log;
pub mod record;
pub mod restore;
pub mod run;
pub mod seam;
pub mod settings;
pub mod start;
pub mod status;
pub mod track;

use model_core::ParameterError;
use model_core::joint::{Joint, JointTarget};
use model_core::pid::PidParameters;
use recording::joint::HostJointParameters;
use wire::Scaling;
use wire::joint::{
    BoardJointParameters, JOINT_VERSION, JointConfiguration, JointHello, JointRequest, JointResponse,
    JointSettings, JointTickReply, JointTickRequest,
};

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

/// A board that answers requests: the emulated one, or the control code on the host.
pub trait JointBoard {
    /// Sends a request and waits for the response.
    ///
    /// # Errors
    /// No response comes.
    fn request(&mut self, request: &JointRequest) -> Result<JointResponse, PilError>;
}

#[cfg(unix)]
impl JointBoard for crate::emulator::Emulator {
    fn request(&mut self, request: &JointRequest) -> Result<JointResponse, PilError> {
        Ok(self.request_joint(request)?)
    }
}

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
    /// Torque that is known to act on it from outside, towards larger angles. Unit: N m.
    pub torque_nm: f64,
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
    /// What the board's DACs have put out. Unit: bar.
    pub commands_bar: [f32; 2],
    /// What the board made of it.
    pub reply: JointTickReply,
}

/// A joint in a loop with its board.
pub struct Loop<'a, B, P> {
    board: &'a mut B,
    plant: &'a mut P,
    hello: JointHello,
    period_s: f64,
    ticks: u64,
    measured: JointMeasured,
    /// The angle that was due at the last tick. Unit: degrees.
    due_deg: f64,
    stop: Stop,
}

/// The usual controller of a joint, at a period (s).
///
/// # Errors
/// The parameters are not valid in single precision.
pub fn parameters(
    joint: &HostJointParameters,
    period_s: f64,
) -> Result<BoardJointParameters, ParameterError> {
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
    Ok(BoardJointParameters {
        joint: joint.convert()?,
        pid,
        turn_rad_per_s: ((highest - lowest) / TURN_S) as f32,
        stiffen_per_s: ((stiff - soft) / STIFFEN_S) as f32,
        slew_bar_per_s: SLEW_BAR_PER_S,
        period_s: period_s as f32,
    })
}

impl<'a, B: JointBoard, P: JointPlant> Loop<'a, B, P> {
    /// A vented joint, its board configured, with other limits and lines of its sensors than it
    /// has, if there are `settings`.
    ///
    /// # Errors
    /// The board does not take the parameters or the settings, or the plant does not answer.
    pub fn new(
        (parameters, settings): (&BoardJointParameters, Option<&JointSettings>),
        board: &'a mut B,
        plant: &'a mut P,
        stop: Stop,
    ) -> Result<Self, PilError> {
        if let Some(settings) = settings {
            match board.request(&JointRequest::Settings(Some(*settings)))? {
                JointResponse::Settings(_) => {}
                JointResponse::Refused(refusal) => return Err(PilError::Refused(refusal)),
                _ => return Err(PilError::OutOfTurn),
            }
        }
        // Behind the settings: it tells how codes are to be read.
        let hello = match board.request(&JointRequest::Identify)? {
            JointResponse::Hello(hello) if hello.version == JOINT_VERSION => hello,
            JointResponse::Hello(hello) => {
                return Err(PilError::Version { board: hello.version, program: JOINT_VERSION });
            }
            _ => return Err(PilError::OutOfTurn),
        };
        let configuration = JointConfiguration { version: JOINT_VERSION, control: parameters.clone() };
        demand(board, &JointRequest::Configure(configuration))?;
        let measured = plant.advance(0.0, [0.0; 2])?;
        let period_s = f64::from(parameters.period_s);
        Ok(Self { board, plant, hello, period_s, ticks: 0, measured, due_deg: 0.0, stop })
    }

    /// A tick: what is measured now, and what the board makes of it, held until the next.
    fn tick(&mut self, wanted: &JointWanted) -> Result<JointSample, PilError> {
        if self.stop.is_requested() {
            return Err(PilError::Stopped);
        }
        let measured = self.measured;
        let time_s = self.ticks as f64 * self.period_s;
        let code = |scaling: &Scaling, quantity, value: f64, (per_unit, unit): (f64, _)| {
            let [min, max] = [scaling.code_min, scaling.code_max]
                .map(|code| (f64::from(scaling.value(code)) * per_unit) as f32);
            if (f64::from(min)..=f64::from(max)).contains(&value) {
                Ok(scaling.code((value / per_unit) as f32))
            } else {
                Err(PilError::OutsideSensor { time_s, quantity, value, min, max, unit })
            }
        };
        let JointHello { pressures: [of_a, of_b], angle, command, .. } = &self.hello;
        let [a, b] = measured.pressures_bar;
        let request = JointTickRequest {
            target: Some(JointTarget {
                angle: wanted.angle_deg.to_radians() as f32,
                stiffness: wanted.stiffness as f32,
                load: wanted.torque_nm as f32,
            }),
            pressure_codes: [
                code(of_a, "pressure a", a, (1.0, "bar"))?,
                code(of_b, "pressure b", b, (1.0, "bar"))?,
            ],
            angle_code: code(angle, "the angle", measured.angle_deg, (1_f64.to_degrees(), "degrees"))?,
        };
        let reply = match self.board.request(&JointRequest::Tick(request))? {
            JointResponse::Tick(reply) => reply,
            _ => return Err(PilError::OutOfTurn),
        };
        if let Some(fault) = reply.fault {
            return Err(PilError::Joint { time_s, fault });
        }
        let commands_bar = reply.dac_codes.map(|code| command.value(code));
        self.due_deg = f64::from(reply.due_rad).to_degrees();
        self.ticks += 1;
        self.measured = self.plant.advance(self.ticks as f64 * self.period_s, commands_bar)?;
        Ok(JointSample { time_s: 0.0, wanted: *wanted, measured, commands_bar, reply })
    }

    /// Follows what is wanted, a tick each, behind the start ([`start`]), and vents. `look` sees
    /// the plant before each tick.
    ///
    /// # Errors
    /// Board or plant do not answer as they should, or a stop is requested.
    pub fn follow(
        &mut self,
        wanted: impl Iterator<Item = JointWanted>,
        mut look: impl FnMut(&JointSample, &P),
    ) -> Result<Vec<JointSample>, PilError> {
        let mut samples = Vec::new();
        for (tick, wanted) in wanted.enumerate() {
            let before = self.tick(&wanted)?;
            let sample = JointSample { time_s: tick as f64 * self.period_s, ..before };
            look(&sample, self.plant);
            samples.push(sample);
        }
        demand(self.board, &JointRequest::Stop)?;
        Ok(samples)
    }
}

fn demand(board: &mut impl JointBoard, request: &JointRequest) -> Result<(), PilError> {
    match board.request(request)? {
        JointResponse::Accepted => Ok(()),
        JointResponse::Refused(refusal) => Err(PilError::Refused(refusal)),
        _ => Err(PilError::OutOfTurn),
    }
}
