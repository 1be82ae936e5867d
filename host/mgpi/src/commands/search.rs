//! What the commands that search for models share: columns, effort, progress, and words where it
//! went badly.

use std::path::Path;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use super::reading::Reading;
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
    #[arg(long, value_name = "COLUMN")]
    output: Option<String>,
    /// The muscle's length at rest in mm, if the recording has length_mm
    #[arg(long, value_name = "MM", conflicts_with = "output")]
    rest_length: Option<f64>,
    /// Range of the input (of the valve, say), in its unit; a value outside is refused
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, allow_hyphen_values = true)]
    input_range: Option<(f64, f64)>,
    #[command(flatten)]
    reading: Reading,
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

/// A recording that was read.
#[derive(Debug)]
pub struct Read {
    /// The recording.
    pub recording: Recording,
    /// The command beside a pressure, where it was recorded.
    pub command: Option<Vec<f64>>,
    /// Another one, that models are tried on.
    pub other: Option<Recording>,
}

impl Columns {
    /// What they are chosen by.
    pub fn choice(&self) -> Choice {
        Choice {
            input: self.input.clone(),
            output: self.output.clone(),
            rest_length_mm: self.rest_length,
            input_range: self.input_range,
            ..self.reading.choice()
        }
    }

    /// The same columns as those of a recording, also where the choice was left open and another
    /// file offers others.
    pub fn choice_of(&self, recording: &Recording) -> Choice {
        self.choice().like(&recording.drive.input.channel, &recording.output.channel)
    }

    /// Reads a recording and another one that models are tried on.
    ///
    /// # Errors
    /// Those of [`Recording::read`].
    pub fn read(
        &self,
        training: &Path,
        heldout: Option<&Path>,
    ) -> Result<(Recording, Option<Recording>), Error> {
        let Read { recording, other, .. } = self.read_with_command(training, heldout)?;
        Ok((recording, other))
    }

    /// The same, with the command beside a pressure where it was recorded.
    ///
    /// # Errors
    /// As above.
    pub fn read_with_command(&self, training: &Path, heldout: Option<&Path>) -> Result<Read, Error> {
        let choice = self.choice();
        let table = choice.table(training)?;
        let training = Recording::of(&table, &choice)?;
        let input = &training.drive.input.channel;
        let command = format!("command_{}", input.unit.suffix());
        // One that cannot be read is missed by nobody but the valve.
        let command = match input.name == command {
            true => None,
            false => training.drive.beside(&table, &command, input.unit).ok().flatten(),
        };
        let choice = self.choice_of(&training);
        let heldout = heldout.map(|file| Recording::read(file, &choice)).transpose()?;
        [Some(&training), heldout.as_ref()].into_iter().flatten().for_each(|it| it.drive.announce());
        Ok(Read { recording: training, command: command.map(|command| command.values), other: heldout })
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
