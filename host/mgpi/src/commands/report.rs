//! `mgpi report`: the paper's figures from a recording, its model and the log of a tracking run.

use std::path::PathBuf;

use clap::Args;

use super::reading::RecordingReading;
use crate::Error;
use crate::output::Outputs;
use identification;
use recording::Recording;
use recording::model_file::ModelFile;
use recording::table::Table;
use report::paper_figures;
use report::tracking::Tracking;

/// Redraws Figs. 8, 11, 12 and 13 of the paper from own measurements.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The model, from `mgpi identify`
    #[arg(long, value_name = "MODEL.toml")]
    model: PathBuf,
    /// The recording that the model is shown beside
    #[arg(long, value_name = "REC.csv")]
    recording: PathBuf,
    /// The log of a tracking run, from `mgpi pil`
    #[arg(long, value_name = "LOG.csv")]
    log: PathBuf,
    /// Where the report goes
    #[arg(short, long, value_name = "REPORT.html")]
    output: PathBuf,
    #[command(flatten)]
    reading: RecordingReading,
    /// Overwrite an existing report
    #[arg(long)]
    force: bool,
}

/// Draws the report.
///
/// # Errors
/// A file is not what it should be, or the report cannot be drawn or written.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let mut outputs = Outputs::claim(
        [&arguments.output],
        &[&arguments.model, &arguments.recording, &arguments.log],
        arguments.force,
    )?;
    let model = ModelFile::read(&arguments.model)?;
    let choice = arguments.reading.choice().like(&model.input, &model.output);
    let recording = Recording::read(&arguments.recording, &choice)?;
    recording.drive.announce();
    let log = Table::read(&arguments.log)?;
    let tracking = Tracking::of_log(&log)?;
    let simulated = identification::simulate(&model.model, &recording.drive.input.values);
    let source = format!(
        "Recording {} with SHA-256 {}, log {} with SHA-256 {}",
        arguments.recording.display(),
        recording.drive.sha256,
        arguments.log.display(),
        log.sha256()
    );
    let report = paper_figures::to_html(&recording, &simulated, &tracking, &source);
    outputs.stage(&arguments.output, report.as_bytes())?;
    outputs.commit()?;
    Ok(())
}
