//! Parquet files, as pandas, Polars and Spark write them.
//!
//! Every column of numbers is a variable, one that is missing is NaN. Times are seconds since the
//! first one. Text, lists, decimals and dates are passed over.

use std::fs::File;

use ::parquet::basic::{ConvertedType, LogicalType, TimeUnit};
use ::parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use ::parquet::data_type::DataType;
use ::parquet::errors::ParquetError;
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::schema::types::ColumnDescriptor;

use super::number::whole;
use super::{Problem, Variable};

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
/// The file is damaged, or a whole number has no `f64`.
pub fn variables(file: File) -> Result<Vec<Variable>, Problem> {
    let reader = SerializedFileReader::new(file).map_err(damaged)?;
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let mut found = Vec::new();
    'columns: for (place, column) in schema.columns().iter().enumerate() {
        let Some(meaning) = meaning(column) else { continue };
        let mut values = Values { name: column.path().string(), meaning, first: None, numbers: Vec::new() };
        for group in 0..reader.num_row_groups() {
            let group = reader.get_row_group(group).map_err(damaged)?;
            let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
            let nullable = column.max_def_level();
            match group.get_column_reader(place).map_err(damaged)? {
                ColumnReader::BoolColumnReader(reader) => values.add(reader, rows, nullable, i128::from)?,
                ColumnReader::Int32ColumnReader(reader) => match meaning {
                    Meaning::Unsigned => {
                        values.add(reader, rows, nullable, |value| i128::from(value as u32))?
                    }
                    _ => values.add(reader, rows, nullable, i128::from)?,
                },
                ColumnReader::Int64ColumnReader(reader) => match meaning {
                    Meaning::Unsigned => {
                        values.add(reader, rows, nullable, |value| i128::from(value as u64))?
                    }
                    _ => values.add(reader, rows, nullable, i128::from)?,
                },
                ColumnReader::FloatColumnReader(reader) => {
                    values.add_real(reader, rows, nullable, f64::from)?
                }
                ColumnReader::DoubleColumnReader(reader) => {
                    values.add_real(reader, rows, nullable, |value| value)?
                }
                _ => continue 'columns,
            }
        }
        found.push((values.name, values.numbers));
    }
    Ok(found)
}

/// What a column's numbers are; None of what is no column of numbers.
fn meaning(column: &ColumnDescriptor) -> Option<Meaning> {
    if column.max_rep_level() > 0 {
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

/// The numbers of a column as far as they are read.
struct Values {
    name: String,
    meaning: Meaning,
    /// The first time, in its unit.
    first: Option<i128>,
    numbers: Vec<f64>,
}

impl Values {
    /// Adds those of a group of rows.
    fn add<D: DataType>(
        &mut self,
        reader: ColumnReaderImpl<D>,
        rows: usize,
        nullable: i16,
        number: impl Fn(D::T) -> i128,
    ) -> Result<(), Problem> {
        for value in read(reader, rows, nullable)? {
            let value = value.map(&number);
            let value = match (value, self.meaning) {
                (None, _) => f64::NAN,
                (Some(value), Meaning::Time(per_second)) => {
                    (value - *self.first.get_or_insert(value)) as f64 / per_second
                }
                (Some(value), _) => whole(&self.name, value)?,
            };
            self.numbers.push(value);
        }
        Ok(())
    }

    /// The same of real numbers.
    fn add_real<D: DataType>(
        &mut self,
        reader: ColumnReaderImpl<D>,
        rows: usize,
        nullable: i16,
        number: impl Fn(D::T) -> f64,
    ) -> Result<(), Problem> {
        let values = read(reader, rows, nullable)?;
        self.numbers.extend(values.into_iter().map(|value| value.map_or(f64::NAN, &number)));
        Ok(())
    }
}

/// The values of a group of rows; None where a value is missing. `nullable` is the definition level
/// of a value that is present.
fn read<D: DataType>(
    mut reader: ColumnReaderImpl<D>,
    rows: usize,
    nullable: i16,
) -> Result<Vec<Option<D::T>>, Problem> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    let mut count = 0;
    while count < rows {
        let (read, _, _) =
            reader.read_records(rows - count, Some(&mut levels), None, &mut values).map_err(damaged)?;
        if read == 0 {
            return Err(Problem::Damaged(format!("a column ends after {count} of {rows} rows")));
        }
        count += read;
    }
    if nullable == 0 {
        return Ok(values.into_iter().map(Some).collect());
    }
    let mut values = values.into_iter();
    Ok(levels.into_iter().map(|level| if level == nullable { values.next() } else { None }).collect())
}

fn damaged(error: ParquetError) -> Problem {
    Problem::Damaged(error.to_string())
}
