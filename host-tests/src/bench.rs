//! A board on a bench: the control code as the production image runs it, tick by tick, with a
//! muscle that is the paper's model behind a valve with a lag, and with everything at hand that can
//! go wrong.

use firmware::faults::black_box::Reset;
use firmware::order::prepare;
use firmware::scaling::{COMMAND, CONTRACTION, PRESSURE, REFERENCE_CODE, SUPPLY, TEMPERATURE, VENT};
use firmware::timing::TickEnd;
use firmware::watchdog::{CheckIns, Task, Watchdog};
use firmware::{AcquisitionError, AdcCode, BlackBox, Board, Capture, Control, DacCode, Samples, TickClock};
use model_core::{Hysteresis, HysteresisState, Mgpi, Mode, Surroundings, paper};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use wire::{Configuration, Fault, Protection, Request, Response, State};

use crate::PERIOD_S;

/// Lag of the pressure behind the command. Unit: s.
const LAG_S: f64 = 0.05;
/// Of the period, in which the valve has to be written. Unit: core clock cycle.
const DEADLINE_CYCLES: u32 = 84_000;

/// What is wrong, from a tick on.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wrong {
    /// Whether the converter has stopped.
    pub no_samples: bool,
    /// The raw code of an input instead of its own.
    pub pressure_code: Option<u16>,
    /// As above.
    pub contraction_code: Option<u16>,
    /// As above.
    pub supply_code: Option<u16>,
    /// As above.
    pub temperature_code: Option<u16>,
    /// Added to the measured pressure. Unit: bar.
    pub pressure_bar: f64,
    /// Added to the measured contraction. Unit: mm.
    pub contraction_mm: f64,
    /// The share of the command that becomes pressure, less one: -1 is a burst.
    pub leak: f64,
    /// The valve stays at this pressure. Unit: bar.
    pub valve_bar: Option<f64>,
    /// Whether ticks take too long.
    pub is_late: bool,
    /// A task that stands still.
    pub silent: Option<Task>,
    /// Whether the host has gone.
    pub no_host: bool,
    /// Whether what sends for the host goes on, and its program stands.
    pub is_host_stuck: bool,
    /// Whether the emergency stop is pressed.
    pub is_stopped: bool,
    /// Whether the voltage is low.
    pub low_voltage: bool,
    /// What the valve's output reads back in place of its own code.
    pub output_code: Option<u16>,
    /// What the reference voltage reads in place of its own code.
    pub reference_code: Option<u16>,
    /// Whether the dump valve's coil has a voltage all the time.
    pub is_coil_held: bool,
}

/// The bench.
pub struct Bench {
    /// None only within a reset.
    control: Option<Control>,
    /// What is wrong.
    pub wrong: Wrong,
    /// What the host asks for. Unit: mm.
    pub reference_mm: f64,
    heartbeat: u16,
    inputs: Inputs,
    check_ins: CheckIns,
    watchdog: Watchdog,
    muscle: Mgpi<f64, { paper::SIZE }, { paper::SIZE }>,
    memory: HysteresisState<f64, { paper::SIZE }>,
    pressure_bar: f64,
    contraction_mm: f64,
    noise: ChaCha8Rng,
}

/// The board's converters.
#[derive(Default)]
struct Inputs {
    samples: Option<Samples>,
    output: DacCode,
}

impl Board for Inputs {
    fn read(&mut self) -> Result<Samples, AcquisitionError> {
        self.samples.ok_or(AcquisitionError)
    }

    fn drive(&mut self, code: DacCode) {
        self.output = code;
    }
}

