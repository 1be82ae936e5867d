//! Which boards there are: the file that a gateway is given.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;
use std::{fs, io};

use board_client::bus::client::Address;
use board_client::bus::port::{Line as PortLine, Parity};
use serde::Deserialize;
use thiserror::Error;
use wire::registers::BAUD;

/// How long an answer may take beside its bytes, if the file does not say: a board answers within
/// 1 ms and may be told to wait up to 50 ms. Unit: s.
const ANSWER_S: f64 = 0.05;
/// Question and answer: 8 and 49 bytes, of 11 bits each with parity. Unit: bit.
const ANSWER_BITS: f64 = 57.0 * 11.0;
/// Rates of a board.
const RATES: std::ops::RangeInclusive<u32> = 9_600..=1_000_000;
/// Numbers of boards.
const NUMBERS: std::ops::RangeInclusive<u8> = 1..=247;

/// Why a file is of no use.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum LinesError {
    #[error("{}: {problem}", file.display())]
    Unreadable { file: PathBuf, problem: io::Error },
    #[error("{}: {problem}", file.display())]
    Toml { file: PathBuf, problem: Box<toml::de::Error> },
    #[error("{}: {problem}", file.display())]
    Wrong { file: PathBuf, problem: String },
}

/// A board of a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Member {
    /// Its number on the bus.
    pub number: u8,
    /// What people call it; unique among all lines.
    pub name: String,
}

/// A line with its boards.
#[derive(Clone, Debug)]
pub struct Line {
    /// What people call it.
    pub name: String,
    /// The port, its rate, and how long an answer may take; its number is the first board's.
    pub address: Address,
    /// The boards, in the order in which they are asked.
    pub boards: Vec<Member>,
}

/// The file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    line: Vec<FileLine>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileLine {
    name: Option<String>,
    port: PathBuf,
    rate_bit_per_s: Option<u32>,
    parity: Option<FileParity>,
    answer_s: Option<f64>,
    boards: Vec<FileBoard>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum FileParity {
    None,
    Even,
    Odd,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "a board is its number, 1 to 247, or { number = 1, name = \"biceps\" }")]
enum FileBoard {
    Number(u8),
    Named { number: u8, name: String },
}

impl From<FileParity> for Parity {
    fn from(parity: FileParity) -> Self {
        match parity {
            FileParity::None => Self::None,
            FileParity::Even => Self::Even,
            FileParity::Odd => Self::Odd,
        }
    }
}

/// Reads the lines of a file. A relative path of a port is relative to the file's folder.
///
/// # Errors
/// It cannot be read; what is wrong in it, by place.
pub fn read(file: &Path) -> Result<Vec<Line>, LinesError> {
    let text = fs::read_to_string(file)
        .map_err(|problem| LinesError::Unreadable { file: file.to_owned(), problem })?;
    let parsed: File = toml::from_str(&text)
        .map_err(|problem| LinesError::Toml { file: file.to_owned(), problem: Box::new(problem) })?;
    lines(parsed, file.parent().unwrap_or(Path::new("")))
        .map_err(|problem| LinesError::Wrong { file: file.to_owned(), problem })
}

