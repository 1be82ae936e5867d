//! Times of day and dates, as loggers write them.

use chrono::{DateTime, NaiveDateTime, NaiveTime, TimeDelta};

/// Dates with times that have one meaning.
const DATED: [&str; 5] = [
    "%Y-%m-%dT%H:%M:%S%.f",
    "%Y-%m-%d %H:%M:%S%.f",
    "%Y/%m/%d %H:%M:%S%.f",
    "%Y%m%dT%H%M%S%.f",
    "%Y-%m-%d_%H:%M:%S%.f",
];
const TIME_OF_DAY: &str = "%H:%M:%S%.f";

/// The clock of a column: how its first stamp is written, and when that was.
#[derive(Clone, Debug)]
pub struct Clock {
    format: Format,
    first: NaiveDateTime,
}

#[derive(Clone, Debug)]
enum Format {
    /// With a time zone.
    Zoned,
    /// One of the formats with a date.
    Dated(&'static str),
    /// A time of day behind a date that stays the same: whether the day or the month comes first
    /// does not matter.
    OfDay { date: String },
}

impl Clock {
    /// The clock whose first stamp this is; `None` if it is no known stamp.
    pub fn of(text: &str) -> Option<Self> {
        let date = text.rsplit_once(' ').map_or("", |(date, _)| date);
        let formats = [Format::Zoned]
            .into_iter()
            .chain(DATED.map(Format::Dated))
            .chain([Format::OfDay { date: date.to_owned() }]);
        formats.into_iter().find_map(|format| {
            let first = format.parse(text)?;
            Some(Self { format, first })
        })
    }

    /// Time since the first stamp. Unit: s. `None` if it is written in another way.
    pub fn seconds(&self, text: &str) -> Option<f64> {
        let since = self.format.parse(text)?.signed_duration_since(self.first);
        Some(in_seconds(since))
    }
}

impl Format {
    fn parse(&self, text: &str) -> Option<NaiveDateTime> {
        // A comma before the fraction is as good as a point (ISO 8601).
        let pointed;
        let text = match text.contains(',') {
            true => {
                pointed = text.replace(',', ".");
                &pointed
            }
            false => text,
        };
        match self {
            Self::Zoned => DateTime::parse_from_rfc3339(text).ok().map(|stamp| stamp.naive_utc()),
            Self::Dated(format) => NaiveDateTime::parse_from_str(text, format).ok(),
            Self::OfDay { date } => {
                let time = text.strip_prefix(date.as_str())?.trim_start();
                let time = NaiveTime::parse_from_str(time, TIME_OF_DAY).ok()?;
                Some(NaiveDateTime::default().date().and_time(time))
            }
        }
    }
}

fn in_seconds(time: TimeDelta) -> f64 {
    time.num_seconds() as f64 + 1e-9 * f64::from(time.subsec_nanos())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_of_many_kinds_are_seconds() {
        for (first, later) in [
            ("2024-05-01T12:00:00", "2024-05-01T12:00:01.5"),
            ("2024-05-01T12:00:00Z", "2024-05-01T12:00:01.500Z"),
            ("2024-05-01T23:59:59+02:00", "2024-05-01T22:00:00.500+00:00"),
            ("2024-05-01 23:59:59.25", "2024-05-02 00:00:00,75"),
            ("2024/05/01 12:00:00", "2024/05/01 12:00:01.5"),
            ("12:00:00.000", "12:00:01.500"),
            ("01.05.2024 12:00:00,000", "01.05.2024 12:00:01,500"),
            ("05/01/2024 12:00:00", "05/01/2024 12:00:01.5"),
        ] {
            let clock = Clock::of(first).expect(first);
            let (zero, found) = (clock.seconds(first), clock.seconds(later));
            assert_eq!((zero, found), (Some(0.0), Some(1.5)), "{first} to {later}");
        }
    }

    #[test]
    fn what_is_no_stamp_has_no_clock() {
        for text in ["", "12", "0.5", "noon", "2024-05-01", "5/1/2024 1:02:03 PM", "25:00:00"] {
            assert!(Clock::of(text).is_none(), "{text}");
        }
        let clock = Clock::of("01.05.2024 23:59:59").expect("a stamp");
        assert_eq!(clock.seconds("02.05.2024 00:00:00"), None);
    }
}
