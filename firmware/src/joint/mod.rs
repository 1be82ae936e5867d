//! A board that drives a joint: two muscles, each on a regulator of its own, and an angle sensor.
//!
//! ```text
//! ADC codes ─▶ watch ─▶ start, or what is asked for ─▶ torque balance + PID ─▶ soft start, slew ─▶ two DAC codes
//!                       in service: the host's pressures ────────────────────────▲
//! ```
//!
//! | file | what it does |
//! |---|---|
//! | this one | the tick, the states, and what a board tells of itself |
//! | `aim` | straight lines between the targets of the host |
//! | `orders` | the requests of the host, between ticks ([`carry_out`]), and what the board has kept ([`recall`]) |
//! | [`settings`] | limits, and the scalings of the sensors |
//! | [`start`] | fills the muscles, and tries the joint before it is controlled |
//! | [`watch`] | what tells a fault of a sensor, a valve or a muscle |
//! | [`pair`] | what only the pair shows: an angle that stands still, a feedback beyond its authority |
//! | [`lock_step`] | a board whose samples come from a host |
//!
//! # States
//! ```text
//! Off ─Configure─▶ Ready ─Arm, Start─▶ Starting ─joint is the model's─▶ Tracking
//!                    ▲───────Stop──────────┴──────────────Stop─────────────┘
//! Off, Ready ─Arm, Service─▶ Service ─Stop─▶ Ready, or Off without a joint
//! every state ─fault─▶ Fault ─Acknowledge─▶ Ready, or Off without a joint
//! ```
//! A board that starts with a joint that it has kept is `Off`, too, until it has looked at its dump
//! valve's coil; then `Ready`. It is driven by orders of the host only.
//!
//! # Contract
//! One [`JointTask::tick`] each period of the installed joint. It reads the board once and writes
//! both valves, in every state: the vented code in all but `Starting`, `Tracking` and `Service`. It
//! takes bounded time, allocates nothing and does not panic. A host that drives, and is silent for
//! [`Protection::bus_silent_ticks`], is a fault.
//!
//! # Safety
//! A fault of either channel, of the angle or of the pair vents **both** muscles, in the tick that
//! sees it: one that is vented alone would let the other turn the joint to its end. The start is
//! without feedback, which with a wrong sign would do the same. In service, without a model, all is
//! watched that is while tracking but for what the start tries: how the joint turns.
//!
//! # Limits
//! The bus has no registers for a joint. The black box keeps what has
//! ended the program, not a fault of the joint, and no trace.

mod aim;
pub mod lock_step;
mod orders;
pub mod pair;
pub mod settings;
pub mod start;
pub mod watch;

use core::hint::black_box;

use model_core::joint::{JointCommand, JointState, JointTarget};
use wire::fault::times::{DUMP_TICKS, MISSING_IN_A_ROW, STOP_TICKS};
use wire::joint::{BoardJointControl, JointBoardState, JointCalibration, JointFault, STOPS};
use wire::{Fault, Protection, Scaling};

use crate::board::{AcquisitionError, AdcCode, DacCode};
use crate::control::{SETTLED_TICKS, TickClock, UNCLOCKED_PERIOD_S};
use crate::faults::black_box::BlackBox;
use crate::monitors::persistence::InARow;
use crate::output::{self, Output};
use crate::scaling::{COMMAND, VENT};
use crate::timing::{TickEnd, Timing};
use aim::Aimed;
pub use orders::{JointNode, carry_out, recall};
use pair::{Moved, Pair};
pub use settings::JointScalings;
use start::Start;
use watch::Watch;

/// The angle in rad. Sensor: a magnetic encoder's analogue output, half a turn over 5 to 95 % of
/// the supply. Plausible: -97 to 97 degrees.
pub const ANGLE: Scaling =
    Scaling { zero_code: 2047.5, codes_per_unit: 1173.0, code_min: 62, code_max: 4033 };

/// How long a board that has kept a joint looks at its dump valve's coil behind its start: twice
/// what [`Fault::DumpHeld`] takes to be seen and the pump takes to let go. Unit: tick.
const LOOK_TICKS: u32 = 2 * (DUMP_TICKS as u32 + 10);

/// The samples of one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointSamples {
    /// Of both pressures.
    pub pressures: [AdcCode; 2],
    /// Of the angle.
    pub angle: AdcCode,
    /// Pressure before both valves.
    pub supply: AdcCode,
    /// Temperature of the processor.
    pub temperature: AdcCode,
    /// The voltages at both outputs, the same numbers as those of the [`DacCode`]s which make them;
    /// none on a board that does not read them back.
    pub outputs: Option<[AdcCode; 2]>,
    /// The reference voltage, as a typical processor would read it; none on a board without one.
    pub reference: Option<AdcCode>,
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
    calibration: JointCalibration,
    /// By the calibration.
    scalings: JointScalings,
    installed: Option<Installed>,
    running: Option<Running>,
    aimed: Aimed,
    /// Asked for in service. Unit: bar.
    pressures: [f32; 2],
    /// It has been driven without a joint: `Off` is then watched as `Ready` is.
    has_served: bool,
    outputs: [Output; 2],
    limits: output::Limits,
    watch: Watch,
    pair: Pair,
    missing: InARow,
    ticks: u32,
    /// Since the host's last sign of life.
    silent_ticks: u32,
    /// How long a start is still taken.
    armed_ticks: u16,
    last: JointOutcome,
    /// None: ticks come when the host wants them, at whatever period the configuration says.
    clock: Option<TickClock>,
    /// None where nothing ends the program.
    black_box: Option<&'static mut BlackBox>,
    timing: Timing,
    noted: Option<Fault>,
    stop: InARow,
    /// The dump valve's coil has a voltage, and its output rests.
    held: InARow,
}

