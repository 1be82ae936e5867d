//! Which boards there are: the file that a gateway is given.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;
use std::{fs, io};

use board_client::bus::client::Address;
use board_client::bus::port::{Line as PortLine, Parity};
use serde::Deserialize;
use thiserror::Error;
use wire::registers::{Access, BAUD, Id};

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

/// How far, and how fast, a board may be asked to move its muscle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// From, to. Unit: mm.
    pub travel_mm: [f64; 2],
    /// Of a trajectory; none where the file says none: the board then limits the valve alone. Unit:
    /// mm/s.
    pub slew_mm_per_s: Option<f64>,
}

impl Limits {
    /// What a board takes.
    pub fn usual() -> Self {
        let travel_mm = match Id::SetpointMm.register().access {
            Access::Write(min, max) => [min, max],
            Access::Read => [0.0; 2],
        };
        Self { travel_mm, slew_mm_per_s: None }
    }
}

/// A board of a line.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// Its number on the bus.
    pub number: u8,
    /// What people call it; unique among all lines and groups.
    pub name: String,
    /// What it may be asked for.
    pub limits: Limits,
}

/// A line with its boards.
#[derive(Clone, Debug)]
pub struct Line {
    /// What people call it.
    pub name: String,
    /// The port, its rate, and how long an answer may take; its number is the first board's.
    pub address: Address,
    /// How the boards are asked.
    pub exchange: Exchange,
    /// The boards, in the order in which they are asked.
    pub boards: Vec<Member>,
}

/// How the boards of a line are asked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Exchange {
    /// All at once, each answers in its slot; a board that does not know this, one by one. It is the
    /// usual one: faster, and each board looks itself at the age of what it is told.
    #[default]
    Slots,
    /// One by one.
    Plain,
}

impl Line {
    /// Whether the same thread may go on with it: name and port are as they were.
    pub fn goes_on_from(&self, before: &Self) -> bool {
        let of = |line: &Self| {
            let Address { port, line: PortLine { baud, parity }, limit, .. } = &line.address;
            (line.name.clone(), port.clone(), *baud, *parity, *limit, line.exchange)
        };
        of(self) == of(before)
    }
}

/// Boards that are ordered together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// What people call it.
    pub name: String,
    /// The names of its boards.
    pub boards: Vec<String>,
}

/// What a file says.
#[derive(Clone, Debug)]
pub struct Lines {
    /// The lines.
    pub lines: Vec<Line>,
    /// Boards that are ordered together.
    pub groups: Vec<Group>,
}

