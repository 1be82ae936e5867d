//! One part fails, on the host: the control code with the rig at its valve, and a dump valve behind
//! the regulator.
//!
//! What a part does when it fails is in [`Failure`]; what is promised then is in `docs/safety.md`.
//! A run tracks by feed-forward, lets the part fail at a random moment, and measures until the
//! muscle is empty.
//!
//! # Limits
//! The dump valve empties the rig as fast as its regulator does, time constant 50 ms: how fast a
//! real one is has to be measured. The rig's regulator gives 6 bar at most, which is below the
//! limits of overpressure: one that lets the supply through is told by what it differs from the
//! command, or by nothing before the host stops.

use firmware::faults::black_box::Reset;
use firmware::order::prepare;
use firmware::scaling::{COMMAND, CONTRACTION, PRESSURE, REFERENCE_CODE, SUPPLY, TEMPERATURE, VENT};
use firmware::timing::TickEnd;
use firmware::watchdog::{CheckIns, Task, Watchdog};
use firmware::{AcquisitionError, AdcCode, BlackBox, Board, Capture, Control, DacCode, Samples, TickClock};
use model_core::{Mode, ModelParameters, Surroundings, paper};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rig::parameters::SUPPLY_BAR;
use rig::plant::{Plant, Setup};
use wire::fault::times::{ALLOWANCE_TICKS, STRAY_TICKS, VENTING_TICKS};
use wire::{Fault, Protection, Request, Response};

use crate::{PERIOD_S, configuration};

/// How long the charge pump keeps the dump valve closed behind the last change of its input. Unit:
/// tick.
const PUMP_TICKS: u32 = 10;
/// The longest that the hardware watchdog waits while the valve is driven: 50 ms by an oscillator
/// of 17 kHz. Unit: tick.
const WATCHDOG_TICKS: u32 = 94;
/// From 6 bar to [`EMPTY_BAR`] by the rig's time constant of 50 ms, 170, and the noise of its
/// sensor. Unit: tick.
const EMPTYING_TICKS: u32 = 190;
/// The pressure below which docs/safety.md calls the muscle empty. Unit: bar.
pub const EMPTY_BAR: f64 = 0.2;
/// How long after a failure that does not show the host stops, at the most. Unit: tick.
const STOP_TICKS: u32 = 2000;

/// A part that fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The converter puts out its last code for ever.
    ConverterStuck,
    /// The amplifier behind it puts out 10 V.
    AmplifierHigh,
    /// The regulator lets the supply through.
    RegulatorOpen,
    /// The pressure sensor shows its last value for ever.
    SensorStuck,
    /// The supply of the converters is a tenth too high, and with it all that they put out.
    ReferenceHigh,
    /// The charge pump keeps the dump valve closed for ever.
    CoilHeld,
    /// The processor's supply falls below the detector's threshold.
    BrownOut,
    /// The crystal stops: the image vents, and resets itself.
    CrystalLost,
    /// A task other than the tick stands still.
    TaskHung,
    /// The tick stands still, the converter at its last code, until the watchdog resets.
    TickHung,
}

impl Failure {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::ConverterStuck,
        Self::AmplifierHigh,
        Self::RegulatorOpen,
        Self::SensorStuck,
        Self::ReferenceHigh,
        Self::CoilHeld,
        Self::BrownOut,
        Self::CrystalLost,
        Self::TaskHung,
        Self::TickHung,
    ];

    /// Whether nothing may tell it before the valve is to be vented; the time counts from there
    /// then.
    pub fn may_be_hidden(self) -> bool {
        matches!(
            self,
            Self::ConverterStuck
                | Self::AmplifierHigh
                | Self::RegulatorOpen
                | Self::SensorStuck
                | Self::CoilHeld
        )
    }

    /// The most ticks until the muscle is empty, from the failure, or of a hidden one from the stop
    /// or the fault.
    pub fn within_ticks(self) -> u32 {
        let seen = match self {
            // By the voltage that is read back.
            Self::ConverterStuck => u32::from(STRAY_TICKS) + PUMP_TICKS,
            // By a pressure that does not fall.
            Self::AmplifierHigh | Self::RegulatorOpen => u32::from(VENTING_TICKS) + PUMP_TICKS,
            Self::SensorStuck | Self::CoilHeld => 0,
            Self::ReferenceHigh => u32::from(STRAY_TICKS),
            Self::BrownOut | Self::CrystalLost => 1,
            Self::TaskHung => u32::from(ALLOWANCE_TICKS) + 2,
            Self::TickHung => PUMP_TICKS,
        };
        seen + EMPTYING_TICKS
    }
}

