//! Tables whose numbers are not held: what their columns are, and their rows, some at a time.
//!
//! A text is gone through once to see how it is written and what its columns are, and again for
//! numbers; files of other programs are [`Numbers`] that are gone through as often.

use std::fmt;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use sha2::{Digest, Sha256};

use super::cell::Cell;
use super::column::{Column, Store, Unkept};
use super::encoding;
use super::heading::Heading;
use super::hexadecimal;
use super::layout::Layout;
use super::lines::{Stream, number};
use super::pieces::{Pieces, Source};
use super::{DataError, DataProblem, Place, Table};

/// Rows that are looked at together: a megabyte of a column.
const BLOCK: usize = 1 << 17;

/// Takes some rows of columns.
pub type Sink<'a> = dyn FnMut(&[&[f64]]) -> io::Result<()> + 'a;

/// Columns of numbers that can be gone through again and again.
pub trait Numbers: fmt::Debug {
    /// Gives these columns to `sink`, from the first row to the last: so many rows at a time, and
    /// the last time what is left. NaN stands for a missing number.
    ///
    /// # Errors
    /// What `sink` says; they cannot be read.
    fn blocks(&self, columns: &[usize], most: usize, sink: &mut Sink) -> io::Result<()>;
}

/// What a file's columns are, without their numbers: for files of any size.
///
/// ```
/// use recording::table::outline::Outline;
///
/// # let folder = tempfile::tempdir()?;
/// # let file = &folder.path().join("rec.csv");
/// std::fs::write(file, "time_s,pressure_bar\n0.0,1.0\n0.1,1.5\n0.2,2.0\n")?;
/// let outline = Outline::of(file, std::fs::File::open(file)?.into())?;
/// assert_eq!(outline.table.rows(), 3);
/// let mut sum = 0.0;
/// outline.blocks(&[1], 2, &mut |columns| {
///     sum += columns[0].iter().sum::<f64>();
///     Ok(())
/// })?;
/// assert_eq!(sum, 4.5);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Outline {
    /// The table, whose columns have no numbers.
    pub table: Table<Unkept>,
    numbers: Box<dyn Numbers>,
}

impl Outline {
    /// The outline of a file of text; `name` is the file's in messages.
    ///
    /// # Errors
    /// The file cannot be read, or is no table.
    pub fn of(name: &Path, file: Arc<File>) -> Result<Self, DataError> {
        let refuse = |error| Place::file(name).error(DataProblem::Unreadable(error));
        Self::of_source(name, Source::of_file(file).map_err(refuse)?)
    }

    /// The same of a text in memory.
    ///
    /// # Errors
    /// The text is no table.
    pub fn of_text(name: &Path, text: String) -> Result<Self, DataError> {
        Self::of_source(name, Source::Bytes(text.into_bytes().into()))
    }

    fn of_source(name: &Path, source: Source<'static>) -> Result<Self, DataError> {
        let text = Text::of(name, source)?;
        let table: Table<Unkept> = text.table()?;
        let headings = table.columns.iter().map(|column| column.heading.clone()).collect();
        let numbers = Box::new(Rows { headings, count: table.rows(), text });
        Ok(Self { table, numbers })
    }

    /// The outline of columns of numbers with these names, which are gone through once; `name` is
    /// the table's in messages, which count its rows from 0.
    ///
    /// # Errors
    /// There is no row; the outer error: they cannot be read.
    pub fn of_numbers(
        name: &Path,
        columns: &[String],
        numbers: Box<dyn Numbers>,
    ) -> io::Result<Result<Self, DataError>> {
        let mut found: Vec<Column<Unkept>> =
            columns.iter().map(|column| Column::new(Heading::of(column), false)).collect();
        let all: Vec<usize> = (0..columns.len()).collect();
        let mut rows = 0;
        numbers.blocks(&all, BLOCK, &mut |block| {
            found.iter_mut().zip(block).for_each(|(column, values)| column.extend(rows, values));
            rows += block.first().map_or(0, |values| values.len());
            Ok(())
        })?;
        if rows == 0 {
            return Ok(Err(Place::file(name).error(DataProblem::NoRows)));
        }
        let table = Table {
            file: name.to_owned(),
            sha256: String::new(),
            notes: Vec::new(),
            header_line: None,
            columns: found,
            rows,
            jumps: Vec::new(),
        };
        Ok(Ok(Self { table, numbers }))
    }

    /// Reads columns again, so many rows at a time, and gives their numbers to `sink`.
    ///
    /// # Errors
    /// What `sink` says; the file cannot be read, or is not what it was.
    pub fn blocks(&self, columns: &[usize], most: usize, sink: &mut Sink) -> io::Result<()> {
        let mut rows = 0;
        self.numbers.blocks(columns, most, &mut |block| {
            rows += block.first().map_or(0, |values| values.len());
            sink(block)
        })?;
        if rows == self.table.rows() { Ok(()) } else { Err(changed()) }
    }
}

