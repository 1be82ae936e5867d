//! A column's name as loggers write it: `pressure_bar`, `Pressure [kPa]`, `contraction / mm`.

use super::Quantity;
use crate::unit::{Meaning, Unit, meaning};

/// A column's name, and what it says of the unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Heading {
    /// As it stands in the file, without blanks around it.
    pub raw: String,
    /// The name without the unit, in small letters, words joined by underscores: `pressure`.
    pub stem: String,
    /// The unit, if the name has one.
    pub unit: Option<Meaning>,
    /// The unit of the row of units, where it is another one.
    pub other: Option<Unit>,
    /// Whether an option says the unit.
    pub is_said: bool,
    /// Whether an option gives the column its name, so that the one in the file no longer counts.
    pub is_named: bool,
    /// Whether an option gives this column's name to another one, so that nobody means this one.
    pub is_displaced: bool,
}

/// What may stand around a unit at the end of a name.
const BRACKETS: [(char, char); 4] = [('[', ']'), ('(', ')'), ('<', '>'), ('{', '}')];

impl Heading {
    /// The heading of a name.
    pub fn of(raw: &str) -> Self {
        let raw = raw.trim();
        let with = |stem: &str, unit| Self {
            raw: raw.to_owned(),
            stem: snake(stem),
            unit,
            other: None,
            is_said: false,
            is_named: false,
            is_displaced: false,
        };
        for (open, close) in BRACKETS {
            // A unit may have brackets itself: `Pressure (bar(g))`.
            let inside = raw.strip_suffix(close).unwrap_or_default();
            let unit_from =
                |(place, _)| Some((&raw[..place], in_brackets(&inside[place + open.len_utf8()..])?));
            if let Some((stem, unit)) = inside.match_indices(open).find_map(unit_from) {
                return with(stem, Some(unit));
            }
        }
        if let Some((stem, unit)) = raw.rsplit_once('/')
            && let Some(unit) = in_brackets(unit)
        {
            return with(stem, Some(unit));
        }
        match after_underscore(raw) {
            // A lowest time is written so by nobody.
            Some((stem, Meaning::Known(unit))) if unit.suffix() == "min" && snake(stem) != "time" => {
                with(raw, None)
            }
            Some((stem, unit)) => with(stem, Some(unit)),
            None => with(raw, None),
        }
    }

    /// The unit, if there is one and it is no other than the row of units says.
    pub fn known(&self) -> Option<Unit> {
        match self.unit {
            Some(Meaning::Known(unit)) if self.other.is_none() => Some(unit),
            _ => None,
        }
    }

    /// The name as we write it: `pressure_bar`; without a known unit the words alone.
    pub fn name(&self) -> String {
        match self.known() {
            Some(unit) if self.stem.is_empty() => format!("_{}", unit.suffix()),
            Some(unit) => format!("{}_{}", self.stem, unit.suffix()),
            None => self.stem.clone(),
        }
    }

    /// Whether it is written as in our own files, in small letters with a unit at the end, or said
    /// by options.
    pub fn is_ours(&self) -> bool {
        let is_said = self.is_named || self.is_said;
        self.raw == super::VALID || is_said || (self.known().is_some() && self.name() == self.raw)
    }

    /// Takes over a unit from an option.
    pub fn say_unit(&mut self, unit: Unit) {
        (self.unit, self.other, self.is_said) = (Some(Meaning::Known(unit)), None, true);
    }

    /// Takes over a unit from the row below the header.
    pub fn add_unit(&mut self, text: &str) {
        let below = in_brackets(strip_brackets(text));
        match (self.unit, below) {
            (Some(Meaning::Known(unit)), Some(Meaning::Known(below))) if unit != below => {
                self.other = Some(below)
            }
            (Some(Meaning::Known(_)), _) => {}
            (None | Some(Meaning::Ambiguous(_)), Some(_)) => self.unit = below,
            (None | Some(Meaning::Ambiguous(_)), None) => {}
        }
    }

    /// As it is shown to people.
    pub fn shown(&self) -> &str {
        if self.raw.is_empty() { "(a column without a name)" } else { &self.raw }
    }

    /// As an option names it.
    pub fn stem_or_raw(&self) -> &str {
        if self.stem.is_empty() { &self.raw } else { &self.stem }
    }

    /// Whether the unit, if it is known, measures this.
    pub fn measures(&self, quantity: Quantity) -> bool {
        self.known().is_some_and(|unit| unit.quantity() == quantity)
    }
}

/// Whether a field of the row below the header is a unit, in brackets or not.
pub fn is_unit(text: &str) -> bool {
    in_brackets(strip_brackets(text)).is_some()
}

fn strip_brackets(text: &str) -> &str {
    let text = text.trim();
    let within = |(open, close): &(char, char)| text.strip_prefix(*open)?.strip_suffix(*close);
    BRACKETS.iter().find_map(within).unwrap_or(text)
}

/// A symbol that stands alone, where `nm` is no torque and `in` no inlet: symbols are written with
/// care.
fn in_brackets(text: &str) -> Option<Meaning> {
    match text.trim() {
        "-" => Unit::of_symbol("1").map(Meaning::Known),
        "NM" => meaning("NM"),
        symbol => Unit::of_symbol(symbol).map(Meaning::Known),
    }
}

/// A name up to an underscore, and the unit behind it; units that have an underscore themselves are
/// longer.
fn after_underscore(raw: &str) -> Option<(&str, Meaning)> {
    raw.match_indices('_').find_map(|(place, _)| Some((&raw[..place], meaning(&raw[place + 1..])?)))
}

/// Words in small letters, joined by underscores.
fn snake(text: &str) -> String {
    let words = text.split(|letter: char| !letter.is_alphanumeric()).filter(|word| !word.is_empty());
    words.map(str::to_lowercase).collect::<Vec<_>>().join("_")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_loggers_are_understood() {
        for (raw, name) in [
            ("pressure_bar", "pressure_bar"),
            ("Pressure [kPa]", "pressure_kpa"),
            ("Muscle Pressure (kPa)", "muscle_pressure_kpa"),
            ("contraction / mm", "contraction_mm"),
            ("Contraction_mm", "contraction_mm"),
            ("torque [Nm]", "torque_newton_metre"),
            ("displacement (nm)", "displacement_nm"),
            ("gap [in]", "gap_in"),
            ("time_min", "time_min"),
            ("pressure_min", "pressure_min"),
            ("temp [°C]", "temp_c"),
            ("cycle", "cycle"),
            ("Untitled 1", "untitled_1"),
            ("", ""),
            ("_s", "_s"),
        ] {
            assert_eq!(Heading::of(raw).name(), name, "{raw}");
        }
        assert_eq!(Heading::of("pressure_min").unit, None);
        assert!(matches!(Heading::of("displacement_nm").unit, Some(Meaning::Ambiguous(_))));
        assert!(matches!(Heading::of("valve_in").unit, Some(Meaning::Ambiguous(_))));
    }

    #[test]
    fn a_row_of_units_adds_what_is_missing_and_may_contradict() {
        let with = |raw: &str, unit: &str| {
            let mut heading = Heading::of(raw);
            heading.add_unit(unit);
            heading
        };
        assert_eq!(with("Pressure", "[kPa]").name(), "pressure_kpa");
        assert_eq!(with("time_s", "s").known(), Some(Unit::S));
        assert_eq!(with("time_s", "ms").known(), None);
        assert_eq!(with("displacement_nm", "Nm").name(), "displacement_newton_metre");
    }
}