/// How a run has ended.
#[derive(Clone, Copy, Debug)]
pub struct End {
    /// What failed.
    pub failure: Failure,
    /// The fault that was latched first.
    pub fault: Option<Fault>,
    /// Ticks until the muscle was empty and stayed so for half a second; none if it never was.
    pub empty_after: Option<u32>,
}

impl End {
    /// Whether the promise is kept.
    pub fn is_kept(&self) -> bool {
        self.empty_after.is_some_and(|ticks| ticks <= self.failure.within_ticks())
    }
}

/// Inputs and output of the board.
#[derive(Default)]
struct Converters {
    samples: Samples,
    output: DacCode,
}

impl Board for Converters {
    fn read(&mut self) -> Result<Samples, AcquisitionError> {
        Ok(self.samples)
    }

    fn drive(&mut self, code: DacCode) {
        self.output = code;
    }
}

/// The board with what hangs on it.
struct Rig {
    control: Option<Control>,
    converters: Converters,
    check_ins: CheckIns,
    watchdog: Watchdog,
    plant: Plant,
    failure: Option<Failure>,
    /// Ticks since the failure.
    failed_for: u32,
    /// Code and measured pressure when it failed.
    last: (DacCode, f64),
    /// Ticks since the dump valve's input has last changed.
    pump_idle: u32,
    measured_bar: f64,
}

impl Rig {
    fn new(seed: u64) -> Self {
        Self {
            control: Some(start(Box::leak(Box::default()), Box::leak(Box::default()), Reset::PowerOn)),
            converters: Converters::default(),
            check_ins: CheckIns::new(),
            watchdog: Watchdog::default(),
            plant: Plant::new(&Setup::sound(seed)),
            failure: None,
            failed_for: 0,
            last: (VENT, 0.0),
            pump_idle: PUMP_TICKS,
            measured_bar: 0.0,
        }
    }

    fn control(&mut self) -> &mut Control {
        self.control.as_mut().expect("there is one but within a reset")
    }

    fn request(&mut self, request: &Request) -> Response {
        prepare(request).map_or_else(Response::Refused, |order| self.control().apply(order))
    }

    /// Configures the board, lets it test itself, and starts it.
    fn start(&mut self) {
        // The rig is not the muscle of the paper, whose model is at hand.
        let protection = Protection { implausible_share: f32::INFINITY, ..Protection::STANDARD };
        let paper = configuration(&ModelParameters::Cascade(paper::mgpi().expect("valid")));
        for request in [Request::Protect(protection), Request::Configure(paper)] {
            assert_eq!(self.request(&request), Response::Accepted);
        }
        (0..protection.self_test_ticks).for_each(|_| self.tick());
        for request in [Request::Arm, Request::Start(Mode::FeedforwardOnly)] {
            assert_eq!(self.request(&request), Response::Accepted);
        }
    }

    fn fail(&mut self, failure: Failure) {
        self.failure = Some(failure);
        self.last = (self.converters.output, self.measured_bar);
        if failure == Failure::CrystalLost {
            self.reset(Reset::Software, Some(Fault::Clock));
        }
    }

    fn reset(&mut self, reset: Reset, crash: Option<Fault>) {
        let (black_box, capture) = self.control.take().expect("there is one").into_memory();
        crash.into_iter().for_each(|fault| black_box.crash(fault, 0));
        self.control = Some(start(black_box, capture, reset));
        self.converters.output = VENT;
    }

    /// What the muscle's valves make of the output. Unit: bar.
    fn asked_bar(&self) -> f64 {
        let asked = f64::from(COMMAND.value(self.converters.output.0));
        let of_regulator = match self.failure {
            Some(Failure::ConverterStuck) => COMMAND.value(self.last.0.0).into(),
            Some(Failure::AmplifierHigh | Failure::RegulatorOpen) => SUPPLY_BAR,
            Some(Failure::ReferenceHigh) => 1.1 * asked,
            _ => asked,
        };
        if self.has_coil_voltage() { of_regulator } else { 0.0 }
    }

    /// Whether the dump valve is kept closed.
    fn has_coil_voltage(&self) -> bool {
        self.failure == Some(Failure::CoilHeld) || self.pump_idle < PUMP_TICKS
    }

    /// The code that is read at the valve's output.
    fn read_back(&self) -> u16 {
        let out =
            if self.failure == Some(Failure::ConverterStuck) { self.last.0 } else { self.converters.output };
        out.0
    }

