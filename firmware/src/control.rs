//! The tick, and the orders between ticks.
//!
//! [`crate::state_machine`] tells which order is taken when, [`crate::faults`] what happens when
//! something is wrong; the orders are in `control/orders.rs`.
//!
//! # Contract
//! One [`Control::tick`] each period of the installed controller. It reads the board once and
//! writes the valve, in every state: the vented code in all but `Tracking`, `Holding` and
//! `Service`. What a sample or a computed value shows at once keeps a code from the valve; what
//! takes several ticks to be seen is looked at behind the write, so that the valve does not wait
//! for it, and takes the code back in the same tick by a second write. It takes bounded time,
//! allocates nothing and does not panic.
//!
//! Behind the write, too, the feed-forward of the next tick is prepared, since it needs nothing
//! that is measured then. So the reference of a tick is the last one that was given before the tick
//! before it ended, and load and temperature are a tick old: who knows the course of the reference
//! gives it a tick ahead, and loses nothing.

mod orders;

use core::hint::black_box;

use model_core::tracking::{Command, Prepared};
use model_core::{Mode, TrackingState};
use wire::fault::times::{DUMP_TICKS, STOP_TICKS};
use wire::{CaptureSample, Fault, OnModelFault, PLAYS, Protection, Refusal, State, TraceEntry};

use crate::adaptation::{Adaptation, Told};
use crate::board::{AcquisitionError, Board, DacCode, Samples};
use crate::bus::player::Player;
use crate::capture::Capture;
use crate::faults::black_box::BlackBox;
use crate::faults::log::FaultLog;
use crate::law::{controller_act, controller_asked, controller_learn, controller_prepare};
use crate::monitors::Monitors;
use crate::monitors::persistence::InARow;
use crate::order::Installation;
use crate::output::{self, Output};
use crate::scaling::{Scalings, VENT};
use crate::state_machine::{Event, Next, next};
use crate::timing::{TickEnd, Timing};

/// How long a board has to run for the resets before to be forgotten. Unit: tick.
pub(crate) const SETTLED_TICKS: u32 = 10_000;

/// The period of ticks that neither a clock nor a configuration tells. Unit: s.
pub(crate) const UNCLOCKED_PERIOD_S: f32 = 1e-3;

/// The clock that raises the ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TickClock {
    /// Unit: s.
    pub period_s: f32,
    /// When the valve has to be written, after the tick is due. Unit: core clock cycle.
    pub deadline_cycles: u32,
}

impl TickClock {
    /// Whether a controller is one for it. `period_s`: of the controller.
    ///
    /// # Errors
    /// It is for ticks of another period.
    pub(crate) fn demand(self, period_s: f32) -> Result<(), Refusal> {
        if (period_s - self.period_s).abs() <= 1e-3 * self.period_s {
            return Ok(());
        }
        let due = self.period_s;
        Err(Refusal::parameter(format_args!("period_s is {period_s} s, must be {due} s")))
    }
}

/// The owner of the tick.
// In this order: what every tick needs stands first, where short addresses reach.
#[derive(Debug)]
#[repr(C)]
pub struct Control {
    pub(crate) state: State,
    pub(crate) monitors: Monitors,
    limits: output::Limits,
    pub(crate) output: Output,
    pub(crate) ticks: u32,
    /// Since the host's last sign of life.
    silent_ticks: u32,
    /// How long a start is still taken.
    pub(crate) armed_ticks: u16,
    /// The last number that the host has told; none before the first.
    pub(crate) heartbeat: Option<u16>,
    /// It has come again since the host's last sign of life.
    is_heartbeat_repeated: bool,
    /// Of this tick.
    pub(crate) reference_mm: f32,
    /// Of the ticks to come.
    pub(crate) next_reference_mm: f32,
    pub(crate) service_code: DacCode,
    overrun: bool,
    stop: InARow,
    /// The dump valve's coil has a voltage, and its output rests.
    held: InARow,
    pub(crate) limited_ticks: u32,
    self_test_ticks: u32,
    pub(crate) timing: Timing,
    pub(crate) faults: FaultLog,
    pub(crate) capture: &'static mut Capture,
    /// None: ticks come when the host wants them, at whatever period the configuration says.
    pub(crate) clock: Option<TickClock>,
    pub(crate) protection: Protection,
    pub(crate) scalings: Scalings,
    running: Option<Running>,
    installed: Option<Installation>,
    pub(crate) player: Player,
    pub(crate) adaptation: Adaptation,
    /// Of a single conversion of pressure and contraction, one standard deviation. Unit: code.
    pub(crate) noise_codes: [f32; 2],
}

