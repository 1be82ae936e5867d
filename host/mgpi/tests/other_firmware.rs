//! `mgpi status` against firmware that is older or newer: it says what it can, and how they differ.

mod common;
#[path = "common/line.rs"]
mod line;

use common::Bench;
use line::{Line, framed};
use serde_json::Value;
use wire::FAULTS;
use wire::registers::{Id, Register, VERSION};

/// A board that answers readings, and has latched a fault twice.
struct Other {
    messages: u16,
    /// How many it knows.
    faults: usize,
    latched: u16,
}

impl Other {
    fn word(&self, address: u16) -> Option<u16> {
        let register = Register::at(address)?;
        let counted = usize::from(address - Id::FaultCounts.register().address.min(address));
        Some(match register.id {
            Id::RegistersVersion => VERSION,
            Id::WireVersion => self.messages,
            Id::Fault => self.latched,
            Id::FaultCounts if counted >= self.faults => return None,
            Id::FaultCounts => 2 * u16::from(counted + 1 == usize::from(self.latched)),
            Id::TickPeriod => 1000 * (address - register.address),
            // 1.0 of 32 bits.
            Id::PressureGain | Id::ContractionGain | Id::CommandGain if address == register.address => 0x3F80,
            _ => 0,
        })
    }

    fn answer(&self, request: &[u8]) -> Vec<u8> {
        let word = |place: usize| u16::from_be_bytes([request[place], request[place + 1]]);
        let (first, count) = (word(2), word(4));
        let words: Option<Vec<u16>> = (first..first + count).map(|address| self.word(address)).collect();
        framed(&words.map_or_else(
            || vec![1, 0x83, 2],
            |words| {
                let bytes = words.into_iter().flat_map(u16::to_be_bytes);
                [1, 3, 2 * count as u8].into_iter().chain(bytes).collect()
            },
        ))
    }

    /// What `mgpi status` says of it: for people, for programs.
    fn shown(self) -> (String, Value) {
        let line = Line::new(move |request| self.answer(request));
        let (bench, port) = (Bench::new(), line.path().display().to_string());
        let json = bench.succeeds(&format!("status --json --port {port}"));
        (bench.succeeds(&format!("status --port {port}")), serde_json::from_str(&json).expect("JSON"))
    }
}

#[test]
fn of_firmware_that_knows_fewer_faults_all_is_shown_that_it_knows_and_how_the_versions_differ() {
    for faults in [1, 2, 12, FAULTS - 2, FAULTS - 1] {
        let latched = 2.min(faults as u16);
        let (text, json) = Other { messages: wire::VERSION - 1, faults, latched }.shown();
        let said = format!("knows faults 1 to {faults} of {FAULTS}");
        assert!(text.contains("the firmware is older") && text.contains(&said), "{text}");
        assert!(text.contains(&format!("messages {}, this program {}", wire::VERSION - 1, wire::VERSION)));
        assert_eq!(json["versions"]["faults"], faults, "{json}");
        assert_eq!(
            (&json["occurred"][0]["number"], &json["occurred"][0]["count"]),
            (&latched.into(), &2.into())
        );
    }
}

#[test]
fn a_fault_of_newer_firmware_is_not_shown_as_none() {
    let number = FAULTS as u16 + 3;
    let (text, json) = Other { messages: wire::VERSION + 1, faults: FAULTS, latched: number }.shown();
    assert!(text.contains(&format!("fault       {number}, which this program does not know")), "{text}");
    assert!(text.contains("the firmware is newer") && text.contains("use a newer mgpi"), "{text}");
    assert_eq!(json["fault"]["number"], number);
}

#[test]
fn of_firmware_of_this_release_no_difference_is_shown() {
    let (text, json) = Other { messages: wire::VERSION, faults: FAULTS, latched: 0 }.shown();
    assert!(text.contains("fault       none") && !text.contains("versions"), "{text}");
    assert_eq!(json["versions"]["difference"], Value::Null);
}
