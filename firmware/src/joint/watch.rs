//! What tells a fault of a joint's sensors, valves and muscles from the samples of each tick.

use wire::joint::{Channel, JointFault};
use wire::{Fault, Protection};

use super::{ANGLE, JointSamples};
use crate::monitors::following::{self, Following};
use crate::monitors::sensor::{self, Sensor};
use crate::scaling::PRESSURE;

/// No joint turns by as much from one tick of 1 ms to the next: at 0.1 rad it would turn by 16
/// revolutions in a second. Unit: rad.
const ANGLE_JUMP_RAD: f32 = 0.1;

/// What was measured in a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// Unit: bar.
    pub pressures: [f32; 2],
    /// Unit: rad.
    pub angle: f32,
}

/// The monitors with what they remember.
#[derive(Clone, Debug)]
pub struct Watch {
    pressure: sensor::Limits,
    angle: sensor::Limits,
    /// Unit: bar.
    overpressure_bar: f32,
    following: following::Limits,
    sensors: [Sensor; 2],
    angle_sensor: Sensor,
    valves: [Following; 2],
    last: JointSamples,
}

impl Watch {
    /// Monitors with these limits, for ticks that are `period_s` apart.
    pub fn new(protection: &Protection, period_s: f32) -> Self {
        // What is beyond any code saturates at the largest number.
        let pressure_jump = (protection.pressure_jump_bar * PRESSURE.codes_per_unit) as u16;
        Self {
            pressure: sensor::Limits {
                scaling: PRESSURE,
                jump: pressure_jump,
                faults: [Fault::PressureSensor, Fault::PressureSpiking],
            },
            angle: sensor::Limits {
                scaling: ANGLE,
                jump: (ANGLE_JUMP_RAD * ANGLE.codes_per_unit) as u16,
                faults: [Fault::ContractionSensor, Fault::ContractionSpiking],
            },
            overpressure_bar: protection.overpressure_hard_bar,
            following: following::Limits {
                band_bar: protection.following_band_bar,
                limit: protection.following_limit_bar_s / period_s,
            },
            sensors: [Sensor::default(); 2],
            angle_sensor: Sensor::default(),
            valves: [Following::default(); 2],
            last: JointSamples::default(),
        }
    }

    /// Keeps samples that nothing is concluded from.
    pub fn look(&mut self, samples: Option<JointSamples>) {
        self.last = samples.unwrap_or(self.last);
    }

    /// Takes the samples of a tick, none where there are none: the last ones stand then. `driven`:
    /// what both outputs have had until now, where they are driven. Unit: bar.
    ///
    /// # Errors
    /// The fault that they show.
    pub fn take(
        &mut self,
        samples: Option<JointSamples>,
        driven: Option<[f32; 2]>,
    ) -> Result<Measured, JointFault> {
        self.look(samples);
        let mut measured = Measured::default();
        let codes = self.last.pressures.iter().zip(&mut self.sensors).zip(&mut measured.pressures);
        for (channel, ((code, sensor), bar)) in Channel::BOTH.into_iter().zip(codes) {
            let of = |fault| JointFault::OfChannel(channel, fault);
            // The sample itself: a burst is no less likely than a spike.
            if PRESSURE.is_plausible(code.0) && PRESSURE.value(code.0) > self.overpressure_bar {
                return Err(of(Fault::OverpressureHard));
            }
            *bar = PRESSURE.value(sensor.take(&self.pressure, code.0).map_err(of)?);
        }
        let angle = self.angle_sensor.take(&self.angle, self.last.angle.0).map_err(|fault| match fault {
            Fault::ContractionSpiking => JointFault::AngleSpiking,
            _ => JointFault::AngleSensor,
        })?;
        measured.angle = ANGLE.value(angle);
        let valves = self.valves.iter_mut().zip(driven.into_iter().flatten()).zip(measured.pressures);
        for (channel, ((valve, command), pressure)) in Channel::BOTH.into_iter().zip(valves) {
            valve
                .take(&self.following, command, pressure)
                .map_err(|fault| JointFault::OfChannel(channel, fault))?;
        }
        Ok(measured)
    }

    /// Forgets the past, with a start or a fault.
    pub fn start_anew(&mut self) {
        self.sensors.iter_mut().chain([&mut self.angle_sensor]).for_each(Sensor::start_anew);
        self.valves = [Following::default(); 2];
    }
}
