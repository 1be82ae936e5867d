//! `docs/registers.md` and `docs/registers.csv`, made of the table in `wire/src/registers`.

use std::fmt::Write as _;
use std::fs;

use anyhow::{Context, Result, ensure};
use wire::registers::{Access, BAUD, Exception, GROUPS, Register, TABLE, UNIT, VERSION};

use crate::run;

const HEADER: &str = "\
<!-- Made by `cargo xtask registers` from wire/src/registers. -->

# Registers

What the board answers by Modbus RTU, to a PLC, to a script or to `mgpi`; [registers.csv](registers.csv) is the same to import.
";

const RULES: &str = "\
All registers are holding registers, at the addresses that go over the wire, counted from 0 (tools that count from 1, or from
40001, add that). Every register can be read by function 3 and by function 4.

| function | what the board does |
|---|---|
| 3, 4 | reads registers |
| 6, 16 | writes one, or several |
| 22 | mask write: bits of a register of one word |
| 23 | writes registers, then reads registers, in one request |
| 8 | diagnostics: sub-function 0 sends its data back; 12, 13, 14 count damaged frames, refused requests, requests for this board |
| 17 | board number, 0xFF while the valve is driven else 0, name and release |
| 43/14 | device identification: 0 vendor, 1 product code, 2 release, 4 product name, 5 processor |
| 65 | to all (number 0) alone: the [exchange in slots](network.md#all-boards-of-a-line-at-once) of a gateway, which each board that it names answers |

- 32 bits take two registers, the high word first; half of such a pair is not written.
- A request is carried out as a whole, or refused as a whole with an exception, and then nothing has changed.
- Limits are compiled into the firmware: nothing that is written exceeds them. What is not finite is refused.
- A damaged frame, or one for another address, is met with silence. Address 0 is carried out by all and answered by none; but
  nothing that opens a valve (arming, a start, the service state), which each board is asked for by its number. A stop, and a
  heartbeat, may be for all.
- A valve is opened in two steps: command 6, then 1 or 5 within 2,000 ticks.
- While the valve is driven, another number has to come to `heartbeat`, or new points to the stream, at least every
  `bus_silent_ticks`. Else it is vented, with fault 21, or with fault 40 where the same number has come again. Readings, set points and
  orders are no sign of life: what sends them may go on while the program behind it stands.
- A write that is stored (groups Controller and Protection, a commit) may take half a second, in which the board hears
  nothing: give it a time-out of 2 s.
- A frame ends with its last byte; one of an unknown function after 3.5 characters of silence. In the emulator 20 ms stand for
  them.

| exception | when |
|---|---|
";

/// Writes both files, or only compares.
///
/// # Errors
/// A file cannot be written, or differs from the table.
pub fn registers(check: bool) -> Result<()> {
    for (name, text) in [("docs/registers.md", page()), ("docs/registers.csv", list())] {
        let path = run::root().join(name);
        if check {
            let is_current = fs::read_to_string(&path).is_ok_and(|found| found == text);
            ensure!(is_current, "{} is out of date: cargo xtask registers", path.display());
        } else {
            fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
        }
    }
    Ok(())
}

fn page() -> String {
    let mut page = HEADER.to_owned();
    // Writing to a string cannot fail.
    let _ = write!(
        page,
        "Version {VERSION} of the map. A new board has the number {UNIT}, {BAUD} bit/s, 8 data bits, no parity, one stop bit; the group \
         Bus changes that.\n\n{RULES}"
    );
    for exception in Exception::ALL {
        let _ = writeln!(page, "| {} | {} |", exception.number(), when(*exception));
    }
    for (group, end) in GROUPS.iter().zip(GROUPS.iter().skip(1).map(|next| next.address).chain([u16::MAX])) {
        let _ = write!(page, "\n## {}\n\n{}\n\n", group.title, group.doc);
        page += "| address | name | type | unit | access | what |\n|---|---|---|---|---|---|\n";
        for register in TABLE.iter().filter(|register| (group.address..end).contains(&register.address)) {
            let _ = writeln!(
                page,
                "| {:#06x} | `{}` | {} | {} | {} | {} |",
                register.address,
                register.name,
                kind(register),
                register.unit,
                access(register),
                register.doc
            );
        }
    }
    page
}

fn list() -> String {
    let mut list = "address,name,type,length,words,unit,access,min,max,description\n".to_owned();
    for register in &TABLE {
        let (access, min, max) = match register.access {
            Access::Read => ("read", String::new(), String::new()),
            Access::Write(min, max) => ("write", min.to_string(), max.to_string()),
        };
        let Register { address, name, kind, length, unit, doc, .. } = register;
        let (kind, words) = (kind.name(), register.words());
        let _ =
            writeln!(list, "{address},{name},{kind},{length},{words},{unit},{access},{min},{max},\"{doc}\"");
    }
    list
}

fn kind(register: &Register) -> String {
    match register.length {
        1 => register.kind.name().to_owned(),
        length => format!("{} × {length}", register.kind.name()),
    }
}

fn access(register: &Register) -> String {
    match register.access {
        Access::Read => "read".to_owned(),
        Access::Write(min, max) => format!("write, {min} to {max}"),
    }
}

fn when(exception: Exception) -> &'static str {
    match exception {
        Exception::IllegalFunction => "there is no such function here",
        Exception::IllegalAddress => "there is no such register, or it is only read",
        Exception::IllegalValue => {
            "a value is out of its limits, not finite, or half of a pair; a length does not fit; a configuration is not valid"
        }
        Exception::DeviceFailure => {
            "the board cannot carry it out; of what is stored: it is in use, but the flash has not kept it"
        }
        Exception::DeviceBusy => "the board's state does not allow it now",
    }
}