/// A joint that was validated.
#[derive(Debug)]
struct Installed {
    control: BoardJointControl,
    /// The same without feedback, for the start.
    open: BoardJointControl,
    moved: Moved,
    period_s: f32,
    /// Of the parameters, as a host has them.
    fingerprint: u32,
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

/// What a tick asks of the valves.
#[derive(Clone, Copy, Debug)]
struct Asked {
    /// Unit: bar.
    commands: [f32; 2],
    /// What the controller made of the tick; none in service.
    command: Option<JointCommand<f32>>,
}

/// The outcome of a tick that does not drive the valves.
const VENTED: JointOutcome = JointOutcome { codes: [VENT; 2], command: None, is_limited: false };

impl JointTask {
    /// A task without a joint, vented, whose ticks come when a host wants them.
    pub fn new(protection: Protection) -> Self {
        Self {
            state: JointBoardState::Off,
            fault: None,
            installed: None,
            running: None,
            aimed: Aimed::still(JointTarget { angle: 0.0, stiffness: 0.0, load: 0.0 }),
            pressures: [0.0; 2],
            has_served: false,
            outputs: [Output::vented(); 2],
            limits: output::Limits::new(&protection, &COMMAND, UNCLOCKED_PERIOD_S),
            watch: Watch::new(&protection, &JointScalings::STANDARD, UNCLOCKED_PERIOD_S),
            pair: Pair::new(&protection),
            protection,
            calibration: JointCalibration::default(),
            scalings: JointScalings::STANDARD,
            missing: InARow::default(),
            ticks: 0,
            silent_ticks: 0,
            armed_ticks: 0,
            last: VENTED,
            clock: None,
            black_box: None,
            timing: Timing::default(),
            noted: None,
            stop: InARow::default(),
            held: InARow::default(),
        }
    }

    /// That of a real board, whose ticks have a clock; at fault, if the black box says that it has
    /// started after one.
    pub fn on_board(protection: Protection, clock: TickClock, black_box: &'static mut BlackBox) -> Self {
        let mut task = Self::new(protection);
        let fault = black_box.fault_at_start();
        (task.clock, task.black_box) = (Some(clock), Some(black_box));
        fault.into_iter().for_each(|fault| task.report_of_board(fault));
        task
    }

    /// The board's state.
    pub fn state(&self) -> JointBoardState {
        self.state
    }

    /// The fault that is latched.
    pub fn fault(&self) -> Option<JointFault> {
        self.fault
    }

    /// One tick: samples, computes, drives.
    pub fn tick<B: JointBoard>(&mut self, board: &mut B) -> JointOutcome {
        self.ticks = self.ticks.wrapping_add(1);
        self.armed_ticks = self.armed_ticks.saturating_sub(1);
        // One that was kept: what a host installs is ready at once.
        if self.state == JointBoardState::Off && self.installed.is_some() && self.ticks > LOOK_TICKS {
            self.leave(JointBoardState::Ready);
        }
        let asked = match self.work(board.read()) {
            Ok(asked) => asked.filter(|_| self.state.is_driven()),
            Err(fault) => {
                self.report(fault);
                None
            }
        };
        let command = asked.and_then(|asked| asked.command);
        let asked = asked.map_or([VENT; 2], |asked| asked.commands.map(command_code));
        let mut codes = [VENT; 2];
        for ((code, output), asked) in codes.iter_mut().zip(&mut self.outputs).zip(asked) {
            *code = if self.state.is_driven() { output.drive(&self.limits, asked) } else { output.vent() };
        }
        board.drive(codes);
        let is_limited = codes != asked || command.is_some_and(|command| command.limited);
        self.last = JointOutcome { codes, command, is_limited };
        if self.ticks == SETTLED_TICKS {
            self.black_box.iter_mut().for_each(|black_box| black_box.settle());
        }
        self.last
    }

    /// Ticks since the start.
    pub fn ticks(&self) -> u32 {
        self.ticks
    }

    /// Takes a fault: both muscles are vented from this tick on. The first one is latched, until it
    /// is acknowledged; one that nothing but power-off ends takes its place.
    pub fn report(&mut self, fault: JointFault) {
        let outlasts = is_for_good(&fault) && !self.is_for_good();
        if self.state != JointBoardState::Fault || outlasts {
            self.fault = Some(fault);
            self.leave(JointBoardState::Fault);
        }
    }

