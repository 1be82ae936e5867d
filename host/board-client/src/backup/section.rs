//! Registers of a board as tables of a backup: each by its name, which has its unit.

use std::ops::RangeInclusive;

use model_core::ObserverParameters;
use toml::{Table, Value as Toml};
use wire::registers::fields::{self, BUS, CALIBRATION, CONTROLLER, INPUTS, OBSERVER};
use wire::registers::{Access, Id, Kind, Register, TABLE, Value};
use wire::{BoardParameters, BusParameters, Calibration, Inputs, Line, Protection};

use recording::model_file::section::{KeyError, Section};

/// Time from tick to tick, which no register of the controller has.
const PERIOD: &str = "period_s";
/// The page of the registers of the group "Protection".
const PROTECTION_PAGE: u16 = 4;

/// The registers of the group "Protection".
pub fn protection_registers() -> impl DoubleEndedIterator<Item = &'static Register> {
    TABLE.iter().filter(|register| register.address >> 8 == PROTECTION_PAGE)
}

/// What a protection has at a register of its group.
pub fn protection_value(protection: &Protection, id: Id) -> Option<Value> {
    fields::of_protection(&mut protection.clone(), id).map(|field| field.get())
}

/// The limits of the plant as a table.
pub fn of_protection(protection: &Protection) -> Table {
    let entry = |register: &Register| {
        let value = protection_value(protection, register.id)?;
        Some((register.name.to_owned(), toml(value)))
    };
    protection_registers().filter_map(entry).collect()
}

/// Gains and limits of the controller as a table.
pub fn of_controller(parameters: &BoardParameters) -> Table {
    let mut parameters = parameters.clone();
    let mut table = Table::new();
    table.insert(PERIOD.to_owned(), toml(Value::F32(parameters.period_s)));
    let is_observed = parameters.observer != ObserverParameters::default();
    for id in CONTROLLER {
        // Older programs know none.
        if OBSERVER.contains(&id) && !is_observed {
            continue;
        }
        if let Some(field) = fields::of_controller(&mut parameters, id) {
            table.insert(id.register().name.to_owned(), toml(field.get()));
        }
    }
    table
}

/// How the board is reached as a table.
pub fn of_bus(bus: &BusParameters) -> Table {
    let mut bus = *bus;
    table(&BUS, |id| fields::of_bus(&mut bus, id).map(|field| field.get()))
}

/// What the sensors have shown as a table.
pub fn of_calibration(calibration: &Calibration) -> Table {
    let mut registers = CALIBRATION.to_vec();
    // Older programs know none but the standard sensors.
    if calibration.inputs != Inputs::STANDARD {
        registers.extend(INPUTS);
    }
    table(&registers, |id| calibration.value(id))
}

/// Registers by their names.
fn table(registers: &[Id], mut value: impl FnMut(Id) -> Option<Value>) -> Table {
    let entry = |id: &Id| Some((id.register().name.to_owned(), toml(value(*id)?)));
    registers.iter().filter_map(entry).collect()
}

/// How the board is reached, of a table.
///
/// # Errors
/// A key that is missing, unknown or of another kind, or a number that its register does not take.
pub fn to_bus(mut section: Section) -> Result<BusParameters, KeyError> {
    let mut bus = BusParameters::STANDARD;
    for id in BUS {
        let value = value_within(&mut section, id.register())?;
        fields::of_bus(&mut bus, id).into_iter().for_each(|field| field.set(value));
    }
    section.finish()?;
    Ok(bus)
}

