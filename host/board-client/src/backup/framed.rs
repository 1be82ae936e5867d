//! What every backup begins with, of which kind it is, and its checksum.

use std::io;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use recording::input;
use recording::model_file::section::{KeyError, Section};
use sha2::{Digest, Sha256};
use thiserror::Error;
use toml::{Table, Value};
use wire::Refusal;

use super::section::shortest;

const SHA256: &str = "sha256";
const KIND: &str = "kind";

/// The boards that a backup is of.
#[derive(Debug)]
pub(super) struct Boards {
    /// What the key `kind` says; none: there is no such key.
    pub kind: Option<&'static str>,
    /// For people.
    pub backup: &'static str,
    /// What brings it to a board.
    pub restore: &'static str,
    /// The format that is written, and those that are read.
    pub format: usize,
    pub formats: RangeInclusive<usize>,
}

/// With one muscle.
pub(super) const ONE_MUSCLE: Boards = Boards {
    kind: None,
    backup: "the backup of a board with one muscle",
    restore: "mgpi restore",
    format: super::FORMAT,
    formats: 1..=super::FORMAT,
};

/// With two channels, of a joint.
pub(super) const JOINT: Boards = Boards {
    kind: Some("joint_board"),
    backup: "the backup of a joint's board",
    restore: "mgpi restore --joint",
    format: super::JOINT_FORMAT,
    formats: super::JOINT_FORMAT..=super::JOINT_FORMAT,
};

/// What is wrong with the file of a backup.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum BackupFileError {
    #[error("{}: cannot be read: {source}", file.display())]
    Unreadable { file: PathBuf, source: io::Error },
    #[error("{}, line {line}: not a TOML file, or cut off: {message}", file.display())]
    Syntax { file: PathBuf, line: usize, message: String },
    #[error("{}, line {line}: {message}", file.display())]
    Key { file: PathBuf, line: usize, message: String },
    #[error("{}: it is {found}; `{command}` takes {wanted}. `{other}` takes this one", file.display())]
    Kind {
        file: PathBuf,
        found: &'static str,
        command: &'static str,
        wanted: &'static str,
        other: &'static str,
    },
    #[error(
        "{}, line {line}: sha256: the lines below have another one, {found}: the file is damaged, or was changed by \
         hand; --force takes it as it is", file.display()
    )]
    Checksum { file: PathBuf, line: usize, found: String },
    #[error("{}: no configuration that a board takes: {message}", file.display())]
    Invalid { file: PathBuf, message: String },
}

/// What is wrong within the text.
pub(super) enum Problem {
    Key(KeyError),
    Invalid(String),
}

impl From<KeyError> for Problem {
    fn from(error: KeyError) -> Self {
        Self::Key(error)
    }
}

impl From<recording::model_file::Problem> for Problem {
    fn from(problem: recording::model_file::Problem) -> Self {
        match problem {
            recording::model_file::Problem::Key(error) => Self::Key(error),
            other => Self::Invalid(other.to_string()),
        }
    }
}

impl From<model_core::ParameterError> for Problem {
    fn from(error: model_core::ParameterError) -> Self {
        Self::Invalid(error.to_string())
    }
}

impl From<Refusal> for Problem {
    fn from(refusal: Refusal) -> Self {
        Self::Invalid(match refusal {
            Refusal::Parameter(message) => message.as_str().to_owned(),
            other => format!("{other:?}"),
        })
    }
}

impl Boards {
    /// The text of a file whose content are these tables.
    pub fn to_toml(&self, tables: &[Table]) -> String {
        let kind = self.kind.map_or(String::new(), |kind| format!("{KIND} = \"{kind}\"\n"));
        let tables: Vec<String> = tables.iter().map(Table::to_string).collect();
        let body = format!("{kind}\n{}", tables.join("\n"));
        let boards = if self.kind.is_some() { "a joint's board" } else { "a valve board" };
        format!(
            "# The configuration of {boards}, by mgpi {}: `{}` brings it to a board.\nformat = {}\n\
             # SHA-256 of all lines below the next one, each ended by a line feed\n{SHA256} = \"{}\"\n{body}",
            env!("CARGO_PKG_VERSION"),
            self.restore,
            self.format,
            sha256(&body)
        )
    }

    /// What `content` makes of a file; `as_it_is`: also of one whose checksum is that of another
    /// content.
    pub fn read<T>(
        &self,
        file: &Path,
        as_it_is: bool,
        content: impl FnOnce(Section) -> Result<T, Problem>,
    ) -> Result<T, BackupFileError> {
        let text = input::text(file)
            .map_err(|source| BackupFileError::Unreadable { file: file.to_owned(), source })?;
        self.parse((file, &text.replace("\r\n", "\n")), as_it_is, content)
    }

