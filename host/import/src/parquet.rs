//! Parquet files, as pandas, Polars and Spark write them.
//!
//! Every column of numbers is a variable, one that is missing is NaN. Times are seconds since the
//! first one. Text, lists, decimals and dates are passed over. A page of each column is unpacked at
//! a time, however large the groups of rows are.

use std::fmt;
use std::fs::File;
use std::rc::Rc;

use ::parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use ::parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use ::parquet::data_type::DataType;
use ::parquet::errors::ParquetError;
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::schema::types::ColumnDescriptor;

use super::Problem;
use super::number::whole;
use super::variables::{Reader, Variable};

/// What the numbers of a column are.
#[derive(Clone, Copy, PartialEq)]
enum Meaning {
    Number,
    /// Whole numbers that are not below 0, though they are stored so.
    Unsigned,
    /// So many of them are a second.
    Time(f64),
}

/// The variables of a file.
///
/// # Errors
/// The file is damaged.
pub fn variables(file: File) -> Result<Vec<Box<dyn Variable>>, Problem> {
    let reader = Rc::new(SerializedFileReader::new(file).map_err(damaged)?);
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let groups = reader.metadata().row_groups();
    let rows = groups.iter().map(|group| usize::try_from(group.num_rows()).unwrap_or(0)).sum();
    let mut found: Vec<Box<dyn Variable>> = Vec::new();
    for (place, column) in schema.columns().iter().enumerate() {
        if let Some(meaning) = meaning(column) {
            let (file, name) = (Rc::clone(&reader), column.path().string());
            found.push(Box::new(Column {
                file,
                place,
                name,
                meaning,
                rows,
                present: column.max_def_level(),
            }));
        }
    }
    Ok(found)
}

/// What a column's numbers are; None of what is no column of numbers.
fn meaning(column: &ColumnDescriptor) -> Option<Meaning> {
    let is_number =
        !matches!(column.physical_type(), Type::INT96 | Type::BYTE_ARRAY | Type::FIXED_LEN_BYTE_ARRAY);
    if column.max_rep_level() > 0 || !is_number {
        return None;
    }
    let per_second = |unit: &TimeUnit| match unit {
        TimeUnit::MILLIS => 1e3,
        TimeUnit::MICROS => 1e6,
        TimeUnit::NANOS => 1e9,
    };
    match (column.logical_type_ref(), column.converted_type()) {
        (Some(LogicalType::Timestamp(time)), _) => Some(Meaning::Time(per_second(&time.unit))),
        (Some(LogicalType::Integer(whole)), _) => {
            Some(if whole.is_signed { Meaning::Number } else { Meaning::Unsigned })
        }
        (None, ConvertedType::NONE) => Some(Meaning::Number),
        (None, ConvertedType::TIMESTAMP_MILLIS) => Some(Meaning::Time(1e3)),
        (None, ConvertedType::TIMESTAMP_MICROS) => Some(Meaning::Time(1e6)),
        _ => None,
    }
}

/// A column.
struct Column {
    file: Rc<SerializedFileReader<File>>,
    /// Among the columns of the file.
    place: usize,
    name: String,
    meaning: Meaning,
    rows: usize,
    /// Definition level of a value that is there.
    present: i16,
}

impl fmt::Debug for Column {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.debug_struct("Column").field("name", &self.name).field("rows", &self.rows).finish()
    }
}

impl Variable for Column {
    fn entries(&self) -> Vec<String> {
        vec![self.name.clone()]
    }

    fn rows(&self) -> usize {
        self.rows
    }

    fn reader(&self, _: &[usize]) -> Result<Box<dyn Reader + '_>, Problem> {
        Ok(Box::new(Values { column: self, group: 0, size: 0, left: 0, values: None, first: None }))
    }
}

/// Where the reading of a column has come to.
struct Values<'a> {
    column: &'a Column,
    /// The next group of rows.
    group: usize,
    /// Rows of the group before that, and how many of them are left.
    size: usize,
    left: usize,
    values: Option<ColumnReader>,
    /// The first time, in its unit.
    first: Option<i128>,
}

impl Reader for Values<'_> {
    fn read(&mut self, rows: usize, columns: &mut [Vec<f64>]) -> Result<(), Problem> {
        let Column { file, place, name, meaning, present, .. } = self.column;
        let (meaning, present) = (*meaning, *present);
        let mut count = 0;
        while count < rows {
            while self.left == 0 {
                let group = file.get_row_group(self.group).map_err(damaged)?;
                self.size = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
                self.left = self.size;
                self.values = Some(group.get_column_reader(*place).map_err(damaged)?);
                self.group += 1;
            }
            let most = self.left.min(rows - count);
            let first = &mut self.first;
            let mut exact = |value: i128| match meaning {
                Meaning::Time(per_second) => Ok((value - *first.get_or_insert(value)) as f64 / per_second),
                _ => whole(name, value),
            };
            let numbers = match &mut self.values {
                Some(ColumnReader::BoolColumnReader(reader)) => {
                    read(reader, most, present, |value| exact(value.into()))
                }
                Some(ColumnReader::Int32ColumnReader(reader)) => {
                    read(reader, most, present, |value| match meaning {
                        Meaning::Unsigned => exact((value as u32).into()),
                        _ => exact(value.into()),
                    })
                }
                Some(ColumnReader::Int64ColumnReader(reader)) => {
                    read(reader, most, present, |value| match meaning {
                        Meaning::Unsigned => exact((value as u64).into()),
                        _ => exact(value.into()),
                    })
                }
                Some(ColumnReader::FloatColumnReader(reader)) => {
                    read(reader, most, present, |value| Ok(value.into()))
                }
                Some(ColumnReader::DoubleColumnReader(reader)) => read(reader, most, present, Ok),
                _ => Err(Problem::Damaged(format!("{name} is stored in two ways"))),
            }?;
            if numbers.is_empty() {
                let (found, rows) = (self.size - self.left, self.size);
                return Err(Problem::Damaged(format!("a column ends after {found} of {rows} rows")));
            }
            self.left -= numbers.len();
            count += numbers.len();
            columns[0].extend(numbers);
        }
        Ok(())
    }
}

/// The next values of a group of rows, so many at most; NaN where one is missing. `present` is the
/// definition level of a value that is there.
fn read<D: DataType>(
    reader: &mut ColumnReaderImpl<D>,
    most: usize,
    present: i16,
    mut number: impl FnMut(D::T) -> Result<f64, Problem>,
) -> Result<Vec<f64>, Problem> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    let (count, _, _) = reader.read_records(most, Some(&mut levels), None, &mut values).map_err(damaged)?;
    let mut values = values.into_iter();
    if present == 0 {
        return values.take(count).map(number).collect();
    }
    let next = |level: i16| if level == present { values.next() } else { None };
    levels.into_iter().map(next).map(|value| value.map_or(Ok(f64::NAN), &mut number)).collect()
}

fn damaged(error: ParquetError) -> Problem {
    Problem::Damaged(error.to_string())
}