fn changed() -> io::Error {
    io::Error::other("the file has changed while it was read")
}

/// The first rows of a text.
#[derive(Debug)]
struct Rows {
    text: Text<'static>,
    headings: Vec<Heading>,
    count: usize,
}

impl Numbers for Rows {
    fn blocks(&self, columns: &[usize], most: usize, sink: &mut Sink) -> io::Result<()> {
        let headings = self.headings.iter().cloned();
        let mut blocks = Blocks {
            header: &self.text.header,
            columns: headings.map(|heading| self.text.column(heading)).collect(),
            wanted: columns,
            most,
            count: 0,
            left: self.count,
            sink,
        };
        self.text.rows(&mut blocks).map_err(|problem| match problem {
            DataProblem::Unreadable(error) => error,
            other => io::Error::other(other),
        })?;
        blocks.flush()
    }
}

/// A text whose header has been found.
#[derive(Debug)]
pub(super) struct Text<'a> {
    file: PathBuf,
    source: Source<'a>,
    written: encoding::Written,
    sha256: String,
    notes: Vec<String>,
    separator: u8,
    header_line: usize,
    headings: Vec<Heading>,
    header: Vec<String>,
    /// Bytes and lines before the first row.
    before: (usize, usize),
}

impl<'a> Text<'a> {
    /// Looks through a text, and finds its header.
    pub fn of(file: &Path, source: Source<'a>) -> Result<Self, DataError> {
        let refuse = |problem| Place::file(file).error(problem);
        let mut hash = Sha256::new();
        let written = encoding::of(source.open(0), |bytes| hash.update(bytes)).map_err(refuse)?;
        let mut pieces = Pieces::of(source.open(written.mark), written.encoding);
        pieces.advance().map_err(|error| refuse(DataProblem::Unreadable(error)))?;
        let begin = pieces.text();
        let Layout { separator, header_line, headings, header, rows, notes } =
            Layout::of(begin).map_err(|problem| match problem {
                DataProblem::NoHeader { .. } => Place { line: Some(1), ..Place::file(file) }.error(problem),
                other => refuse(other),
            })?;
        let (left, lines) = rows.position();
        let before = (begin.len() - left, lines);
        let notes = written.note.map(str::to_owned).into_iter().chain(notes).collect();
        drop(pieces);
        let (file, sha256) = (file.to_owned(), hexadecimal(&hash.finalize()));
        Ok(Self { file, source, written, sha256, notes, separator, header_line, headings, header, before })
    }

    /// The table.
    pub fn table<S: Store>(&self) -> Result<Table<S>, DataError> {
        let mut table = Table {
            file: self.file.clone(),
            sha256: self.sha256.clone(),
            notes: self.notes.clone(),
            header_line: Some(self.header_line),
            columns: self.headings.iter().map(|heading| self.column(heading.clone())).collect(),
            rows: 0,
            jumps: Vec::new(),
        };
        let mut filler =
            Filler { table: &mut table, header: &self.header, repeated: 0, wide: None, whole: None, cut: 0 };
        self.rows(&mut filler).map_err(|problem| Place::file(&self.file).error(problem))?;
        filler.finish()?;
        Ok(table)
    }

    fn column<S: Store>(&self, heading: Heading) -> Column<S> {
        Column::new(heading, self.separator != b',')
    }

    /// Gives every row to `taker`, as long as that takes any.
    fn rows(&self, taker: &mut impl Taker) -> Result<(), DataProblem> {
        let mut pieces = Pieces::of(self.source.open(self.written.mark), self.written.encoding);
        pieces.advance().map_err(DataProblem::Unreadable)?;
        let mut lines = Stream::of(pieces, self.before.0, self.before.1);
        if self.separator == b' ' {
            while let Some(line) = lines.next_line().map_err(DataProblem::Unreadable)? {
                let fields = line.text.split_whitespace();
                if !taker.take(line.number, fields).map_err(DataProblem::Unreadable)? {
                    break;
                }
            }
            return Ok(());
        }
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(self.separator)
            .from_reader(lines);
        let mut record = csv::StringRecord::new();
        while reader.read_record(&mut record).map_err(unreadable)? {
            let place = record.position().map_or(1, csv::Position::line) as usize - 1;
            let line = reader.get_ref().number(place);
            if !taker.take(line, record.iter().map(str::trim)).map_err(DataProblem::Unreadable)? {
                break;
            }
        }
        Ok(())
    }
}

fn unreadable(error: csv::Error) -> DataProblem {
    if error.is_io_error() { DataProblem::Unreadable(error.into()) } else { DataProblem::Csv(error) }
}

