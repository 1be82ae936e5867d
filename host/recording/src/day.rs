//! When a recording was made, by its file: the date in its name, else that of its last change.

use std::fmt;
use std::path::Path;
use std::time::SystemTime;

use chrono::{DateTime, Datelike, NaiveDate, Utc};

/// Days of a year, for its share that has passed.
const YEAR: f64 = 365.25;

/// A day.
///
/// ```
/// use std::path::Path;
///
/// use recording::day::Day;
///
/// let day = Day::in_name(Path::new("biceps_2026-03-14_run2.csv")).expect("a date");
/// assert_eq!(day.to_string(), "2026-03-14");
/// assert!(day > Day::in_name(Path::new("20260228.csv")).expect("a date"));
/// assert_eq!(Day::in_name(Path::new("run_12345678.csv")), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Day(NaiveDate);

impl Day {
    /// The date in a file's name, as `2026-03-14`, `2026_03_14` or `20260314`; the first, if there
    /// are several. None where eight digits are no date of this or the last century.
    pub fn in_name(file: &Path) -> Option<Self> {
        let name = file.file_name()?.to_string_lossy();
        let bytes = name.as_bytes();
        (0..bytes.len()).find_map(|from| {
            // What begins in the middle of a number is no date.
            let is_inside = from > 0 && bytes[from - 1].is_ascii_digit();
            let parts = if is_inside { None } else { parts(&bytes[from..]) };
            let (year, month, day) = parts?;
            let is_likely = (1900..2100).contains(&year);
            NaiveDate::from_ymd_opt(year, month, day).filter(|_| is_likely).map(Self)
        })
    }

    /// The date in a file's name, else the day of its last change, by universal time; none where
    /// the system does not know it.
    pub fn of_file(file: &Path) -> Option<Self> {
        let changed = || file.metadata().and_then(|about| about.modified()).ok();
        Self::in_name(file).or_else(|| Some(Self(DateTime::<Utc>::from(changed()?).date_naive())))
    }

    /// Today, by universal time.
    pub fn today() -> Self {
        Self(DateTime::<Utc>::from(SystemTime::now()).date_naive())
    }

    /// The year, and which share of it has passed.
    pub fn years(self) -> f64 {
        f64::from(self.0.year()) + f64::from(self.0.ordinal0()) / YEAR
    }
}

impl fmt::Display for Day {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)
    }
}

/// Year, month and day that a text begins with, with one kind of sign between them or none; behind
/// them no digit.
fn parts(text: &[u8]) -> Option<(i32, u32, u32)> {
    let number = |from: usize, count: usize| -> Option<u32> {
        let digits = text.get(from..from + count)?;
        let is_number = digits.iter().all(u8::is_ascii_digit);
        is_number.then(|| digits.iter().fold(0, |number, digit| 10 * number + u32::from(digit - b'0')))
    };
    let gap = match text.get(4)? {
        b'-' | b'_' | b'.' => 1,
        _ => 0,
    };
    if gap == 1 && text.get(4) != text.get(7) {
        return None;
    }
    let (month, day) = (4 + gap, 6 + 2 * gap);
    let is_over = text.get(day + 2).is_none_or(|next| !next.is_ascii_digit());
    is_over.then_some(())?;
    Some((number(0, 4)? as i32, number(month, 2)?, number(day, 2)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_found_in_names_and_other_numbers_are_none() {
        let in_name = |name: &str| Day::in_name(Path::new(name)).map(|day| day.to_string());
        for name in [
            "2026-03-14.csv",
            "run 2026_03_14.csv",
            "m3.2026.03.14.csv",
            "20260314T1200.csv",
            "a20260314b.csv",
        ] {
            assert_eq!(in_name(name).as_deref(), Some("2026-03-14"), "{name}");
        }
        for name in
            ["2026-13-14.csv", "202603.csv", "120260314.csv", "2026031412.csv", "2026-03_14.csv", "run.csv"]
        {
            assert_eq!(in_name(name), None, "{name}");
        }
    }

    #[test]
    fn days_lie_on_a_line_of_years() {
        let years = |name: &str| Day::in_name(Path::new(name)).expect("a date").years();
        assert_eq!(years("2026-01-01"), 2026.0);
        assert!((years("2026-07-02") - 2026.5).abs() < 0.01);
    }
}
