//! The fields of a column.

use std::fmt;

use super::DataProblem;
use super::cell::{Cell, may_be_thousands};
use super::heading::Heading;
use super::stamp::Clock;

/// The fields of a column as numbers.
#[derive(Clone, Copy, Debug)]
pub struct Values<'a> {
    /// One a row; NaN where one is missing. Times of day and dates: s since the first.
    pub numbers: &'a [f64],
    /// Whether they are dates or times of day.
    pub are_stamps: bool,
}

/// Where the numbers of a column go.
pub trait Store: Default + fmt::Debug {
    /// Takes the next one.
    fn push(&mut self, number: f64);

    /// Leaves out those from this row on.
    fn truncate(&mut self, rows: usize);
}

impl Store for Vec<f64> {
    fn push(&mut self, number: f64) {
        self.push(number);
    }

    fn truncate(&mut self, rows: usize) {
        self.truncate(rows);
    }
}

/// Keeps no number: where it matters only what a column is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unkept;

impl Store for Unkept {
    fn push(&mut self, _: f64) {}

    fn truncate(&mut self, _: usize) {}
}

/// A column, whose fields may be anything.
#[derive(Debug)]
pub struct Column<S = Vec<f64>> {
    pub heading: Heading,
    may_have_comma: bool,
    /// Ends with the first field that is no value: nobody can use what comes behind.
    numbers: S,
    /// Whether a field has been anything but a hole.
    has_value: bool,
    clock: Option<Clock>,
    bad: Option<(usize, Bad)>,
    comma: Option<(usize, String)>,
    has_decimal_commas: bool,
    has_points: bool,
}

/// What is wrong with a field.
#[derive(Clone, Debug)]
enum Bad {
    Text(String),
    Infinite(String),
    Ragged { found: usize, expected: usize },
}

impl Column {
    /// A column of numbers, NaN where one is missing.
    pub fn of_numbers(heading: Heading, values: &[f64]) -> Self {
        let mut column = Self { numbers: Vec::with_capacity(values.len()), ..Self::new(heading, false) };
        column.extend(0, values);
        column
    }

    /// The numbers, one a row, as far as they are any.
    pub fn numbers(&self) -> &[f64] {
        &self.numbers
    }

    /// Forgets the numbers, and goes on.
    pub fn clear(&mut self) {
        self.numbers.clear();
    }
}

impl<S: Store> Column<S> {
    pub fn new(heading: Heading, may_have_comma: bool) -> Self {
        Self {
            heading,
            may_have_comma,
            numbers: S::default(),
            has_value: false,
            clock: None,
            bad: None,
            comma: None,
            has_decimal_commas: false,
            has_points: false,
        }
    }

    /// Adds the numbers of the rows from this one on, NaN where one is missing.
    pub fn extend(&mut self, first: usize, values: &[f64]) {
        if self.bad.is_some() {
            return;
        }
        for (place, value) in values.iter().enumerate() {
            if value.is_infinite() {
                self.bad = Some((first + place, Bad::Infinite(value.to_string())));
                return;
            }
            self.numbers.push(*value);
        }
    }

    /// Adds the field of a row.
    pub fn push(&mut self, row: usize, field: &str) {
        if self.bad.is_some() {
            return;
        }
        let value = match Cell::of(field, self.may_have_comma) {
            // Among times of a clock a number is no time.
            Cell::Number(_) | Cell::Comma(_) if self.clock.is_some() => None,
            Cell::Number(number) => {
                // Only where there may be commas does it matter.
                self.has_points |= self.may_have_comma && field.contains('.');
                Some(number)
            }
            Cell::Comma(number) => {
                self.has_decimal_commas |= !may_be_thousands(field);
                self.comma.get_or_insert_with(|| (row, field.to_owned()));
                Some(number)
            }
            Cell::Hole => Some(f64::NAN),
            Cell::Infinite => {
                self.bad = Some((row, Bad::Infinite(field.to_owned())));
                None
            }
            Cell::Text => self.stamp(field).or_else(|| flag(&self.heading, field)),
        };
        match value {
            Some(value) => {
                self.has_value |= !value.is_nan();
                self.numbers.push(value);
            }
            None => {
                self.bad.get_or_insert_with(|| (row, Bad::Text(field.to_owned())));
            }
        }
    }

    /// Seconds since the first stamp; the first field that is no hole says how stamps are written.
    fn stamp(&mut self, field: &str) -> Option<f64> {
        if self.clock.is_none() && !self.has_value {
            self.clock = Clock::of(field);
        }
        self.clock.as_ref()?.seconds(field)
    }

    /// Adds a hole, since the row ends before this column.
    pub fn push_missing(&mut self, row: usize, found: usize, expected: usize) {
        self.bad.get_or_insert((row, Bad::Ragged { found, expected }));
    }

    /// Leaves out the rows from this one on.
    pub fn truncate(&mut self, rows: usize) {
        self.numbers.truncate(rows);
        self.bad.take_if(|(row, _)| *row >= rows);
    }

    /// Whether they are dates or times of day.
    ///
    /// # Errors
    /// The first row whose field is no value, and why.
    pub fn are_stamps(&self) -> Result<bool, (usize, DataProblem)> {
        match self.bad.clone() {
            None => Ok(self.clock.is_some()),
            Some((row, Bad::Infinite(value))) => Err((row, DataProblem::NotFinite { value })),
            Some((row, Bad::Ragged { found, expected })) => {
                Err((row, DataProblem::Ragged { found, expected }))
            }
            Some((row, Bad::Text(value))) if looks_like_time(&value) => {
                Err((row, DataProblem::NotATime { value }))
            }
            Some((row, Bad::Text(value))) => Err((row, DataProblem::NotANumber { value })),
        }
    }

    /// Whether all fields are numbers or holes.
    pub fn is_numeric(&self) -> bool {
        self.bad.is_none() && self.clock.is_none()
    }

    /// Whether a comma can only be a decimal one.
    pub fn has_decimal_commas(&self) -> bool {
        self.has_decimal_commas
    }

    /// Whether a number has a point.
    pub fn has_points(&self) -> bool {
        self.has_points
    }

    /// The first number with a comma, and its row.
    pub fn first_comma(&self) -> Option<(usize, String)> {
        self.comma.clone()
    }
}

/// Whether a text may be meant as a time: it has colons between digits.
fn looks_like_time(text: &str) -> bool {
    text.contains(':') && text.starts_with(|first: char| first.is_ascii_digit())
}

/// True and false, in a column of flags.
fn flag(heading: &Heading, field: &str) -> Option<f64> {
    if heading.name() != super::VALID {
        return None;
    }
    match field.to_lowercase().as_str() {
        "true" => Some(1.0),
        "false" => Some(0.0),
        _ => None,
    }
}
