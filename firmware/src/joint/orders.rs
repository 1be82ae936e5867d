//! The requests of the host, carried out between ticks: by link on a real board, in lock-step in
//! the emulator and on a host.

use model_core::joint::JointTarget;
use model_core::pid::PidParameters;
use wire::fault::times::LOOP_RESETS;
use wire::joint::{
    BoardJointControl, BoardJointParameters, JOINT_VERSION, JointAim, JointBoardState, JointConfiguration,
    JointFault, JointHello, JointReport, JointRequest, JointResponse, JointSettings, JointTickReply,
};
use wire::registers::{ARMED_TICKS, HIGHEST_BAR};
use wire::{Fault, Refusal};

use super::aim::Aimed;
use super::pair::{Moved, Pair};
use super::settings::checked;
use super::start::Start;
use super::watch::Watch;
use super::{Installed, JointTask, Running};
use crate::control::UNCLOCKED_PERIOD_S;
use crate::output;
use crate::report::FIRMWARE_VERSION;
use crate::scaling::COMMAND;

/// What has a joint's task.
pub trait JointNode {
    /// Works on the task, between two ticks; a tick that is due waits meanwhile.
    fn task<R>(&mut self, work: impl FnOnce(&mut JointTask) -> R) -> R;
}

impl JointNode for JointTask {
    fn task<R>(&mut self, work: impl FnOnce(&mut JointTask) -> R) -> R {
        work(self)
    }
}

/// Carries a request out. The long work, a joint's validation, is done outside of the task's lock.
/// A tick does not come this way: [`JointTask::tick`].
// Not inlined: what it needs of the stack is then not needed by its callers' other work.
#[inline(never)]
pub fn carry_out(node: &mut impl JointNode, request: &JointRequest) -> JointResponse {
    match request {
        JointRequest::Identify => JointResponse::Hello(node.task(|task| task.hello())),
        JointRequest::Configure(configuration) => match Installed::prepare(configuration) {
            Ok(installed) => node.task(|task| task.install(installed)),
            Err(refusal) => JointResponse::Refused(refusal),
        },
        JointRequest::Arm => node.task(JointTask::arm),
        JointRequest::Start(stiffness) => node.task(|task| task.start(*stiffness)),
        JointRequest::Stop => node.task(JointTask::stop),
        JointRequest::Acknowledge => node.task(JointTask::acknowledge),
        JointRequest::Aim(aim) => node.task(|task| match aim {
            Some(_) if task.state == JointBoardState::Service => JointResponse::WrongState(task.state),
            aim => {
                aim.iter().for_each(|aim| task.aim(*aim));
                JointResponse::Report(task.tell())
            }
        }),
        JointRequest::Service => node.task(JointTask::serve),
        JointRequest::Press(pressures) => node.task(|task| task.press(*pressures)),
        JointRequest::Settings(settings) => node.task(|task| task.set(settings.as_ref())),
        JointRequest::Tick(_) => JointResponse::Refused(Refusal::NotHere),
    }
}

impl JointTask {
    /// Takes where the joint is to go, a sign of life of the host. A target that is no number is a
    /// fault.
    pub fn aim(&mut self, aim: JointAim) {
        self.silent_ticks = 0;
        let JointTarget { angle, stiffness, load } = aim.target;
        if (angle + stiffness + load).is_finite() {
            self.aimed.take(aim);
        } else {
            self.report(JointFault::OfBoard(Fault::Reference));
        }
    }

    /// Takes what the host wants both pressures (bar) to be, a sign of life in service. One that is
    /// no number is a fault.
    fn press(&mut self, pressures: [f32; 2]) -> JointResponse {
        if self.state != JointBoardState::Service {
            return JointResponse::WrongState(self.state);
        }
        let [a, b] = pressures;
        if !(a + b).is_finite() {
            self.report(JointFault::OfBoard(Fault::Reference));
            return JointResponse::Report(self.tell());
        }
        let highest = self.highest_bar();
        if pressures.iter().any(|bar| !(0.0..=highest).contains(bar)) {
            return JointResponse::Refused(Refusal::parameter(format_args!(
                "pressures of {a} and {b} bar, must be 0 to {highest} bar"
            )));
        }
        self.silent_ticks = 0;
        self.pressures = pressures;
        JointResponse::Report(self.tell())
    }

    /// The highest pressure that a host may ask for: that at which the mean of a single muscle's
    /// pressure vents, and what is compiled in. Unit: bar.
    fn highest_bar(&self) -> f32 {
        self.protection.overpressure_soft_bar.min(HIGHEST_BAR as f32)
    }

    /// What the last tick has come to.
    pub fn reply(&self) -> JointTickReply {
        let command = self.last.command;
        JointTickReply {
            dac_codes: self.outputs.map(|output| output.code().0),
            state: self.state,
            fault: self.fault,
            due_rad: command.map_or(0.0, |command| command.due),
            stiffness: command.map_or(0.0, |command| command.stiffness),
            feedback_nm: command.map_or(0.0, |command| command.feedback),
            is_limited: self.last.is_limited,
            is_as_stiff: command.is_none_or(|command| command.is_as_stiff),
        }
    }

