//! Which columns of a table are the time, the input and the output of a recording.

use super::{CONTRACTION, Choice, INPUTS, LENGTH, Series, Timing};
use crate::table::naming::Found;
use crate::table::rows::holes;
use crate::table::{DataError, DataProblem, Place, Table};
use crate::unit::{Channel, Quantity, Unit};

/// Rows that are so far apart in the middle are more likely milliseconds than seconds. Unit: s.
const DOUBTFUL_STEPS_S: std::ops::RangeInclusive<f64> = 1.0..=1000.0;
/// Fewer rows say nothing of their distance.
const LEAST_ROWS: usize = 3;
/// From here on times are counted from 1970: the year 2001. Unit: s.
const EPOCH_S: f64 = 1e9;
/// The year 2128. Unit: s.
const EPOCH_END_S: f64 = 5e9;

/// The times of a table.
pub struct Times<'a> {
    /// The column.
    pub index: usize,
    /// The column as it is shown.
    pub column: &'a str,
    /// A row each; NaN where there is none. Unit: s.
    pub seconds: Vec<f64>,
    /// What was done.
    pub note: Option<String>,
    /// The unit that the name says, of times that are numbers.
    unit: Option<Unit>,
}

impl<'a> Times<'a> {
    /// Takes the times.
    pub fn of(table: &'a Table) -> Result<Self, DataError> {
        let index = table.time_column()?;
        let column = table.shown(index);
        let values = table.numbers(index)?;
        if values.are_stamps {
            let note = format!("{column} was read as times of a clock, in s from the first one");
            let seconds = values.numbers.to_vec();
            return Ok(Self { index, column, seconds, note: Some(note), unit: None });
        }
        let first = values.numbers.iter().copied().find(|value| !value.is_nan()).unwrap_or(0.0);
        let said = table.unit_of(index)?;
        let unit = match said {
            Some(unit) => unit,
            None if table.is_labview_time(index) => Unit::S,
            None => since_1970(first).ok_or_else(|| {
                let cure = "say --units time=s or --units time=ms".to_owned();
                table.heading_place(index).error(DataProblem::UnknownUnit { cure })
            })?,
        };
        let in_seconds = |value: f64| unit.convert(value, Unit::S);
        let Some(first_s) = in_seconds(first) else {
            let problem = DataProblem::OtherQuantity { found: "a time", is: unit.symbol() };
            return Err(table.heading_place(index).error(problem));
        };
        let is_since_1970 = (EPOCH_S..EPOCH_END_S).contains(&first_s);
        let zero = if is_since_1970 { first } else { 0.0 };
        let seconds = match unit == Unit::S && !is_since_1970 {
            true => values.numbers.to_vec(),
            false => values.numbers.iter().filter_map(|value| in_seconds(value - zero)).collect(),
        };
        let note = match (is_since_1970, said == Some(Unit::S) || table.is_unit_said(index)) {
            (true, _) => {
                Some(format!("{column} was read as {unit} since 1970, and counted from the first row"))
            }
            (false, true) => None,
            (false, false) => Some(format!("{column} was read as a time in {unit}")),
        };
        Ok(Self { index, column, seconds, note, unit: said })
    }

    /// Asks where seconds may be milliseconds.
    pub fn check_step(&self, table: &Table, timing: &Timing) -> Result<(), DataError> {
        let (Some(unit), step_s) = (self.unit, timing.median_step_s) else { return Ok(()) };
        let smaller = match unit.suffix() {
            "s" => "ms",
            "ms" => "us",
            _ => return Ok(()),
        };
        if table.is_unit_said(self.index) || table.rows() < LEAST_ROWS || !DOUBTFUL_STEPS_S.contains(&step_s)
        {
            return Ok(());
        }
        let (column, unit) = (table.as_option(self.index), unit.suffix());
        Err(table.heading_place(self.index).error(DataProblem::SlowRows { step_s, column, smaller, unit }))
    }
}

/// The unit in which a time since 1970 lies in this century.
fn since_1970(time: f64) -> Option<Unit> {
    let units = ["s", "ms", "us", "ns"].into_iter().filter_map(Unit::of_symbol);
    units
        .into_iter()
        .find(|unit| unit.convert(time, Unit::S).is_some_and(|s| (EPOCH_S..EPOCH_END_S).contains(&s)))
}

/// A column that was chosen, and the unit that its values are wanted in.
pub struct Chosen {
    /// Its place in the table.
    pub index: usize,
    /// The column under our name, in its own unit.
    pub column: String,
    unit: Unit,
    wanted: Channel,
}

impl Chosen {
    /// A column in its own unit, unless the name that was asked for has another one.
    fn of(table: &Table, found: Found, asked: Option<&str>) -> Self {
        let Found { index, unit, name } = found;
        let asked = asked.filter(|asked| table.shown(index) != *asked).and_then(Channel::of_column);
        let wanted = asked.filter(|asked| asked.unit.quantity() == unit.quantity());
        let wanted = wanted.unwrap_or_else(|| Channel { name: name.clone(), unit });
        Self { index, column: name, unit, wanted }
    }

    /// What was done to the values, if anything.
    pub fn note(&self) -> Option<String> {
        let Self { column, unit, wanted, .. } = self;
        (unit != &wanted.unit).then(|| format!("{column} was converted to {}", wanted.unit))
    }

