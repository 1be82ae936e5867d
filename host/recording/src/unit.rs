//! The units of columns: how they are written, what they measure, and how they are converted.
//!
//! A name such as `pressure_bar` carries its unit as the part after the last underscore. A model's
//! keys and figures take over the units of its columns; [`Unit::convert`] is for the places that
//! need another one. Some spellings stand for two units ([`meaning`]): they are asked about, never
//! guessed.

use std::fmt;

/// What a unit measures.
///
/// ```
/// use recording::unit::{Quantity, Unit};
///
/// assert_eq!(Unit::BAR.quantity(), Quantity::Pressure);
/// assert_ne!(Unit::MM.quantity(), Unit::BAR.quantity());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Base unit: s.
    Time,
    /// Base unit: Hz.
    Frequency,
    /// Base unit: Pa.
    Pressure,
    /// Base unit: m.
    Length,
    /// Base unit: rad.
    Angle,
    /// Base unit: N.
    Force,
    /// Base unit: N·m.
    Torque,
    /// Base unit: N·m/rad.
    Stiffness,
    /// Base unit: kg.
    Mass,
    /// Base unit: V.
    Voltage,
    /// Base unit: A.
    Current,
    /// Base unit: K.
    Temperature,
    /// Base unit: 1.
    Ratio,
}

/// A unit that columns may have.
///
/// ```
/// use recording::unit::Unit;
///
/// assert_eq!(Unit::of_column("pressure_kpa").and_then(|kpa| kpa.convert(250.0, Unit::BAR)), Some(2.5));
/// assert_eq!(Unit::BAR.convert(1.0, Unit::MM), None); // a pressure is no length
/// assert_eq!(Unit::of_column("pressure_furlongs"), None); // an unknown unit is refused
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Unit {
    suffix: &'static str,
    symbol: &'static str,
    /// Other ways to write it, apart from the suffix in capitals.
    spellings: &'static [&'static str],
    quantity: Quantity,
    /// Of the base unit.
    factor: f64,
    /// The base unit's value at 0.
    zero: f64,
}

use Quantity::{
    Angle, Current, Force, Frequency, Length, Mass, Pressure, Ratio, Stiffness, Temperature, Time, Torque,
    Voltage,
};

/// Every known unit. Factors: International System of Units (BIPM 2019); of psi, lbf, in and mmHg:
/// NIST SP 811.
const KNOWN: [Unit; 44] = [
    unit("s", "s", &["sec", "second", "seconds"], Time, 1.0),
    unit("ms", "ms", &["msec", "millisecond", "milliseconds"], Time, 1e-3),
    unit("us", "µs", &["μs", "usec", "microsecond", "microseconds"], Time, 1e-6),
    unit("ns", "ns", &["nanosecond", "nanoseconds"], Time, 1e-9),
    unit("min", "min", &["minute", "minutes"], Time, 60.0),
    unit("h", "h", &["hour", "hours"], Time, 3600.0),
    unit("hz", "Hz", &[], Frequency, 1.0),
    unit("khz", "kHz", &[], Frequency, 1e3),
    unit("bar", "bar", &["Bar", "barg", "bar(g)"], Pressure, 1e5),
    unit("mbar", "mbar", &[], Pressure, 1e2),
    unit("pa", "Pa", &["pascal"], Pressure, 1.0),
    unit("hpa", "hPa", &[], Pressure, 1e2),
    unit("kpa", "kPa", &["Kpa", "KPa"], Pressure, 1e3),
    unit("mpa", "MPa", &["Mpa"], Pressure, 1e6),
    unit("psi", "psi", &["Psi", "psig", "PSIG"], Pressure, 6_894.757_293_168_361),
    unit("atm", "atm", &[], Pressure, 101_325.0),
    unit("torr", "Torr", &[], Pressure, 101_325.0 / 760.0),
    unit("mmhg", "mmHg", &[], Pressure, 133.322_387_415),
    unit("m", "m", &["metre", "meter"], Length, 1.0),
    unit("cm", "cm", &[], Length, 1e-2),
    unit("mm", "mm", &["millimetre", "millimeter"], Length, 1e-3),
    unit("um", "µm", &["μm", "micron", "micrometre", "micrometer"], Length, 1e-6),
    unit("nm", "nm", &["nanometre", "nanometer"], Length, 1e-9),
    unit("in", "in", &["inch", "inches"], Length, 0.0254),
    unit("deg", "°", &["degree", "degrees"], Angle, std::f64::consts::PI / 180.0),
    unit("rad", "rad", &["radian", "radians"], Angle, 1.0),
    unit("n", "N", &["newton"], Force, 1.0),
    unit("kn", "kN", &[], Force, 1e3),
    unit("kgf", "kgf", &["kp"], Force, 9.806_65),
    unit("lbf", "lbf", &[], Force, 4.448_221_615_260_5),
    unit("newton_metre", "N·m", &["Nm", "N m", "N*m", "N.m", "newton_meter"], Torque, 1.0),
    unit("kg", "kg", &[], Mass, 1.0),
    unit("v", "V", &["volt", "volts"], Voltage, 1.0),
    unit("mv", "mV", &[], Voltage, 1e-3),
    unit("a", "A", &["ampere"], Current, 1.0),
    unit("ma", "mA", &[], Current, 1e-3),
    unit("c", "°C", &["degC", "Celsius", "celsius", "℃"], Temperature, 1.0).with_zero(273.15),
    unit("k", "K", &["kelvin", "Kelvin"], Temperature, 1.0),
    unit("f", "°F", &["degF", "Fahrenheit"], Temperature, 5.0 / 9.0).with_zero(273.15 - 32.0 * 5.0 / 9.0),
    unit("percent", "%", &["pct"], Ratio, 1e-2),
    unit("ratio", "1", &[], Ratio, 1.0),
    unit("mrad", "mrad", &[], Angle, 1e-3),
    unit("g", "g", &["gram"], Mass, 1e-3),
    unit("nm_per_rad", "N·m/rad", &["Nm/rad"], Stiffness, 1.0),
];

