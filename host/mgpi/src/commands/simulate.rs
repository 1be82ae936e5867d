//! `mgpi simulate`: a model's answer to the input of a recording.

use std::path::PathBuf;

use clap::Args;

use super::reading::{RecordingReading, say_left_out};
use crate::Error;
use crate::output::Outputs;
use recording::model_file::ModelFile;
use recording::simulation;
use recording::unit::Channel;
use recording::{Drive, Recording, Series, TIME};

/// Simulates a model with its extensions, from rest, with the input of a recording.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The model, from `mgpi identify`
    model: PathBuf,
    /// The recording; the model knows which of its columns to use: its input, load_n and
    /// temperature_c where an extension needs them
    #[arg(long, value_name = "REC.csv")]
    input: PathBuf,
    /// Where the answer goes: time, input, simulated output; if the recording has the output, it
    /// and the error
    #[arg(short, long, value_name = "OUT.csv")]
    output: PathBuf,
    #[command(flatten)]
    reading: RecordingReading,
    /// Overwrite an existing output
    #[arg(long)]
    force: bool,
}

/// Simulates.
///
/// # Errors
/// A file is not what it should be, or the output cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let mut outputs =
        Outputs::claim([&arguments.output], &[&arguments.model, &arguments.input], arguments.force)?;
    let model = ModelFile::read(&arguments.model)?;
    let choice = arguments.reading.choice().like(&model.input, &model.output);
    let table = choice.table(&arguments.input)?;
    let is_measured = table.find(&model.output.name)?.is_some() || choice.rest_length_mm.is_some();
    let compared = is_measured.then(|| Recording::of(&table, &choice)).transpose()?;
    let mut drive = match &compared {
        Some(recording) => recording.drive.clone(),
        None => Drive::of(&table, &choice)?,
    };
    drive.announce();
    // As it was measured, drop-outs included.
    let measured = is_measured.then(|| drive.measured(&table, &choice)).transpose()?;
    let simulated = simulation::simulate(&model, &table, &drive)?;

    let text = csv(&drive, &model.output, &simulated, measured.as_ref());
    outputs.stage(&arguments.output, text.as_bytes())?;
    outputs.commit()?;
    say!("{} rows simulated", simulated.len());
    if let Some(recording) = compared {
        say_left_out(&recording.left_out);
        let figures = recording.figures(&simulated);
        say!("{}", figures.in_words(recording.stroke(), recording.output.channel.unit));
    }
    Ok(())
}

/// The answer as a recording: its output column is the simulated one.
fn csv(drive: &Drive, output: &Channel, simulated: &[f64], measured: Option<&Series>) -> String {
    let errors: Vec<f64>;
    let mut names = vec![TIME.to_owned(), drive.input.channel.name.clone(), output.name.clone()];
    let mut columns: Vec<&[f64]> = vec![&drive.time_s, &drive.input.values, simulated];
    if let Some(measured) = measured {
        names.extend([format!("measured_{}", output.name), format!("error_{}", output.unit.suffix())]);
        errors = measured.values.iter().zip(simulated).map(|(measured, model)| measured - model).collect();
        columns.extend([&*measured.values, &*errors]);
    }
    let mut text = names.join(",") + "\n";
    for row in 0..drive.time_s.len() {
        let fields: Vec<String> = columns.iter().map(|column| column[row].to_string()).collect();
        text += &(fields.join(",") + "\n");
    }
    text
}