    fn tell(&self) -> JointReport {
        let samples = self.watch.samples();
        JointReport {
            ticks: self.ticks,
            pressure_codes: samples.pressures.map(|code| code.0),
            angle_code: samples.angle.0,
            supply_code: samples.supply.0,
            late_ticks: self.timing.late,
            noted: self.noted,
            tick: self.reply(),
        }
    }

    fn hello(&self) -> JointHello {
        JointHello {
            version: JOINT_VERSION,
            firmware: FIRMWARE_VERSION,
            state: self.state,
            fault: self.fault,
            pressures: self.scalings.pressures,
            angle: self.scalings.angle,
            command: COMMAND,
            ticks: self.ticks,
        }
    }

    fn install(&mut self, installed: Installed) -> JointResponse {
        if !matches!(self.state, JointBoardState::Off | JointBoardState::Ready) {
            return JointResponse::WrongState(self.state);
        }
        if let Err(refusal) = self.clock.map_or(Ok(()), |clock| clock.demand(installed.period_s)) {
            return JointResponse::Refused(refusal);
        }
        self.installed = Some(installed);
        self.set_up();
        self.leave(JointBoardState::Ready);
        JointResponse::Accepted
    }

    /// Takes settings, or tells those that there are.
    fn set(&mut self, settings: Option<&JointSettings>) -> JointResponse {
        if let Some(settings) = settings {
            if !matches!(self.state, JointBoardState::Off | JointBoardState::Ready) {
                return JointResponse::WrongState(self.state);
            }
            match checked(settings, self.clock.is_some()) {
                Ok((protection, scalings)) => {
                    (self.protection, self.scalings) = (protection, scalings);
                    self.calibration = settings.calibration;
                }
                Err(refusal) => return JointResponse::Refused(refusal),
            }
            self.armed_ticks = 0;
            self.set_up();
        }
        JointResponse::Settings(JointSettings { protection: self.protection, calibration: self.calibration })
    }

    /// Output and monitors by the limits, the scalings and the period that there are now.
    fn set_up(&mut self) {
        let period_s = self.installed.as_ref().map_or(UNCLOCKED_PERIOD_S, |installed| installed.period_s);
        let protection = self.protection.for_period(period_s);
        self.limits = output::Limits::new(&protection, &COMMAND, period_s);
        self.watch = Watch::new(&protection, &self.scalings, period_s);
        self.pair = Pair::new(&protection);
    }

    fn arm(&mut self) -> JointResponse {
        if !matches!(self.state, JointBoardState::Off | JointBoardState::Ready) {
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
        self.aimed = Aimed::still(JointTarget { angle: middle, stiffness, load: 0.0 });
        self.restart();
        self.state = JointBoardState::Starting;
        self.silent_ticks = 0;
        self.armed_ticks = 0;
        JointResponse::Accepted
    }

    /// Lets the host drive both valves by pressures, which begin at 0 bar.
    fn serve(&mut self) -> JointResponse {
        if !matches!(self.state, JointBoardState::Off | JointBoardState::Ready) {
            return JointResponse::WrongState(self.state);
        }
        if self.armed_ticks == 0 {
            return JointResponse::Refused(Refusal::NotArmed);
        }
        self.restart();
        self.has_served = true;
        self.leave(JointBoardState::Service);
        self.silent_ticks = 0;
        JointResponse::Accepted
    }

    /// The monitors forget the past.
    fn restart(&mut self) {
        self.watch.restart();
        self.pair.restart();
    }

    fn stop(&mut self) -> JointResponse {
        if self.state.is_driven() {
            self.leave(self.home());
        }
        JointResponse::Accepted
    }

    fn acknowledge(&mut self) -> JointResponse {
        if self.state == JointBoardState::Fault {
            let resets = self.black_box.as_ref().map_or(0, |black_box| black_box.resets());
            if self.is_for_good() || resets >= LOOP_RESETS {
                return JointResponse::WrongState(self.state);
            }
            self.fault = None;
            self.black_box.iter_mut().for_each(|black_box| black_box.reopen());
            self.restart();
            self.leave(self.home());
        }
        JointResponse::Accepted
    }
}

impl Installed {
    /// A joint that is valid.
    // Not inlined: it needs much stack, and only while it runs.
    #[inline(never)]
    fn prepare(configuration: &JointConfiguration) -> Result<Self, Refusal> {
        if configuration.version != JOINT_VERSION {
            return Err(Refusal::Version(JOINT_VERSION));
        }
        let parameters = &configuration.control;
        let none = PidParameters { kp: 0.0, ki: 0.0, kd: 0.0, ..parameters.pid };
        let open = BoardJointParameters { pid: none, ..parameters.clone() };
        let control = BoardJointControl::try_new(parameters)?;
        Ok(Self {
            moved: Moved::new(&control),
            control,
            open: BoardJointControl::try_new(&open)?,
            period_s: parameters.period_s,
        })
    }
}
