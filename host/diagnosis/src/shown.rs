//! Names and units of causes' parameters, as they are shown.
//!
//! Inside the diagnosis a name's `mm` stands for the output's unit and its `bar` for the input's: `mm_per_s`,
//! `band_bar`. Values are in the recording's own units already; here names and units become those as well.

use recording::model_file::names::Names;

/// Names that say no more than their unit, or whose unit depends on an exponent beside them.
const WHOLE: [(&str, &str, &str); 3] = [
    ("mm_per_s", "rate", "mm/s"),
    ("width_gain", "width gain", "(s/bar)^exponent"),
    ("width_gain_of_contraction_rate", "width gain of contraction rate", "(s/mm)^exponent"),
];

/// Ends of names, each with its unit; the longer of two that fit comes first.
const ENDS: [(&str, &str); 9] = [
    ("_mm_per_n", "mm/N"),
    ("_mm_per_k", "mm/K"),
    ("_per_decade", "per decade"),
    ("_per_n", "1/N"),
    ("_per_k", "1/K"),
    ("_bar", "bar"),
    ("_hz", "Hz"),
    ("_mm", "mm"),
    ("_s", "s"),
];

/// A parameter's name with its unit, as files have it: `deg_per_s` where the output is in degrees.
pub fn key(name: &str, units: Names) -> String {
    let shown = |part| match part {
        "mm" => units.output.suffix(),
        "bar" => units.input.suffix(),
        other => other,
    };
    name.split('_').map(shown).collect::<Vec<_>>().join("_")
}

/// A parameter's name in words, and its unit as people write it.
pub fn quantity(name: &str, units: Names) -> (String, String) {
    let whole = WHOLE.iter().find(|(whole, ..)| *whole == name);
    let (words, unit) = match whole {
        Some((_, words, unit)) => ((*words).to_owned(), *unit),
        None => {
            let end = ENDS.iter().find_map(|(end, unit)| Some((name.strip_suffix(end)?, *unit)));
            let (stem, unit) = end.unwrap_or((name, "1"));
            (stem.replace('_', " "), unit)
        }
    };
    let unit = match unit.contains("mm") {
        true => unit.replace("mm", units.output.symbol()),
        false => unit.replace("bar", units.input.symbol()),
    };
    (words, unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use recording::unit::Unit;

    /// Those of a force over a voltage.
    fn others() -> Names {
        let unit = |text| Unit::of_symbol(text).expect(text);
        Names { input: unit("V"), output: unit("N") }
    }

    #[test]
    fn a_parameter_has_the_units_of_the_recording() {
        let pairs = [
            ("time_constant_s", "time_constant_s", ("time constant", "s", "s")),
            ("offset_mm_per_n", "offset_n_per_n", ("offset", "mm/N", "N/N")),
            ("gain_per_k", "gain_per_k", ("gain", "1/K", "1/K")),
            ("mm_per_s", "n_per_s", ("rate", "mm/s", "N/s")),
            ("band_bar", "band_v", ("band", "bar", "V")),
            ("width_gain", "width_gain", ("width gain", "(s/bar)^exponent", "(s/V)^exponent")),
            ("damping_ratio", "damping_ratio", ("damping ratio", "1", "1")),
        ];
        for (name, other, (words, unit, other_unit)) in pairs {
            assert_eq!((key(name, Names::BOARD), key(name, others())), (name.to_owned(), other.to_owned()));
            assert_eq!(quantity(name, Names::BOARD), (words.to_owned(), unit.to_owned()));
            assert_eq!(quantity(name, others()), (words.to_owned(), other_unit.to_owned()));
        }
    }
}