/// Takes rows.
trait Taker {
    /// The fields of a row, and the line that it stands in; `false` if no other is wanted.
    fn take<'f>(&mut self, line: usize, fields: impl Iterator<Item = &'f str> + Clone) -> io::Result<bool>;
}

/// Whether the fields of a row are those of the header.
fn is_header<'f>(header: &[String], fields: impl Iterator<Item = &'f str>) -> bool {
    fields.eq(header.iter().map(String::as_str))
}

/// Gives blocks of rows away.
struct Blocks<'a, 's> {
    header: &'a [String],
    columns: Vec<Column>,
    /// The columns that are wanted.
    wanted: &'a [usize],
    most: usize,
    /// Rows in the block.
    count: usize,
    /// Rows of the table that have not come yet.
    left: usize,
    sink: &'a mut Sink<'s>,
}

impl Taker for Blocks<'_, '_> {
    fn take<'f>(&mut self, _: usize, fields: impl Iterator<Item = &'f str> + Clone) -> io::Result<bool> {
        if is_header(self.header, fields.clone()) {
            return Ok(true);
        }
        if self.left == 0 {
            return Ok(false);
        }
        for (place, field) in fields.enumerate().filter(|(place, _)| self.wanted.contains(place)) {
            if let Some(column) = self.columns.get_mut(place) {
                column.push(self.count, field);
            }
        }
        (self.left, self.count) = (self.left - 1, self.count + 1);
        if self.count == self.most {
            self.flush()?;
        }
        Ok(true)
    }
}

impl Blocks<'_, '_> {
    fn flush(&mut self) -> io::Result<()> {
        if self.count == 0 {
            return Ok(());
        }
        let block: Vec<&[f64]> = self.wanted.iter().map(|&index| self.columns[index].numbers()).collect();
        if block.iter().any(|numbers| numbers.len() != self.count) {
            return Err(changed());
        }
        (self.sink)(&block)?;
        self.columns.iter_mut().for_each(Column::clear);
        self.count = 0;
        Ok(())
    }
}

/// A row with more fields than the header.
#[derive(Clone, Copy, Debug)]
struct Wide {
    row: usize,
    fields: usize,
}

/// Puts rows into a table.
struct Filler<'a, S> {
    table: &'a mut Table<S>,
    header: &'a [String],
    /// How often the header came again.
    repeated: usize,
    /// The first row with more numbers than the header has names.
    wide: Option<Wide>,
    /// The last row with as many fields as the first one, and how many those are.
    whole: Option<(usize, usize)>,
    /// Rows since then that begin with a number.
    cut: usize,
}

impl<S: Store> Taker for Filler<'_, S> {
    fn take<'f>(&mut self, line: usize, fields: impl Iterator<Item = &'f str> + Clone) -> io::Result<bool> {
        let table = &mut *self.table;
        if is_header(self.header, fields.clone()) {
            self.repeated += 1;
            return Ok(true);
        }
        let row = table.rows;
        if number(&table.jumps, row) != line {
            table.jumps.push((row, line));
        }
        table.rows += 1;
        let (mut found, mut has_more, mut begins_with_number) = (0, false, false);
        for (place, field) in fields.enumerate() {
            found = place + 1;
            begins_with_number |= place == 0 && Cell::of(field, true).is_number();
            match table.columns.get_mut(place) {
                Some(column) => column.push(row, field),
                None => has_more |= Cell::of(field, true).is_number(),
            }
        }
        let expected = table.columns.len();
        for column in table.columns.iter_mut().skip(found) {
            column.push_missing(row, found, expected);
        }
        if has_more {
            self.wide.get_or_insert(Wide { row, fields: found });
        }
        let width = self.whole.map_or(found, |(_, width)| width);
        if width <= found && found <= expected.max(width) + 1 && !has_more {
            (self.whole, self.cut) = (Some((row, width)), 0);
        } else {
            self.cut += usize::from(begins_with_number);
        }
        Ok(true)
    }
}

