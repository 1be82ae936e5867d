//! The monitors: what tells a fault of sensors, valve, muscle and supply from the samples of each
//! tick.
//!
//! | file | what it watches |
//! |---|---|
//! | [`sensor`] | pressure and contraction, each for itself: open, short, spikes |
//! | [`stuck`] | pressure and contraction, against the command |
//! | [`slow`] | supply and temperature |
//! | [`overpressure`] | pressure against its limits, at once and on average |
//! | [`following`] | pressure against command: leak, burst, stuck valve |
//! | [`authority`] | feedback beside a feed-forward |
//! | [`survey`] | the model against itself, and contraction against pressure |
//! | [`venting`] | pressure behind a valve that is vented |
//! | [`own`] | what the board reads back of itself |
//! | [`persistence`] | how long something has to last |
//!
//! # Contract
//! Once a tick, in every state but `Off` and `Fault`, where only the venting is watched:
//! [`Monitors::take`] before the valve is written, for what the controller needs and what a single
//! sample shows; and [`Monitors::watch`] behind it, for what takes several ticks to be seen. A tick
//! without samples is one with the last. Both read whole numbers where they can: codes are compared
//! with limits that were turned into codes once.

pub mod authority;
pub mod following;
pub mod overpressure;
pub mod own;
pub mod persistence;
pub mod sensor;
pub mod slow;
pub mod stuck;
pub mod survey;
pub mod venting;

use wire::fault::times::{IMPLAUSIBLE_TICKS, MISSING_IN_A_ROW};
use wire::{Fault, Protection, Scaling};

use crate::board::{AcquisitionError, DacCode, Samples};
use crate::scaling::Scalings;
use authority::Authority;
use following::Following;
use overpressure::Overpressure;
use own::Own;
use persistence::InARow;
use sensor::Sensor;
use slow::Slow;
use stuck::Stuck;
use survey::Loop;
use venting::Venting;

/// The protection's limits in the units of the monitors, and what is watched beyond them.
#[derive(Clone, Debug)]
struct Limits {
    pressure: sensor::Limits,
    contraction: sensor::Limits,
    command: Scaling,
    /// How far the command has to move past a sensor that does not. Unit: DAC code.
    stuck: u16,
    supply: slow::Limits,
    temperature: slow::Limits,
    overpressure: overpressure::Limits,
    venting: venting::Limits,
    following: following::Limits,
    implausible_share: f32,
    authority_bar: f32,
}

/// The monitors with what they remember.
#[derive(Clone, Debug)]
pub struct Monitors {
    limits: Limits,
    last: Samples,
    missing: InARow,
    pressure: Sensor,
    contraction: Sensor,
    /// Of pressure and contraction.
    stuck: [Stuck<u16, 1>; 2],
    /// That of the contraction which could last be trusted.
    contraction_code: u16,
    supply: Slow,
    temperature: Slow,
    overpressure: Overpressure,
    following: Following,
    venting: Venting,
    own: Own,
    implausible: InARow,
    authority: Authority,
}

impl Monitors {
    /// Monitors with these limits and scalings, for ticks that are `period_s` apart.
    pub fn new(protection: &Protection, scalings: &Scalings, period_s: f32) -> Self {
        Self {
            limits: Limits::new(protection, scalings, period_s),
            last: Samples::default(),
            missing: InARow::default(),
            pressure: Sensor::default(),
            contraction: Sensor::default(),
            stuck: [Stuck::default(); 2],
            contraction_code: 0,
            supply: Slow::default(),
            temperature: Slow::default(),
            overpressure: Overpressure::default(),
            following: Following::default(),
            venting: Venting::default(),
            own: Own::default(),
            implausible: InARow::default(),
            authority: Authority::default(),
        }
    }

    /// The last samples as they were read, good or not.
    pub fn samples(&self) -> Samples {
        self.last
    }

    /// Keeps samples that nothing is concluded from.
    pub fn look(&mut self, samples: Result<Samples, AcquisitionError>) {
        self.last = samples.unwrap_or(self.last);
    }

    /// Samples of pressure and contraction that were replaced by the one before.
    pub fn bridged(&self) -> u32 {
        self.pressure.bridged.wrapping_add(self.contraction.bridged)
    }

    /// Takes the samples of a tick; answers the contraction. Unit: mm.
    ///
    /// # Errors
    /// The fault that the samples show.
    #[inline(always)]
    pub fn take(&mut self, samples: Result<Samples, AcquisitionError>) -> Result<f32, Fault> {
        if self.missing.holds_for(MISSING_IN_A_ROW, samples.is_err()) {
            return Err(Fault::Acquisition);
        }
        if let Ok(samples) = samples {
            self.last = samples;
            let Limits { contraction, overpressure, .. } = &self.limits;
            overpressure.hold(samples.pressure.0)?;
            self.contraction_code = self.contraction.take(contraction, samples.contraction.0)?;
        }
        Ok(self.limits.contraction.scaling.value(self.contraction_code))
    }