    /// The same of its name and its text.
    pub fn parse<T>(
        &self,
        (file, text): (&Path, &str),
        as_it_is: bool,
        content: impl FnOnce(Section) -> Result<T, Problem>,
    ) -> Result<T, BackupFileError> {
        let at = |error: &KeyError| BackupFileError::Key {
            file: file.to_owned(),
            line: error.line(text),
            message: error.to_string(),
        };
        let table = text.parse::<Table>().map_err(|error| {
            let end = error.span().map_or(text.len(), |span| span.start.min(text.len()));
            let line = 1 + text.as_bytes()[..end].iter().filter(|byte| **byte == b'\n').count();
            BackupFileError::Syntax {
                file: file.to_owned(),
                line,
                message: error.message().replace('\n', ", "),
            }
        })?;
        if let Some((found, other)) = self.other(&table) {
            let (command, wanted) = (self.restore, self.backup);
            return Err(BackupFileError::Kind { file: file.to_owned(), found, command, wanted, other });
        }
        let mut top = Section::top(table);
        let format = top.count("format").map_err(|error| at(&error))?;
        if !self.formats.contains(&format) {
            let (oldest, newest) = (self.formats.start(), self.formats.end());
            let known = if oldest == newest {
                format!("format {newest}")
            } else {
                format!("formats {oldest} to {newest}")
            };
            let trouble = format!("{format} is of another version; this program reads {known}");
            return Err(at(&top.error("format", &trouble)));
        }
        let said = top.text(SHA256).map_err(|error| at(&error))?;
        let line = top.error(SHA256, "").line(text);
        let body: String = text.split_inclusive('\n').skip(line).collect();
        let found = sha256(&body);
        if said != found && !as_it_is {
            return Err(BackupFileError::Checksum { file: file.to_owned(), line, found });
        }
        if let Some(wanted) = self.kind {
            let kind = top.text(KIND).map_err(|error| at(&error))?;
            if kind != wanted {
                let trouble = format!("\"{kind}\" is not known, must be \"{wanted}\"");
                return Err(at(&top.error(KIND, &trouble)));
            }
        }
        content(top).map_err(|problem| match problem {
            Problem::Key(error) => at(&error),
            Problem::Invalid(message) => BackupFileError::Invalid { file: file.to_owned(), message },
        })
    }

    /// What a file is that is another one than is wanted, and what takes it; none where it is the
    /// right one, or nobody knows.
    fn other(&self, table: &Table) -> Option<(&'static str, &'static str)> {
        let is_backup = table.contains_key(SHA256);
        match table.get(KIND).map(Value::as_str) {
            None if is_backup && self.kind.is_some() => Some((ONE_MUSCLE.backup, ONE_MUSCLE.restore)),
            Some(kind) if kind == JOINT.kind && self.kind != JOINT.kind => {
                Some((JOINT.backup, JOINT.restore))
            }
            Some(Some("joint")) if !is_backup => Some(("the model of a joint", "mgpi deploy --joint")),
            Some(Some(_)) if !is_backup => Some(("a model of one muscle", "mgpi deploy")),
            _ => None,
        }
    }
}

/// Every number of single precision in its shortest form, but for those whose key `is_other`.
pub(super) fn shorten(value: &mut Value, is_other: fn(&str) -> bool) {
    match value {
        Value::Float(number) => *number = shortest(*number as f32),
        Value::Array(values) => values.iter_mut().for_each(|value| shorten(value, is_other)),
        Value::Table(table) => {
            table.iter_mut().filter(|(key, _)| !is_other(key)).for_each(|(_, value)| shorten(value, is_other))
        }
        _ => {}
    }
}

/// What changes from one table to another, a line each; `path` is that of both, with a dot behind
/// it.
pub(super) fn between(path: &str, before: &Table, after: &Table) -> Vec<String> {
    let gone = before.keys().filter(|key| !after.contains_key(*key));
    let of_key = |key: &String| {
        let path = format!("{path}{key}");
        let (before, after) = (before.get(key), after.get(key));
        let table = |value: Option<&Value>| value.and_then(Value::as_table).cloned();
        match (table(before), table(after)) {
            _ if before == after => Vec::new(),
            (None, None) => {
                vec![format!("{path:<36} {} -> {}", value_in_words(before), value_in_words(after))]
            }
            (before, after) => {
                between(&format!("{path}."), &before.unwrap_or_default(), &after.unwrap_or_default())
            }
        }
    };
    after.keys().chain(gone).flat_map(of_key).collect()
}

fn value_in_words(value: Option<&Value>) -> String {
    value.map_or_else(|| "none".to_owned(), Value::to_string)
}

fn sha256(text: &str) -> String {
    Sha256::digest(text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
}
