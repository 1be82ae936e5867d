//! How each fault is brought about on the bench, and when what detects it begins: one arm a fault,
//! so that a new fault without one does not compile.

use firmware::faults::black_box::Reset;
use firmware::scaling::{CONTRACTION, PRESSURE, SUPPLY, TEMPERATURE};
use firmware::watchdog::Task;
use host_tests::bench::Bench;
use host_tests::configuration;
use model_core::{Mode, ModelParameters, paper};
use wire::registers::Learning;
use wire::{Configuration, Fault, OnModelFault, Protection, Request};

/// A fault that is being injected.
pub struct Injection {
    pub fault: Fault,
    /// Ticks since it began.
    ticks: u32,
    /// Lowest and highest command since then. Unit: bar.
    command_bar: (f64, f64),
    /// Whether the muscle was contracted by more than half then.
    was_contracted: bool,
}

/// The controller of a run in which a fault is to be injected.
pub fn configuration_for(fault: Fault) -> Configuration {
    let mut configuration = configuration(&ModelParameters::Cascade(paper::mgpi().expect("valid")));
    if fault == Fault::NotFinite {
        // Allowed, but beyond what an error of a few millimetres leaves of single precision.
        configuration.tracking.pid.kp = 3e38;
    }
    configuration
}

/// Its mode. Without feedback nothing makes good what a leak takes away.
pub fn mode_for(fault: Fault) -> Mode {
    match fault {
        Fault::NotFinite | Fault::Leak | Fault::ValveStuck | Fault::PressureStuck | Fault::Adaptation => {
            Mode::FeedforwardOnly
        }
        _ => Mode::Both,
    }
}

/// A model that cannot be inverted in single precision: a range far beyond where the muscle still
/// moves.
pub fn model_without_round_trip() -> Configuration {
    let mut parameters = paper::mgpi().expect("valid");
    parameters.input_max = 26.0;
    configuration(&ModelParameters::Cascade(parameters))
}

impl Injection {
    pub fn of(fault: Fault) -> Self {
        Self { fault, ticks: 0, command_bar: (f64::INFINITY, f64::NEG_INFINITY), was_contracted: false }
    }

