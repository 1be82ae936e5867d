//! Variables of a file as columns of a table, none of whose numbers are held.

use std::fmt;
use std::io;

use recording::table::outline::{Numbers, Sink};

use super::Problem;

/// A variable of a file: columns of one length.
pub trait Variable: fmt::Debug {
    /// What it is listed as where it is no part of the table, and counted.
    fn entries(&self) -> Vec<String>;

    /// Its columns.
    ///
    /// # Errors
    /// It has no columns of this length.
    fn columns(&self) -> Result<Vec<String>, Problem> {
        Ok(self.entries())
    }

    /// How many numbers a column has.
    fn rows(&self) -> usize;

    /// Reads some of its columns from the first row on.
    ///
    /// # Errors
    /// It cannot be read.
    fn reader(&self, columns: &[usize]) -> Result<Box<dyn Reader + '_>, Problem>;
}

/// Where the reading of some columns has come to.
pub trait Reader {
    /// Adds so many rows more to each column; there are as many.
    ///
    /// # Errors
    /// The file ends before, or is damaged.
    fn read(&mut self, rows: usize, columns: &mut [Vec<f64>]) -> Result<(), Problem>;
}

/// What a file holds: variables of one length.
#[derive(Debug)]
pub struct Found {
    pub variables: Vec<Box<dyn Variable>>,
    /// Variables that are no part of the table, each with how many values it has.
    pub left_out: Vec<(String, usize)>,
    /// What was done to make it one, in words.
    pub notes: Vec<String>,
}

/// Variables of one length, as a table.
#[derive(Debug)]
pub struct Variables {
    /// Each with its place among the columns.
    all: Vec<(Box<dyn Variable>, usize)>,
    rows: usize,
}

/// The variables that have as many values as most have, of equally many lengths the larger; and the
/// others, which are not read, each with how many it has.
pub fn of_one_length(found: Vec<Box<dyn Variable>>) -> Found {
    let count = |length: usize| -> usize {
        found.iter().filter(|one| one.rows() == length).map(|one| one.entries().len()).sum()
    };
    let length = found.iter().map(|one| one.rows()).max_by_key(|&length| (count(length), length));
    let (mut variables, mut left_out) = (Vec::new(), Vec::new());
    for one in found {
        match Some(one.rows()) == length {
            true => variables.push(one),
            false => left_out.extend(one.entries().into_iter().map(|entry| (entry, one.rows()))),
        }
    }
    Found { variables, left_out, notes: Vec::new() }
}

impl Variables {
    /// Variables of one length, and the names of their columns.
    ///
    /// # Errors
    /// There is no variable, or not all have the same number of rows.
    pub fn of(these: Vec<Box<dyn Variable>>) -> Result<(Self, Vec<String>), Problem> {
        let rows = these.first().ok_or(Problem::Nothing)?.rows();
        let (mut all, mut names) = (Vec::new(), Vec::new());
        for one in these {
            let first = names.len();
            names.extend(one.columns()?);
            all.push((one, first));
        }
        if names.is_empty() {
            return Err(Problem::Nothing);
        }
        Ok((Self { all, rows }, names))
    }

    fn read(&self, wanted: &[usize], most: usize, sink: &mut Sink) -> Result<(), Problem> {
        // Of each variable with such columns: those, and where they stand among the wanted ones.
        let mut readers = Vec::new();
        for (place, (one, first)) in self.all.iter().enumerate() {
            let last = self.all.get(place + 1).map_or(usize::MAX, |(_, next)| *next);
            let these = wanted.iter().enumerate().filter(|(_, column)| (*first..last).contains(*column));
            let (targets, columns): (Vec<usize>, Vec<usize>) =
                these.map(|(target, column)| (target, column - first)).unzip();
            if !columns.is_empty() {
                let values = vec![Vec::new(); columns.len()];
                readers.push((one.reader(&columns)?, targets, values));
            }
        }
        for first in (0..self.rows).step_by(most.max(1)) {
            let rows = most.min(self.rows - first);
            for (reader, _, values) in &mut readers {
                values.iter_mut().for_each(Vec::clear);
                reader.read(rows, values)?;
            }
            let mut block: Vec<&[f64]> = vec![&[]; wanted.len()];
            for (_, targets, values) in &readers {
                targets.iter().zip(values).for_each(|(&target, values)| block[target] = values);
            }
            sink(&block)?;
        }
        Ok(())
    }
}

impl Numbers for Variables {
    fn blocks(&self, columns: &[usize], most: usize, sink: &mut Sink) -> io::Result<()> {
        self.read(columns, most, sink).map_err(|problem| match problem {
            Problem::Unreadable(error) => error,
            other => io::Error::other(other),
        })
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// The columns of variables, read so many rows at a time.
    pub fn read(variables: Vec<Box<dyn Variable>>, most: usize) -> Result<Vec<(String, Vec<f64>)>, Problem> {
        let (variables, names) = Variables::of(variables)?;
        let mut found: Vec<(String, Vec<f64>)> = names.into_iter().map(|name| (name, Vec::new())).collect();
        let all: Vec<usize> = (0..found.len()).collect();
        variables.read(&all, most, &mut |block| {
            found.iter_mut().zip(block).for_each(|((_, values), more)| values.extend_from_slice(more));
            Ok(())
        })?;
        Ok(found)
    }

    #[derive(Debug)]
    struct Constant(&'static str, usize);

    impl Variable for Constant {
        fn entries(&self) -> Vec<String> {
            vec![self.0.to_owned()]
        }

        fn rows(&self) -> usize {
            self.1
        }

        fn reader(&self, _: &[usize]) -> Result<Box<dyn Reader + '_>, Problem> {
            unreachable!("nothing is read")
        }
    }

    #[test]
    fn variables_of_another_length_are_listed() {
        let named = |name, count| Box::new(Constant(name, count)) as Box<dyn Variable>;
        let Found { variables: these, left_out: others, .. } =
            of_one_length(vec![named("rate", 1), named("t", 5), named("p", 5), named("note", 2)]);
        let names: Vec<String> = these.iter().flat_map(|one| one.entries()).collect();
        assert_eq!(names, ["t", "p"]);
        assert_eq!(others, [("rate".to_owned(), 1), ("note".to_owned(), 2)]);
    }
}
