//! Strict reading of a table of a TOML file: every key is asked for by name and taken out, and what
//! is left at the end is an unknown key.

use std::fmt;

use toml::de::DeTable;
use toml::{Table, Value};

/// A table whose keys are being taken out.
pub struct Section {
    /// Name of the table, empty for the file's top level.
    name: String,
    table: Table,
}

/// What is wrong with a key: its section, name and the trouble.
#[derive(Debug)]
pub struct KeyError {
    section: String,
    key: String,
    trouble: Trouble,
}

#[derive(Debug)]
enum Trouble {
    Missing,
    Unknown,
    Kind { wanted: &'static str, found: &'static str },
    NotFinite(f64),
    Other(String),
}

impl fmt::Display for KeyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.section.is_empty() {
            write!(f, "[{}] ", self.section)?;
        }
        write!(f, "{}: ", self.key)?;
        match &self.trouble {
            Trouble::Missing => write!(f, "missing"),
            Trouble::Unknown => write!(f, "unknown key"),
            Trouble::Kind { wanted, found } => write!(f, "{wanted} is needed, not a value of type {found}"),
            Trouble::NotFinite(value) => write!(f, "{value} is not finite"),
            Trouble::Other(trouble) => write!(f, "{trouble}"),
        }
    }
}

impl std::error::Error for KeyError {}

impl KeyError {
    /// The line of the key in the file's text, from 1 on; of a missing one that of its table, or 1.
    pub fn line(&self, text: &str) -> usize {
        let Ok(top) = DeTable::parse(text) else { return 1 };
        let (mut table, mut place) = (Some(top.get_ref()), 0);
        for part in self.section.split('.').filter(|part| !part.is_empty()).chain([self.key.as_str()]) {
            let found = table.and_then(|table| table.iter().find(|(name, _)| name.get_ref() == part));
            let Some((name, value)) = found else { break };
            (table, place) = (value.get_ref().as_table(), name.span().start);
        }
        1 + text.bytes().take(place).filter(|byte| *byte == b'\n').count()
    }
}

impl Section {
    /// The top level of a file.
    pub fn top(table: Table) -> Self {
        Self { name: String::new(), table }
    }

    /// A table of this one.
    pub fn section(&mut self, key: &str) -> Result<Self, KeyError> {
        let value = self.take(key)?;
        let name = if self.name.is_empty() { key.to_owned() } else { format!("{}.{key}", self.name) };
        match value {
            Value::Table(table) => Ok(Self { name, table }),
            other => Err(self.kind(key, "a table", &other)),
        }
    }

    /// A list of tables of this one.
    pub fn sections(&mut self, key: &str) -> Result<Vec<Self>, KeyError> {
        let values = match self.take(key)? {
            Value::Array(values) => values,
            other => return Err(self.kind(key, "a list of tables", &other)),
        };
        let table = |(place, value)| match value {
            Value::Table(table) => Ok(Self { name: format!("{}.{key}[{place}]", self.name), table }),
            other => Err(self.kind(key, "a list of tables", &other)),
        };
        values.into_iter().enumerate().map(table).collect()
    }

    /// A table of this one that may be missing.
    pub fn optional_section(&mut self, key: &str) -> Result<Option<Self>, KeyError> {
        if self.has(key) { self.section(key).map(Some) } else { Ok(None) }
    }

    /// Whether the key is there.
    pub fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// A finite number.
    pub fn number(&mut self, key: &str) -> Result<f64, KeyError> {
        let value = self.take(key)?;
        self.finite(key, &value)
    }

    /// A number that may be infinite, which switches a limit off.
    pub fn limit(&mut self, key: &str) -> Result<f64, KeyError> {
        match self.take(key)? {
            Value::Float(limit) if limit.is_infinite() => Ok(limit),
            value => self.finite(key, &value),
        }
    }

    /// A list of finite numbers.
    pub fn numbers(&mut self, key: &str) -> Result<Vec<f64>, KeyError> {
        match self.take(key)? {
            Value::Array(values) => values.iter().map(|value| self.finite(key, value)).collect(),
            other => Err(self.kind(key, "a list of numbers", &other)),
        }
    }

    /// A whole number that is not negative.
    pub fn count(&mut self, key: &str) -> Result<usize, KeyError> {
        let value = self.take(key)?;
        match value.as_integer().and_then(|number| usize::try_from(number).ok()) {
            Some(count) => Ok(count),
            None => Err(self.error(key, &format!("{value} is not a count"))),
        }
    }

    /// True or false.
    pub fn truth(&mut self, key: &str) -> Result<bool, KeyError> {
        match self.take(key)? {
            Value::Boolean(truth) => Ok(truth),
            other => Err(self.kind(key, "true or false", &other)),
        }
    }

    /// A string.
    pub fn text(&mut self, key: &str) -> Result<String, KeyError> {
        match self.take(key)? {
            Value::String(text) => Ok(text),
            other => Err(self.kind(key, "a string", &other)),
        }
    }

    /// An error at a key of this table.
    pub fn error(&self, key: &str, trouble: &str) -> KeyError {
        self.trouble(key, Trouble::Other(trouble.to_owned()))
    }

    /// Refuses keys that nobody asked for.
    pub fn finish(self) -> Result<(), KeyError> {
        match self.table.keys().next() {
            Some(key) => Err(self.trouble(key, Trouble::Unknown)),
            None => Ok(()),
        }
    }

    fn take(&mut self, key: &str) -> Result<Value, KeyError> {
        self.table.remove(key).ok_or_else(|| self.trouble(key, Trouble::Missing))
    }

    fn finite(&self, key: &str, value: &Value) -> Result<f64, KeyError> {
        match *value {
            Value::Float(number) if number.is_finite() => Ok(number),
            Value::Float(number) => Err(self.trouble(key, Trouble::NotFinite(number))),
            Value::Integer(number) => Ok(number as f64),
            ref other => Err(self.kind(key, "a number", other)),
        }
    }

    fn kind(&self, key: &str, wanted: &'static str, found: &Value) -> KeyError {
        self.trouble(key, Trouble::Kind { wanted, found: found.type_str() })
    }

    fn trouble(&self, key: &str, trouble: Trouble) -> KeyError {
        KeyError { section: self.name.clone(), key: key.to_owned(), trouble }
    }
}