#[derive(Debug)]
struct Running {
    mode: Mode,
    state: TrackingState<f32, PLAYS>,
    /// Of the next tick.
    prepared: Prepared<f32>,
}

/// What a tick has done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TickOutcome {
    /// What was written to the valve.
    pub code: DacCode,
    /// The feed-forward part of the command. Unit: bar.
    pub feedforward_bar: f32,
    /// The feedback part of the command. Unit: bar.
    pub feedback_bar: f32,
    /// A limit or the slew rate changed the command.
    pub is_limited: bool,
    /// The controller drives the valve.
    pub is_tracking: bool,
    /// A fault is latched; the valve is vented.
    pub is_at_fault: bool,
    /// This tick found the one before unfinished.
    pub is_overrun: bool,
}

/// The outcome of a tick that does not drive the valve.
const VENTED: TickOutcome = TickOutcome {
    code: VENT,
    feedforward_bar: 0.0,
    feedback_bar: 0.0,
    is_limited: false,
    is_tracking: false,
    is_at_fault: false,
    is_overrun: false,
};

impl Control {
    /// A control without a controller, vented; at fault, if the black box says that the board has
    /// started after one.
    pub fn new(
        protection: Protection,
        clock: Option<TickClock>,
        black_box: &'static mut BlackBox,
        capture: &'static mut Capture,
    ) -> Self {
        let faults = FaultLog::new(black_box);
        let period_s = clock.map_or(UNCLOCKED_PERIOD_S, |clock| clock.period_s);
        Self {
            clock,
            state: if faults.latched().is_some() { State::Fault } else { State::Off },
            protection,
            scalings: Scalings::STANDARD,
            installed: None,
            running: None,
            monitors: Monitors::new(&protection, &Scalings::STANDARD, period_s),
            limits: output::Limits::new(&protection, &Scalings::STANDARD.command, period_s),
            output: Output::vented(),
            faults,
            capture,
            timing: Timing::default(),
            ticks: 0,
            limited_ticks: 0,
            self_test_ticks: 0,
            silent_ticks: 0,
            armed_ticks: 0,
            heartbeat: None,
            is_heartbeat_repeated: false,
            reference_mm: 0.0,
            next_reference_mm: 0.0,
            service_code: VENT,
            overrun: false,
            stop: InARow::default(),
            held: InARow::default(),
            player: Player::new(),
            adaptation: Adaptation::default(),
            noise_codes: [0.0; 2],
        }
    }

    /// The control of a board whose muscle is a simulation.
    pub fn simulated(black_box: &'static mut BlackBox, capture: &'static mut Capture) -> Self {
        Self::new(Protection::SIMULATED, None, black_box, capture)
    }

    /// What outlives the program, when it ends.
    pub fn into_memory(self) -> (&'static mut BlackBox, &'static mut Capture) {
        (self.faults.into_black_box(), self.capture)
    }

    /// The board's state.
    pub fn state(&self) -> State {
        self.state
    }

    /// Ticks since the start.
    pub fn ticks(&self) -> u32 {
        self.ticks
    }

    /// How codes are scaled.
    pub fn scalings(&self) -> &Scalings {
        &self.scalings
    }

    /// Time from tick to tick, by the clock or, without one, by the configuration. Unit: s.
    pub(crate) fn period_s(&self) -> f32 {
        let of_installation = || self.installed.as_ref().map(|installed| installed.period_s);
        self.clock.map(|clock| clock.period_s).or_else(of_installation).unwrap_or(UNCLOCKED_PERIOD_S)
    }

    /// What the board has learnt of its muscle.
    pub fn learnt(&self) -> Told {
        self.adaptation.told(self.installed.as_ref().map(|installed| installed.tracking.adapter()))
    }

