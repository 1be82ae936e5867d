//! `mgpi import`: a recording out of a file of another program.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;

use crate::Error;
use crate::output::Outputs;
use crate::parquet::{self, is_parquet};
use import::{Imported, Options, Values, read};
use recording::numbers::{legible, median, range};
use recording::table::naming::{Naming, Renamed};
use recording::table::{Table, VALID};
use recording::unit::Unit;

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
    let options = Options { sheet: sheet.as_deref(), columns: map, clock: clock.as_deref() };
    let Imported { mut table, left_out, notes } = read(file, &options)?;
    notes.iter().for_each(|note| say!("{note}"));
    for (name, count) in &left_out {
        if let Some(wanted) = map.iter().find(|wanted| wanted.column == *name) {
            return Err(Error::Usage(format!(
                "{}: {name}, which is to be {}, has {count} values, the others {}",
                file.display(),
                wanted.name,
                table.rows()
            )));
        }
    }
    table.name(&Naming { columns: map.clone(), ..Naming::default() })?;
    let Some(output) = output else {
        list(&table);
        for (name, count) in &left_out {
            say!("{name:<24}{count} values, of another length than the others");
        }
        return Ok(());
    };
    let columns = written(&table)?;
    if is_parquet(output) {
        let columns: Vec<(&str, Values)> =
            columns.iter().map(|(name, values)| (name.as_str(), Values::Numbers(values))).collect();
        parquet::stage(&mut outputs, output, &columns)?;
    } else {
        outputs.stage_by(output, |target| csv(target, &columns, table.rows()))?;
    }
    outputs.commit()?;
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    say!("{} rows of {} in {}", table.rows(), names.join(", "), output.display());
    Ok(())
}

/// What the file has: a line a column.
fn list(table: &Table) {
    for index in 0..table.columns() {
        let unit = match table.unit_of(index) {
            Ok(Some(unit)) => unit.to_string(),
            Ok(None) => "no unit in its name".to_owned(),
            Err(error) => error.problem.to_string(),
        };
        let words = match table.numbers(index) {
            Ok(values) => of_values(values.numbers),
            Err(error) => error.problem.to_string(),
        };
        say!("{:<24}{words}; {unit}", table.shown(index));
    }
    say!("{} rows; -o REC.csv writes a recording, --map says which variable is which", table.rows());
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

/// The columns that are written: those that are mapped, and those of a known unit; a name each.
fn written(table: &Table) -> Result<Vec<(String, &[f64])>, Error> {
    let mut columns = Vec::new();
    for index in 0..table.columns() {
        let (name, is_named) = (table.our_name(index), table.is_named(index));
        let has_unit = is_named || table.unit_of(index).is_ok_and(|unit| unit.is_some());
        if !has_unit && name != VALID && !table.time_column().is_ok_and(|time| time == index) {
            continue;
        }
        let values = table.numbers(index)?;
        // Dates and times of day are counted from the first one.
        let name = if values.are_stamps { format!("time_{}", Unit::S.suffix()) } else { name };
        columns.push((name, values.numbers));
    }
    Ok(columns)
}

/// Numbers so that they read back as the same bits; a missing one is an empty field.
fn csv(target: &mut dyn Write, columns: &[(String, &[f64])], rows: usize) -> io::Result<()> {
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    writeln!(target, "{}", names.join(","))?;
    for row in 0..rows {
        for (place, (_, values)) in columns.iter().enumerate() {
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