    /// Looks at what takes several ticks to be seen. `command`: what was out until this tick;
    /// `outermost`: the loop of the installed model; `is_driven`: whether the valve is.
    ///
    /// # Errors
    /// The fault that the last samples have shown.
    #[inline(always)]
    pub fn watch(
        &mut self,
        command: DacCode,
        outermost: Option<&Loop>,
        is_driven: bool,
    ) -> Result<(), Fault> {
        let Limits { pressure, supply, temperature, stuck, following, .. } = &self.limits;
        let pressure_code = self.pressure.take(pressure, self.last.pressure.0)?;
        self.overpressure.take(&self.limits.overpressure, pressure_code)?;
        self.supply.take(supply, self.last.supply.0)?;
        self.temperature.take(temperature, self.last.temperature.0)?;
        let [of_pressure, of_contraction] = &mut self.stuck;
        of_pressure.take(pressure_code, [command.0], [*stuck], Fault::PressureStuck)?;
        of_contraction.take(self.contraction_code, [command.0], [*stuck], Fault::ContractionStuck)?;
        let (pressure_bar, contraction_mm) = (
            pressure.scaling.value(pressure_code),
            self.limits.contraction.scaling.value(self.contraction_code),
        );
        let share = self.limits.implausible_share;
        let is_implausible =
            outermost.is_some_and(|outermost| !outermost.is_plausible(pressure_bar, contraction_mm, share));
        if self.implausible.holds_for(IMPLAUSIBLE_TICKS, is_implausible) {
            return Err(Fault::Implausible);
        }
        if is_driven {
            self.following.take(following, self.limits.command.value(command.0), pressure_bar)
        } else {
            Ok(())
        }
    }

    /// Looks whether a valve that is vented lets the pressure fall.
    ///
    /// # Errors
    /// It does not.
    #[inline(always)]
    pub fn watch_venting(&mut self, is_driven: bool) -> Result<(), Fault> {
        self.venting.take(&self.limits.venting, is_driven, self.last.pressure.0)
    }

    /// Looks at what the board reads back of itself, in every state but at fault. `out`: what was
    /// out until this tick.
    ///
    /// # Errors
    /// The output is not what was written, or the reference voltage is out of its range.
    #[inline(always)]
    pub fn watch_own(&mut self, out: DacCode) -> Result<(), Fault> {
        self.own.take(self.last.output, self.last.reference, out)
    }

    /// Looks at the feedback (bar) beside a feed-forward; 0 where there are not both.
    ///
    /// # Errors
    /// It contradicts the feed-forward.
    #[inline(always)]
    pub fn judge(&mut self, feedback_bar: f32) -> Result<(), Fault> {
        self.authority.take(feedback_bar.abs() > self.limits.authority_bar)
    }

    /// Looks at the vented muscle at the end of the self-test.
    ///
    /// # Errors
    /// Pressure is left: the valve does not vent.
    pub fn is_vented(&self) -> Result<(), Fault> {
        if self.last.pressure.0 > self.limits.venting.vented { Err(Fault::ValveStuck) } else { Ok(()) }
    }

    /// Forgets the past, with a fault or an installation.
    pub fn restart(&mut self) {
        self.missing = InARow::default();
        self.pressure.restart();
        self.contraction.restart();
        (self.supply, self.temperature) = (Slow::default(), Slow::default());
        self.overpressure = Overpressure::default();
        self.stuck = [Stuck::default(); 2];
        self.following = Following::default();
        self.implausible = InARow::default();
        self.authority = Authority::default();
    }
}

impl Limits {
    fn new(protection: &Protection, scalings: &Scalings, period_s: f32) -> Self {
        let Scalings { pressure, contraction, supply, command, .. } = *scalings;
        // A difference of infinite size saturates at a code that no converter has.
        let codes = |scaling: &Scaling, difference: f32| (difference * scaling.codes_per_unit) as u16;
        let of =
            |scaling: Scaling, jump, faults| sensor::Limits { scaling, jump: codes(&scaling, jump), faults };
        Self {
            pressure: of(
                pressure,
                protection.pressure_jump_bar,
                [Fault::PressureSensor, Fault::PressureSpiking],
            ),
            contraction: of(
                contraction,
                protection.contraction_jump_mm,
                [Fault::ContractionSensor, Fault::ContractionSpiking],
            ),
            command,
            stuck: codes(&command, protection.stuck_command_bar),
            supply: slow::Limits::of_supply(protection, supply),
            temperature: slow::Limits::of_temperature(protection),
            overpressure: overpressure::Limits::new(protection, &pressure),
            venting: venting::Limits::new(protection, &pressure),
            following: following::Limits {
                band_bar: protection.following_band_bar,
                limit: protection.following_limit_bar_s / period_s,
            },
            implausible_share: protection.implausible_share,
            authority_bar: protection.authority_bar,
        }
    }
}