const fn unit(
    suffix: &'static str,
    symbol: &'static str,
    spellings: &'static [&'static str],
    quantity: Quantity,
    factor: f64,
) -> Unit {
    Unit { suffix, symbol, spellings, quantity, factor, zero: 0.0 }
}

/// Ends of names that stand for two things, and the words that tell them apart in `--units`.
const AMBIGUOUS: [(&str, &[&str]); 3] = [
    ("nm", &["nm (nanometre)", "newton_metre"]),
    ("NM", &["nm (nanometre)", "newton_metre"]),
    ("in", &["inch"]),
];

/// What the end of a name, or a symbol in brackets, may mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// One unit.
    Known(Unit),
    /// Two units or more, or one and no unit; how each is said by `--units`.
    Ambiguous(&'static [&'static str]),
}

/// The unit that the end of a column's name stands for, in small letters (`kpa`) or as a symbol
/// (`kPa`); `None` if it is none.
pub fn meaning(end: &str) -> Option<Meaning> {
    match AMBIGUOUS.iter().find(|(ambiguous, _)| *ambiguous == end) {
        Some((_, choices)) => Some(Meaning::Ambiguous(choices)),
        None => Unit::of_symbol(end).map(Meaning::Known),
    }
}

impl Unit {
    /// Seconds: what times are in.
    pub const S: Self = KNOWN[0];
    /// Bar: what a board's valve is told.
    pub const BAR: Self = KNOWN[8];
    /// Millimetres: what a board tracks.
    pub const MM: Self = KNOWN[20];
    /// Newton: what loads are in.
    pub const N: Self = KNOWN[26];
    /// Degrees Celsius: what temperatures are in.
    pub const CELSIUS: Self = KNOWN[36];

    /// The unit of a name that we wrote ourselves, `None` if the name does not end in one.
    pub fn of_column(name: &str) -> Option<Self> {
        let ends_in = |unit: &Self| name.strip_suffix(unit.suffix).is_some_and(|words| words.ends_with('_'));
        KNOWN.into_iter().filter(ends_in).max_by_key(|unit| unit.suffix.len())
    }

    /// The unit that is written so: as its symbol, suffix, or suffix in capitals. `None` if it is
    /// unknown.
    pub fn of_symbol(text: &str) -> Option<Self> {
        let is_so = |unit: &Self| {
            unit.symbol == text
                || unit.suffix == text
                || unit.spellings.contains(&text)
                || (text.chars().all(|letter| !letter.is_lowercase()) && unit.suffix == text.to_lowercase())
        };
        KNOWN.into_iter().find(is_so)
    }