    /// Before each tick. Answers whether what is detected is there in the tick.
    pub fn apply(&mut self, bench: &mut Bench) -> bool {
        let tick = self.ticks;
        self.ticks += 1;
        let command_bar = bench.command_bar();
        self.command_bar = (self.command_bar.0.min(command_bar), self.command_bar.1.max(command_bar));
        let (low, high) = self.command_bar;
        let has_moved = high - low > 1.55;
        let (codes, pressure_bar) = (bench.samples(), bench.pressure_bar());
        if tick == 0 {
            self.was_contracted = bench.reference_mm > 60.0;
        }
        let (wrong, is_first) = (&mut bench.wrong, tick == 0);
        match self.fault {
            Fault::Acquisition => wrong.no_samples = true,
            Fault::PressureSensor => wrong.pressure_code = Some(0),
            Fault::ContractionSensor => wrong.contraction_code = Some(4095),
            Fault::SupplySensor => wrong.supply_code = Some(4095),
            Fault::Reference => {
                bench.reference_mm = if tick.is_multiple_of(2) { f64::NAN } else { f64::INFINITY }
            }
            Fault::PressureStuck => {
                wrong.pressure_code.get_or_insert(codes.pressure.0);
                return has_moved;
            }
            Fault::ContractionStuck => {
                wrong.contraction_code.get_or_insert(codes.contraction.0);
                return has_moved;
            }
            Fault::PressureSpiking => {
                wrong.pressure_bar = if pressure_bar > 3.0 { -2.0 } else { 2.0 };
            }
            Fault::ContractionSpiking => wrong.contraction_mm = 15.0,
            Fault::Implausible => {
                let towards = if self.was_contracted { -90.0 } else { 90.0 };
                let step = (towards - wrong.contraction_mm).clamp(-2.0, 2.0);
                wrong.contraction_mm += step;
                return step == 0.0;
            }
            Fault::OverpressureHard => wrong.pressure_code = Some(PRESSURE.code(7.7)),
            Fault::OverpressureSoft => {
                let begin = f64::from(PRESSURE.value(codes.pressure.0));
                let ramp = (begin + 0.4).min(7.1);
                wrong.pressure_code = Some(PRESSURE.code(ramp as f32));
                return ramp >= 7.1;
            }
            Fault::SupplyLow => wrong.supply_code = Some(SUPPLY.code(3.5)),
            Fault::Leak => {
                wrong.leak = -0.7;
                return command_bar - pressure_bar >= 2.0;
            }
            Fault::ValveStuck => {
                wrong.valve_bar.get_or_insert(pressure_bar);
                return (command_bar - pressure_bar).abs() >= 2.0;
            }
            Fault::Adaptation => {
                // A sensor that slips, slowly enough to be learnt, to the end of the bounds.
                // Steps are counted, not ticks: the table's time begins behind the last one.
                let step = (-40.0 - wrong.contraction_mm).clamp(-0.005, 0.005);
                wrong.contraction_mm += step;
                bench.control().adaptation().switch(Learning::On);
                return false;
            }
            Fault::NotFinite => {
                bench.reference_mm += 20.0;
                bench.request(&Request::SetMode(Mode::Both));
                // A reference acts in the tick after the one that it is given in.
                return !is_first;
            }
            Fault::Model if is_first => {
                bench.demand(&Request::Stop);
                let strict = Protection { on_model_fault: OnModelFault::Vent, ..Protection::STANDARD };
                bench.demand(&Request::Protect(strict));
                bench.demand(&Request::Configure(model_without_round_trip()));
            }
            // A valve that gives too little, which the feedback makes good as far as it goes.
            Fault::Authority => {
                wrong.leak = -0.7;
                let contraction_mm = f64::from(CONTRACTION.value(codes.contraction.0));
                return bench.reference_mm - contraction_mm > 41.0;
            }
            Fault::VentIneffective => {
                if pressure_bar < 1.0 && wrong.valve_bar.is_none() {
                    return false;
                }
                if wrong.valve_bar.replace(pressure_bar).is_none() {
                    bench.demand(&Request::Stop);
                }
            }
            Fault::OutputStray => wrong.output_code = Some(4095),
            Fault::ReferenceVoltage => wrong.reference_code = Some(1350),
            Fault::DumpHeld => {
                wrong.is_coil_held = true;
                if is_first {
                    // Its self-test lets go of the coil.
                    bench.demand(&Request::Stop);
                    bench.demand(&Request::Configure(configuration_for(self.fault)));
                }
            }
            Fault::EmergencyStop => wrong.is_stopped = true,
            Fault::Deadline => wrong.is_late = true,
            Fault::TaskSilent => wrong.silent = Some(Task::Link),
            Fault::BusSilent => wrong.no_host = true,
            Fault::HeartbeatStands => wrong.is_host_stuck = true,
            Fault::BrownOut => wrong.low_voltage = true,
            Fault::Temperature => wrong.temperature_code = Some(TEMPERATURE.code(95.0)),
            Fault::ConfigurationCorrupt
            | Fault::ConfigurationVersion
            | Fault::CalibrationCorrupt
            | Fault::ImageDamaged
            | Fault::MemoryDamaged
                if is_first =>
            {
                bench.control().report(self.fault)
            }
            Fault::StackOverflow | Fault::HardFault | Fault::Panic if is_first => {
                bench.reset(Reset::Software, Some(self.fault));
            }
            Fault::WatchdogReset if is_first => bench.reset(Reset::Watchdog, None),
            Fault::ResetLoop if is_first => (0..3).for_each(|_| bench.reset(Reset::Watchdog, None)),
            Fault::Clock if is_first => bench.control().note(Fault::Clock),
            // What happens once.
            Fault::Model
            | Fault::ConfigurationCorrupt
            | Fault::ConfigurationVersion
            | Fault::CalibrationCorrupt
            | Fault::ImageDamaged
            | Fault::MemoryDamaged
            | Fault::StackOverflow
            | Fault::HardFault
            | Fault::Panic
            | Fault::WatchdogReset
            | Fault::ResetLoop
            | Fault::Clock => {}
        }
        true
    }
}
