//! The tick and the state machine around it.
//!
//! | state | valve | Install | Start | SetMode | Stop | fault in a tick |
//! |---|---|---|---|---|---|---|
//! | Off | vented | Ready | refused | refused | Off | (not looked for) |
//! | Ready | vented | Ready | Tracking | refused | Ready | (not looked for) |
//! | Tracking | driven | refused | refused | Tracking | Ready | Fault |
//! | Fault | vented | Ready | refused | refused | Fault | Fault |
//!
//! # Contract
//! One [`Control::tick`] each period of the installed controller. It reads the board once and writes the
//! valve once, in every state. It takes bounded time, allocates nothing and does not panic.

use model_core::{Measured, Mode, TrackingState};
use wire::{Fault, Flags, Hello, PLAYS, Refusal, Response, State, TickReply, VERSION};

use crate::board::{Board, DacCode, Samples};
use crate::law::controller_step;
use crate::order::{BoardTracking, Order};
use crate::scaling::{COMMAND, CONTRACTION, PRESSURE, VENT};

/// The owner of the tick.
#[derive(Debug, Default)]
pub struct Control {
    tracking: Option<BoardTracking>,
    running: Option<Running>,
    fault: Option<Fault>,
    reference_mm: f32,
    ticks: u32,
    overruns: u32,
    overrun: bool,
}

#[derive(Debug)]
struct Running {
    mode: Mode,
    state: TrackingState<f32, PLAYS>,
}

impl Control {
    /// A control without a controller, vented.
    pub const fn new() -> Self {
        Self {
            tracking: None,
            running: None,
            fault: None,
            reference_mm: 0.0,
            ticks: 0,
            overruns: 0,
            overrun: false,
        }
    }

    /// The state of the table above.
    pub fn state(&self) -> State {
        match (&self.fault, &self.tracking, &self.running) {
            (Some(_), _, _) => State::Fault,
            (None, _, Some(_)) => State::Tracking,
            (None, Some(_), None) => State::Ready,
            (None, None, None) => State::Off,
        }
    }

    /// Carries an order out, or says why not.
    pub fn apply(&mut self, order: Order) -> Response {
        let state = self.state();
        match (order, state) {
            (Order::Identify, _) => return Response::Hello(self.hello()),
            (Order::Install(tracking), State::Off | State::Ready | State::Fault) => {
                self.tracking = Some(tracking);
                self.fault = None;
            }
            (Order::Start(mode), State::Ready) => {
                self.running = self.tracking.as_ref().map(|t| Running { mode, state: t.rest_state(mode) });
            }
            (Order::SetMode(mode), State::Tracking) => {
                self.running.iter_mut().for_each(|running| running.mode = mode);
            }
            (Order::Stop, _) => self.running = None,
            (Order::Reference(reference_mm), _) => self.reference_mm = reference_mm,
            (Order::Install(_) | Order::Start(_) | Order::SetMode(_), _) => {
                return Response::Refused(Refusal::WrongState(state));
            }
        }
        Response::Accepted
    }

    /// One tick: samples, computes, drives.
    pub fn tick<B: Board>(&mut self, board: &mut B) -> TickReply {
        self.ticks = self.ticks.wrapping_add(1);
        let samples = board.read().map_err(|_| Fault::Acquisition);
        let mut reply = self.track(samples).unwrap_or_else(|fault| {
            self.running = None;
            self.fault = Some(fault);
            VENTED
        });
        board.drive(DacCode(reply.dac_code));
        reply.flags = reply
            .flags
            .with(Flags::TRACKING, self.running.is_some())
            .with(Flags::FAULT, self.fault.is_some())
            .with(Flags::OVERRUN, core::mem::take(&mut self.overrun));
        reply
    }

    /// Notes that a tick was due before the one before had ended.
    pub fn note_overrun(&mut self) {
        self.overruns = self.overruns.wrapping_add(1);
        self.overrun = true;
    }

    fn track(&mut self, samples: Result<Samples, Fault>) -> Result<TickReply, Fault> {
        let (Some(tracking), Some(running)) = (&self.tracking, &mut self.running) else {
            return Ok(VENTED);
        };
        let Samples { pressure, contraction, surroundings } = samples?;
        if !PRESSURE.is_plausible(pressure.0) {
            return Err(Fault::PressureSensor);
        }
        if !CONTRACTION.is_plausible(contraction.0) {
            return Err(Fault::ContractionSensor);
        }
        let measured = Measured { contraction: CONTRACTION.value(contraction.0), surroundings };
        let command =
            controller_step(tracking, &mut running.state, running.mode, self.reference_mm, measured)
                .map_err(|_| Fault::Reference)?;
        Ok(TickReply {
            dac_code: COMMAND.code(command.command),
            feedforward_bar: command.feedforward,
            feedback_bar: command.feedback,
            flags: Flags::default().with(Flags::LIMITED, command.limited),
        })
    }

    fn hello(&self) -> Hello {
        Hello {
            version: VERSION,
            firmware: FIRMWARE_VERSION,
            state: self.state(),
            fault: self.fault,
            pressure: PRESSURE,
            contraction: CONTRACTION,
            command: COMMAND,
            ticks: self.ticks,
            overruns: self.overruns,
        }
    }
}

/// The reply of a tick that did not drive the valve.
const VENTED: TickReply =
    TickReply { dac_code: VENT.0, feedforward_bar: 0.0, feedback_bar: 0.0, flags: Flags(0) };

/// Major, minor and patch of the package's version.
const FIRMWARE_VERSION: [u16; 3] = [
    number(env!("CARGO_PKG_VERSION_MAJOR")),
    number(env!("CARGO_PKG_VERSION_MINOR")),
    number(env!("CARGO_PKG_VERSION_PATCH")),
];

/// The value of a string of digits, at compile time.
const fn number(digits: &str) -> u16 {
    let digits = digits.as_bytes();
    let mut value = 0;
    let mut i = 0;
    while i < digits.len() {
        value = value * 10 + (digits[i] - b'0') as u16;
        i += 1;
    }
    value
}
