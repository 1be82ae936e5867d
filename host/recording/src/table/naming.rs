//! Which column is which: the options that say so, and the search for a column.

use std::str::FromStr;

use super::column::Store;
use super::heading::Heading;
use super::{DataError, DataProblem, Table};
use crate::unit::{Channel, Meaning, Quantity, Unit};

/// The column of times in LabVIEW's files.
const LABVIEW_TIME: &str = "X_Value";

/// A column of a file under a name of ours: `pressure=p:psi`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Renamed {
    /// Our name, without a unit.
    pub name: String,
    /// The column, as the file has it.
    pub column: String,
    /// Its unit, if its own name does not say.
    pub unit: Option<Unit>,
}

/// The unit of a column: `time=ms`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnitOf {
    /// The column, as the file has it, or without its unit.
    pub column: String,
    /// The unit.
    pub unit: Unit,
}

/// What the user says of a file's columns.
#[derive(Clone, Debug, Default)]
pub struct Naming {
    /// The column of times.
    pub time: Option<String>,
    /// Columns under other names.
    pub columns: Vec<Renamed>,
    /// Units of columns.
    pub units: Vec<UnitOf>,
    /// Channels of a model or another recording: a column of the same name has the same unit.
    pub known: Vec<Channel>,
}

/// A column that was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// Its place in the table, from 0.
    pub index: usize,
    /// Its unit.
    pub unit: Unit,
    /// The column under our name: `pressure_kpa`.
    pub name: String,
}

impl FromStr for Renamed {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, column) =
            text.split_once('=').ok_or("a name and a column are needed: pressure=p or pressure=p:psi")?;
        let (column, unit) = match column.rsplit_once(':') {
            Some((column, unit)) => (column, Some(unit_of(unit)?)),
            None => (column, None),
        };
        // `pressure_bar=p` says the unit too.
        let heading = Heading::of(name);
        let unit = unit.or(heading.known());
        Ok(Self { name: heading.stem, column: column.trim().to_owned(), unit })
    }
}

impl FromStr for UnitOf {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (column, unit) = text.split_once('=').ok_or("a column and its unit are needed: time=ms")?;
        Ok(Self { column: column.trim().to_owned(), unit: unit_of(unit)? })
    }
}

fn unit_of(text: &str) -> Result<Unit, String> {
    let unknown = || {
        let known = Unit::known_suffixes().replace(" _", " ");
        format!("the unit {text} is not known; known are {}", known.trim_start_matches('_'))
    };
    Unit::of_symbol(text.trim()).ok_or_else(unknown)
}

impl<S: Store> Table<S> {
    /// Gives columns the names and units that the user says.
    ///
    /// # Errors
    /// A column is not there, or there twice.
    pub fn name(&mut self, naming: &Naming) -> Result<(), DataError> {
        // The file's own names count, before any column gets another one.
        let time = naming.time.iter().map(|column| ("time", column.as_str(), None));
        let renamed = naming.columns.iter().map(|it| (it.name.as_str(), it.column.as_str(), it.unit));
        let place = |(name, column, unit): (_, &str, _)| Ok((self.existing(column)?, name, unit));
        let renamed: Vec<(usize, &str, Option<Unit>)> =
            time.chain(renamed).map(place).collect::<Result<_, DataError>>()?;
        let units: Vec<Option<usize>> =
            naming.units.iter().map(|it| self.position(&it.column)).collect::<Result<_, _>>()?;
        for (index, name, unit) in renamed {
            let heading = &mut self.columns[index].heading;
            (heading.stem, heading.is_named, heading.is_displaced) = (name.to_owned(), true, false);
            if let Some(unit) = unit {
                heading.say_unit(unit);
            }
            let others = self.columns.iter_mut().map(|column| &mut column.heading);
            others
                .filter(|other| other.stem == name && !other.is_named)
                .for_each(|other| other.is_displaced = true);
        }
        for (UnitOf { column, unit }, index) in naming.units.iter().zip(units) {
            let index = index.map_or_else(|| self.existing(column), Ok)?;
            self.columns[index].heading.say_unit(*unit);
        }
        for known in &naming.known {
            let is_same = |heading: &&mut Heading| {
                heading.raw == known.name && matches!(heading.unit, Some(Meaning::Ambiguous(_)))
            };
            if let Some(heading) = self.columns.iter_mut().map(|column| &mut column.heading).find(is_same) {
                heading.unit = Some(Meaning::Known(known.unit));
            }
        }
        Ok(())
    }

    /// The column of a name that the user says.
    fn existing(&self, name: &str) -> Result<usize, DataError> {
        self.position(name)?.ok_or_else(|| self.missing(name, String::new()))
    }

