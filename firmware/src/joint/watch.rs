//! What tells a fault of a joint's sensors, valves and muscles, of its supply and of the board
//! itself, from the samples of each tick. What watches each of them is that of a board with one
//! muscle ([`crate::monitors`]).

use wire::joint::{Channel, JointFault};
use wire::{Fault, Protection};

use super::{JointSamples, JointScalings};
use crate::board::DacCode;
use crate::monitors::following::{self, Following};
use crate::monitors::overpressure::{self, Overpressure};
use crate::monitors::own::Own;
use crate::monitors::sensor::{self, Sensor};
use crate::monitors::slow::{self, Slow};
use crate::monitors::stuck::Stuck;
use crate::monitors::venting::{self, Venting};
use crate::scaling::{COMMAND, SUPPLY};

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
    /// The same. Unit: ADC code.
    pub angle_code: u16,
}

/// The monitors with what they remember.
#[derive(Clone, Debug)]
pub struct Watch {
    pressures: [sensor::Limits; 2],
    angle: sensor::Limits,
    overpressures: [overpressure::Limits; 2],
    /// How far a command has to move past a pressure that does not. Unit: DAC code.
    stuck: u16,
    following: following::Limits,
    ventings: [venting::Limits; 2],
    supply: slow::Limits,
    temperature: slow::Limits,
    sensors: [Sensor; 2],
    angle_sensor: Sensor,
    mean: [Overpressure; 2],
    /// Of both pressures.
    still: [Stuck<u16, 1>; 2],
    valves: [Following; 2],
    vented: [Venting; 2],
    /// Of the supply and the temperature.
    slow: [Slow; 2],
    /// Of both outputs; the first one looks at the reference voltage, too.
    own: [Own; 2],
    last: JointSamples,
}

impl Watch {
    /// Monitors with these limits and scalings, for ticks that are `period_s` apart.
    pub fn new(protection: &Protection, scalings: &JointScalings, period_s: f32) -> Self {
        let JointScalings { pressures, angle } = *scalings;
        Self {
            pressures: pressures.map(|scaling| sensor::Limits {
                scaling,
                // What is beyond any code saturates at the largest number.
                jump: (protection.pressure_jump_bar * scaling.codes_per_unit) as u16,
                faults: [Fault::PressureSensor, Fault::PressureSpiking],
            }),
            angle: sensor::Limits {
                scaling: angle,
                jump: (ANGLE_JUMP_RAD * angle.codes_per_unit) as u16,
                faults: [Fault::ContractionSensor, Fault::ContractionSpiking],
            },
            overpressures: pressures.map(|pressure| overpressure::Limits::new(protection, &pressure)),
            stuck: (protection.stuck_command_bar * COMMAND.codes_per_unit) as u16,
            following: following::Limits {
                band_bar: protection.following_band_bar,
                limit: protection.following_limit_bar_s / period_s,
            },
            ventings: pressures.map(|pressure| venting::Limits::new(protection, &pressure)),
            supply: slow::Limits::of_supply(protection, SUPPLY),
            temperature: slow::Limits::of_temperature(protection),
            sensors: [Sensor::default(); 2],
            angle_sensor: Sensor::default(),
            mean: [Overpressure::default(); 2],
            still: [Stuck::default(); 2],
            valves: [Following::default(); 2],
            vented: [Venting::default(); 2],
            slow: [Slow::default(); 2],
            own: [Own::default(); 2],
            last: JointSamples::default(),
        }
    }

    /// The last samples as they were read, good or not.
    pub fn samples(&self) -> JointSamples {
        self.last
    }

    /// Takes the samples of a tick, none where there are none: the last ones stand then.
    pub fn look(&mut self, samples: Option<JointSamples>) {
        self.last = samples.unwrap_or(self.last);
    }

    /// Looks at what the board reads back of itself. `out`: what both outputs have had until now.
    ///
    /// # Errors
    /// An output is not what was written, or the reference voltage is out of its range.
    pub fn look_at_own(&mut self, out: [DacCode; 2]) -> Result<(), JointFault> {
        let JointSamples { outputs, reference, .. } = self.last;
        let [of_a, of_b] = &mut self.own;
        let [read_a, read_b] = outputs.map_or([None; 2], |codes| codes.map(Some));
        let [out_a, out_b] = out;
        of_a.take(read_a, reference, out_a).map_err(|fault| match fault {
            Fault::ReferenceVoltage => JointFault::OfBoard(fault),
            _ => JointFault::OfChannel(Channel::A, fault),
        })?;
        of_b.take(read_b, None, out_b).map_err(|fault| JointFault::OfChannel(Channel::B, fault))
    }

    /// Looks at the last samples. `out`: what both outputs have had until now; `is_driven`: whether
    /// they are driven.
    ///
    /// # Errors
    /// The fault that they show.
    pub fn take(&mut self, out: [DacCode; 2], is_driven: bool) -> Result<Measured, JointFault> {
        let mut measured = Measured::default();
        let sensors = self.sensors.iter_mut().zip(&mut self.mean).zip(&mut self.still);
        let limits = self.pressures.iter().zip(&self.overpressures);
        let codes = self.last.pressures.iter().zip(out).zip(&mut measured.pressures);
        for (channel, ((((sensor, mean), still), (of_sensor, overpressure)), ((code, out), bar))) in
            Channel::BOTH.into_iter().zip(sensors.zip(limits).zip(codes))
        {
            let of = |fault| JointFault::OfChannel(channel, fault);
            overpressure.hold(code.0).map_err(of)?;
            let code = sensor.take(of_sensor, code.0).map_err(of)?;
            mean.take(overpressure, code).map_err(of)?;
            // Of one that is vented the venting is looked at.
            if is_driven {
                still.take(code, [out.0], [self.stuck], Fault::PressureStuck).map_err(of)?;
            }
            *bar = of_sensor.scaling.value(code);
        }
        let angle = self.angle_sensor.take(&self.angle, self.last.angle.0).map_err(|fault| match fault {
            Fault::ContractionSpiking => JointFault::AngleSpiking,
            _ => JointFault::AngleSensor,
        })?;
        (measured.angle, measured.angle_code) = (self.angle.scaling.value(angle), angle);
        let [supply, temperature] = &mut self.slow;
        supply.take(&self.supply, self.last.supply.0).map_err(JointFault::OfBoard)?;
        temperature.take(&self.temperature, self.last.temperature.0).map_err(JointFault::OfBoard)?;
        let valves = self.valves.iter_mut().zip(&mut self.vented).zip(&self.ventings);
        let of_both = valves.zip(self.last.pressures).zip(out).zip(measured.pressures);
        for (channel, (((((valve, vented), venting), code), out), bar)) in
            Channel::BOTH.into_iter().zip(of_both)
        {
            let mut found = vented.take(venting, is_driven, code.0);
            if is_driven {
                found = found.and_then(|()| valve.take(&self.following, COMMAND.value(out.0), bar));
            }
            found.map_err(|fault| JointFault::OfChannel(channel, fault))?;
        }
        Ok(measured)
    }

    /// Forgets the past, with a start or a fault.
    pub fn restart(&mut self) {
        self.sensors.iter_mut().chain([&mut self.angle_sensor]).for_each(Sensor::restart);
        self.mean = [Overpressure::default(); 2];
        self.still = [Stuck::default(); 2];
        self.valves = [Following::default(); 2];
        self.slow = [Slow::default(); 2];
    }
}
