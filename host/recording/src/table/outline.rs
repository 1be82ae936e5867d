//! A text as a table, in two passes: what its columns are, and their numbers, which need not be
//! held together.

use std::io;
use std::path::Path;

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

/// What a file's columns are, without their numbers: for files of any size.
///
/// ```
/// use recording::table::outline::Outline;
///
/// # let folder = tempfile::tempdir()?;
/// # let file = &folder.path().join("rec.csv");
/// std::fs::write(file, "time_s,pressure_bar\n0.0,1.0\n0.1,1.5\n0.2,2.0\n")?;
/// let outline = Outline::of(file)?.expect("a file, no pipe");
/// assert_eq!(outline.table.rows(), 3);
/// let mut sum = 0.0;
/// outline.blocks(&[1], 2, |columns| {
///     sum += columns[0].iter().sum::<f64>();
///     Ok(())
/// })?;
/// assert_eq!(sum, 4.5);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Outline<'a> {
    /// The table, whose columns have no numbers.
    pub table: Table<Unkept>,
    text: Text<'a>,
}

impl<'a> Outline<'a> {
    /// The outline of a file; `None` of what can be read once only.
    ///
    /// # Errors
    /// The file cannot be read, or is no table.
    pub fn of(file: &'a Path) -> Result<Option<Self>, DataError> {
        let refuse = |error| Place::file(file).error(DataProblem::Unreadable(error));
        match Source::of_file(file).map_err(refuse)? {
            Some(source) => {
                let text = Text::of(file, source)?;
                Ok(Some(Self { table: text.table()?, text }))
            }
            None => Ok(None),
        }
    }

    /// Reads columns again, so many rows at a time at most, and gives their numbers to `sink`.
    ///
    /// # Errors
    /// What `sink` says; the file cannot be read, or is not what it was.
    pub fn blocks(
        &self,
        columns: &[usize],
        most: usize,
        sink: impl FnMut(&[&[f64]]) -> io::Result<()>,
    ) -> io::Result<()> {
        let headings = self.table.columns.iter().map(|column| column.heading.clone());
        let mut blocks = Blocks {
            header: &self.text.header,
            columns: headings.map(|heading| self.text.column(heading)).collect(),
            wanted: columns,
            most,
            count: 0,
            left: self.table.rows(),
            sink,
        };
        self.text.rows(&mut blocks).map_err(|problem| match problem {
            DataProblem::Unreadable(error) => error,
            other => io::Error::other(other),
        })?;
        if blocks.left > 0 {
            return Err(changed());
        }
        blocks.flush()
    }
}

fn changed() -> io::Error {
    io::Error::other("the file has changed while it was read")
}

/// A text whose header has been found.
#[derive(Debug)]
pub(super) struct Text<'a> {
    file: &'a Path,
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
    pub fn of(file: &'a Path, source: Source<'a>) -> Result<Self, DataError> {
        let refuse = |problem| Place::file(file).error(problem);
        let open = |skipped| source.open(skipped).map_err(|error| refuse(DataProblem::Unreadable(error)));
        let mut hash = Sha256::new();
        let written = encoding::of(open(0)?, |bytes| hash.update(bytes)).map_err(refuse)?;
        let mut pieces = Pieces::of(open(written.mark)?, written.encoding);
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
        let sha256 = hexadecimal(&hash.finalize());
        Ok(Self { file, source, written, sha256, notes, separator, header_line, headings, header, before })
    }

    /// The table.
    pub fn table<S: Store>(&self) -> Result<Table<S>, DataError> {
        let mut table = Table {
            file: self.file.to_owned(),
            sha256: self.sha256.clone(),
            notes: self.notes.clone(),
            header_line: Some(self.header_line),
            columns: self.headings.iter().map(|heading| self.column(heading.clone())).collect(),
            rows: 0,
            jumps: Vec::new(),
        };
        let mut filler =
            Filler { table: &mut table, header: &self.header, repeated: 0, wide: None, whole: None, cut: 0 };
        self.rows(&mut filler).map_err(|problem| Place::file(self.file).error(problem))?;
        filler.finish()?;
        Ok(table)
    }

    fn column<S: Store>(&self, heading: Heading) -> Column<S> {
        Column::new(heading, self.separator != b',')
    }

    /// Gives every row to `taker`, as long as that takes any.
    fn rows(&self, taker: &mut impl Taker) -> Result<(), DataProblem> {
        let bytes = self.source.open(self.written.mark).map_err(DataProblem::Unreadable)?;
        let mut pieces = Pieces::of(bytes, self.written.encoding);
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
struct Blocks<'a, F> {
    header: &'a [String],
    columns: Vec<Column>,
    /// The columns that are wanted.
    wanted: &'a [usize],
    most: usize,
    /// Rows in the block.
    count: usize,
    /// Rows of the table that have not come yet.
    left: usize,
    sink: F,
}

impl<F: FnMut(&[&[f64]]) -> io::Result<()>> Taker for Blocks<'_, F> {
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

impl<F: FnMut(&[&[f64]]) -> io::Result<()>> Blocks<'_, F> {
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
            let outline = Outline::of(file.path()).expect("a table").expect("a file");
            assert_eq!(
                (outline.table.rows(), outline.table.notes()),
                (whole.rows(), whole.notes()),
                "{text}"
            );
            assert_eq!(outline.table.sha256(), whole.sha256());
            for most in 1..=whole.rows() {
                let mut found = [Vec::new(), Vec::new()];
                let sink = |columns: &[&[f64]]| {
                    assert!(columns[0].len() <= most);
                    found.iter_mut().zip(columns).for_each(|(all, some)| all.extend_from_slice(some));
                    Ok(())
                };
                outline.blocks(&[1, 0], most, sink).expect("as before");
                for (found, place) in found.iter().zip([1, 0]) {
                    let expected = whole.numbers(place).expect("numbers").numbers;
                    let bits = |numbers: &[f64]| numbers.iter().map(|it| it.to_bits()).collect::<Vec<_>>();
                    assert_eq!(bits(found), bits(expected), "{text} in blocks of {most}");
                }
            }
        }
    }

    #[test]
    fn a_file_that_grows_is_what_it_was_and_one_that_changes_is_told() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        let text = "time_s,pressure_bar\n0,1\n1,2\n";
        fs::write(file.path(), text).expect("it is written");
        let outline = Outline::of(file.path()).expect("a table").expect("a file");
        let rows = || {
            let mut rows = 0;
            let sink = |columns: &[&[f64]]| {
                rows += columns[0].len();
                Ok(())
            };
            outline.blocks(&[0], 9, sink).map(|()| rows)
        };
        fs::write(file.path(), format!("{text}2,3\n")).expect("it is written");
        assert_eq!(rows().expect("what it was"), 2);
        for other in ["time_s,pressure_bar\n0,1\n", "time_s,pressure_bar\nx,1\n1,2\n"] {
            fs::write(file.path(), other).expect("it is written");
            assert!(rows().is_err(), "{other}");
        }
    }
}