    /// The column of a name: as it stands in the file, as we write it, or without its unit, in the
    /// end in letters of any size.
    ///
    /// # Errors
    /// There are two.
    pub(super) fn position(&self, name: &str) -> Result<Option<usize>, DataError> {
        let wanted = Heading::of(name);
        let ways: [&dyn Fn(&Heading) -> bool; 5] = [
            &|heading| heading.raw == wanted.raw && !heading.is_named,
            &|heading| heading.name() == wanted.raw,
            &|heading| heading.name() == wanted.name() && !heading.name().is_empty(),
            &|heading| heading.stem == wanted.raw && !heading.stem.is_empty(),
            &|heading| heading.stem == wanted.stem && wanted.unit.is_none() && !heading.stem.is_empty(),
        ];
        for is_it in ways {
            let is_it = |&index: &usize| {
                let heading = &self.columns[index].heading;
                is_it(heading) && !heading.is_displaced
            };
            let mut found = (0..self.columns.len()).filter(is_it);
            if let Some(index) = found.next() {
                return match found.next() {
                    Some(second) => Err(self.heading_place(second).error(DataProblem::DoubledColumn)),
                    None => Ok(Some(index)),
                };
            }
        }
        Ok(None)
    }

    /// The column of one of our names, or that of the same words in another unit of the same
    /// quantity; `None` if there is no such column.
    ///
    /// # Errors
    /// There are two, or the unit is not known, or may be two.
    pub fn find(&self, name: &str) -> Result<Option<Found>, DataError> {
        let wanted = Heading::of(name);
        let index = match self.position(name)? {
            Some(index) => index,
            None => {
                let in_another_unit = |index: &usize| {
                    let heading = &self.columns[*index].heading;
                    let same = wanted
                        .known()
                        .is_some_and(|unit| heading.known().is_none() || heading.measures(unit.quantity()));
                    heading.stem == wanted.stem && !wanted.stem.is_empty() && same && !heading.is_displaced
                };
                let mut found = (0..self.columns.len()).filter(in_another_unit);
                match (found.next(), found.next()) {
                    (None, _) => return Ok(None),
                    (Some(index), None) => index,
                    (Some(_), Some(second)) => {
                        return Err(self.heading_place(second).error(DataProblem::DoubledColumn));
                    }
                }
            }
        };
        let heading = &self.columns[index].heading;
        let unit = heading.known().ok_or_else(|| self.without_known_unit(index))?;
        Ok(Some(Found { index, unit, name: heading.name() }))
    }

    /// That a column's unit is not known, and the option that says it.
    fn without_known_unit(&self, index: usize) -> DataError {
        let heading = &self.columns[index].heading;
        let column = heading.shown();
        let problem = match (heading.unit, heading.other) {
            (Some(Meaning::Known(name)), Some(row)) => {
                DataProblem::TwoUnits { column: column.to_owned(), name: name.symbol(), row: row.symbol() }
            }
            (Some(Meaning::Ambiguous(choices)), _) => {
                let options: Vec<String> = choices
                    .iter()
                    .map(|choice| choice.split(' ').next().unwrap_or(choice))
                    .map(|unit| format!("--units {}={unit}", heading.stem_or_raw()))
                    .collect();
                DataProblem::AmbiguousUnit { choices, cure: format!("say {}", options.join(" or ")) }
            }
            _ => DataProblem::UnknownUnit { cure: format!("say it by --units {column}=UNIT") },
        };
        self.heading_place(index).error(problem)
    }

    /// The column of times: `time_s`, or what else is evidently one.
    ///
    /// # Errors
    /// There is none, or there are two.
    pub fn time_column(&self) -> Result<usize, DataError> {
        const NAMES: [&str; 6] = ["time_s", "time", "timestamp", "time_stamp", "datetime", "date_time"];
        for name in NAMES {
            if let Some(index) = self.position(name)? {
                return Ok(index);
            }
        }
        // LabVIEW's column of times, and a letter whose unit is one of time.
        let is_time = |heading: &Heading| {
            heading.raw == LABVIEW_TIME
                || matches!(heading.stem.as_str(), "time" | "t" | "timestamp")
                    && heading.measures(Quantity::Time)
        };
        let mut found = (0..self.columns.len()).filter(|&index| is_time(&self.columns[index].heading));
        match (found.next(), found.next()) {
            (Some(index), None) => Ok(index),
            (Some(_), Some(second)) => Err(self.heading_place(second).error(DataProblem::DoubledColumn)),
            (None, _) => {
                let guess = self.of_quantity(Quantity::Time).next();
                let guess = guess.map_or("COLUMN", |(_, column)| column);
                Err(self.missing("time_s", format!("; name it by --time {guess}")))
            }
        }
    }

    /// The unit that a column's name, the row of units or an option says; `None` if none does.
    ///
    /// # Errors
    /// The unit may be two.
    pub fn unit_of(&self, index: usize) -> Result<Option<Unit>, DataError> {
        let heading = &self.columns[index].heading;
        match (heading.known(), heading.unit) {
            (None, Some(_)) => Err(self.without_known_unit(index)),
            (known, _) => Ok(known),
        }
    }

    /// Whether an option says the column's unit.
    pub fn is_unit_said(&self, index: usize) -> bool {
        self.columns[index].heading.is_said
    }

    /// Whether a column is that of LabVIEW's times, which are in seconds.
    pub fn is_labview_time(&self, index: usize) -> bool {
        self.columns[index].heading.raw == LABVIEW_TIME
    }
}
