//! What the commands that search for models share: columns, effort, progress, and words where it
//! went badly.

use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use super::reading::RecordingReading;
use crate::Error;
use identification::progress::{Tell, left};
use identification::{self, IdentificationError};
use recording::worth::{Grade, Worth};
use recording::{Choice, Recording};

/// Which columns of a recording are used.
#[derive(Args, Debug)]
pub struct Columns {
    /// Input column [default: pressure_bar, else command_bar]
    #[arg(long, value_name = "COLUMN")]
    input: Option<String>,
    /// Output column [default: contraction_mm]
    #[arg(long, value_name = "COLUMN", conflicts_with = "rest_length")]
    output: Option<String>,
    /// Range of the input (of the valve, say), in its unit; a value outside is refused
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, allow_hyphen_values = true)]
    input_range: Option<(f64, f64)>,
    #[command(flatten)]
    reading: RecordingReading,
}

/// What a model is tried on that is searched for.
#[derive(Args, Debug)]
pub struct HeldOutArguments {
    /// Another recording that a model is tried on [default: hold out the second half of the cycles]
    #[arg(long, value_name = "REC2.csv")]
    pub validate: Option<PathBuf>,
    /// Hold nothing out where there is no other recording
    #[arg(long, conflicts_with = "validate")]
    pub no_holdout: bool,
}

/// How much is searched.
#[derive(Args, Debug)]
pub struct Effort {
    /// Number of starts of the search
    #[arg(long, default_value_t = identification::STARTS, value_name = "N")]
    pub starts: usize,
    /// Seed of the starts
    #[arg(long, default_value_t = identification::SEED, value_name = "N")]
    pub seed: u64,
    /// Threads, 0 for one a core
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub threads: usize,
}

impl Columns {
    /// What they are chosen by.
    pub fn choice(&self) -> Choice {
        Choice {
            input: self.input.clone(),
            output: self.output.clone(),
            input_range: self.input_range,
            has_options: true,
            ..self.reading.choice()
        }
    }

    /// The same columns as those of a recording, also where the choice was left open and another
    /// file offers others.
    pub fn choice_of(&self, recording: &Recording) -> Choice {
        self.choice().like(&recording.drive.input.channel, &recording.output.channel)
    }

    /// Reads recordings, at least one, and another one that models are tried on: the columns of all
    /// are those of the first, in its units.
    ///
    /// # Errors
    /// Those of [`Recording::read`].
    pub fn read(
        &self,
        training: &[PathBuf],
        heldout: Option<&Path>,
    ) -> Result<(Vec<Recording>, Option<Recording>), Error> {
        let mut choice = self.choice();
        let mut recordings = Vec::new();
        for file in training {
            let recording = Recording::read(file, &choice)?;
            choice = self.choice_of(&recording);
            recordings.push(recording);
        }
        let heldout = heldout.map(|file| Recording::read(file, &choice)).transpose()?;
        recordings.iter().chain(&heldout).for_each(|it| it.drive.announce());
        Ok((recordings, heldout))
    }
}

fn range(text: &str) -> Result<(f64, f64), String> {
    let limits = text.split_once(',').and_then(|(low, high)| Some((low.parse().ok()?, high.parse().ok()?)));
    match limits {
        Some((low, high)) if low < high => Ok((low, high)),
        _ => Err("two numbers LOW,HIGH are needed, the lower first".to_owned()),
    }
}

/// Works with a bar that shows how much of the work is done, and how long the rest will take.
pub fn with_bar<T>(what: &'static str, work: impl FnOnce(Tell<'_>) -> T) -> T {
    const PARTS: f64 = 1000.0;
    let style = ProgressStyle::with_template("{prefix} {wide_bar} {percent} %{msg}");
    let bar = ProgressBar::new(PARTS as u64)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        .with_prefix(what);
    let result = work(&|share| {
        let part = (PARTS * share) as u64;
        if part > bar.position() {
            bar.set_position(part);
            let left = left(share, bar.elapsed());
            bar.set_message(left.map_or(String::new(), |left| format!(", {left}")));
        }
    });
    bar.finish_and_clear();
    result
}

/// That no model can be made of a recording, with the recording's name.
pub fn unidentified(recording: &Recording, source: IdentificationError) -> Error {
    Error::Identification {
        file: recording.drive.file.clone(),
        columns: recording.columns(),
        source: Box::new(source),
    }
}

/// A plain word where a model does not describe the recording.
pub fn warn_of_poor_fit(recording: &Recording, worth: &Worth) {
    if worth.grade() == Grade::Poor {
        let file = recording.drive.file.display();
        eprintln!("warning: {file}: this model does not describe the recording: {worth}");
    }
}
