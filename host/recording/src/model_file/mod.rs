//! The model file `model.toml`, format 1.
//!
//! # Design
//! Keys carry their units, which are those of the model's input and output columns (`c1_per_bar`,
//! `weights_mm`; for a force over a position `c1_per_mm`, `weights_n`). Numbers are written so that
//! they read back as the same bits. Reading is strict: an unknown, missing or mistyped key, another
//! format, a number that is not finite, or parameters that no invertible model can be made of are
//! refused by a [`ModelFileError`] that names file and key.
//!
//! | file | what it does |
//! |---|---|
//! | [`names`] | names and units of the parameters |
//! | `section` | takes keys out of a TOML table, strictly |
//! | `parameters` | the stages of each model, both directions |
//! | [`control`] | what the recording shows of time and noise, and the feedback tuned from it |
//! | `extensions` | what the muscle does beside hysteresis, both directions, and in other units |
//! | `listed` | a board's model in its backup, both directions |
//! | `convert` | a model in the units of a board |
//! | `read`, `write` | the format in either direction |

pub mod control;
mod convert;
mod extensions;
pub mod listed;
pub mod names;
mod parameters;
mod read;
mod scale;
pub mod section;
pub(crate) mod values;
pub mod write;

use std::io;
use std::path::{Path, PathBuf};

use model_core::extension::valve_lag::LEAD_LIMIT;
use model_core::{ExtensionParameters, ParameterError};
use thiserror::Error;

use crate::figures::Figures;
use crate::input;
use crate::model::{Density, HostExtendedModel, HostModel, HostParameters, simulate};
use crate::unit::Channel;
use crate::worth::{Limit, Worth};
use crate::{Recording, Source, TOOL};
use control::{Recorded, Tuning};
use names::Names;
use section::KeyError;

/// The format that this version writes and reads.
pub const FORMAT: usize = 1;
/// The recordings of a model behind the first.
const FURTHER: &str = "further";
/// Whether each recording was answered by a model of the others.
const BY_RECORDING: &str = "by_recording";
/// Where the held-out part of a recording begins.
const FROM: &str = "from_s";
/// The words of an input that comes after the valve.
const PRESSURE: &str = "pressure";
/// What limits a model.
const LIMITED_BY: &str = "limited_by";
/// Whether the muscle has been through its whole range before it comes from rest.
const PRECONDITIONED: &str = "preconditioned";

/// A model with what is known about it.
#[derive(Clone, Debug)]
pub struct ModelFile {
    /// What the model is driven by.
    pub input: Channel,
    /// What it predicts.
    pub output: Channel,
    /// The density that the plays come from.
    pub density: Density,
    /// The raw parameters, including the validity range.
    pub parameters: HostParameters,
    /// What the muscle does beside hysteresis.
    pub extensions: ExtensionParameters<f64>,
    /// The model of these parameters.
    pub model: HostModel,
    /// Where the parameters come from; a model from a paper has none.
    pub identification: Option<Identification>,
    /// What its recording shows of time and noise.
    pub recorded: Option<Recorded>,
    /// The feedback that was tuned for it.
    pub tuning: Option<Tuning>,
}

/// What a model was identified from, and how well.
#[derive(Clone, Debug, PartialEq)]
pub struct Identification {
    /// What wrote the file, with its version.
    pub tool: String,
    /// The recording it was identified from.
    pub recording: Source,
    /// Further recordings that it was identified from.
    pub further: Vec<Source>,
    /// Number of rows that were scored.
    pub scored_rows: usize,
    /// Highest less lowest scored output. Output unit.
    pub stroke: f64,
    /// Figures on the recording. Output unit.
    pub training: Figures,
    /// How well a model does on what it was not identified from.
    pub heldout: Option<HeldOut>,
    /// What limits the model; None where that is not known.
    pub limit: Option<Limit>,
    /// Number of starts.
    pub starts: usize,
    /// How the best start ended.
    pub termination: String,
    /// Standard errors by parameter name, without those of parameters at a bound. The parameter's
    /// unit.
    pub standard_errors: Vec<(String, f64)>,
}

impl Identification {
    /// How a model was identified from a recording, whose input it answers with `simulated` (a
    /// value a row, output unit). `standard_errors`: by parameter name, in the parameter's unit.
    pub fn of(
        recording: &Recording,
        simulated: &[f64],
        heldout: Option<HeldOut>,
        starts: usize,
        termination: String,
        standard_errors: Vec<(String, f64)>,
    ) -> Self {
        let training = recording.figures(simulated);
        Self {
            tool: TOOL.to_owned(),
            recording: recording.source(),
            further: Vec::new(),
            scored_rows: recording.drive.scored.iter().filter(|&&scored| scored).count(),
            stroke: recording.stroke(),
            limit: Limit::of(recording, &training, heldout.as_ref().map(|heldout| &heldout.figures)),
            training,
            heldout,
            starts,
            termination,
            standard_errors,
        }
    }

