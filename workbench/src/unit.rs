//! The units that a column's name can end in.
//!
//! A name such as `pressure_bar` carries its unit as the part after the last underscore. The units are
//! labels: nothing is converted, a model's keys and figures take over the units of its columns.

use std::fmt;

/// A unit that column names may end in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unit {
    suffix: &'static str,
    symbol: &'static str,
}

/// Suffix and symbol of every known unit.
const KNOWN: [Unit; 24] = [
    unit("s", "s"),
    unit("ms", "ms"),
    unit("hz", "Hz"),
    unit("bar", "bar"),
    unit("mbar", "mbar"),
    unit("kpa", "kPa"),
    unit("mpa", "MPa"),
    unit("m", "m"),
    unit("mm", "mm"),
    unit("um", "µm"),
    unit("deg", "°"),
    unit("rad", "rad"),
    unit("n", "N"),
    unit("kn", "kN"),
    unit("nm", "N·m"),
    unit("kg", "kg"),
    unit("v", "V"),
    unit("mv", "mV"),
    unit("a", "A"),
    unit("ma", "mA"),
    unit("c", "°C"),
    unit("k", "K"),
    unit("percent", "%"),
    unit("ratio", "1"),
];

const fn unit(suffix: &'static str, symbol: &'static str) -> Unit {
    Unit { suffix, symbol }
}

impl Unit {
    /// Millimetres: what a board tracks.
    pub const MM: Self = unit("mm", "mm");

    /// The unit of a column's name, `None` if the name does not end in one.
    pub fn of_column(name: &str) -> Option<Self> {
        let (_, suffix) = name.rsplit_once('_')?;
        KNOWN.into_iter().find(|unit| unit.suffix == suffix)
    }

    /// As it stands in column names and keys, without the underscore: `kpa`.
    pub fn suffix(self) -> &'static str {
        self.suffix
    }

    /// All suffixes as a list for messages: `_s, _ms, …`.
    pub fn known_suffixes() -> String {
        KNOWN.map(|unit| format!("_{}", unit.suffix)).join(", ")
    }
}

/// A quantity by the name of its column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Name of the column.
    pub name: String,
    /// Unit, by the name's suffix.
    pub unit: Unit,
}

impl Channel {
    /// The channel of a column, `None` if its name does not end in a known unit.
    pub fn of_column(name: &str) -> Option<Self> {
        Unit::of_column(name).map(|unit| Self { name: name.to_owned(), unit })
    }

    /// The name without its unit, as words: `contraction`.
    pub fn words(&self) -> String {
        self.name.trim_end_matches(self.unit.suffix).trim_end_matches('_').replace('_', " ")
    }
}

/// The name and unit, as an axis shows them: `contraction (mm)`.
impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.words(), self.unit)
    }
}

/// The symbol, as people write it: `kPa`.
impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.symbol)
    }
}
