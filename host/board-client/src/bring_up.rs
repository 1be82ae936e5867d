//! A board with the bring-up image: asking it for a run over its service link, and the record of
//! what it has told (`wire::bring_up`).
//!
//! # Contract
//! A report that is cut off, disturbed or of another form is refused as a whole: there is no record
//! of half a board. Whether a part is faulty the board says; the record keeps value, limits and
//! verdict as they came.

use std::path::Path;
use std::time::{Duration, Instant};

use recording::day::Day;
use thiserror::Error;
use toml::{Table, Value};
use wire::bring_up::{CHECKSUM, ECHO, END, FAULTY, GOOD, NONE, OUTPUT, RUN, Wanted};

use crate::bus::port::{Line, Parity, Port, PortError};
use crate::joint::link::BAUD;
use crate::stop::Stop;

/// The longest silence within a report: the cycle of the flash takes 1.5 s at most, the watchdog
/// bites behind 4 to 8 s.
const SILENCE: Duration = Duration::from_secs(9);
/// How long somebody who wants to stop waits at most.
const GLANCE: Duration = Duration::from_millis(100);
/// More than any report has: a port that never ends is no board's. Unit: byte.
const MOST_BYTES: usize = 64 * 1024;

/// Why there is no record.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum BringUpError {
    #[error(transparent)]
    Port(#[from] PortError),
    #[error(
        "{port}: nobody answers: is the bring-up image in the board (docs/bring-up.md), and the port its service link, \
         TX and RX crossed?"
    )]
    Silent { port: String },
    #[error("{port}: the report breaks off behind the part {last}")]
    CutOff { port: String, last: String },
    #[error("{port}: line {line} of the report is not `NAME VALUE LOWEST HIGHEST ok` or `FAULT`: {text:?}")]
    NotALine { port: String, line: usize, text: String },
    #[error("{port}: the report's checksum is {told}, that of its lines {found}: the link is disturbed")]
    Checksum { port: String, told: String, found: String },
    #[error("{} of {parts} parts are faulty: {}", faulty.len(), faulty.join(", "))]
    Faulty { parts: usize, faulty: Vec<String> },
    #[error("interrupted; the board finishes its run by itself")]
    Stopped,
}

/// A part of the report.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// With the unit at its end, if it has one.
    pub name: String,
    /// As it was told.
    pub value: String,
    /// Lowest and highest value of a sound one; none of a word.
    pub limits: Option<[String; 2]>,
    /// Whether it is within them.
    pub is_good: bool,
}

impl Part {
    fn of_line(line: &str) -> Option<Self> {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let &[name, value, lowest, highest, verdict] = &words[..] else { return None };
        let limits = (lowest != NONE).then(|| [lowest.to_owned(), highest.to_owned()]);
        let is_known = [GOOD, FAULTY].contains(&verdict);
        is_known.then(|| Self {
            name: name.to_owned(),
            value: value.to_owned(),
            limits,
            is_good: verdict == GOOD,
        })
    }

    /// In a line, for people.
    pub fn in_words(&self) -> String {
        let Self { name, value, limits, is_good } = self;
        let verdict = if *is_good { GOOD } else { FAULTY };
        match limits {
            Some([lowest, highest]) => {
                format!("{verdict:5}  {name}: {value}, has to be {lowest} to {highest}")
            }
            None => format!("{verdict:5}  {name}: {value}"),
        }
    }

    fn to_table(&self) -> Table {
        let number = |text: &str| {
            let whole = text.parse().map(Value::Integer).ok();
            whole
                .or_else(|| text.parse().ok().map(Value::Float))
                .unwrap_or_else(|| Value::String(text.to_owned()))
        };
        let mut table = Table::new();
        if self.value != NONE {
            let value =
                if self.limits.is_some() { number(&self.value) } else { Value::String(self.value.clone()) };
            table.insert("value".to_owned(), value);
        }
        for (key, text) in ["lowest", "highest"].into_iter().zip(self.limits.iter().flatten()) {
            table.insert(key.to_owned(), number(text));
        }
        table.insert("good".to_owned(), Value::Boolean(self.is_good));
        table
    }
}

/// What a board has told, from the first part to the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// In the order of the run.
    pub parts: Vec<Part>,
}

impl Report {
    /// Reads a whole one. `port`: for messages.
    ///
    /// # Errors
    /// It is cut off, disturbed, or no report.
    pub fn parse(port: &Path, text: &[u8]) -> Result<Self, BringUpError> {
        let port = port.display().to_string();
        let lines = String::from_utf8_lossy(text);
        let mut parts = Vec::new();
        let mut before = 0;
        for (index, line) in lines.split_inclusive('\n').enumerate() {
            let not_a_line = || BringUpError::NotALine {
                port: port.clone(),
                line: index + 1,
                text: line.trim_end().to_owned(),
            };
            if let Some(end) =
                line.strip_prefix(END).filter(|end| end.starts_with(' ') && end.ends_with('\n'))
            {
                let words: Vec<&str> = end.split_ascii_whitespace().collect();
                let &[count, faulty, told] = &words[..] else { return Err(not_a_line()) };
                let found = text.get(..before).map(|before| format!("{:08x}", CHECKSUM.checksum(before)));
                let found = found.unwrap_or_default();
                let report = Self { parts };
                let counts = [report.parts.len(), report.faulty().len()].map(|count| count.to_string());
                if found != told || counts != [count, faulty] {
                    return Err(BringUpError::Checksum { port, told: told.to_owned(), found });
                }
                return Ok(report);
            }
            parts.push(Part::of_line(line).filter(|_| line.ends_with('\n')).ok_or_else(not_a_line)?);
            before += line.len();
        }
        match parts.pop() {
            Some(last) => Err(BringUpError::CutOff { port, last: last.name }),
            None => Err(BringUpError::Silent { port }),
        }
    }

