//! What can go wrong on a board, by stable numbers. [`table`] says what each means and what cures
//! it, [`times`] how long each lasts before the board reacts.

pub mod table;
pub mod times;

use serde::{Deserialize, Serialize};

/// A fault. The numbers are stable: a new one is added at the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
#[allow(missing_docs, reason = "the fault table has a page on each")]
pub enum Fault {
    Acquisition = 1,
    PressureSensor = 2,
    ContractionSensor = 3,
    Reference = 4,
    SupplySensor = 5,
    PressureStuck = 6,
    ContractionStuck = 7,
    PressureSpiking = 8,
    ContractionSpiking = 9,
    Implausible = 10,
    OverpressureHard = 11,
    OverpressureSoft = 12,
    SupplyLow = 13,
    Leak = 14,
    ValveStuck = 15,
    NotFinite = 16,
    Model = 17,
    Authority = 18,
    Deadline = 19,
    TaskSilent = 20,
    BusSilent = 21,
    ConfigurationCorrupt = 22,
    ConfigurationVersion = 23,
    BrownOut = 24,
    StackOverflow = 25,
    HardFault = 26,
    Panic = 27,
    WatchdogReset = 28,
    ResetLoop = 29,
    Clock = 30,
    Temperature = 31,
    EmergencyStop = 32,
    VentIneffective = 33,
    OutputStray = 34,
    ReferenceVoltage = 35,
    ImageDamaged = 36,
    MemoryDamaged = 37,
    DumpHeld = 38,
    CalibrationCorrupt = 39,
    HeartbeatStands = 40,
    Adaptation = 41,
}

/// Number of faults.
pub const FAULTS: usize = Fault::ALL.len();

impl Fault {
    /// All of them, in the order of their numbers, which begin at 1.
    pub const ALL: [Self; 41] = [
        Self::Acquisition,
        Self::PressureSensor,
        Self::ContractionSensor,
        Self::Reference,
        Self::SupplySensor,
        Self::PressureStuck,
        Self::ContractionStuck,
        Self::PressureSpiking,
        Self::ContractionSpiking,
        Self::Implausible,
        Self::OverpressureHard,
        Self::OverpressureSoft,
        Self::SupplyLow,
        Self::Leak,
        Self::ValveStuck,
        Self::NotFinite,
        Self::Model,
        Self::Authority,
        Self::Deadline,
        Self::TaskSilent,
        Self::BusSilent,
        Self::ConfigurationCorrupt,
        Self::ConfigurationVersion,
        Self::BrownOut,
        Self::StackOverflow,
        Self::HardFault,
        Self::Panic,
        Self::WatchdogReset,
        Self::ResetLoop,
        Self::Clock,
        Self::Temperature,
        Self::EmergencyStop,
        Self::VentIneffective,
        Self::OutputStray,
        Self::ReferenceVoltage,
        Self::ImageDamaged,
        Self::MemoryDamaged,
        Self::DumpHeld,
        Self::CalibrationCorrupt,
        Self::HeartbeatStands,
        Self::Adaptation,
    ];

    /// The stable number.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// Whether nothing but power-off ends it.
    pub fn outlasts_acknowledgement(self) -> bool {
        table::TABLE.iter().any(|row| row.fault == self && row.latch == table::Latch::PowerOn)
    }

    /// The fault with a number.
    pub fn of_code(code: u8) -> Option<Self> {
        Self::ALL.get(usize::from(code).checked_sub(1)?).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::Fault;

    #[test]
    fn every_number_is_that_of_its_place_and_of_one_fault() {
        for (place, fault) in Fault::ALL.into_iter().enumerate() {
            assert_eq!(usize::from(fault.code()), place + 1);
            assert_eq!(Fault::of_code(fault.code()), Some(fault));
        }
        assert_eq!([Fault::of_code(0), Fault::of_code(Fault::ALL.len() as u8 + 1)], [None; 2]);
    }
}
