//! What a field says.

/// How a missing value is written, in small letters.
const HOLES: [&str; 11] = ["", "-", "--", "?", "na", "n/a", "#n/a", "none", "null", "nil", "missing"];

/// A field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell {
    /// A number with a decimal point, or a whole one.
    Number(f64),
    /// A number with a comma in it.
    Comma(f64),
    /// A value that is missing: NaN, empty, or one of the words for it.
    Hole,
    /// A number that is infinite, or too large for one.
    Infinite,
    /// Anything else.
    Text,
}

impl Cell {
    /// Reads a field; `may_have_comma` where commas separate no fields.
    pub fn of(field: &str, may_have_comma: bool) -> Self {
        match field.parse::<f64>() {
            Ok(number) if number.is_finite() => Self::Number(number),
            Ok(number) if number.is_nan() => Self::Hole,
            Ok(_) => Self::Infinite,
            Err(_) => Self::of_rare(field.trim(), may_have_comma),
        }
    }

    fn of_rare(field: &str, may_have_comma: bool) -> Self {
        if HOLES.contains(&field.to_lowercase().as_str()) {
            return Self::Hole;
        }
        if let Some((value, _)) = field.split_once(" #") {
            return Self::of(value.trim_end(), may_have_comma);
        }
        if may_have_comma && field.matches(',').count() == 1 {
            return match field.replace(',', ".").parse::<f64>() {
                Ok(number) if number.is_finite() && !field.contains('.') => Self::Comma(number),
                _ => Self::Text,
            };
        }
        Self::Text
    }

    /// Whether it is a number, with a point or a comma.
    pub fn is_number(self) -> bool {
        matches!(self, Self::Number(_) | Self::Comma(_) | Self::Infinite)
    }
}

/// Whether the comma of a field may stand between thousands: one to three digits before it, of
/// which the first is no zero, and three behind.
pub fn may_be_thousands(field: &str) -> bool {
    let Some((whole, rest)) = field.trim().trim_start_matches(['-', '+']).split_once(',') else {
        return false;
    };
    let is_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    (1..=3).contains(&whole.len())
        && !whole.starts_with('0')
        && is_digits(whole)
        && rest.len() == 3
        && is_digits(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_told_apart() {
        for (field, cell) in [
            ("1.5", Cell::Number(1.5)),
            ("-2e3", Cell::Number(-2000.0)),
            ("0,05", Cell::Comma(0.05)),
            ("1,5e-3", Cell::Comma(0.0015)),
            ("1.234,5", Cell::Text),
            ("NaN", Cell::Hole),
            ("n/a", Cell::Hole),
            ("", Cell::Hole),
            ("1e999", Cell::Infinite),
            ("inf", Cell::Infinite),
            ("2 # touched", Cell::Number(2.0)),
            ("two", Cell::Text),
        ] {
            assert_eq!(Cell::of(field, true), cell, "{field}");
        }
        assert_eq!(Cell::of("0,05", false), Cell::Text);
    }

    #[test]
    fn thousands_are_three_digits_behind_one_to_three() {
        for (field, may_be) in
            [("1,234", true), ("-12,000", true), ("0,123", false), ("1,23", false), ("1234,567", false)]
        {
            assert_eq!(may_be_thousands(field), may_be, "{field}");
        }
    }
}