/// What the sensors have shown, of a table.
///
/// # Errors
/// As for [`to_bus`].
pub fn to_calibration(mut section: Section) -> Result<Calibration, KeyError> {
    let line = Line { zero_code: 0.0, codes_per_unit: 1.0 };
    let mut calibration = Calibration {
        pressure: line,
        contraction: line,
        supply: line,
        command: line,
        day: 0,
        inputs: Inputs::STANDARD,
    };
    for id in CALIBRATION {
        let value = value_within(&mut section, id.register())?;
        fields::of_calibration(&mut calibration, id).into_iter().for_each(|field| field.set(value));
    }
    if section.has(Id::PressureInput.register().name) {
        for id in INPUTS {
            let value = value_within(&mut section, id.register())?;
            fields::of_inputs(&mut calibration.inputs, id).into_iter().for_each(|field| field.set(value));
        }
    }
    section.finish()?;
    Ok(calibration)
}

/// A value that its register takes.
pub(crate) fn value_within(section: &mut Section, register: &Register) -> Result<Value, KeyError> {
    let value = value(section, register)?;
    match register.access {
        Access::Write(min, max) if !register.takes(value) => Err(section.error(
            register.name,
            &format!("{} is out of range, must be {min} to {max} {}", value.number(), register.unit),
        )),
        _ => Ok(value),
    }
}

/// The limits of the plant of a table.
///
/// # Errors
/// A key that is missing, unknown or of another kind.
pub fn to_protection(mut section: Section) -> Result<Protection, KeyError> {
    let mut protection = Protection::STANDARD;
    for register in protection_registers() {
        let value = value(&mut section, register)?;
        fields::of_protection(&mut protection, register.id).into_iter().for_each(|field| field.set(value));
    }
    section.finish()?;
    Ok(protection)
}

/// Puts gains and limits of a table into a controller's parameters.
///
/// # Errors
/// A key that is missing, unknown or of another kind.
pub fn to_controller(mut section: Section, parameters: &mut BoardParameters) -> Result<(), KeyError> {
    parameters.period_s = section.number(PERIOD)? as f32;
    let is_observed = section.has(Id::ObserverSlope.register().name);
    for id in CONTROLLER {
        if OBSERVER.contains(&id) && !is_observed {
            continue;
        }
        let value = value(&mut section, id.register())?;
        fields::of_controller(parameters, id).into_iter().for_each(|field| field.set(value));
    }
    section.finish()
}

/// The version of the messages that a board had, one of those that are known.
///
/// # Errors
/// It is missing, no whole number, or another one.
pub fn messages(board: &mut Section, known: RangeInclusive<u16>) -> Result<u16, KeyError> {
    let messages = board.count("messages")?;
    let found = u16::try_from(messages).ok().filter(|messages| known.contains(messages));
    found.ok_or_else(|| {
        let (oldest, newest) = (known.start(), known.end());
        let known = if oldest == newest {
            format!("version {newest}")
        } else {
            format!("versions {oldest} to {newest}")
        };
        board.error("messages", &format!("{messages} is of another version; this program reads {known}"))
    })
}

/// The version of the firmware that a board had.
///
/// # Errors
/// It is missing, or no version.
pub fn release(board: &mut Section) -> Result<[u16; 3], KeyError> {
    let firmware = board.text("firmware")?;
    let release: Option<Vec<u16>> = firmware.split('.').map(|part| part.parse().ok()).collect();
    release
        .and_then(|release| <[u16; 3]>::try_from(release).ok())
        .ok_or_else(|| board.error("firmware", &format!("\"{firmware}\" is no version such as \"0.1.0\"")))
}

fn value(section: &mut Section, register: &Register) -> Result<Value, KeyError> {
    let number = section.limit(register.name)?;
    let value = Value::of_number(register.kind, number);
    if register.kind != Kind::F32 && value.number() != number {
        return Err(section.error(register.name, &format!("{number} is no whole number of its register")));
    }
    Ok(value)
}

/// A value; one of single precision in its shortest decimal form, which is read back as the same.
fn toml(value: Value) -> Toml {
    match value {
        Value::F32(number) => Toml::Float(shortest(number)),
        value => Toml::Integer(value.number() as i64),
    }
}

/// The number of double precision whose decimal form is the shortest one of a number of single
/// precision.
pub fn shortest(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(f64::from(number))
}