    /// The code that the reference reads, whose converter has a supply that may be too high.
    fn reference(&self) -> u16 {
        let share = if self.failure == Some(Failure::ReferenceHigh) { 1.1 } else { 1.0 };
        (REFERENCE_CODE / share) as u16
    }

    fn tick(&mut self) {
        let measured = self.plant.step(self.asked_bar(), PERIOD_S);
        self.measured_bar = measured.pressure_bar;
        self.failed_for += u32::from(self.failure.is_some());
        if self.failure == Some(Failure::TickHung) {
            if self.failed_for < WATCHDOG_TICKS {
                self.pump_idle += 1;
                return;
            }
            if self.failed_for == WATCHDOG_TICKS {
                self.reset(Reset::Watchdog, None);
            }
        }
        let shown_bar =
            if self.failure == Some(Failure::SensorStuck) { self.last.1 } else { measured.pressure_bar };
        self.converters.samples = Samples {
            pressure: AdcCode(PRESSURE.code(shown_bar as f32)),
            contraction: AdcCode(CONTRACTION.code(measured.contraction_mm as f32)),
            supply: AdcCode(SUPPLY.code(SUPPLY_BAR as f32)),
            temperature: AdcCode(TEMPERATURE.code(30.0)),
            output: Some(AdcCode(self.read_back())),
            reference: Some(AdcCode(self.reference())),
            surroundings: Surroundings::default(),
        };
        self.check_ins.check_in(Task::Supervisor);
        if self.failure != Some(Failure::TaskHung) {
            self.check_ins.check_in(Task::Link);
        }
        let has_coil_voltage = self.has_coil_voltage();
        let Some(control) = &mut self.control else { return };
        control.hear_coil(has_coil_voltage);
        if self.failure == Some(Failure::BrownOut) {
            control.report(Fault::BrownOut);
        }
        control.tick(&mut self.converters);
        if !self.watchdog.is_content(&self.check_ins) {
            control.report(Fault::TaskSilent);
        }
        control.close_tick(TickEnd { elapsed_cycles: 1_000, is_overrun: false });
        self.pump_idle = if control.keeps_dump_closed() { 0 } else { self.pump_idle.saturating_add(1) };
    }
}

fn start(black_box: &'static mut BlackBox, capture: &'static mut Capture, reset: Reset) -> Control {
    let clock = TickClock { period_s: PERIOD_S as f32, deadline_cycles: 84_000 };
    *black_box = BlackBox::after(reset, *black_box);
    *capture = Capture::new();
    Control::new(Protection::STANDARD, Some(clock), black_box, capture)
}

/// A run: which part fails, when, at which course of the pressure, and when the host stops, by the
/// seed.
///
/// # Panics
/// The board does not take the orders of the host before anything has failed.
pub fn run(seed: u64) -> End {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let failure = Failure::ALL[random.next_u32() as usize % Failure::ALL.len()];
    let mut between = |low: u32, high: u32| low + random.next_u32() % (high - low);
    let (fails_at, stops_after) = (between(500, 3000), between(1, STOP_TICKS));
    let (mean_mm, swing_mm) = (f64::from(between(40, 80)), f64::from(between(0, 35)));
    let period_ticks = f64::from(between(400, 8000));
    let mut rig = Rig::new(seed);
    rig.start();
    let (mut counted_from, mut empty_for) = (None, 0);
    for tick in 0..fails_at + STOP_TICKS + 2000 {
        if tick == fails_at {
            assert_eq!(rig.control().fault(), None, "seed {seed}");
            rig.fail(failure);
        }
        let mm = mean_mm + swing_mm * (std::f64::consts::TAU * f64::from(tick) / period_ticks).sin();
        rig.request(&Request::Reference(mm as f32));
        rig.request(&Request::Heartbeat(tick as u16));
        if tick == fails_at + stops_after {
            rig.request(&Request::Stop);
        }
        rig.tick();
        let is_asked = tick >= fails_at + stops_after || rig.control().fault().is_some();
        if tick >= fails_at && (is_asked || !failure.may_be_hidden()) {
            counted_from.get_or_insert(tick);
        }
        empty_for = if rig.measured_bar < EMPTY_BAR { empty_for + 1 } else { 0 };
        if let Some(from) = counted_from
            && empty_for > 500
        {
            let empty_after = Some((tick - empty_for + 1).saturating_sub(from));
            return End { failure, fault: rig.control().fault(), empty_after };
        }
    }
    End { failure, fault: rig.control().fault(), empty_after: None }
}
