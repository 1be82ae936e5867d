//! Gains, limits, the bus's parameters, calibrations and inputs as registers: which field stands
//! behind which.

use model_core::TrackingParameters;

use super::{Id, Value};
use crate::{
    BoardParameters, BusParameters, Calibration, Input, Inputs, OnModelFault, Parity, Protection, Signal,
};

/// A field that a register reads and writes.
#[derive(Debug)]
pub enum Field<'a> {
    /// A quantity.
    Quantity(&'a mut f32),
    /// A whole number: of ticks, bits or microseconds.
    Whole(&'a mut u32),
    /// What follows when the model does not stand its test.
    OnModelFault(&'a mut OnModelFault),
    /// A board's number.
    Unit(&'a mut u8),
    /// A parity.
    Parity(&'a mut Parity),
    /// What a sensor puts out.
    Signal(&'a mut Signal),
}

impl Field<'_> {
    /// What it holds.
    pub fn get(&self) -> Value {
        match self {
            Self::Quantity(quantity) => Value::F32(**quantity),
            Self::Whole(number) => Value::U32(**number),
            Self::OnModelFault(OnModelFault::Vent) => Value::U16(0),
            Self::OnModelFault(OnModelFault::FeedbackOnly) => Value::U16(1),
            Self::Unit(unit) => Value::U16((**unit).into()),
            Self::Parity(parity) => Value::U16(parity.number()),
            Self::Signal(signal) => Value::U16(signal.number()),
        }
    }

    /// Sets it. A value of another kind, which the table does not let through, changes nothing.
    pub fn set(self, value: Value) {
        match (self, value) {
            (Self::Quantity(quantity), Value::F32(value)) => *quantity = value,
            (Self::Whole(number), Value::U32(value)) => *number = value,
            (Self::OnModelFault(reaction), Value::U16(0)) => *reaction = OnModelFault::Vent,
            (Self::OnModelFault(reaction), Value::U16(_)) => *reaction = OnModelFault::FeedbackOnly,
            (Self::Unit(unit), Value::U16(value)) => *unit = u8::try_from(value).unwrap_or(*unit),
            (Self::Parity(parity), Value::U16(value)) => {
                *parity = Parity::of_number(value).unwrap_or(*parity);
            }
            (Self::Signal(signal), Value::U16(value)) => {
                *signal = Signal::of_number(value).unwrap_or(*signal);
            }
            _ => {}
        }
    }
}

/// The registers of the group "Controller".
pub const CONTROLLER: [Id; 11] = [
    Id::Kp,
    Id::Ki,
    Id::Kd,
    Id::DerivativeFilter,
    Id::TrackingTime,
    Id::CommandMin,
    Id::CommandMax,
    Id::CommandSlew,
    Id::ObserverSlope,
    Id::ObserverReach,
    Id::ObserverBand,
];

/// Those of them that are the observer's.
pub const OBSERVER: [Id; 3] = [Id::ObserverSlope, Id::ObserverReach, Id::ObserverBand];

/// The field of one of [`CONTROLLER`].
pub fn of_controller(tracking: &mut BoardParameters, id: Id) -> Option<Field<'_>> {
    let TrackingParameters { pid, observer, command_min, command_max, slew_bar_per_s, .. } = tracking;
    Some(Field::Quantity(match id {
        Id::Kp => &mut pid.kp,
        Id::Ki => &mut pid.ki,
        Id::Kd => &mut pid.kd,
        Id::DerivativeFilter => &mut pid.derivative_filter_s,
        Id::TrackingTime => &mut pid.tracking_time_s,
        Id::CommandMin => command_min,
        Id::CommandMax => command_max,
        Id::CommandSlew => slew_bar_per_s,
        Id::ObserverSlope => &mut observer.slope,
        Id::ObserverReach => &mut observer.reach,
        Id::ObserverBand => &mut observer.band,
        _ => return None,
    }))
}

/// The first register of [`CONTROLLER`] whose field exceeds what is compiled into the board, and
/// what it holds.
pub fn excess(tracking: &mut BoardParameters) -> Option<(Id, Value)> {
    CONTROLLER
        .into_iter()
        .filter_map(|id| Some((id, of_controller(tracking, id)?.get())))
        .find(|(id, value)| !id.register().takes(*value))
}

/// The registers of the group "Protection".
pub const PROTECTION: [Id; 17] = [
    Id::SelfTestTicks,
    Id::VentedBar,
    Id::OverpressureHard,
    Id::OverpressureSoft,
    Id::SupplyMin,
    Id::PressureJump,
    Id::ContractionJump,
    Id::StuckCommand,
    Id::ImplausibleShare,
    Id::FollowingBand,
    Id::FollowingLimit,
    Id::Authority,
    Id::BusSilent,
    Id::SoftStart,
    Id::Slew,
    Id::TemperatureMax,
    Id::OnModelFault,
];

/// The first register of [`PROTECTION`] whose limit exceeds what is compiled into the board, and
/// what it holds.
pub fn excess_of_protection(protection: &Protection) -> Option<(Id, Value)> {
    let mut protection = *protection;
    PROTECTION
        .into_iter()
        .filter_map(|id| Some((id, of_protection(&mut protection, id)?.get())))
        .find(|(id, value)| !id.register().takes(*value))
}

/// The field of a register of the group "Protection".
pub fn of_protection(protection: &mut Protection, id: Id) -> Option<Field<'_>> {
    Some(match id {
        Id::SelfTestTicks => Field::Whole(&mut protection.self_test_ticks),
        Id::BusSilent => Field::Whole(&mut protection.bus_silent_ticks),
        Id::OnModelFault => Field::OnModelFault(&mut protection.on_model_fault),
        _ => Field::Quantity(match id {
            Id::VentedBar => &mut protection.vented_bar,
            Id::OverpressureHard => &mut protection.overpressure_hard_bar,
            Id::OverpressureSoft => &mut protection.overpressure_soft_bar,
            Id::SupplyMin => &mut protection.supply_min_bar,
            Id::PressureJump => &mut protection.pressure_jump_bar,
            Id::ContractionJump => &mut protection.contraction_jump_mm,
            Id::StuckCommand => &mut protection.stuck_command_bar,
            Id::ImplausibleShare => &mut protection.implausible_share,
            Id::FollowingBand => &mut protection.following_band_bar,
            Id::FollowingLimit => &mut protection.following_limit_bar_s,
            Id::Authority => &mut protection.authority_bar,
            Id::SoftStart => &mut protection.soft_start_bar_per_s,
            Id::Slew => &mut protection.slew_bar_per_s,
            Id::TemperatureMax => &mut protection.temperature_max_c,
            _ => return None,
        }),
    })
}

/// The registers of [`BusParameters`].
pub const BUS: [Id; 4] = [Id::BusNumber, Id::BusParity, Id::BusRate, Id::BusTurnaround];

/// The field of one of [`BUS`].
pub fn of_bus(bus: &mut BusParameters, id: Id) -> Option<Field<'_>> {
    Some(match id {
        Id::BusNumber => Field::Unit(&mut bus.unit),
        Id::BusParity => Field::Parity(&mut bus.parity),
        Id::BusRate => Field::Whole(&mut bus.baud),
        Id::BusTurnaround => Field::Whole(&mut bus.turnaround_us),
        _ => return None,
    })
}

/// The registers of [`Calibration`]; behind them stands its checksum.
pub const CALIBRATION: [Id; 9] = [
    Id::CalibratedPressureZero,
    Id::CalibratedPressureGain,
    Id::CalibratedContractionZero,
    Id::CalibratedContractionGain,
    Id::CalibratedSupplyZero,
    Id::CalibratedSupplyGain,
    Id::CalibratedCommandZero,
    Id::CalibratedCommandGain,
    Id::CalibrationDay,
];

/// The field of one of [`CALIBRATION`].
pub fn of_calibration(calibration: &mut Calibration, id: Id) -> Option<Field<'_>> {
    let Calibration { pressure, contraction, supply, command, day, .. } = calibration;
    Some(match id {
        Id::CalibratedPressureZero => Field::Quantity(&mut pressure.zero_code),
        Id::CalibratedPressureGain => Field::Quantity(&mut pressure.codes_per_unit),
        Id::CalibratedContractionZero => Field::Quantity(&mut contraction.zero_code),
        Id::CalibratedContractionGain => Field::Quantity(&mut contraction.codes_per_unit),
        Id::CalibratedSupplyZero => Field::Quantity(&mut supply.zero_code),
        Id::CalibratedSupplyGain => Field::Quantity(&mut supply.codes_per_unit),
        Id::CalibratedCommandZero => Field::Quantity(&mut command.zero_code),
        Id::CalibratedCommandGain => Field::Quantity(&mut command.codes_per_unit),
        Id::CalibrationDay => Field::Whole(day),
        _ => return None,
    })
}

/// The registers of [`Inputs`]; behind them stands their checksum.
pub const INPUTS: [Id; 12] = [
    Id::PressureInput,
    Id::PressureInputPin,
    Id::PressureInputLow,
    Id::PressureInputHigh,
    Id::ContractionInput,
    Id::ContractionInputPin,
    Id::ContractionInputLow,
    Id::ContractionInputHigh,
    Id::SupplyInput,
    Id::SupplyInputPin,
    Id::SupplyInputLow,
    Id::SupplyInputHigh,
];

/// The field of one of [`INPUTS`].
pub fn of_inputs(inputs: &mut Inputs, id: Id) -> Option<Field<'_>> {
    let place = INPUTS.iter().position(|input| *input == id)?;
    let input = match place / 4 {
        0 => &mut inputs.pressure,
        1 => &mut inputs.contraction,
        _ => &mut inputs.supply,
    };
    let Input { signal, pin_v, low, high } = input;
    Some(match place % 4 {
        0 => Field::Signal(signal),
        1 => Field::Quantity(pin_v),
        2 => Field::Quantity(low),
        _ => Field::Quantity(high),
    })
}