    /// As it stands in column names and keys, without the underscore: `kpa`.
    pub fn suffix(self) -> &'static str {
        self.suffix
    }

    /// As people write it: `kPa`.
    pub fn symbol(self) -> &'static str {
        self.symbol
    }

    /// What it measures.
    pub fn quantity(self) -> Quantity {
        self.quantity
    }

    /// A value of this unit in another one of the same quantity; `None` for units of different
    /// quantities.
    pub fn convert(self, value: f64, to: Self) -> Option<f64> {
        let convert = || match self == to {
            true => value,
            false => (value * self.factor + self.zero - to.zero) / to.factor,
        };
        (self.quantity == to.quantity).then(convert)
    }

    /// All suffixes as a list for messages: `_s, _ms, …`.
    pub fn known_suffixes() -> String {
        KNOWN.map(|unit| format!("_{}", unit.suffix)).join(", ")
    }

    const fn with_zero(self, zero: f64) -> Self {
        Self { zero, ..self }
    }
}

/// Bar: what drives a muscle, unless something else is said.
impl Default for Unit {
    fn default() -> Self {
        Self::BAR
    }
}

impl PartialEq for Unit {
    fn eq(&self, other: &Self) -> bool {
        self.suffix == other.suffix
    }
}

impl Eq for Unit {}

/// A quantity by the name of its column.
///
/// ```
/// use recording::unit::{Channel, Unit};
///
/// let pressure = Channel::of_column("pressure_bar").expect("bar is known");
/// assert_eq!((pressure.stem(), pressure.unit), ("pressure", Unit::BAR));
/// ```
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

    /// The name without its unit: `supply` of `supply_bar`.
    pub fn stem(&self) -> &str {
        let stem = self.name.strip_suffix(self.unit.suffix).unwrap_or(&self.name);
        stem.strip_suffix('_').unwrap_or(stem)
    }

    /// The name without its unit, as words: `muscle pressure`.
    pub fn words(&self) -> String {
        self.stem().replace('_', " ")
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

#[cfg(test)]
mod tests {
    use super::*;

    fn known(text: &str) -> Unit {
        match meaning(text) {
            Some(Meaning::Known(unit)) => unit,
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn constants_are_the_units_of_their_names() {
        let constants = [Unit::S, Unit::BAR, Unit::MM, Unit::N, Unit::CELSIUS];
        assert_eq!(constants.map(Unit::suffix), ["s", "bar", "mm", "n", "c"]);
    }

    #[test]
    fn values_are_converted_within_a_quantity_only() {
        for (from, value, to, expected) in [
            ("kPa", 250.0, "bar", 2.5),
            ("psi", 14.503_773_773, "bar", 1.0),
            ("MPa", 0.6, "bar", 6.0),
            ("in", 2.0, "mm", 50.8),
            ("um", 1500.0, "mm", 1.5),
            ("kgf", 1.0, "N", 9.806_65),
            ("K", 293.15, "°C", 20.0),
            ("°F", 68.0, "°C", 20.0),
            ("min", 1.5, "s", 90.0),
        ] {
            let unit = |text| Unit::of_symbol(text).expect(text);
            let found = unit(from).convert(value, unit(to)).expect("one quantity");
            assert!((found - expected).abs() < 1e-9, "{value} {from} is {found} {to}");
        }
        assert_eq!(known("bar").convert(1.0, known("mm")), None);
    }

    #[test]
    fn what_may_be_two_units_is_ambiguous() {
        assert!(matches!(meaning("nm"), Some(Meaning::Ambiguous(_))));
        assert!(matches!(meaning("NM"), Some(Meaning::Ambiguous(_))));
        assert!(matches!(meaning("in"), Some(Meaning::Ambiguous(_))));
        assert_eq!(
            [known("Nm"), known("nanometre"), known("inch")].map(Unit::suffix),
            ["newton_metre", "nm", "in"]
        );
        assert_eq!([known("MPa"), known("KPA"), known("sec")].map(Unit::suffix), ["mpa", "kpa", "s"]);
        // A millipascal is not known.
        assert_eq!((meaning("mPa"), meaning("Torque")), (None, None));
    }

    #[test]
    fn the_longest_end_of_a_name_is_its_unit() {
        let channel = Channel::of_column("shaft_torque_newton_metre").expect("known");
        assert_eq!((channel.words().as_str(), channel.unit.suffix()), ("shaft torque", "newton_metre"));
        assert_eq!(Channel::of_column("contraction_mm").expect("known").to_string(), "contraction (mm)");
        assert_eq!(Unit::of_column("cycle"), None);
    }
}
