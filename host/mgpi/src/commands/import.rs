//! `mgpi import`: a recording out of a file of another program.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;

use crate::Error;
use crate::output::{Outputs, directory};
use crate::parquet::{is_parquet, write_blocks};
use import::{Imported, Options, read};
use recording::input::is_standard;
use recording::numbers::{legible, median, range};
use recording::table::naming::{Naming, Renamed};
use recording::table::outline::{Outline, Sink};
use recording::table::{DataProblem, Place, Store, Table, VALID};
use recording::unit::Unit;

/// Rows that are written together: a megabyte of a column.
const BLOCK: usize = 1 << 17;

/// Makes a recording of a file of another program: NumPy (npy, npz), MATLAB (mat), HDF5, Parquet,
/// spreadsheets (xlsx, xls, xlsb, ods), bags of ROS 2 (mcap), text. Without -o it lists what is in
/// the file.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The file; of a bag its folder will do
    file: PathBuf,
    /// Variables of the file under our names, with the unit if their own name does not say:
    /// time=t,pressure=p:psi,contraction=x:in
    #[arg(long, value_name = "NAME=VARIABLE[:UNIT],…", value_delimiter = ',')]
    map: Vec<Renamed>,
    /// Sheet of a spreadsheet [default: the first]
    #[arg(long, value_name = "NAME")]
    sheet: Option<String>,
    /// The topic of a bag whose times the recording has [default: that of the output]
    #[arg(long, value_name = "TOPIC")]
    clock: Option<String>,
    /// Where the recording goes: the mapped variables, and those whose names end in a unit; as
    /// Parquet if it ends in .parquet
    #[arg(short, long, value_name = "REC.csv")]
    output: Option<PathBuf>,
    /// Overwrite an existing output
    #[arg(long)]
    force: bool,
}

/// Imports.
///
/// # Errors
/// The file is not what it should be, lacks a variable, or the output cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { file, map, sheet, clock, output, force } = arguments;
    let mut outputs = Outputs::claim(output, &[file], *force)?;
    let naming = Naming { columns: map.clone(), ..Naming::default() };
    let options = Options {
        sheet: sheet.as_deref(),
        columns: map,
        clock: clock.as_deref(),
        // The output has to have room there, too.
        scratch: output.as_deref().filter(|output| !is_standard(output)).map(directory),
    };
    let Imported { mut outline, left_out, notes } = read(file, &options)?;
    notes.iter().for_each(|note| say!("{note}"));
    for (name, count) in &left_out {
        if let Some(wanted) = map.iter().find(|wanted| wanted.column == *name) {
            return Err(Error::Usage(format!(
                "{}: {name}, which is to be {}, has {count} values, the others {}",
                file.display(),
                wanted.name,
                outline.table.rows()
            )));
        }
    }
    outline.table.name(&naming)?;
    let Some(output) = output else {
        list(&outline)?;
        for (name, count) in &left_out {
            say!("{name:<24}{count} values, of another length than the others");
        }
        return Ok(());
    };
    let columns = written(&outline.table)?;
    columns.stage(&mut outputs, output, |sink| outline.blocks(&columns.places, BLOCK, sink))?;
    outputs.commit()?;
    columns.say(outline.table.rows(), output);
    Ok(())
}

/// What the file has: a line a column.
fn list(outline: &Outline) -> Result<(), Error> {
    let table = &outline.table;
    for index in 0..table.columns() {
        let unit = match table.unit_of(index) {
            Ok(Some(unit)) => unit.to_string(),
            Ok(None) => "no unit in its name".to_owned(),
            Err(error) => error.problem.to_string(),
        };
        let words = match table.are_stamps(index) {
            Ok(_) => of_values(&values(outline, index)?),
            Err(error) => error.problem.to_string(),
        };
        say!("{:<24}{words}; {unit}", table.shown(index));
    }
    say!("{} rows; -o REC.csv writes a recording, --map says which variable is which", table.rows());
    Ok(())
}

/// The numbers of a column: the usual step is the middle one of all.
fn values(outline: &Outline, index: usize) -> Result<Vec<f64>, Error> {
    let mut values = Vec::with_capacity(outline.table.rows());
    let read = outline.blocks(&[index], BLOCK, &mut |columns| {
        columns.iter().for_each(|some| values.extend_from_slice(some));
        Ok(())
    });
    read.map_err(|error| Place::file(outline.table.file()).error(DataProblem::Unreadable(error)))?;
    Ok(values)
}

/// Range and, of what only increases, the usual step.
fn of_values(values: &[f64]) -> String {
    let (low, high) = range(values.iter().filter(|value| !value.is_nan()));
    let missing = values.iter().filter(|value| value.is_nan()).count();
    let holes = if missing > 0 { format!(", {missing} missing") } else { String::new() };
    let mut steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let increases = steps.len() > 1 && steps.iter().all(|step| *step > 0.0);
    let step =
        if increases { format!(", steps of {}", legible(median(&mut steps), 4)) } else { String::new() };
    format!("{} to {}{holes}{step}", legible(low, 4), legible(high, 4))
}

/// The columns that are written, each with its place in the table and its name.
struct Written {
    places: Vec<usize>,
    names: Vec<String>,
}

/// The columns that are written: those that are mapped, and those of a known unit.
fn written<S: Store>(table: &Table<S>) -> Result<Written, Error> {
    let (mut places, mut names) = (Vec::new(), Vec::new());
    for index in 0..table.columns() {
        let (name, is_named) = (table.our_name(index), table.is_named(index));
        let has_unit = is_named || table.unit_of(index).is_ok_and(|unit| unit.is_some());
        if !has_unit && name != VALID && !table.time_column().is_ok_and(|time| time == index) {
            continue;
        }
        // Dates and times of day are counted from the first one.
        let are_stamps = table.are_stamps(index)?;
        places.push(index);
        names.push(if are_stamps { format!("time_{}", Unit::S.suffix()) } else { name });
    }
    if places.is_empty() {
        let shown: Vec<&str> = (0..table.columns()).map(|index| table.shown(index)).collect();
        return Err(Error::Usage(format!(
            "{}: no column has a unit, so that nothing would be written; --map says which is which: --map \
             time={}:s,pressure=…; there are {}",
            table.file().display(),
            shown[0],
            shown.join(", ")
        )));
    }
    Ok(Written { places, names })
}

impl Written {
    /// Stages the output, of which `blocks` gives some rows at a time.
    fn stage(
        &self,
        outputs: &mut Outputs,
        output: &Path,
        blocks: impl FnOnce(&mut Sink) -> io::Result<()>,
    ) -> Result<(), Error> {
        outputs.stage_by(output, |target| match is_parquet(output) {
            true => write_blocks(target, &self.names, blocks),
            false => {
                writeln!(target, "{}", self.names.join(","))?;
                blocks(&mut |columns| csv(target, columns))
            }
        })?;
        Ok(())
    }

    fn say(&self, rows: usize, output: &Path) {
        say!("{rows} rows of {} in {}", self.names.join(", "), output.display());
    }
}

/// Numbers so that they read back as the same bits; a missing one is an empty field.
fn csv(target: &mut dyn Write, columns: &[&[f64]]) -> io::Result<()> {
    for row in 0..columns.first().map_or(0, |numbers| numbers.len()) {
        for (place, values) in columns.iter().enumerate() {
            let separator = if place == 0 { "" } else { "," };
            match values[row] {
                value if value.is_nan() => write!(target, "{separator}")?,
                value => write!(target, "{separator}{value}")?,
            }
        }
        writeln!(target)?;
    }
    Ok(())
}