/// The file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    line: Vec<FileLine>,
    #[serde(default)]
    group: Vec<FileGroup>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileGroup {
    name: String,
    boards: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileLine {
    name: Option<String>,
    port: PathBuf,
    rate_bit_per_s: Option<u32>,
    parity: Option<FileParity>,
    answer_s: Option<f64>,
    #[serde(default)]
    exchange: Exchange,
    travel_mm: Option<[f64; 2]>,
    slew_mm_per_s: Option<f64>,
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
#[serde(
    untagged,
    expecting = "a board is its number, 1 to 247, or { number = 1, name = \"biceps\" }, with travel_mm = [0, 40] and \
                 slew_mm_per_s = 100 where it has limits of its own"
)]
enum FileBoard {
    Number(u8),
    Named(Named),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Named {
    number: u8,
    name: Option<String>,
    travel_mm: Option<[f64; 2]>,
    slew_mm_per_s: Option<f64>,
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

/// Whether a line, a group or a gateway can be called so: the name is a part of keys on the network.
pub fn is_name(name: &str) -> bool {
    let is_forbidden = |letter: char| "/*$#?".contains(letter) || letter.is_whitespace();
    !name.is_empty() && !name.starts_with('@') && !name.contains(is_forbidden)
}

/// What is said of one that it cannot.
pub const NO_NAME: &str = "this name cannot be part of a key: it must not be empty, begin with @, or have one of / * $ # ? or a \
                           space in it";

/// Reads the lines of a file. A relative path of a port is relative to the file's folder.
///
/// # Errors
/// It cannot be read; what is wrong in it, by place.
pub fn read(file: &Path) -> Result<Lines, LinesError> {
    let text = fs::read_to_string(file)
        .map_err(|problem| LinesError::Unreadable { file: file.to_owned(), problem })?;
    let parsed: File = toml::from_str(&text)
        .map_err(|problem| LinesError::Toml { file: file.to_owned(), problem: Box::new(problem) })?;
    lines(parsed, file.parent().unwrap_or(Path::new("")))
        .map_err(|problem| LinesError::Wrong { file: file.to_owned(), problem })
}

/// The limits of a board, or a line: what it says, and else what its line says, or is usual.
fn limits(
    travel_mm: Option<[f64; 2]>,
    slew_mm_per_s: Option<f64>,
    otherwise: Limits,
) -> Result<Limits, String> {
    let [min, max] = Limits::usual().travel_mm;
    if let Some([from, to]) = travel_mm.filter(|[from, to]| !(min <= *from && from < to && *to <= max)) {
        return Err(format!("travel_mm = [{from}, {to}] is no range within {min} to {max} mm"));
    }
    if let Some(slew) = slew_mm_per_s.filter(|slew| !(*slew > 0.0 && slew.is_finite())) {
        return Err(format!("slew_mm_per_s = {slew} is no rate"));
    }
    Ok(Limits {
        travel_mm: travel_mm.unwrap_or(otherwise.travel_mm),
        slew_mm_per_s: slew_mm_per_s.or(otherwise.slew_mm_per_s),
    })
}

/// The groups, whose boards all are there.
fn groups(groups: Vec<FileGroup>, mut names: BTreeSet<String>) -> Result<Vec<Group>, String> {
    let boards = names.clone();
    for FileGroup { name, boards: members } in &groups {
        if !is_name(name) {
            return Err(format!("group {name}: {NO_NAME}"));
        }
        if !names.insert(name.clone()) {
            return Err(format!("group {name}: a board or another group has this name too"));
        }
        if members.is_empty() {
            return Err(format!("group {name}: there is no board"));
        }
        let mut seen = BTreeSet::new();
        for member in members {
            if !boards.contains(member) {
                return Err(format!("group {name}: there is no board {member} in any line"));
            }
            if !seen.insert(member) {
                return Err(format!("group {name}: board {member} is there twice"));
            }
        }
    }
    Ok(groups.into_iter().map(|FileGroup { name, boards }| Group { name, boards }).collect())
}

fn lines(File { line, group }: File, directory: &Path) -> Result<Lines, String> {
    if line.is_empty() {
        return Err("there is no [[line]]".to_owned());
    }
    let (mut names, mut ports) = (BTreeSet::new(), BTreeSet::new());
    let mut lines = Vec::new();
    for (index, line) in line.into_iter().enumerate() {
        let name = line.name.unwrap_or_else(|| format!("line-{}", index + 1));
        let wrong = |problem: String| Err(format!("line {name}: {problem}"));
        if !is_name(&name) {
            return wrong(NO_NAME.to_owned());
        }
        if lines.iter().any(|other: &Line| other.name == name) {
            return wrong("another line has this name too".to_owned());
        }
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
        let of_line = match limits(line.travel_mm, line.slew_mm_per_s, Limits::usual()) {
            Ok(limits) => limits,
            Err(problem) => return wrong(problem),
        };
        let mut numbers = BTreeSet::new();
        let mut boards = Vec::new();
        for board in line.boards {
            let Named { number, name: given, travel_mm, slew_mm_per_s } = match board {
                FileBoard::Number(number) => {
                    Named { number, name: None, travel_mm: None, slew_mm_per_s: None }
                }
                FileBoard::Named(named) => named,
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
            let limits = match limits(travel_mm, slew_mm_per_s, of_line) {
                Ok(limits) => limits,
                Err(problem) => return wrong(format!("board {number}: {problem}")),
            };
            boards.push(Member { number, name: member, limits });
        }
        let Some(first) = boards.first() else {
            return wrong("there is no board".to_owned());
        };
        let parity = line.parity.map_or(Parity::None, Parity::from);
        let address = Address { port, line: PortLine { baud, parity }, unit: first.number, limit };
        lines.push(Line { name, address, exchange: line.exchange, boards });
    }
    Ok(Lines { groups: groups(group, names)?, lines })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn parsed(text: &str) -> Result<Lines, String> {
        let file: File = toml::from_str(text).map_err(|error| error.to_string())?;
        lines(file, Path::new("/lab"))
    }

    #[test]
    fn numbers_alone_will_do_and_names_may_be_given() {
        let lines = parsed(
            "[[line]]\nport = \"line-1\"\nboards = [1, {number = 2, name = \"biceps\"}]\n\
             [[line]]\nname = \"right\"\nport = \"/dev/ttyUSB0\"\nrate_bit_per_s = 1000000\nparity = \"even\"\nboards = [1]\n",
        )
        .expect("two lines")
        .lines;
        let names: Vec<&str> = lines.iter().flat_map(|line| &line.boards).map(|board| &*board.name).collect();
        assert_eq!(names, ["line-1/1", "biceps", "right/1"]);
        assert_eq!(lines[0].address.port, Path::new("/lab/line-1"));
        assert_eq!(lines[1].address.port, Path::new("/dev/ttyUSB0"));
        assert_eq!((lines[1].address.line.baud, lines[1].address.line.parity), (1_000_000, Parity::Even));
    }

    #[test]
    fn a_board_has_the_limits_that_it_is_given_or_its_lines_or_the_usual_ones() {
        let lines = parsed(
            "[[line]]\nport = \"p\"\nslew_mm_per_s = 80\nboards = [1, {number = 2, travel_mm = [5, 40.5]}]\n\
             [[line]]\nport = \"q\"\nboards = [1]\n[[group]]\nname = \"all\"\nboards = [\"line-1/1\", \"line-2/1\"]",
        )
        .expect("two lines");
        let limits: Vec<Limits> =
            lines.lines.iter().flat_map(|line| &line.boards).map(|board| board.limits).collect();
        let of_line = Limits { slew_mm_per_s: Some(80.0), ..Limits::usual() };
        assert_eq!(limits, [of_line, Limits { travel_mm: [5.0, 40.5], ..of_line }, Limits::usual()]);
        assert_eq!(lines.groups[0].boards, ["line-1/1", "line-2/1"]);
    }

    #[test]
    fn a_name_that_would_be_a_pattern_or_two_parts_of_a_key_is_refused() {
        for name in ["", "a/b", "*", "a*", "$x", "a#", "a?", "a b", "@ros2_lv"] {
            assert!(!is_name(name), "{name}");
            let of_line = parsed(&format!("[[line]]\nname = \"{name}\"\nport = \"p\"\nboards = [1]"));
            assert!(of_line.expect_err(name).contains("cannot be part of a key"));
            let of_group = parsed(&format!(
                "[[line]]\nport = \"p\"\nboards = [1]\n[[group]]\nname = \"{name}\"\nboards = [\"line-1/1\"]"
            ));
            assert!(of_group.expect_err(name).contains("cannot be part of a key"));
        }
        assert!(is_name("left-arm_2"));
    }

    #[test]
    fn a_slow_line_is_given_the_time_that_its_bytes_take() {
        let limit = |rate: u32| {
            let lines = parsed(&format!("[[line]]\nport = \"p\"\nrate_bit_per_s = {rate}\nboards = [1]\n"));
            lines.expect("a line").lines[0].address.limit.as_secs_f64()
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
            (
                "boards = [1]\n[[line]]\nname = \"left\"\nport = \"q\"\nboards = [2]",
                "line left: another line has this name too",
            ),
            ("boards = [1]\nrates = 3", "unknown field `rates`"),
            (
                "boards = [1]\ntravel_mm = [0, 900]",
                "line left: travel_mm = [0, 900] is no range within -20 to 200 mm",
            ),
            (
                "boards = [{number = 1, travel_mm = [40, 0]}]",
                "line left: board 1: travel_mm = [40, 0] is no range within -20 to 200 mm",
            ),
            ("boards = [1]\nslew_mm_per_s = 0.0", "line left: slew_mm_per_s = 0 is no rate"),
            ("boards = [1]\n[[group]]\nname = \"a\"\nboards = []", "group a: there is no board"),
            (
                "boards = [1]\n[[group]]\nname = \"a\"\nboards = [\"biceps\"]",
                "group a: there is no board biceps in any line",
            ),
            (
                "boards = [1]\n[[group]]\nname = \"a\"\nboards = [\"left/1\", \"left/1\"]",
                "group a: board left/1 is there twice",
            ),
            (
                "boards = [{number = 1, name = \"a\"}]\n[[group]]\nname = \"a\"\nboards = [\"a\"]",
                "group a: a board or another group has this name too",
            ),
        ] {
            let said = line(rest).expect_err(rest);
            assert!(said.contains(message), "{said}");
        }
    }
}
