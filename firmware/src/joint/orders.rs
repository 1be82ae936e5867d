//! The requests of the host, carried out between ticks: by link on a real board, in lock-step in
//! the emulator and on a host; and what the board has kept, behind its start.

use model_core::joint::JointTarget;
use model_core::pid::PidParameters;
use wire::fault::times::LOOP_RESETS;
use wire::joint::{
    BoardJointControl, BoardJointParameters, JOINT_VERSION, JointAim, JointBoardState, JointCalibration,
    JointConfiguration, JointFault, JointHello, JointReport, JointRequest, JointResponse, JointSettings,
    JointStatus, JointTickReply, JointTiming,
};
use wire::registers::{ARMED_TICKS, HIGHEST_BAR};
use wire::{Fault, Protection, Refusal, fingerprint};

use super::aim::Aimed;
use super::pair::{Moved, Pair};
use super::settings::{JointScalings, checked, checked_limits};
use super::start::Start;
use super::watch::Watch;
use super::{Installed, JointSamples, JointTask, Running};
use crate::control::UNCLOCKED_PERIOD_S;
use crate::output;
use crate::report::{FIRMWARE_VERSION, converters_supply_v, output_v};
use crate::scaling::{COMMAND, SUPPLY, TEMPERATURE};
use crate::store::{JointParameters, SaveError, Sealed};

/// What has a joint's task.
pub trait JointNode {
    /// Works on the task, between two ticks; a tick that is due waits meanwhile.
    fn task<R>(&mut self, work: impl FnOnce(&mut JointTask) -> R) -> R;

    /// Keeps what an accepted request has changed ([`JointParameters::changed_by`]), without power
    /// too where there is a store.
    ///
    /// # Errors
    /// It is kept until power is lost only.
    fn keep(&mut self, request: &JointRequest) -> Result<(), SaveError>;

    /// The raw parameters of the joint that was kept last; none before that, and where nothing is
    /// kept. They are beside the task: no tick waits while they are read.
    fn control(&self) -> Option<&BoardJointParameters>;
}

impl JointNode for JointTask {
    fn task<R>(&mut self, work: impl FnOnce(&mut JointTask) -> R) -> R {
        work(self)
    }

    /// There is no store.
    fn keep(&mut self, _: &JointRequest) -> Result<(), SaveError> {
        Ok(())
    }

    fn control(&self) -> Option<&BoardJointParameters> {
        None
    }
}

/// Carries a request out, and keeps what it changes. What is carried out and not kept is refused as
/// [`Refusal::NotStored`]. A tick does not come this way: [`JointTask::tick`].
// Not inlined, like what follows: what they need of the stack is then not needed at once, nor by
// their callers' other work.
#[inline(never)]
pub fn carry_out(node: &mut impl JointNode, request: &JointRequest) -> JointResponse {
    let response = apply(node, request);
    let is_done = matches!(response, JointResponse::Accepted | JointResponse::Settings(_));
    if is_done && node.keep(request).is_err() {
        return JointResponse::Refused(Refusal::NotStored);
    }
    response
}

/// Takes what a board has kept, behind its start and before any request, each part validated as one
/// that a host sends. What is not valid is a fault; the standard one stands for it, or no joint. A
/// board that has started at fault takes it, too: it stays at fault.
#[inline(never)]
pub fn recall(node: &mut impl JointNode, kept: &JointParameters) {
    let JointParameters { protection, calibration, control } = kept;
    node.task(|task| {
        task.recall_limits(protection);
        calibration.iter().for_each(|calibration| task.recall_calibration(calibration));
        task.set_up();
    });
    let Some(control) = control else { return };
    let prepared = Installed::prepare(control);
    node.task(|task| {
        if prepared.and_then(|installed| task.take(installed)).is_err() {
            task.report_of_board(Fault::ConfigurationCorrupt);
        }
    });
}

/// Carries a request out. The long work, a joint's validation, is done outside of the task's lock.
#[inline(never)]
fn apply(node: &mut impl JointNode, request: &JointRequest) -> JointResponse {
    match request {
        JointRequest::Identify => JointResponse::Hello(node.task(|task| task.hello())),
        JointRequest::Configure(JointConfiguration { version: JOINT_VERSION, control }) => {
            match Installed::prepare(control) {
                Ok(installed) => node.task(|task| task.install(installed)),
                Err(refusal) => JointResponse::Refused(refusal),
            }
        }
        JointRequest::Configure(_) => JointResponse::Refused(Refusal::Version(JOINT_VERSION)),
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
        JointRequest::Installed => JointResponse::Installed(node.task(|task| task.fingerprint())),
        JointRequest::Control => control(node),
        JointRequest::Status => {
            let told = node.task(|task| task.told());
            JointResponse::Status(told.status())
        }
        JointRequest::Tick(_) => JointResponse::Refused(Refusal::NotHere),
    }
}

