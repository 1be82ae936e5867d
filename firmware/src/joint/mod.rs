//! A board that drives a joint: two muscles, each on a regulator of its own, and an angle sensor.
//!
//! ```text
//! ADC codes ─▶ watch ─▶ start, or what is asked for ─▶ torque balance + PID ─▶ soft start, slew ─▶ two DAC codes
//! ```
//!
//! | file | what it does |
//! |---|---|
//! | this one | the tick, the states and the orders between ticks |
//! | [`start`] | fills the muscles, and tries the joint before it is controlled |
//! | [`watch`] | what tells a fault of a sensor, a valve or a muscle |
//! | [`lock_step`] | a board whose samples come from a host |
//!
//! # States
//! ```text
//! Off ─Configure─▶ Ready ─Arm, Start─▶ Starting ─joint is the model's─▶ Tracking
//!                    ▲───────Stop──────────┴──────────────Stop─────────────┘
//! every state ─fault─▶ Fault ─Acknowledge─▶ Ready, or Off without a joint
//! ```
//!
//! # Contract
//! One [`JointTask::tick`] each period of the installed joint. It reads the board once and writes
//! both valves, in every state: the vented code in all but `Starting` and `Tracking`. It takes
//! bounded time, allocates nothing and does not panic.
//!
//! # Safety
//! A fault of either channel, of the angle or of the pair vents **both** muscles, in the tick that
//! sees it: one that is vented alone would let the other turn the joint to its end. The start is
//! without feedback, which with a wrong sign would do the same.
//!
//! # Limits
//! The image that drives two channels of a real board is still to be written: these are the control
//! code and its monitors, in the emulator and on a host. Nothing of a joint is stored, and the bus
//! has no registers for it.

pub mod lock_step;
pub mod start;
pub mod watch;

use core::hint::black_box;

use model_core::joint::{JointCommand, JointState, JointTarget};
use model_core::pid::PidParameters;
use wire::fault::times::MISSING_IN_A_ROW;
use wire::joint::{
    BoardJointControl, BoardJointParameters, JOINT_VERSION, JointBoardState, JointConfiguration, JointFault,
    JointHello, JointRequest, JointResponse, STOPS,
};
use wire::registers::ARMED_TICKS;
use wire::{Fault, Protection, Refusal, Scaling};

use crate::board::{AcquisitionError, AdcCode, DacCode};
use crate::monitors::persistence::InARow;
use crate::output::{self, Output};
use crate::report::FIRMWARE_VERSION;
use crate::scaling::{COMMAND, PRESSURE, VENT};
use start::Start;
use watch::Watch;

/// The angle in rad. Sensor: a magnetic encoder's analogue output, half a turn over 5 to 95 % of
/// the supply. Plausible: -97 to 97 degrees.
pub const ANGLE: Scaling =
    Scaling { zero_code: 2047.5, codes_per_unit: 1173.0, code_min: 62, code_max: 4033 };

/// The samples of one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointSamples {
    /// Of both pressures.
    pub pressures: [AdcCode; 2],
    /// Of the angle.
    pub angle: AdcCode,
}

/// Sensors and valves of a joint.
pub trait JointBoard {
    /// The samples of this tick, in bounded time.
    ///
    /// # Errors
    /// There are none that are newer than those of the tick before.
    fn read(&mut self) -> Result<JointSamples, AcquisitionError>;

    /// Writes both valves' set points.
    fn drive(&mut self, codes: [DacCode; 2]);
}

/// The owner of a joint's tick.
#[derive(Debug)]
pub struct JointTask {
    state: JointBoardState,
    fault: Option<JointFault>,
    protection: Protection,
    installed: Option<Installed>,
    running: Option<Running>,
    target: JointTarget<f32>,
    outputs: [Output; 2],
    limits: output::Limits,
    watch: Watch,
    missing: InARow,
    ticks: u32,
    /// Since the host's last sign of life.
    silent_ticks: u32,
    /// How long a start is still taken.
    armed_ticks: u16,
}

/// A joint that was validated.
#[derive(Debug)]
struct Installed {
    control: BoardJointControl,
    /// The same without feedback, for the start.
    open: BoardJointControl,
    period_s: f32,
}

#[derive(Debug)]
struct Running {
    state: JointState<f32, STOPS>,
    /// None when the joint has been tried.
    start: Option<Start>,
}

/// What a tick has done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointOutcome {
    /// What was written to both valves.
    pub codes: [DacCode; 2],
    /// What the controller made of the tick; none where it did not drive.
    pub command: Option<JointCommand<f32>>,
    /// A limit of an output changed a command.
    pub is_limited: bool,
}