    /// What the model is worth.
    pub fn worth(&self) -> Worth {
        let Self { training, heldout, stroke, limit, .. } = self;
        Worth::from_figures(training, heldout.as_ref().map(|heldout| &heldout.figures), *stroke, *limit)
    }
}

/// Figures on rows that took no part in identifying the model that they are of.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOut {
    /// The recording: another one, or that of the model.
    pub recording: Source,
    /// Of the model's own recording: the rows from this time on, by a model of the rows before.
    /// None for another recording, and where stretches all through it were held out. Unit: s.
    pub from_s: Option<f64>,
    /// Whether each of several recordings was answered by a model of the others.
    pub by_recording: bool,
    /// The figures. Output unit.
    pub figures: Figures,
}

/// What is wrong with a model file.
#[derive(Debug, Error)]
#[error("{}{problem}", input::name(file))]
pub struct ModelFileError {
    file: PathBuf,
    problem: Problem,
}

/// Each message follows the file's name.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum Problem {
    #[error(": cannot be read: {0}")]
    Unreadable(#[from] io::Error),
    #[error(", line {line}: not a TOML file, or cut off: {message}")]
    Syntax { line: usize, message: String },
    #[error(": {0}")]
    Key(#[from] KeyError),
    #[error(": format {0} is of another version; this one reads format {FORMAT}")]
    Format(usize),
    #[error(": no invertible model: {0}")]
    Parameters(String),
}

impl ModelFile {
    /// What the model is worth; None of a model that was not identified from a recording.
    pub fn worth(&self) -> Option<Worth> {
        self.identification.as_ref().map(Identification::worth)
    }

    /// Reads a model file.
    ///
    /// # Errors
    /// See the module's design.
    pub fn read(path: &Path) -> Result<Self, ModelFileError> {
        let refuse = |problem| ModelFileError { file: path.to_owned(), problem };
        Self::parse(path, &input::text(path).map_err(|error| refuse(error.into()))?)
    }

    /// Reads the contents of a model file; `file` is its name in messages.
    ///
    /// # Errors
    /// See the module's design.
    pub fn parse(file: &Path, text: &str) -> Result<Self, ModelFileError> {
        read::parse(text).map_err(|problem| ModelFileError { file: file.to_owned(), problem })
    }

    /// The file's text.
    pub fn to_toml(&self) -> String {
        write::to_toml(self)
    }

    /// The stroke that percentages refer to: that of the recording that the model was identified
    /// from; of a model without a recording, from the lowest to the highest input, coming from
    /// rest. Output unit.
    pub fn stroke(&self) -> f64 {
        self.identification.as_ref().map_or_else(
            || {
                let (lowest, highest) = self.parameters.input();
                let output = simulate(&self.model, &[lowest, highest]);
                output[1] - output[0]
            },
            |identification| identification.stroke,
        )
    }

    /// The model with its extensions, from its input on: one from a pressure is without the valve.
    ///
    /// # Errors
    /// None for a model that was read; else the first extension that there cannot be.
    pub fn extended(&self) -> Result<HostExtendedModel, ParameterError> {
        HostExtendedModel::try_new(&self.parameters, &self.acting())
    }

    /// The extensions that act between its input and its output: from a pressure without the
    /// valve.
    pub fn acting(&self) -> ExtensionParameters<f64> {
        let from_pressure = self.input.words() == PRESSURE;
        if from_pressure { self.extensions.without_valve() } else { self.extensions.clone() }
    }

    /// The same, with the usual lead limit in the model's unit where a valve's lag has it in bar,
    /// as one that was found in a recording has.
    #[must_use]
    pub fn with_usual_lead_limit(mut self) -> Self {
        let usual = extensions::lead_limit(&self.names());
        if let Some(lag) = &mut self.extensions.valve_lag
            && lag.lead_limit == LEAD_LIMIT
        {
            lag.lead_limit = usual;
        }
        self
    }

    /// The causes that the model is extended by, by their names in the file.
    pub fn causes(&self) -> Vec<String> {
        extensions::causes_of(&self.extensions, &self.names())
    }

    /// Names and units of the parameters.
    pub fn names(&self) -> Names {
        Names { input: self.input.unit, output: self.output.unit }
    }
}
