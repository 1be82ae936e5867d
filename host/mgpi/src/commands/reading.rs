//! The options of every command that reads a recording or a reference: which column is which, in
//! what unit.

use clap::Args;

use recording::Choice;
use recording::left_out::LeftOut;
use recording::table::naming::{Naming, Renamed, UnitOf};

/// What is said of a file's columns.
#[derive(Args, Debug)]
pub struct Reading {
    /// Column of the times [default: time_s]
    #[arg(long, value_name = "COLUMN")]
    time: Option<String>,
    /// Columns of the file under our names, with the unit if its own name does not say:
    /// time=t:ms,pressure=p:psi
    #[arg(long, value_name = "NAME=COLUMN,…", value_delimiter = ',')]
    columns: Vec<Renamed>,
    /// Units of columns: time=ms,contraction=nm
    #[arg(long, value_name = "COLUMN=UNIT,…", value_delimiter = ',')]
    units: Vec<UnitOf>,
    /// Refuse a file that has to be mended, or a column that is none of ours
    #[arg(long)]
    strict: bool,
}

impl Reading {
    /// The choice that says this, and leaves the rest open.
    pub fn choice(&self) -> Choice {
        Choice {
            naming: Naming {
                time: self.time.clone(),
                columns: self.columns.clone(),
                units: self.units.clone(),
                known: Vec::new(),
            },
            is_strict: self.strict,
            ..Choice::default()
        }
    }
}

/// What is said of the columns of a recording, whose muscle has a length at rest.
#[derive(Args, Debug)]
pub struct RecordingReading {
    /// The muscle's length at rest in mm, if the recording has length_mm
    #[arg(long, value_name = "MM")]
    rest_length: Option<f64>,
    #[command(flatten)]
    reading: Reading,
}

impl RecordingReading {
    /// The choice that says this, and leaves the rest open.
    pub fn choice(&self) -> Choice {
        Choice { rest_length_mm: self.rest_length, ..self.reading.choice() }
    }
}

/// Says which rows are not scored, a line each, under names of a column's width.
pub fn say_left_out(left_out: &LeftOut) {
    for words in left_out.in_words() {
        say!("not scored    {words}");
    }
}