impl JointTask {
    /// A task without a joint, vented.
    pub fn new(protection: Protection) -> Self {
        const UNCLOCKED_PERIOD_S: f32 = 1e-3;
        Self {
            state: JointBoardState::Off,
            fault: None,
            installed: None,
            running: None,
            target: JointTarget { angle: 0.0, stiffness: 0.0, load: 0.0 },
            outputs: [Output::vented(); 2],
            limits: output::Limits::new(&protection, &COMMAND, UNCLOCKED_PERIOD_S),
            watch: Watch::new(&protection, UNCLOCKED_PERIOD_S),
            protection,
            missing: InARow::default(),
            ticks: 0,
            silent_ticks: 0,
            armed_ticks: 0,
        }
    }

    /// The board's state.
    pub fn state(&self) -> JointBoardState {
        self.state
    }

    /// The fault that is latched.
    pub fn fault(&self) -> Option<JointFault> {
        self.fault
    }

    /// Takes what the joint is to do, a sign of life of the host. One that is no number is a fault.
    pub fn aim(&mut self, target: JointTarget<f32>) {
        self.silent_ticks = 0;
        if (target.angle + target.stiffness + target.load).is_finite() {
            self.target = target;
        } else {
            self.report(JointFault::OfBoard(Fault::Reference));
        }
    }

    /// Carries a request out. A tick does not come this way: [`Self::tick`].
    pub fn carry_out(&mut self, request: &JointRequest) -> JointResponse {
        match request {
            JointRequest::Identify => JointResponse::Hello(self.hello()),
            JointRequest::Configure(configuration) => self.configure(configuration),
            JointRequest::Arm => self.arm(),
            JointRequest::Start(stiffness) => self.start(*stiffness),
            JointRequest::Stop => self.stop(),
            JointRequest::Acknowledge => self.acknowledge(),
            JointRequest::Tick(_) => JointResponse::Refused(Refusal::NotHere),
        }
    }

    /// One tick: samples, computes, drives.
    pub fn tick<B: JointBoard>(&mut self, board: &mut B) -> JointOutcome {
        self.ticks = self.ticks.wrapping_add(1);
        self.armed_ticks = self.armed_ticks.saturating_sub(1);
        let command = match self.work(board.read()) {
            Ok(command) => command,
            Err(fault) => {
                self.report(fault);
                None
            }
        };
        let asked = match command.filter(|_| self.state.is_driven()) {
            Some(command) => command.commands.map(command_code),
            None => [VENT; 2],
        };
        let mut codes = [VENT; 2];
        for ((code, output), asked) in codes.iter_mut().zip(&mut self.outputs).zip(asked) {
            *code = if self.state.is_driven() { output.drive(&self.limits, asked) } else { output.vent() };
        }
        board.drive(codes);
        let is_limited = codes != asked || command.is_some_and(|command| command.limited);
        JointOutcome { codes, command, is_limited }
    }

    /// Takes a fault: both muscles are vented from this tick on.
    pub fn report(&mut self, fault: JointFault) {
        if self.state != JointBoardState::Fault {
            self.fault = Some(fault);
            self.leave(JointBoardState::Fault);
        }
    }

    /// What the samples of a tick lead to; none where nothing is driven.
    fn work(
        &mut self,
        samples: Result<JointSamples, AcquisitionError>,
    ) -> Result<Option<JointCommand<f32>>, JointFault> {
        if self.missing.holds_for(MISSING_IN_A_ROW, samples.is_err()) {
            return Err(JointFault::OfBoard(Fault::Acquisition));
        }
        let driven = self.outputs.map(|output| COMMAND.value(output.code().0));
        let is_driven = self.state.is_driven();
        if matches!(self.state, JointBoardState::Off | JointBoardState::Fault) {
            self.watch.look(samples.ok());
            return Ok(None);
        }
        let measured = self.watch.take(samples.ok(), is_driven.then_some(driven))?;
        let (Some(installed), Some(running)) = (&self.installed, &mut self.running) else {
            return Ok(None);
        };
        self.silent_ticks = self.silent_ticks.saturating_add(1);
        if self.silent_ticks > self.protection.bus_silent_ticks {
            return Err(JointFault::OfBoard(Fault::BusSilent));
        }
        let (control, target) = match &mut running.start {
            Some(start) => (&installed.open, start.target()),
            None => (&installed.control, self.target),
        };
        let command = joint_step(black_box(control), &mut running.state, &target, measured.angle)
            .map_err(|_| JointFault::OfBoard(Fault::NotFinite))?;
        let [a, b] = command.commands;
        if !(a + b).is_finite() {
            return Err(JointFault::OfBoard(Fault::NotFinite));
        }
        if let Some(start) = &mut running.start
            && start.take(&measured, command.commands)?
        {
            running.start = None;
            self.state = JointBoardState::Tracking;
            // Until the host says otherwise it stays where the start has left it.
            self.target = JointTarget { angle: running.state.due(), stiffness: target.stiffness, load: 0.0 };
        }
        Ok(Some(command))
    }