impl<S: Store> Filler<'_, S> {
    fn finish(self) -> Result<(), DataError> {
        let Self { table, repeated, wide, whole, cut, .. } = self;
        let ends = whole.map_or(table.rows, |(row, _)| row + 1);
        // At the end of a file a row may be cut off, and lines that are no rows may follow.
        if ends < table.rows && cut <= 1 && wide.is_none() {
            let (first, left) = (number(&table.jumps, ends), table.rows - ends);
            table
                .notes
                .push(format!("{left} incomplete lines at the end, from line {first} on, were left out"));
            table.columns.iter_mut().for_each(|column| column.truncate(ends));
            table.rows = ends;
        }
        if repeated > 0 {
            table.notes.push(format!("the header came again {repeated} times and was skipped"));
        }
        if let Some(Wide { row, fields: found }) = wide {
            let expected = table.columns.len();
            let place = Place { line: Some(number(&table.jumps, row)), ..Place::file(&table.file) };
            return Err(place.error(match found > expected + 1 && found <= 2 * expected {
                true => DataProblem::SplitNumbers { found, expected },
                false => DataProblem::Ragged { found, expected },
            }));
        }
        match table.rows {
            0 => Err(Place::file(&table.file).error(DataProblem::NoRows)),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn reopened(file: &tempfile::NamedTempFile) -> Arc<File> {
        file.reopen().expect("it is there").into()
    }

    #[test]
    fn blocks_have_the_numbers_of_the_whole_table() {
        for text in [
            "time_s,pressure_bar\n0,1\n1,nan\n2,3\n3,4\n4,5\n",
            "# a\nTime (s);Pressure (kPa)\n0,0;1,5\n\n0,1;\nTime (s);Pressure (kPa)\n0,2;3,5\n0,3;4,5\n",
            "time,pressure_bar\n2024-05-01 12:00:00,1\n2024-05-01 12:00:01,2\n2024-05-01 12:00:02.5,3\n",
            "time_s,pressure_bar,note\n0,1,\"a\nb\"\n1,2,c\n2,3,d\n3,4\n",
            "t p\ns bar\n0 1\n1 2\n2 3\n",
        ] {
            let file = tempfile::NamedTempFile::new().expect("a file");
            fs::write(file.path(), text).expect("it is written");
            let whole = Table::parse(file.path(), text.as_bytes()).expect("a table");
            let outline = Outline::of(file.path(), reopened(&file)).expect("a table");
            assert_eq!(
                (outline.table.rows(), outline.table.notes()),
                (whole.rows(), whole.notes()),
                "{text}"
            );
            for most in 1..=whole.rows() {
                let mut found = [Vec::new(), Vec::new()];
                let mut sink = |columns: &[&[f64]]| {
                    assert!(columns[0].len() <= most);
                    found.iter_mut().zip(columns).for_each(|(all, some)| all.extend_from_slice(some));
                    Ok(())
                };
                outline.blocks(&[1, 0], most, &mut sink).expect("as before");
                for (found, place) in found.iter().zip([1, 0]) {
                    let expected = whole.numbers(place).expect("numbers").numbers;
                    let bits = |numbers: &[f64]| numbers.iter().map(|it| it.to_bits()).collect::<Vec<_>>();
                    assert_eq!(bits(found), bits(expected), "{text} in blocks of {most}");
                }
            }
        }
    }

    /// Two columns of five rows.
    #[derive(Debug)]
    struct Two([[f64; 5]; 2]);

    impl Numbers for Two {
        fn blocks(&self, columns: &[usize], most: usize, sink: &mut Sink) -> io::Result<()> {
            (0..5).step_by(most.min(2)).try_for_each(|first| {
                let last = 5.min(first + most.min(2));
                sink(&columns.iter().map(|&column| &self.0[column][first..last]).collect::<Vec<_>>())
            })
        }
    }

    #[test]
    fn columns_of_numbers_are_a_table_that_tells_the_row_of_what_is_infinite() {
        let outline = |values: [f64; 5]| {
            let names = ["time_s", "pressure_bar"].map(str::to_owned);
            let numbers = Box::new(Two([[0.0, 1.0, 2.0, 3.0, 4.0], values]));
            Outline::of_numbers("x.npy".as_ref(), &names, numbers).expect("in memory").expect("a table")
        };
        let sound = outline([1.0, f64::NAN, 3.0, 4.0, 5.0]).table;
        assert_eq!((sound.rows(), sound.are_stamps(1).expect("numbers")), (5, false));
        let table = outline([1.0, f64::NAN, 3.0, f64::NEG_INFINITY, f64::INFINITY]).table;
        let error = table.are_stamps(1).expect_err("refused").to_string();
        assert_eq!(error, "x.npy, row 3, column pressure_bar: `-inf` is not finite");
        assert!(table.are_stamps(0).is_ok());
    }

    #[test]
    fn a_file_that_grows_is_what_it_was_and_one_that_changes_is_told() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        let text = "time_s,pressure_bar\n0,1\n1,2\n";
        fs::write(file.path(), text).expect("it is written");
        let outline = Outline::of(file.path(), reopened(&file)).expect("a table");
        let rows = || {
            let mut rows = 0;
            let mut sink = |columns: &[&[f64]]| {
                rows += columns[0].len();
                Ok(())
            };
            outline.blocks(&[0], 9, &mut sink).map(|()| rows)
        };
        fs::write(file.path(), format!("{text}2,3\n")).expect("it is written");
        assert_eq!(rows().expect("what it was"), 2);
        for other in ["time_s,pressure_bar\n0,1\n", "time_s,pressure_bar\nx,1\n1,2\n"] {
            fs::write(file.path(), other).expect("it is written");
            assert!(rows().is_err(), "{other}");
        }
    }
}