    /// What the board learns of its muscle.
    pub fn adaptation(&mut self) -> &mut Adaptation {
        &mut self.adaptation
    }

    /// The fault that is latched.
    pub fn fault(&self) -> Option<Fault> {
        self.faults.latched()
    }

    /// One tick: samples, computes, drives.
    pub fn tick<B: Board>(&mut self, board: &mut B) -> TickOutcome {
        self.ticks = self.ticks.wrapping_add(1);
        let before = self.output.code();
        let mut outcome = self.work(board.read()).unwrap_or_else(|fault| {
            self.report(fault);
            VENTED
        });
        let asked = outcome.code;
        outcome.code =
            if self.state.is_driven() { self.output.drive(&self.limits, asked) } else { self.output.vent() };
        board.drive(outcome.code);
        outcome.is_limited |= outcome.code != asked;
        let reference_mm = self.reference_mm;
        // The valve has its code in time; what is looked at from here on can only take it back.
        let watched = self.watch(before, outcome.feedback_bar).and_then(|()| self.learn(&outcome));
        if let Err(fault) = watched.and_then(|()| self.prepare()) {
            self.report(fault);
            outcome = TickOutcome { code: self.output.vent(), ..VENTED };
            board.drive(outcome.code);
        }
        self.armed_ticks = self.armed_ticks.saturating_sub(1);
        outcome.is_tracking = self.running.is_some();
        outcome.is_at_fault = self.faults.latched().is_some();
        outcome.is_overrun = core::mem::take(&mut self.overrun);
        self.record(&outcome, reference_mm);
        outcome
    }

    /// Takes the next tick's set point from the player, if it plays.
    #[inline(always)]
    fn play(&mut self) {
        match self.player.next(self.ticks.wrapping_add(1)) {
            Some(bar) if self.state == State::Service => self.service_code = self.scalings.command_code(bar),
            Some(mm) => self.next_reference_mm = mm,
            None => {}
        }
    }

    /// Looks at what takes several ticks to be seen. `before`: what was out until this tick.
    fn watch(&mut self, before: DacCode, feedback_bar: f32) -> Result<(), Fault> {
        if self.state != State::Fault {
            self.monitors.watch_own(before)?;
        }
        if self.state == State::Off {
            return Ok(());
        }
        self.monitors.watch_venting(self.state.is_driven())?;
        if self.state == State::Fault {
            return Ok(());
        }
        let outermost = self.installed.as_ref().map(|installed| &installed.survey.outermost);
        self.monitors.watch(before, outermost, self.state.is_driven())?;
        if !self.state.is_driven() {
            return Ok(());
        }
        let has_both = self.running.as_ref().is_some_and(|running| running.mode == Mode::Both);
        self.monitors.judge(if has_both { feedback_bar } else { 0.0 })?;
        self.silent_ticks = self.silent_ticks.saturating_add(1);
        match (self.silent_ticks > self.protection.bus_silent_ticks, self.is_heartbeat_repeated) {
            (false, _) => Ok(()),
            (true, false) => Err(Fault::BusSilent),
            (true, true) => Err(Fault::HeartbeatStands),
        }
    }

    /// Learns from the tick, if that is switched on.
    ///
    /// # Errors
    /// The muscle has left what may be learnt.
    #[inline(always)]
    fn learn(&mut self, outcome: &TickOutcome) -> Result<(), Fault> {
        let Some((adapted, is_new)) = self.adaptation.learner(self.monitors.bridged()) else {
            return Ok(());
        };
        let (Some(Installation { tracking, .. }), Some(running)) = (&self.installed, &self.running) else {
            adapted.interrupt();
            return Ok(());
        };
        let pressure_bar = self.scalings.pressure.value(self.monitors.samples().pressure.0);
        let command_bar = self.scalings.command.value(outcome.code.0);
        let follows = (command_bar - pressure_bar).abs() <= self.protection.following_band_bar;
        let is_trusted = is_new && follows && !outcome.is_limited;
        let Running { state, prepared, .. } = running;
        controller_learn(tracking, state, prepared, is_trusted, adapted);
        if adapted.is_beyond() { Err(Fault::Adaptation) } else { Ok(()) }
    }

