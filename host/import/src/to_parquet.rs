//! Tables as Parquet, for pandas, Polars and Spark.
//!
//! Numbers are `DOUBLE`, bit for bit, words are UTF-8. A number that is missing (NaN) and an empty word are null. A group
//! of rows is written at a time, so that beside the columns no more than that is held.

use std::io::{self, Write};
use std::sync::Arc;

use ::parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use ::parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType};
use ::parquet::errors::ParquetError;
use ::parquet::file::properties::WriterProperties;
use ::parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use ::parquet::schema::types::Type;

use super::Values;

/// Rows of a group: a megabyte of a column of numbers.
const GROUP: usize = 1 << 17;
/// Definition levels of a value that is missing, and of one that is there.
const LEVELS: [i16; 2] = [0, 1];

/// Writes columns of one length, each with its name.
///
/// # Errors
/// The target takes no more.
pub fn write(target: impl Write + Send, columns: &[(&str, Values)]) -> io::Result<()> {
    let mut writer = Writer::new(target, columns)?;
    let rows = columns.iter().map(|(_, values)| values.len()).max().unwrap_or(0);
    for first in (0..rows).step_by(GROUP) {
        let last = rows.min(first + GROUP);
        let group: Vec<Values> = columns.iter().map(|(_, values)| values.part(first..last)).collect();
        writer.group(&group)?;
    }
    writer.close()
}

/// Writes columns a group of rows at a time.
pub struct Writer<W: Write + Send>(SerializedFileWriter<W>);

impl<W: Write + Send> Writer<W> {
    /// Begins a file of columns with these names, whose values are of these kinds; the values are
    /// not written.
    ///
    /// # Errors
    /// The target takes no more.
    pub fn new(target: W, columns: &[(&str, Values)]) -> io::Result<Self> {
        Self::begin(target, columns).map_err(full)
    }

    fn begin(target: W, columns: &[(&str, Values)]) -> Result<Self, ParquetError> {
        let fields = columns.iter().map(|(name, values)| {
            let (physical, logical) = match values {
                Values::Numbers(_) => (Physical::DOUBLE, None),
                Values::Words(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            };
            let field = Type::primitive_type_builder(name, physical).with_repetition(Repetition::OPTIONAL);
            field.with_logical_type(logical).build().map(Arc::new)
        });
        let schema =
            Type::group_type_builder("recording").with_fields(fields.collect::<Result<_, _>>()?).build()?;
        let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
        SerializedFileWriter::new(target, Arc::new(schema), Arc::new(properties)).map(Self)
    }

    /// Writes a group of rows, as many of each column.
    ///
    /// # Errors
    /// The target takes no more.
    pub fn group(&mut self, columns: &[Values]) -> io::Result<()> {
        self.add(columns).map_err(full)
    }

    fn add(&mut self, columns: &[Values]) -> Result<(), ParquetError> {
        let mut group = self.0.next_row_group()?;
        for values in columns {
            match values {
                Values::Numbers(values) => {
                    add::<DoubleType, _>(&mut group, values, |value| (!value.is_nan()).then_some(*value))?
                }
                Values::Words(values) => add::<ByteArrayType, _>(&mut group, values, |value| {
                    (!value.is_empty()).then(|| ByteArray::from(value.as_bytes().to_vec()))
                })?,
            }
        }
        group.close().map(drop)
    }

    /// Ends the file.
    ///
    /// # Errors
    /// The target takes no more.
    pub fn close(self) -> io::Result<()> {
        self.0.close().map(drop).map_err(full)
    }
}

/// A full disk is said as that.
fn full(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(error) => match error.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(error) => io::Error::other(error),
        },
        error => io::Error::other(error),
    }
}

/// Writes the rows of one column of a group; `known` is None where one is missing.
fn add<D: DataType, V>(
    group: &mut SerializedRowGroupWriter<'_, impl Write + Send>,
    values: &[V],
    known: impl Fn(&V) -> Option<D::T>,
) -> Result<(), ParquetError> {
    let values: Vec<Option<D::T>> = values.iter().map(known).collect();
    let levels: Vec<i16> = values.iter().map(|value| LEVELS[usize::from(value.is_some())]).collect();
    let there: Vec<D::T> = values.into_iter().flatten().collect();
    let Some(mut column) = group.next_column()? else { return Ok(()) };
    column.typed::<D>().write_batch(&there, Some(&levels), None)?;
    column.close()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back_bit_for_bit_and_missing_ones_missing() {
        // More than one group of rows.
        let numbers: Vec<f64> =
            (0..GROUP + 3).map(|row| if row % 7 == 3 { f64::NAN } else { 0.1 * row as f64 }).collect();
        let words: Vec<String> =
            (0..GROUP + 3).map(|row| if row == 5 { String::new() } else { format!("{row} µm") }).collect();
        let mut file = tempfile::NamedTempFile::new().expect("a file");
        let columns = [("pressure_bar", Values::Numbers(&numbers)), ("note", Values::Words(&words))];
        write(&mut file, &columns).expect("it is written");
        let found = crate::parquet::variables(file.reopen().expect("it is there")).expect("it is read");
        let found = crate::variables::tests::read(found, 1000).expect("it is read");
        let [(name, values)] = &found[..] else { panic!("words are no variable: {}", found.len()) };
        assert_eq!(name, "pressure_bar");
        assert!(values.iter().map(|value| value.to_bits()).eq(numbers.iter().map(|value| value.to_bits())));
    }
}