impl Bench {
    /// A board after power-on.
    ///
    /// # Panics
    /// Never: the paper's model is valid.
    pub fn new(seed: u64) -> Self {
        let muscle = paper::mgpi().and_then(|parameters| Mgpi::try_new(&parameters)).expect("valid");
        let memory = muscle.rest_state();
        Self {
            // The control keeps both for as long as the board runs.
            control: Some(control(Box::leak(Box::default()), Box::leak(Box::default()), Reset::PowerOn)),
            wrong: Wrong::default(),
            reference_mm: 0.0,
            heartbeat: 0,
            inputs: Inputs::default(),
            check_ins: CheckIns::new(),
            watchdog: Watchdog::default(),
            muscle,
            memory,
            pressure_bar: 0.0,
            contraction_mm: 0.0,
            noise: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    /// Sends a request and answers the response.
    pub fn request(&mut self, request: &Request) -> Response {
        prepare(request).map_or_else(Response::Refused, |order| self.control().apply(order))
    }

    /// Sends a request that has to be accepted.
    ///
    /// # Panics
    /// It is not.
    pub fn demand(&mut self, request: &Request) {
        let response = self.request(request);
        let state = self.state();
        assert_eq!(response, Response::Accepted, "{request:?} in state {state:?}");
    }

    /// Configures the board, lets it test itself, and starts tracking.
    pub fn start(&mut self, protection: Protection, configuration: &Configuration, mode: Mode) {
        self.demand(&Request::Protect(protection));
        self.demand(&Request::Configure(configuration.clone()));
        for _ in 0..protection.self_test_ticks {
            self.tick();
        }
        self.open(&Request::Start(mode));
    }

    /// Opens the valve by a request, in two steps.
    ///
    /// # Panics
    /// One of them is refused.
    pub fn open(&mut self, request: &Request) {
        self.demand(&Request::Arm);
        self.demand(request);
    }

    /// A tick as the image has it: plant, samples, watchdog, control, clock.
    pub fn tick(&mut self) {
        self.plant();
        self.inputs.samples = self.sample();
        if !self.wrong.no_host {
            self.heartbeat = self.heartbeat.wrapping_add(u16::from(!self.wrong.is_host_stuck));
            self.request(&Request::Reference(self.reference_mm as f32));
            self.request(&Request::Heartbeat(self.heartbeat));
        }
        for task in [Task::Link, Task::Supervisor] {
            if self.wrong.silent != Some(task) {
                self.check_ins.check_in(task);
            }
        }
        if self.wrong.low_voltage {
            self.control().report(Fault::BrownOut);
        }
        let is_stopped = self.wrong.is_stopped;
        self.control().hear_stop(is_stopped);
        let has_voltage = self.wrong.is_coil_held || self.control().keeps_dump_closed();
        self.control().hear_coil(has_voltage);
        self.control.iter_mut().for_each(|control| _ = control.tick(&mut self.inputs));
        if !self.watchdog.is_content(&self.check_ins) {
            self.control().report(Fault::TaskSilent);
        }
        let elapsed_cycles = if self.wrong.is_late { DEADLINE_CYCLES + 1 } else { 1_000 };
        self.control().close_tick(TickEnd { elapsed_cycles, is_overrun: false });
    }

    /// Ends the program, and restarts it after a reset: `crash` is what has sealed the record
    /// before, if anything.
    ///
    /// # Panics
    /// Never.
    pub fn reset(&mut self, reset: Reset, crash: Option<Fault>) {
        let (black_box, capture) = self.control.take().expect("there is one").into_memory();
        if let Some(fault) = crash {
            black_box.crash(fault, 0);
        }
        self.control = Some(control(black_box, capture, reset));
        self.inputs.output = VENT;
        (self.check_ins, self.watchdog) = (CheckIns::new(), Watchdog::default());
    }

    /// The control under test.
    ///
    /// # Panics
    /// Never.
    pub fn control(&mut self) -> &mut Control {
        self.control.as_mut().expect("there is one but within a reset")
    }

    /// The code that is out.
    pub fn output(&self) -> DacCode {
        self.inputs.output
    }

    /// The command that is out. Unit: bar.
    pub fn command_bar(&self) -> f64 {
        COMMAND.value(self.inputs.output.0).into()
    }

    /// The true pressure. Unit: bar.
    pub fn pressure_bar(&self) -> f64 {
        self.pressure_bar
    }

    /// The codes of the last samples.
    pub fn samples(&self) -> Samples {
        self.inputs.samples.unwrap_or_default()
    }

    /// The board's state.
    pub fn state(&mut self) -> State {
        self.control().state()
    }

    fn plant(&mut self) {
        let target = self.wrong.valve_bar.unwrap_or(self.command_bar() * (1.0 + self.wrong.leak));
        self.pressure_bar += (1.0 - (-PERIOD_S / LAG_S).exp()) * (target - self.pressure_bar);
        self.contraction_mm = self.muscle.step(&mut self.memory, self.pressure_bar).unwrap_or(f64::NAN);
    }

    fn sample(&mut self) -> Option<Samples> {
        let wrong = self.wrong;
        let mut noisy = |code: u16| AdcCode(code + (self.noise.next_u32() % 3) as u16 - 1);
        let pressure = noisy(PRESSURE.code((self.pressure_bar + wrong.pressure_bar) as f32));
        let contraction = noisy(CONTRACTION.code((self.contraction_mm + wrong.contraction_mm) as f32));
        let (supply, temperature) = (noisy(SUPPLY.code(8.0)), noisy(TEMPERATURE.code(30.0)));
        let or = |code: AdcCode, other: Option<u16>| other.map_or(code, AdcCode);
        (!wrong.no_samples).then_some(Samples {
            pressure: or(pressure, wrong.pressure_code),
            contraction: or(contraction, wrong.contraction_code),
            supply: or(supply, wrong.supply_code),
            temperature: or(temperature, wrong.temperature_code),
            output: Some(or(AdcCode(self.inputs.output.0), wrong.output_code)),
            reference: Some(or(AdcCode(REFERENCE_CODE as u16), wrong.reference_code)),
            surroundings: Surroundings::default(),
        })
    }
}

/// The control of a board that starts after a reset.
fn control(black_box: &'static mut BlackBox, capture: &'static mut Capture, reset: Reset) -> Control {
    let clock = TickClock { period_s: PERIOD_S as f32, deadline_cycles: DEADLINE_CYCLES };
    *black_box = BlackBox::after(reset, *black_box);
    *capture = Capture::new();
    Control::new(Protection::STANDARD, Some(clock), black_box, capture)
}