    /// The same of a fault of the board as a whole.
    pub fn report_of_board(&mut self, fault: Fault) {
        self.report(JointFault::OfBoard(fault));
    }

    /// Takes a fault that is only to be known of; the first one is told.
    pub fn note(&mut self, fault: Fault) {
        self.noted = self.noted.or(Some(fault));
    }

    /// Whether nothing but power-off ends the fault that is latched.
    fn is_for_good(&self) -> bool {
        self.fault.as_ref().is_some_and(is_for_good)
    }

    /// Takes how long the tick has taken, by a clock of the image.
    pub fn close_tick(&mut self, end: TickEnd) {
        let deadline = self.clock.map_or(u32::MAX, |clock| clock.deadline_cycles);
        if self.timing.take(end, deadline) && self.state.is_driven() {
            self.report_of_board(Fault::Deadline);
        }
    }

    /// Takes what the emergency stop reads back: whether its contacts are open. One sample may be a
    /// spark.
    pub fn hear_stop(&mut self, is_open: bool) {
        if self.stop.holds_for(STOP_TICKS, is_open) {
            self.report_of_board(Fault::EmergencyStop);
        }
    }

    /// Takes whether the dump valve's coil has a voltage, which it must not have where the output
    /// that holds it rests.
    pub fn hear_coil(&mut self, has_voltage: bool) {
        if self.held.holds_for(DUMP_TICKS, has_voltage && !self.keeps_dump_closed()) {
            self.report_of_board(Fault::DumpHeld);
        }
    }

    /// Whether the dump valve behind the regulators is to be kept closed, tick by tick. It opens
    /// without that: at a fault, before a joint is configured, where its coil is looked at, and
    /// with a program that stands still.
    pub fn keeps_dump_closed(&self) -> bool {
        !matches!(self.state, JointBoardState::Off | JointBoardState::Fault)
    }

    /// What the samples of a tick lead to; none where nothing is driven.
    fn work(&mut self, samples: Result<JointSamples, AcquisitionError>) -> Result<Option<Asked>, JointFault> {
        if self.missing.holds_for(MISSING_IN_A_ROW, samples.is_err()) {
            return Err(JointFault::OfBoard(Fault::Acquisition));
        }
        self.watch.look(samples.ok());
        let out = self.outputs.map(|output| output.code());
        if self.state == JointBoardState::Fault {
            return Ok(None);
        }
        self.watch.look_at_own(out)?;
        // Before it has ever been driven its sensors may hang in the air.
        if self.state == JointBoardState::Off && !self.has_served {
            return Ok(None);
        }
        let measured = self.watch.take(out, self.state.is_driven())?;
        if !self.state.is_driven() {
            return Ok(None);
        }
        self.silent_ticks = self.silent_ticks.saturating_add(1);
        if self.silent_ticks > self.protection.bus_silent_ticks {
            return Err(JointFault::OfBoard(Fault::BusSilent));
        }
        if self.state == JointBoardState::Service {
            self.pair.serve(&measured)?;
            return Ok(Some(Asked { commands: self.pressures, command: None }));
        }
        let (Some(installed), Some(running)) = (&self.installed, &mut self.running) else {
            return Ok(None);
        };
        let (control, target) = match &mut running.start {
            // A weight that the host knows of hangs there already.
            Some(start) => (&installed.open, JointTarget { load: self.aimed.load(), ..start.target() }),
            None => (&installed.control, self.aimed.at(self.ticks)),
        };
        let command = joint_step(black_box(control), &mut running.state, &target, measured.angle)
            .map_err(|_| JointFault::OfBoard(Fault::NotFinite))?;
        let [a, b] = command.commands;
        if !(a + b).is_finite() {
            return Err(JointFault::OfBoard(Fault::NotFinite));
        }
        if running.start.is_none() {
            let made = (&command, target.load);
            self.pair.track(&installed.control, &installed.moved, &measured, made)?;
        }
        if let Some(start) = &mut running.start
            && start.take(&measured, command.commands)?
        {
            running.start = None;
            self.state = JointBoardState::Tracking;
            // Until the host says otherwise it stays where the start has left it.
            let angle = running.state.due();
            self.aimed = Aimed::still(JointTarget { angle, ..target });
        }
        Ok(Some(Asked { commands: command.commands, command: Some(command) }))
    }

    /// Goes to a state in which nothing is driven. The next write, in this tick if it is still to
    /// come, vents.
    fn leave(&mut self, state: JointBoardState) {
        self.state = state;
        self.running = None;
        self.pressures = [0.0; 2];
        self.armed_ticks = 0;
    }

    /// Where it rests, vented: by whether it has a joint.
    fn home(&self) -> JointBoardState {
        if self.installed.is_some() { JointBoardState::Ready } else { JointBoardState::Off }
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

/// Whether nothing but power-off ends a fault.
fn is_for_good(fault: &JointFault) -> bool {
    matches!(fault, JointFault::OfBoard(fault) if fault.outlasts_acknowledgement())
}

/// The code of a command in bar.
fn command_code(bar: f32) -> DacCode {
    if bar > 0.0 { DacCode(COMMAND.code(bar)) } else { VENT }
}
