//! What the control tells of itself: greeting, telemetry, what it puts out.

use wire::{Hello, Signals, Telemetry, VERSION};

use crate::adaptation::Told;
use crate::board::{AdcCode, Samples};
use crate::control::Control;
use crate::scaling::{REFERENCE_CODE, REFERENCE_SUPPLY_V, TEMPERATURE};

/// What the control is asked for and puts out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outputs {
    /// Unit: mm.
    pub reference_mm: f32,
    /// Of the ticks to come. Unit: mm.
    pub next_reference_mm: f32,
    /// At the valve. Unit: bar.
    pub command_bar: f32,
    /// Asked for in the service state. Unit: bar.
    pub service_bar: f32,
    /// Of a tick, 0 if it has none. Unit: core clock cycle.
    pub deadline_cycles: u32,
    /// Of a single conversion, one standard deviation. Unit: bar.
    pub pressure_noise_bar: f32,
    /// The same. Unit: mm.
    pub contraction_noise_mm: f32,
    /// The last one that was told.
    pub heartbeat: u16,
    /// How long a start is still taken. Unit: tick.
    pub armed_ticks: u16,
    /// At the valve's output, read back; 0 where it is not. Unit: V.
    pub output_v: f32,
    /// Supply of the converters, measured against the processor's reference; 0 on a board without
    /// one. Unit: V.
    pub converters_supply_v: f32,
    /// What was learnt of the muscle.
    pub adaptation: Told,
}

/// The highest code of a converter, that of its supply.
const HIGHEST_CODE: f32 = 4095.0;

impl Control {
    /// Who the board is.
    pub(crate) fn hello(&self) -> Hello {
        Hello {
            version: VERSION,
            firmware: FIRMWARE_VERSION,
            state: self.state,
            fault: self.faults.latched(),
            pressure: self.scalings.pressure,
            contraction: self.scalings.contraction,
            command: self.scalings.command,
            ticks: self.ticks,
            overruns: self.timing.overruns,
        }
    }

    /// What it is asked for and puts out.
    pub(crate) fn outputs(&self) -> Outputs {
        let Samples { output, reference, .. } = self.monitors.samples();
        let converters_supply_v = reference.map_or(0.0, converters_supply_v);
        let [of_pressure, of_contraction] = self.noise_codes;
        Outputs {
            pressure_noise_bar: of_pressure / self.scalings.pressure.codes_per_unit,
            contraction_noise_mm: of_contraction / self.scalings.contraction.codes_per_unit,
            output_v: output.map_or(0.0, |read| output_v(read, converters_supply_v)),
            converters_supply_v,
            heartbeat: self.heartbeat.unwrap_or(0),
            armed_ticks: self.armed_ticks,
            reference_mm: self.reference_mm,
            next_reference_mm: self.next_reference_mm,
            command_bar: self.scalings.command.value(self.output.code().0),
            service_bar: self.scalings.command.value(self.service_code.0),
            deadline_cycles: self.clock.map_or(0, |clock| clock.deadline_cycles),
            adaptation: self.learnt(),
        }
    }

    /// What was counted and measured.
    pub(crate) fn telemetry(&self) -> Telemetry {
        let Samples { pressure, contraction, supply, temperature, .. } = self.monitors.samples();
        Telemetry {
            state: self.state,
            fault: self.faults.latched(),
            ticks: self.ticks,
            worst_tick_cycles: self.timing.worst_cycles,
            mean_tick_cycles: self.timing.mean_cycles(),
            overruns: self.timing.overruns,
            late_ticks: self.timing.late,
            limited_ticks: self.limited_ticks,
            bridged_samples: self.monitors.bridged(),
            resets: self.faults.resets(),
            signals: Signals {
                pressure_bar: self.scalings.pressure.value(pressure.0),
                contraction_mm: self.scalings.contraction.value(contraction.0),
                supply_bar: self.scalings.supply.value(supply.0),
                temperature_c: TEMPERATURE.value(temperature.0),
            },
            faults: self.faults.counters(),
        }
    }
}

/// Supply of the converters, by what it makes of the processor's reference. Unit: V.
pub(crate) fn converters_supply_v(reference: AdcCode) -> f32 {
    REFERENCE_SUPPLY_V * REFERENCE_CODE / f32::from(reference.0.max(1))
}

/// A voltage that a converter with this supply (V) has read. Unit: V.
pub(crate) fn output_v(read: AdcCode, converters_supply_v: f32) -> f32 {
    f32::from(read.0) / HIGHEST_CODE * converters_supply_v
}

/// Major, minor and patch of the package's version.
pub const FIRMWARE_VERSION: [u16; 3] = [
    number(env!("CARGO_PKG_VERSION_MAJOR")),
    number(env!("CARGO_PKG_VERSION_MINOR")),
    number(env!("CARGO_PKG_VERSION_PATCH")),
];

/// The value of a string of digits, at compile time.
const fn number(digits: &str) -> u16 {
    let mut digits = digits.as_bytes();
    let mut value = 0;
    while let [digit, rest @ ..] = digits {
        value = value * 10 + (*digit - b'0') as u16;
        digits = rest;
    }
    value
}