    /// The values of the column in the unit that is wanted.
    pub fn series(&self, mut values: Vec<f64>) -> Series {
        if self.unit != self.wanted.unit {
            let convert = |value: f64| self.unit.convert(value, self.wanted.unit).unwrap_or(value);
            values.iter_mut().for_each(|value| *value = convert(*value));
        }
        Series { channel: self.wanted.clone(), values }
    }
}

/// The input: the one that is named, else the first of the usual ones.
pub fn input(table: &Table, choice: &Choice) -> Result<Chosen, DataError> {
    let names = choice.input.as_deref().map_or(INPUTS.to_vec(), |name| vec![name]);
    for name in &names {
        if let Some(found) = table.find(name)? {
            return Ok(Chosen::of(table, found, choice.input.as_deref()));
        }
    }
    let cure = cure(table, choice.has_options.then_some("--input"), names[0]);
    Err(table.missing(&names.join(" or "), cure))
}

/// The output: the one that is named, else the contraction; with the muscle's length at rest, if it
/// is to be made of its length (mm).
pub fn output(table: &Table, choice: &Choice) -> Result<(Chosen, Option<f64>), DataError> {
    let name = choice.output.as_deref().unwrap_or(CONTRACTION);
    let length = || table.find(LENGTH);
    if name == CONTRACTION && choice.rest_length_mm.is_some() {
        let found = length()?.ok_or_else(|| table.missing(LENGTH, String::new()))?;
        return Ok((Chosen::of(table, found, Some(LENGTH)), choice.rest_length_mm));
    }
    if let Some(found) = table.find(name)? {
        return Ok((Chosen::of(table, found, choice.output.as_deref()), None));
    }
    if name == CONTRACTION && length()?.is_some() {
        let place = Place { column: Some(LENGTH.to_owned()), ..Place::file(table.file()) };
        return Err(place.error(DataProblem::NoRestLength));
    }
    Err(table.missing(name, cure(table, choice.has_options.then_some("--output"), name)))
}

/// The option (`option`, else `--columns`) that would name a column instead of a missing one, if
/// the file has one that may be meant: one of the same quantity, else of a quantity that is
/// measured so, else one without a unit.
fn cure(table: &Table, option: Option<&str>, wanted: &str) -> String {
    let Some(channel) = Channel::of_column(wanted) else { return String::new() };
    let (stem, unit) = (channel.stem(), channel.unit.suffix());
    let quote = |column: &str| match column.contains(char::is_whitespace) {
        true => format!("\"{column}\""),
        false => column.to_owned(),
    };
    let quantities = [
        channel.unit.quantity(),
        Quantity::Voltage,
        Quantity::Current,
        Quantity::Angle,
        Quantity::Force,
        Quantity::Length,
    ];
    // What has one of our own names is no candidate for another one.
    let is_input = INPUTS.contains(&wanted) || channel.unit.quantity() == Quantity::Pressure;
    let others: &[&str] =
        if is_input { &["time", "contraction", "length"] } else { &["time", "pressure", "command"] };
    let is_other = |(stem, _): &(&str, &str)| !others.contains(stem);
    let with_unit = quantities.into_iter().find_map(|quantity| table.of_quantity(quantity).find(is_other));
    let time = table.time_column().ok();
    let is_free = |(index, column): &(usize, &str)| Some(*index) != time && !column.starts_with('(');
    let without = table.without_unit().find(is_free).map(|(_, column)| column);
    match (with_unit, without) {
        (Some((_, column)), _) => match option {
            Some(option) => format!("; if {column} is meant, say {option} {}", quote(column)),
            None => format!("; if {column} is meant, say --columns {stem}={}", quote(column)),
        },
        (None, Some(column)) => format!(
            "; if {column} is meant, say --columns {stem}={}:{unit}, with its own unit",
            quote(column)
        ),
        (None, None) => String::new(),
    }
}

/// What is said of rows that lack one of these columns.
pub fn left_out(table: &Table, columns: &[(&[f64], &str)]) -> Option<String> {
    let worst = columns.iter().map(|(values, name)| (holes(values), *name));
    let (missing, name) =
        worst.max_by_key(|(missing, _)| missing.iter().map(ExactSizeIterator::len).sum::<usize>())?;
    let count: usize = missing.iter().map(ExactSizeIterator::len).sum();
    let longest = missing.iter().max_by_key(|hole| hole.len())?;
    let line = table.place(longest.start, name).number();
    Some(format!(
        "{count} rows without a value of {name} were left out, the longest stretch {} rows from line {line} on",
        longest.len()
    ))
}

/// What is said of columns that have no unit, and so no use.
pub fn not_used(table: &Table, time: usize) -> Option<String> {
    let unused: Vec<&str> =
        table.without_unit().filter(|(index, _)| *index != time).map(|(_, column)| column).collect();
    (!unused.is_empty()).then(|| format!("not used, without a unit: {}", unused.join(", ")))
}

/// Whether the values that there are come at even distances: no hole is longer than twice the usual
/// one.
pub fn is_sampled_slowly(values: &[f64]) -> bool {
    let mut lengths: Vec<usize> = holes(values).iter().map(ExactSizeIterator::len).collect();
    lengths.sort_unstable();
    let usual = lengths.get(lengths.len() / 2).copied().unwrap_or(0);
    lengths.last().is_some_and(|longest| *longest <= 2 * usual) && lengths.len() > 1
}
