//! The orders of the host, carried out between ticks.

use model_core::Mode;
use wire::registers::ARMED_TICKS;
use wire::{Fault, Protection, Refusal, Response};

use super::{Control, Running};
use crate::adaptation::Adaptation;
use crate::board::DacCode;
use crate::law::{controller_asked, controller_prepare};
use crate::monitors::Monitors;
use crate::order::{Installation, Order};
use crate::output;
use crate::scaling::Scalings;
use crate::state_machine::{Event, Next, next};
use crate::store::Sealed;

impl Control {
    /// Carries an order out, or says why not.
    // Not inlined: what it needs of the stack is then not needed while an order is prepared.
    #[inline(never)]
    pub fn apply(&mut self, order: Order) -> Response {
        let done = match order {
            Order::Identify => return Response::Hello(self.hello()),
            Order::Telemetry => return Response::Telemetry(self.telemetry()),
            Order::FaultRecord => return Response::FaultRecord(self.faults.record()),
            Order::Capture(order) => {
                return self.capture.apply(order).map_or(Response::Accepted, Response::Captured);
            }
            Order::Reference(reference_mm) => {
                self.next_reference_mm = reference_mm;
                Ok(())
            }
            Order::Protect(protection) => self.protect(protection),
            Order::Install(installation) => self.install(installation),
            Order::Start(mode) => self.start(mode),
            Order::SetMode(mode) => self.set_mode(mode),
            Order::Stop => self.advance(Event::Stop),
            Order::Acknowledge => self.acknowledge(),
            Order::Service(code) => self.service(code),
            Order::Arm => self.advance(Event::Arm).map(|()| self.armed_ticks = ARMED_TICKS),
            Order::Heartbeat(number) => {
                self.beat(number);
                Ok(())
            }
        };
        done.map_or_else(Response::Refused, |()| Response::Accepted)
    }

    fn protect(&mut self, protection: Protection) -> Result<(), Refusal> {
        if self.state.is_driven() {
            return Err(Refusal::WrongState(self.state));
        }
        self.protection = protection;
        self.scale();
        Ok(())
    }

    /// Takes other scalings; the valve must be vented.
    ///
    /// # Errors
    /// It is driven.
    pub fn calibrate(&mut self, scalings: &Scalings) -> Result<(), Refusal> {
        if self.state.is_driven() {
            return Err(Refusal::WrongState(self.state));
        }
        self.scalings = *scalings;
        self.scale();
        Ok(())
    }

    /// Takes a calibration that was kept. One that is damaged, or that no working sensor has, is a
    /// fault: the scalings stay those of the standard sensors.
    pub fn recall(&mut self, kept: &Sealed) {
        let done = kept
            .open()
            .and_then(|calibration| Scalings::calibrated(calibration).ok())
            .and_then(|scalings| self.calibrate(&scalings).ok());
        if done.is_none() {
            self.report(Fault::CalibrationCorrupt);
        }
    }

    /// Turns the protection's limits into those of a tick.
    fn scale(&mut self) {
        let period_s = self.period_s();
        self.monitors = Monitors::new(&self.protection, &self.scalings, period_s);
        self.limits = output::Limits::new(&self.protection, &self.scalings.command, period_s);
    }

    fn install(&mut self, installation: Installation) -> Result<(), Refusal> {
        self.clock.map_or(Ok(()), |clock| clock.demand(installation.period_s))?;
        self.demand(Event::Install)?;
        let inverse = installation.tracking.inverse();
        if self.installed.as_ref().is_none_or(|installed| installed.tracking.inverse() != inverse) {
            self.adaptation = Adaptation::default();
        }
        self.installed = Some(installation);
        self.scale();
        self.advance(Event::Install)
    }

    /// Whether the state takes an event, for what has to be known before it is done.
    fn demand(&self, event: Event) -> Result<(), Refusal> {
        if next(self.state, event) == Next::Refused { Err(Refusal::WrongState(self.state)) } else { Ok(()) }
    }

    fn start(&mut self, mode: Mode) -> Result<(), Refusal> {
        let event = if mode == Mode::Hold { Event::Hold } else { Event::Start };
        self.demand(event)?;
        self.demand_armed()?;
        let mode = self.permitted(mode)?;
        let asked_mm = match (&self.installed, self.adaptation.acting()) {
            (Some(Installation { tracking, .. }), Some(adapted)) => {
                controller_asked(tracking, adapted, self.next_reference_mm)
            }
            _ => self.next_reference_mm,
        };
        let installed = self.installed.as_ref();
        let running = installed.map(|installed| self.running(installed, mode, asked_mm)).transpose()?;
        self.advance(event)?;
        self.monitors.restart();
        self.running = running;
        Ok(())
    }

    fn service(&mut self, code: u16) -> Result<(), Refusal> {
        self.demand(Event::Service)?;
        if !self.state.is_driven() {
            self.demand_armed()?;
        }
        self.advance(Event::Service).map(|()| self.service_code = DacCode(code))
    }

    /// The valve is opened in two steps.
    fn demand_armed(&self) -> Result<(), Refusal> {
        if self.armed_ticks > 0 { Ok(()) } else { Err(Refusal::NotArmed) }
    }

    /// The controller at rest, its first tick prepared.
    fn running(&self, installed: &Installation, mode: Mode, asked_mm: f32) -> Result<Running, Refusal> {
        let mut state = installed.tracking.rest_state(mode);
        let reference_mm = self.next_reference_mm;
        let surroundings = &self.monitors.samples().surroundings;
        controller_prepare(&installed.tracking, &mut state, (asked_mm, reference_mm), surroundings)
            .map(|prepared| Running { mode, state, prepared })
            .map_err(|_| {
                Refusal::parameter(format_args!("the reference is {reference_mm} mm, must be finite"))
            })
    }

    fn set_mode(&mut self, mode: Mode) -> Result<(), Refusal> {
        let event = if mode == Mode::Hold { Event::Hold } else { Event::SetMode };
        let mode = self.permitted(mode)?;
        self.advance(event)?;
        self.running.iter_mut().for_each(|running| running.mode = mode);
        Ok(())
    }

    /// What becomes of a mode if the installed model has not stood its test.
    fn permitted(&self, mode: Mode) -> Result<Mode, Refusal> {
        let is_good = self.installed.as_ref().is_none_or(|installed| installed.survey.is_invertible);
        match mode {
            Mode::Both if !is_good => Ok(Mode::FeedbackOnly),
            Mode::FeedforwardOnly if !is_good => {
                Err(Refusal::parameter(format_args!("the model has not stood its test: feedback only")))
            }
            mode => Ok(mode),
        }
    }

    fn acknowledge(&mut self) -> Result<(), Refusal> {
        if !self.faults.acknowledge() {
            return Err(Refusal::WrongState(self.state));
        }
        self.advance(Event::Acknowledge)
    }
}