    fn hello(&self) -> JointHello {
        JointHello {
            version: JOINT_VERSION,
            firmware: FIRMWARE_VERSION,
            state: self.state,
            fault: self.fault,
            pressure: PRESSURE,
            angle: ANGLE,
            command: COMMAND,
            ticks: self.ticks,
        }
    }

    fn configure(&mut self, configuration: &JointConfiguration) -> JointResponse {
        if !matches!(self.state, JointBoardState::Off | JointBoardState::Ready) {
            return JointResponse::WrongState(self.state);
        }
        if configuration.version != JOINT_VERSION {
            return JointResponse::Refused(Refusal::Version(JOINT_VERSION));
        }
        match Installed::try_new(&configuration.control) {
            Ok(installed) => {
                let protection = self.protection.for_period(installed.period_s);
                self.limits = output::Limits::new(&protection, &COMMAND, installed.period_s);
                self.watch = Watch::new(&protection, installed.period_s);
                self.installed = Some(installed);
                self.leave(JointBoardState::Ready);
                JointResponse::Accepted
            }
            Err(refusal) => JointResponse::Refused(refusal),
        }
    }

    fn arm(&mut self) -> JointResponse {
        if self.state != JointBoardState::Ready {
            return JointResponse::WrongState(self.state);
        }
        self.armed_ticks = ARMED_TICKS;
        JointResponse::Accepted
    }

    fn start(&mut self, stiffness: f32) -> JointResponse {
        let Some(installed) = self.installed.as_ref().filter(|_| self.state == JointBoardState::Ready) else {
            return JointResponse::WrongState(self.state);
        };
        if self.armed_ticks == 0 {
            return JointResponse::Refused(Refusal::NotArmed);
        }
        if !(stiffness > 0.0 && stiffness.is_finite()) {
            let refusal =
                Refusal::parameter(format_args!("stiffness is {stiffness} N m/rad, must be above 0"));
            return JointResponse::Refused(refusal);
        }
        let angles = installed.control.joint().angles();
        let middle = 0.5 * (angles.min() + angles.max());
        let start = Start::new((angles.min(), angles.max()), stiffness, installed.period_s);
        self.running = Some(Running { state: installed.control.rest_state(middle), start: Some(start) });
        self.watch.start_anew();
        self.state = JointBoardState::Starting;
        self.silent_ticks = 0;
        self.armed_ticks = 0;
        JointResponse::Accepted
    }

    fn stop(&mut self) -> JointResponse {
        if self.state.is_driven() {
            self.leave(JointBoardState::Ready);
        }
        JointResponse::Accepted
    }

    fn acknowledge(&mut self) -> JointResponse {
        if self.state == JointBoardState::Fault {
            self.fault = None;
            self.watch.start_anew();
            let has_joint = self.installed.is_some();
            self.leave(if has_joint { JointBoardState::Ready } else { JointBoardState::Off });
        }
        JointResponse::Accepted
    }

    /// Goes to a state in which nothing is driven. The next write, in this tick if it is still to
    /// come, vents.
    fn leave(&mut self, state: JointBoardState) {
        self.state = state;
        self.running = None;
        self.armed_ticks = 0;
    }
}

impl Installed {
    fn try_new(parameters: &BoardJointParameters) -> Result<Self, Refusal> {
        let none = PidParameters { kp: 0.0, ki: 0.0, kd: 0.0, ..parameters.pid };
        let open = BoardJointParameters { pid: none, ..parameters.clone() };
        Ok(Self {
            control: BoardJointControl::try_new(parameters)?,
            open: BoardJointControl::try_new(&open)?,
            period_s: parameters.period_s,
        })
    }
}

/// One sample of a joint's controller: torque balance, two equations, PID. Angle: rad. Not inlined,
/// so that what it costs can be counted.
///
/// # Errors
/// A value that is not finite; the state is then as it was.
#[inline(never)]
pub fn joint_step(
    control: &BoardJointControl,
    state: &mut JointState<f32, STOPS>,
    target: &JointTarget<f32>,
    angle: f32,
) -> Result<JointCommand<f32>, model_core::InputError> {
    control.step(state, target, angle)
}

/// The code of a command in bar.
fn command_code(bar: f32) -> DacCode {
    if bar > 0.0 { DacCode(COMMAND.code(bar)) } else { VENT }
}
