//! The registers of the board's Modbus: what a user, a PLC or `mgpi` reads and writes.
//!
//! # Design
//! [`TABLE`] is the one list of registers: the board answers from it, the host asks by it,
//! `docs/registers.md` and `docs/registers.csv` are made of it. Registers stand in groups; between
//! two groups, and within some, there are free addresses, so that one write never changes two
//! groups.
//!
//! # Contract
//! * Addresses are those of the frame, counted from 0. All registers are holding registers; all can
//!   be read, by function 3 or 4 alike.
//! * A number of 32 bits takes two registers, the high word first. Half of one is not written.
//! * A write is carried out as a whole or refused as a whole, by an [`Exception`]. The limits in
//!   the table are compiled into the board: nothing that comes by the bus exceeds them.
//! * A moment is a number of ticks; texts and bytes stand two in a register, the first one in the
//!   high half.
//!
//! # Versions
//! [`VERSION`] is that of the map, apart from those of the messages, the storage and the release.
//! It is raised when a register that exists comes to mean something else; new registers leave it.

pub mod fields;
mod names;
mod table;
mod value;
mod windows;

pub use names::{
    BusListens, Command, Exception, Learning, StreamOrder, StreamState, UpdateOrder, UpdateResult,
    UpdateTrial, UploadOrder, UploadResult, mode, mode_number, state, state_number,
};
pub use table::{GROUPS, Group, HIGHEST_BAR, Id, TABLE};
pub use value::{Kind, Value};
pub(crate) use windows::CRC;
pub use windows::{
    CAPTURE_HEAD, CAPTURE_SAMPLES, MESSAGE_REGISTERS, QUEUE_POINTS, SAMPLE_REGISTERS, STREAM_POINTS,
    TRACE_ENTRY_REGISTERS, UPLOAD_BYTES, UPLOAD_REGISTERS, bytes_of, checksum, pack_bytes, pack_sample,
    pack_trace_entry, unpack_sample, unpack_trace_entry,
};

/// Version of the map.
pub const VERSION: u16 = 1;
/// A new board's number on the bus.
pub const UNIT: u8 = 1;
/// A new board's rate; 8 data bits, no parity, one stop bit. Unit: bit/s.
pub const BAUD: u32 = 115_200;
/// How long a board that was armed takes a start: a PLC that does something once a second has time
/// for both steps. Unit: tick.
pub const ARMED_TICKS: u16 = 2_000;
/// The longest frame, address and CRC included. Unit: byte.
pub const FRAME_BYTES: usize = 256;
/// The most registers that are read at once.
pub const MOST_READ: u16 = 125;
/// The most registers that are written at once.
pub const MOST_WRITTEN: u16 = 123;

/// A register, or a run of them of one kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Register {
    /// Which one.
    pub id: Id,
    /// With the unit, if it has one.
    pub name: &'static str,
    /// Of its first word.
    pub address: u16,
    /// What its words are.
    pub kind: Kind,
    /// Number of values, more than 1 in a run.
    pub length: u16,
    /// "" for a pure number.
    pub unit: &'static str,
    /// Whether it is written too.
    pub access: Access,
    /// What it says, in a line.
    pub doc: &'static str,
}

/// What a host may do with a register.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Access {
    /// Read it.
    Read,
    /// Read and write it, within these limits.
    Write(f64, f64),
}

impl Register {
    /// Number of words.
    pub const fn words(&self) -> u16 {
        self.length * self.kind.words()
    }

    /// The address behind its last word.
    pub const fn end(&self) -> u16 {
        self.address + self.words()
    }

    /// The register that has an address.
    pub fn at(address: u16) -> Option<&'static Self> {
        let behind = TABLE.partition_point(|register| register.address <= address);
        TABLE.get(behind.checked_sub(1)?).filter(|register| address < register.end())
    }

    /// Whether it may be written with this value.
    pub fn takes(&self, value: Value) -> bool {
        match self.access {
            Access::Read => false,
            Access::Write(min, max) => {
                // The limits as the register itself would hold them.
                let [min, max] = [min, max].map(|limit| Value::of_number(self.kind, limit).number());
                value.kind() == self.kind && (min..=max).contains(&value.number())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn registers_follow_each_other_without_overlap_and_an_address_belongs_to_one() {
        for pair in TABLE.windows(2) {
            assert!(pair[0].end() <= pair[1].address, "{} and {}", pair[0].name, pair[1].name);
        }
        for address in 0..=u16::MAX {
            let owners: std::vec::Vec<_> =
                TABLE.iter().filter(|r| (r.address..r.end()).contains(&address)).collect();
            assert_eq!(Register::at(address), owners.first().copied());
            assert!(owners.len() <= 1);
        }
    }

    #[test]
    fn every_register_is_found_by_its_name_and_its_number() {
        let names: HashSet<_> = TABLE.iter().map(|register| register.name).collect();
        assert_eq!(names.len(), TABLE.len());
        for register in &TABLE {
            assert_eq!(register.id.register(), register);
        }
    }

    #[test]
    fn groups_are_apart() {
        for group in &GROUPS[1..] {
            assert_eq!(Register::at(group.address - 1), None, "{}", group.title);
            assert!(Register::at(group.address).is_some(), "{}", group.title);
        }
    }

    #[test]
    fn limits_are_in_order_and_a_name_ends_in_its_unit() {
        for register in &TABLE {
            if let Access::Write(min, max) = register.access {
                assert!(min <= max, "{}", register.name);
            }
            let suffix = match register.unit {
                "" | "code" | "code/bar" | "code/mm" => continue,
                "°C" => "_c".into(),
                "tick" => "ticks".into(),
                "cycle" => "cycles".into(),
                unit => std::format!("_{}", unit.to_lowercase().replace(' ', "_").replace('/', "_per_")),
            };
            let name = register.name;
            assert!(name.ends_with(&suffix) || name.contains("tick"), "{name}, unit {}", register.unit);
        }
    }
}