    /// Does what the next tick can do without its samples.
    fn prepare(&mut self) -> Result<(), Fault> {
        self.play();
        self.reference_mm = self.next_reference_mm;
        let (Some(Installation { tracking, .. }), Some(running)) = (&self.installed, &mut self.running)
        else {
            return Ok(());
        };
        let surroundings = &self.monitors.samples().surroundings;
        // As in `track`.
        let (tracking, state) = (black_box(tracking), black_box(&mut running.state));
        let asked_mm = match self.adaptation.acting() {
            Some(adapted) => controller_asked(tracking, adapted, self.reference_mm),
            None => self.reference_mm,
        };
        running.prepared = controller_prepare(tracking, state, (asked_mm, self.reference_mm), surroundings)
            .map_err(|_| Fault::Reference)?;
        Ok(())
    }

    /// Takes how long the tick has taken, by a clock of the image.
    pub fn close_tick(&mut self, end: TickEnd) {
        self.overrun = end.is_overrun;
        let deadline = self.clock.map_or(u32::MAX, |clock| clock.deadline_cycles);
        if self.timing.take(end, deadline) && self.state.is_driven() {
            self.report(Fault::Deadline);
        }
    }

    /// Takes a fault that something else than the samples has shown; the next tick vents. One that
    /// is latched already is nothing new.
    pub fn report(&mut self, fault: Fault) {
        if self.fault() == Some(fault) {
            return;
        }
        self.faults.latch(fault, self.ticks);
        self.capture.stop();
        // Nothing refuses this event.
        let _ = self.enter(Event::Trip);
    }

    /// Takes what the emergency stop reads back: whether its contacts are open. One sample may be a
    /// spark.
    pub fn hear_stop(&mut self, is_open: bool) {
        if self.stop.holds_for(STOP_TICKS, is_open) {
            self.report(Fault::EmergencyStop);
        }
    }

    /// Takes whether the dump valve's coil has a voltage, which it must not have where the output
    /// that holds it rests. Counted again as long as that lasts.
    pub fn hear_coil(&mut self, has_voltage: bool) {
        if self.held.holds_for(DUMP_TICKS, has_voltage && !self.keeps_dump_closed()) {
            self.held = InARow::default();
            self.report(Fault::DumpHeld);
        }
    }

    /// Whether the dump valve behind the regulator is to be kept closed, tick by tick. It opens
    /// without that: at a fault, before a configuration and in its self-test, where its coil is
    /// looked at, and with a program that stands still.
    pub fn keeps_dump_closed(&self) -> bool {
        !matches!(self.state, State::Off | State::SelfTest | State::Fault)
    }

    /// Takes the host's heartbeat. The number before says nothing of it: whatever stands between
    /// host and board may repeat that.
    pub fn beat(&mut self, number: u16) {
        if self.heartbeat.replace(number) == Some(number) {
            self.is_heartbeat_repeated = true;
        } else {
            self.live();
        }
    }

    /// Takes a sign of life of the host.
    pub(crate) fn live(&mut self) {
        self.silent_ticks = 0;
        self.is_heartbeat_repeated = false;
    }

    /// Whether there is a muscle behind the valve: ticks have a clock of their own. Else it is a
    /// simulation.
    pub fn has_muscle(&self) -> bool {
        self.clock.is_some()
    }

    /// Takes the noise of the converter, of pressure and contraction (code).
    pub fn hear_noise(&mut self, codes: [f32; 2]) {
        self.noise_codes = codes;
    }

    /// Takes a fault that is only to be known of.
    pub fn note(&mut self, fault: Fault) {
        self.faults.count(fault);
    }

    /// Goes to the next state, and does what it begins with.
    fn advance(&mut self, event: Event) -> Result<(), Refusal> {
        self.enter(event)?;
        if self.state == State::SelfTest {
            self.monitors.restart();
            self.self_test_ticks = self.protection.self_test_ticks;
            if self.self_test_ticks == 0 {
                self.end_self_test().unwrap_or_else(|fault| self.report(fault));
            }
        }
        Ok(())
    }