fn lines(File { line }: File, directory: &Path) -> Result<Vec<Line>, String> {
    if line.is_empty() {
        return Err("there is no [[line]]".to_owned());
    }
    let (mut names, mut ports) = (BTreeSet::new(), BTreeSet::new());
    let mut lines = Vec::new();
    for (index, line) in line.into_iter().enumerate() {
        let name = line.name.unwrap_or_else(|| format!("line-{}", index + 1));
        let wrong = |problem: String| Err(format!("line {name}: {problem}"));
        let port = directory.join(&line.port);
        if !ports.insert(port.clone()) {
            return wrong(format!("another line has the port {} too", line.port.display()));
        }
        let baud = line.rate_bit_per_s.unwrap_or(BAUD);
        if !RATES.contains(&baud) {
            return wrong(format!(
                "rate_bit_per_s = {baud} is not in {} to {} bit/s",
                RATES.start(),
                RATES.end()
            ));
        }
        let answer_s = line.answer_s.unwrap_or(ANSWER_S + ANSWER_BITS / f64::from(baud));
        let Some(limit) = Duration::try_from_secs_f64(answer_s).ok().filter(|limit| !limit.is_zero()) else {
            return wrong(format!("answer_s = {answer_s} is no time"));
        };
        let mut numbers = BTreeSet::new();
        let mut boards = Vec::new();
        for board in line.boards {
            let (number, given) = match board {
                FileBoard::Number(number) => (number, None),
                FileBoard::Named { number, name } => (number, Some(name)),
            };
            if !NUMBERS.contains(&number) {
                return wrong(format!(
                    "board {number}: numbers are {} to {}",
                    NUMBERS.start(),
                    NUMBERS.end()
                ));
            }
            if !numbers.insert(number) {
                return wrong(format!("board {number} is there twice"));
            }
            let member = given.unwrap_or_else(|| format!("{name}/{number}"));
            if !names.insert(member.clone()) {
                return wrong(format!("another board has the name {member} too"));
            }
            boards.push(Member { number, name: member });
        }
        let Some(first) = boards.first() else {
            return wrong("there is no board".to_owned());
        };
        let parity = line.parity.map_or(Parity::None, Parity::from);
        let address = Address { port, line: PortLine { baud, parity }, unit: first.number, limit };
        lines.push(Line { name, address, boards });
    }
    Ok(lines)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn parsed(text: &str) -> Result<Vec<Line>, String> {
        let file: File = toml::from_str(text).map_err(|error| error.to_string())?;
        lines(file, Path::new("/lab"))
    }

    #[test]
    fn numbers_alone_will_do_and_names_may_be_given() {
        let lines = parsed(
            "[[line]]\nport = \"line-1\"\nboards = [1, {number = 2, name = \"biceps\"}]\n\
             [[line]]\nname = \"right\"\nport = \"/dev/ttyUSB0\"\nrate_bit_per_s = 1000000\nparity = \"even\"\nboards = [1]\n",
        )
        .expect("two lines");
        let names: Vec<&str> = lines.iter().flat_map(|line| &line.boards).map(|board| &*board.name).collect();
        assert_eq!(names, ["line-1/1", "biceps", "right/1"]);
        assert_eq!(lines[0].address.port, Path::new("/lab/line-1"));
        assert_eq!(lines[1].address.port, Path::new("/dev/ttyUSB0"));
        assert_eq!((lines[1].address.line.baud, lines[1].address.line.parity), (1_000_000, Parity::Even));
    }

    #[test]
    fn a_slow_line_is_given_the_time_that_its_bytes_take() {
        let limit = |rate: u32| {
            let lines = parsed(&format!("[[line]]\nport = \"p\"\nrate_bit_per_s = {rate}\nboards = [1]\n"));
            lines.expect("a line")[0].address.limit.as_secs_f64()
        };
        // 57 bytes take 65 ms there.
        assert!(limit(9_600) > 0.1 && limit(1_000_000) < 0.06);
    }

    #[test]
    fn what_is_wrong_is_told_by_line_board_value_and_limit() {
        let line = |rest: &str| parsed(&format!("[[line]]\nname = \"left\"\nport = \"p\"\n{rest}"));
        for (rest, message) in [
            ("boards = []", "line left: there is no board"),
            ("boards = [0]", "line left: board 0: numbers are 1 to 247"),
            ("boards = [300]", "a board is its number, 1 to 247"),
            ("boards = [3, 3]", "line left: board 3 is there twice"),
            (
                "boards = [1]\nrate_bit_per_s = 4000000",
                "line left: rate_bit_per_s = 4000000 is not in 9600 to 1000000 bit/s",
            ),
            ("boards = [1]\nanswer_s = -1.0", "line left: answer_s = -1 is no time"),
            (
                "boards = [1]\n[[line]]\nport = \"p\"\nboards = [1]",
                "line line-2: another line has the port p too",
            ),
            ("boards = [1]\nrates = 3", "unknown field `rates`"),
        ] {
            let said = line(rest).expect_err(rest);
            assert!(said.contains(message), "{said}");
        }
    }
}