    /// The names of the parts that are not as they have to be.
    pub fn faulty(&self) -> Vec<String> {
        self.parts.iter().filter(|part| !part.is_good).map(|part| part.name.clone()).collect()
    }

    /// Whether nothing is faulty.
    ///
    /// # Errors
    /// Something is; its names.
    pub fn verdict(&self) -> Result<(), BringUpError> {
        match self.faulty() {
            faulty if faulty.is_empty() => Ok(()),
            faulty => Err(BringUpError::Faulty { parts: self.parts.len(), faulty }),
        }
    }

    /// The record: a table a part, behind who has made it, of today.
    pub fn to_toml(&self, made_by: &str) -> String {
        let mut table = Table::new();
        table.insert("made_by".to_owned(), made_by.into());
        table.insert("day".to_owned(), Day::today().to_string().into());
        table.insert("passed".to_owned(), self.faulty().is_empty().into());
        table.insert("faulty".to_owned(), self.faulty().into());
        self.parts.iter().for_each(|part| {
            table.insert(part.name.clone(), part.to_table().into());
        });
        format!("# Bring-up of a valve board, a part each: docs/bring-up.md\n{table}")
    }
}

/// Asks a board for a run, and waits for the whole report. `each`: shown each part as it comes.
///
/// # Errors
/// The port cannot be used, nobody answers, or not by a whole report.
pub fn run(port: &Path, wanted: Wanted, stop: &Stop, each: impl Fn(&Part)) -> Result<Report, BringUpError> {
    let mut link = Port::open(port, Line { baud: BAUD, parity: Parity::None })?;
    link.discard()?;
    let words = [(true, RUN), (wanted.output, OUTPUT), (wanted.echo, ECHO)];
    let words: Vec<&str> = words.iter().filter(|(is_wanted, _)| *is_wanted).map(|(_, word)| *word).collect();
    // The empty line ends whatever stood on the line before.
    link.send(format!("\n{}\n", words.join(" ")).as_bytes(), Instant::now() + SILENCE)?;
    let (mut text, mut shown) = (Vec::new(), 0);
    let mut heard = Instant::now();
    while heard.elapsed() < SILENCE && text.len() < MOST_BYTES {
        if stop.is_requested() {
            return Err(BringUpError::Stopped);
        }
        let mut buffer = [0; 256];
        let count = link.receive(&mut buffer, Instant::now() + GLANCE)?;
        if count == 0 {
            continue;
        }
        heard = Instant::now();
        text.extend_from_slice(&buffer[..count]);
        while let Some(length) = text[shown..].iter().position(|&byte| byte == b'\n') {
            let line = String::from_utf8_lossy(&text[shown..shown + length]).into_owned();
            shown += length + 1;
            match Part::of_line(&line) {
                Some(part) => each(&part),
                None => return Report::parse(port, &text[..shown]),
            }
        }
    }
    Report::parse(port, &text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report() -> String {
        let lines =
            "unique_id 0a1b - - ok\ncrystal_hz - 7680000 8320000 FAULT\nsupply_v 3.301 3.102 3.498 ok\n";
        format!("{lines}end 3 1 {:08x}\n", CHECKSUM.checksum(lines.as_bytes()))
    }

    fn said(text: &str) -> String {
        Report::parse(Path::new("P"), text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn a_report_becomes_a_record_with_a_table_a_part() {
        let report = Report::parse(Path::new("P"), report().as_bytes()).unwrap();
        assert_eq!(report.faulty(), ["crystal_hz"]);
        assert_eq!(report.verdict().unwrap_err().to_string(), "1 of 3 parts are faulty: crystal_hz");
        let record: Table = report.to_toml("mgpi 1").parse().unwrap();
        assert_eq!(record["made_by"].as_str(), Some("mgpi 1"));
        assert_eq!(record["passed"].as_bool(), Some(false));
        assert_eq!(record["unique_id"]["value"].as_str(), Some("0a1b"));
        assert_eq!(record["crystal_hz"].get("value"), None);
        assert_eq!(record["crystal_hz"]["lowest"].as_integer(), Some(7_680_000));
        assert_eq!(record["supply_v"]["value"].as_float(), Some(3.301));
        assert_eq!(record["supply_v"]["good"].as_bool(), Some(true));
    }

    #[test]
    fn a_report_that_is_cut_off_or_disturbed_is_no_report() {
        let whole = report();
        for length in 0..whole.len() {
            assert!(Report::parse(Path::new("P"), &whole.as_bytes()[..length]).is_err(), "{length}");
        }
        for place in 0..whole.len() {
            let mut bytes = whole.clone().into_bytes();
            bytes[place] ^= 1;
            assert!(Report::parse(Path::new("P"), &bytes).is_err(), "{place}");
        }
        assert!(said("").starts_with("P: nobody answers"));
        assert_eq!(said("a 1 0 2 ok\nb 1 0 2 ok\n"), "P: the report breaks off behind the part b");
        assert_eq!(
            said("a 1 0 2 ok\nb 1 0 2\n"),
            "P: line 2 of the report is not `NAME VALUE LOWEST HIGHEST ok` or `FAULT`: \"b 1 0 2\""
        );
        assert!(said(&whole.replace("0a1b", "0a1c")).contains("the link is disturbed"));
    }
}