    /// Goes to the next state, and ends what it has no place for.
    fn enter(&mut self, event: Event) -> Result<(), Refusal> {
        let was_driven = self.state.is_driven();
        self.state = match next(self.state, event) {
            Next::To(state) => state,
            Next::Home if self.installed.is_some() => State::SelfTest,
            Next::Home => State::Off,
            Next::Refused => return Err(Refusal::WrongState(self.state)),
        };
        // Whatever else is ordered, or goes wrong, between the two steps of a start ends it.
        self.armed_ticks = 0;
        if !was_driven {
            // Silence counts from the start on.
            self.live();
        }
        if !self.state.is_driven() {
            self.running = None;
            self.service_code = VENT;
            self.player.clear();
        }
        Ok(())
    }

    /// What the samples of a tick lead to.
    fn work(&mut self, samples: Result<Samples, AcquisitionError>) -> Result<TickOutcome, Fault> {
        if matches!(self.state, State::Off | State::Fault) {
            self.monitors.look(samples);
            return Ok(VENTED);
        }
        let contraction_mm = self.monitors.take(samples)?;
        match self.state {
            State::Tracking | State::Holding => self.track(contraction_mm),
            State::Service => Ok(TickOutcome { code: self.service_code, ..VENTED }),
            State::SelfTest => self.self_test().map(|()| VENTED),
            State::Off | State::Ready | State::Fault => Ok(VENTED),
        }
    }

    fn track(&mut self, contraction_mm: f32) -> Result<TickOutcome, Fault> {
        let (Some(Installation { tracking, .. }), Some(running)) = (&self.installed, &mut self.running)
        else {
            return Ok(VENTED);
        };
        let Running { mode, state, prepared } = running;
        // Behind pointers that the compiler knows nothing of: it would else reach each number of
        // the static control by its whole address, by two instructions more than from a register.
        let (tracking, state) = (black_box(tracking), black_box(state));
        let command = controller_act(tracking, state, *mode, *prepared, contraction_mm)
            .map_err(|_| Fault::NotFinite)?;
        let Command { command, feedforward, feedback, limited } = command;
        if !(feedforward + feedback + command).is_finite() {
            return Err(Fault::NotFinite);
        }
        Ok(TickOutcome {
            code: self.scalings.command_code(command),
            feedforward_bar: feedforward,
            feedback_bar: feedback,
            is_limited: limited,
            ..VENTED
        })
    }

    fn self_test(&mut self) -> Result<(), Fault> {
        self.self_test_ticks = self.self_test_ticks.saturating_sub(1);
        if self.self_test_ticks > 0 {
            return Ok(());
        }
        self.monitors.is_vented()?;
        self.end_self_test()
    }

    fn end_self_test(&mut self) -> Result<(), Fault> {
        if self.installed.as_ref().is_some_and(|installed| !installed.survey.is_invertible) {
            match self.protection.on_model_fault {
                OnModelFault::Vent => return Err(Fault::Model),
                OnModelFault::FeedbackOnly => self.note(Fault::Model),
            }
        }
        // The only state that this is called in takes the event.
        let _ = self.enter(Event::Tested);
        Ok(())
    }

    /// Leaves the tick in trace, capture and counters.
    fn record(&mut self, outcome: &TickOutcome, reference_mm: f32) {
        let Samples { pressure, contraction, supply, .. } = self.monitors.samples();
        self.limited_ticks = self.limited_ticks.wrapping_add(outcome.is_limited.into());
        self.faults.note(TraceEntry {
            tick: self.ticks,
            pressure_code: pressure.0,
            contraction_code: contraction.0,
            supply_code: supply.0,
            dac_code: outcome.code.0,
            reference_64th_mm: (64.0 * reference_mm) as i16,
        });
        self.capture.take(
            self.ticks,
            CaptureSample {
                reference_mm,
                pressure_code: pressure.0,
                contraction_code: contraction.0,
                dac_code: outcome.code.0,
                feedback_4096th_bar: (4096.0 * outcome.feedback_bar) as i16,
            },
        );
        if self.ticks == SETTLED_TICKS {
            self.faults.settle();
        }
    }
}
