//! `mgpi diagnose`: what a simulation gets wrong about a recording, and why.

use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use super::search::Columns;
use super::{diagnosed_summary, recorded};
use crate::Error;
use crate::output::Outputs;
use diagnosis::diagnosed::{Examined, NotDiagnosed};
use diagnosis::extend::Operator;
use diagnosis::json::to_json;
use recording::Choice;
use recording::model_file::ModelFile;
use report::diagnosed;

/// Shows what a simulation gets wrong about a recording, and names the cause.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The recording, or several of one muscle, between which it is let down and left at rest;
    /// load_n, temperature_c and, beside pressure_bar, command_bar are used where they are there
    #[arg(value_name = "REC.csv", required = true)]
    recordings: Vec<PathBuf>,
    /// Also write the model, extended by the named causes where that is better, for simulate, pil
    /// and the board
    #[arg(short = 'o', value_name = "EXTENDED.toml")]
    model_file: Option<PathBuf>,
    /// An operator model to begin with; one of too poor a form, or of another muscle, is said to be
    /// that
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    /// Another recording of the same muscle that the gain is counted on [default: the last third of
    /// the rows]
    #[arg(long, value_name = "REC2.csv")]
    validate: Option<PathBuf>,
    /// Also write a page that shows it: one HTML file
    #[arg(long, value_name = "REPORT.html")]
    report: Option<PathBuf>,
    /// Also write the diagnosis as JSON
    #[arg(long, value_name = "DIAGNOSIS.json")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
    /// Overwrite existing outputs
    #[arg(long)]
    force: bool,
}

/// Diagnoses.
///
/// # Errors
/// The recording is not what it should be or too short, or an output cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { recordings: files, model_file, model, validate, report, json, .. } = arguments;
    let inputs: Vec<&Path> = files.iter().chain(validate).chain(model).map(PathBuf::as_path).collect();
    let mut outputs = Outputs::claim(model_file.iter().chain(report).chain(json), &inputs, arguments.force)?;
    let given = model.as_ref().map(|model| ModelFile::read(model)).transpose()?;
    let choice = match &given {
        Some(given) => arguments.columns.choice().like(&given.input, &given.output),
        None => arguments.columns.choice(),
    };
    let examined = read_all(files, &choice, &arguments.columns)?;
    let given = given.map(|file| Operator { parameters: file.parameters, density: file.density });
    let choice = arguments.columns.choice_of(&examined.recording);
    let other = validate.as_ref().map(|file| read(file, &choice)).transpose()?;
    let name = examined.recording.drive.file.clone();
    let found = with_bar(|progress| examined.diagnosed(given.as_ref(), other, progress));
    let found = found.map_err(|error| match error {
        NotDiagnosed::Diagnosis(source) => Error::Diagnosis { file: name.clone(), source },
        NotDiagnosed::NotSimulated(file) => Error::NotSimulated(file),
    })?;
    if let Some(model_file) = model_file {
        let mut file = found.model()?;
        file.recorded = recorded::of_columns(&file, &found.examined.columns);
        outputs.stage(model_file, file.to_toml().as_bytes())?;
    }
    if let Some(report) = report {
        outputs.stage(report, diagnosed::to_html(&found).as_bytes())?;
    }
    if let Some(json) = json {
        outputs.stage(json, format!("{:#}\n", to_json(&found)).as_bytes())?;
    }
    outputs.commit()?;
    diagnosed_summary::print((&name, model_file.as_deref()), &found);
    Ok(())
}

/// The columns of a recording that a diagnosis looks at; what was done to read it is said.
///
/// # Errors
/// The recording is not what it should be.
pub fn read(file: &Path, choice: &Choice) -> Result<Examined, Error> {
    let examined = Examined::of(&choice.table(file)?, choice)?;
    examined.recording.drive.announce();
    Ok(examined)
}

/// Several recordings as one; the columns of the others are those of the first.
fn read_all(files: &[PathBuf], choice: &Choice, columns: &Columns) -> Result<Examined, Error> {
    let mut parts: Vec<Examined> = Vec::new();
    for file in files {
        let part = match parts.first() {
            None => read(file, choice)?,
            Some(first) => read(file, &columns.choice_of(&first.recording))?,
        };
        parts.push(part);
    }
    Ok(Examined::joined(parts)?)
}

/// Works with a bar that shows how far it is, and with what.
fn with_bar<T>(work: impl FnOnce(&(dyn Fn(f64, &str) + Sync)) -> T) -> T {
    const PARTS: f64 = 1000.0;
    let style = ProgressStyle::with_template("diagnosing {wide_bar} {percent} % {msg}");
    let bar =
        ProgressBar::new(PARTS as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let result = work(&|share, what| {
        bar.set_position((PARTS * share) as u64);
        bar.set_message(what.to_owned());
    });
    bar.finish_and_clear();
    result
}