/// The joint that the board has, read back. What was kept is told only where it is the joint that
/// the task runs: a bit that was lost since then is no answer.
#[inline(never)]
fn control(node: &mut impl JointNode) -> JointResponse {
    let Some(installed) = node.task(|task| task.fingerprint()) else {
        return JointResponse::Control(None);
    };
    match node.control() {
        Some(kept) if fingerprint(kept) == installed => JointResponse::Control(Some(kept.clone())),
        _ => JointResponse::Refused(Refusal::NotHere),
    }
}

/// What is copied of the task between two ticks for a [`JointStatus`], which is computed outside.
struct Told {
    report: JointReport,
    samples: JointSamples,
    timing: Option<JointTiming>,
    resets: u32,
}

impl Told {
    fn status(&self) -> JointStatus {
        let JointSamples { supply, temperature, outputs, reference, .. } = self.samples;
        let converters_supply_v = reference.map(converters_supply_v);
        JointStatus {
            report: self.report,
            supply_bar: SUPPLY.value(supply.0),
            temperature_c: TEMPERATURE.value(temperature.0),
            outputs_v: outputs
                .zip(converters_supply_v)
                .map(|(codes, supply_v)| codes.map(|code| output_v(code, supply_v))),
            converters_supply_v,
            timing: self.timing,
            resets: self.resets,
        }
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

    /// Of the joint that it has.
    fn fingerprint(&self) -> Option<u32> {
        self.installed.as_ref().map(|installed| installed.fingerprint)
    }

    /// What a status is made of.
    fn told(&self) -> Told {
        let timing = self.clock.map(|clock| JointTiming {
            worst_cycles: self.timing.worst_cycles,
            mean_cycles: self.timing.mean_cycles(),
            deadline_cycles: clock.deadline_cycles,
            overruns: self.timing.overruns,
        });
        Told { report: self.tell(), samples: self.watch.samples(), timing, resets: self.resets() }
    }

    /// In a row, less than 10 s apart.
    fn resets(&self) -> u32 {
        self.black_box.as_ref().map_or(0, |black_box| black_box.resets())
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
        if let Err(refusal) = self.take(installed) {
            return JointResponse::Refused(refusal);
        }
        self.leave(JointBoardState::Ready);
        JointResponse::Accepted
    }

    /// Takes a joint; what state follows is left to others.
    fn take(&mut self, installed: Installed) -> Result<(), Refusal> {
        self.clock.map_or(Ok(()), |clock| clock.demand(installed.period_s))?;
        self.installed = Some(installed);
        self.set_up();
        Ok(())
    }

    /// Takes limits that were kept.
    fn recall_limits(&mut self, kept: &Protection) {
        match checked_limits(kept, self.clock.is_some()) {
            Ok(protection) => self.protection = protection,
            Err(_) => self.report_of_board(Fault::ConfigurationCorrupt),
        }
    }

    /// Takes a calibration that was kept. One that is damaged, or that no working sensor has, is a
    /// fault: the scalings stay those of the standard sensors.
    fn recall_calibration(&mut self, kept: &Sealed<JointCalibration>) {
        let opened = kept.open().and_then(|calibration| {
            JointScalings::calibrated(calibration).ok().map(|scalings| (*calibration, scalings))
        });
        match opened {
            Some((calibration, scalings)) => (self.calibration, self.scalings) = (calibration, scalings),
            None => self.report_of_board(Fault::CalibrationCorrupt),
        }
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
            if self.is_for_good() || self.resets() >= LOOP_RESETS {
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
    fn prepare(parameters: &BoardJointParameters) -> Result<Self, Refusal> {
        let none = PidParameters { kp: 0.0, ki: 0.0, kd: 0.0, ..parameters.pid };
        let open = BoardJointParameters { pid: none, ..parameters.clone() };
        let control = BoardJointControl::try_new(parameters)?;
        Ok(Self {
            moved: Moved::new(&control),
            control,
            open: BoardJointControl::try_new(&open)?,
            period_s: parameters.period_s,
            fingerprint: fingerprint(parameters),
        })
    }
}
