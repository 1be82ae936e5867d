//! `mgpi identify`: from a recording to a model.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use model_core::Kind;

use super::identified_json;
use super::search::{Columns, Effort, unidentified, warn_of_poor_fit, with_bar};
use crate::holdout::later_cycles;
use crate::identification::named::slope_dimension;
use crate::identification::{self, Fit, Options, Weights, searches};
use crate::model_file::names::Names;
use crate::model_file::{HeldOut, Identification, ModelFile, Source};
use crate::output::Outputs;
use crate::recording::{Recording, Timing};
use crate::report::identified::Identified;
use crate::{Error, TOOL};

/// Identifies a model from a recording.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The recording
    #[arg(value_name = "REC.csv")]
    recording: PathBuf,
    /// Where the model goes
    #[arg(short = 'o', value_name = "MODEL.toml")]
    model_file: PathBuf,
    /// Kind of model
    #[arg(long, value_enum, default_value = "mgpi")]
    model: Model,
    /// Number of plays
    #[arg(long, default_value_t = 10, value_name = "N")]
    plays: usize,
    /// Weights of the plays
    #[arg(long, value_enum, default_value = "exponential")]
    weights: PlayWeights,
    /// Number of dead zones, for mgpi and mpi
    #[arg(long, default_value_t = 10, value_name = "M")]
    dead_zones: usize,
    /// Envelope of the plays, for mgpi and sgpi [default: tanh; agpi and egpi have two tanh]
    #[arg(long, value_enum)]
    envelope: Option<Envelope>,
    /// Number of knots of a piecewise-linear envelope
    #[arg(long, default_value_t = 12, value_name = "K")]
    knots: usize,
    /// Also write a report (one HTML file)
    #[arg(long, value_name = "REPORT.html")]
    report: Option<PathBuf>,
    /// Also write the figures and parameters as JSON
    #[arg(long, value_name = "FIGURES.json")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
    /// Another recording that the model is tried on [default: hold out the second half of the cycles]
    #[arg(long, value_name = "REC2.csv")]
    validate: Option<PathBuf>,
    /// Hold nothing out where there is no other recording
    #[arg(long, conflicts_with = "validate")]
    no_holdout: bool,
    #[command(flatten)]
    effort: Effort,
    /// Overwrite existing outputs
    #[arg(long)]
    force: bool,
}

/// Kinds of model that can be identified.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Model {
    /// Classical Prandtl-Ishlinskii: plays and a gain
    Cpi,
    /// Symmetric generalized: envelope, plays, gain
    Sgpi,
    /// Asymmetric generalized: an envelope for each direction, plays, gain
    Agpi,
    /// Kuhnen's modified: plays, dead zones
    Mpi,
    /// Extended generalized: as agpi, and a function of the input added
    Egpi,
    /// Modified generalized: envelope, plays, dead zones
    Mgpi,
}

/// Envelopes of the plays.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Envelope {
    /// c0 tanh(c1 x + c2) + c3
    Tanh,
    /// Piecewise-linear through free knots
    Pl,
}

/// What the weights of the plays are made of.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum PlayWeights {
    /// rho exp(-tau r)
    Exponential,
    /// Each by itself, for at most 32 plays
    Free,
}

impl From<PlayWeights> for Weights {
    fn from(weights: PlayWeights) -> Self {
        match weights {
            PlayWeights::Exponential => Self::Exponential,
            PlayWeights::Free => Self::Free,
        }
    }
}

impl From<Model> for Kind {
    fn from(model: Model) -> Self {
        match model {
            Model::Cpi => Self::Cpi,
            Model::Sgpi => Self::Sgpi,
            Model::Agpi => Self::Agpi,
            Model::Mpi => Self::Mpi,
            Model::Egpi => Self::Egpi,
            Model::Mgpi => Self::Mgpi,
        }
    }
}

/// Identifies.
///
/// # Errors
/// A recording is not what it should be, no model can be made of it, or an output cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { model_file, report, json, .. } = arguments;
    arguments.check_envelope()?;
    let inputs: Vec<&Path> =
        [&arguments.recording].into_iter().chain(&arguments.validate).map(PathBuf::as_path).collect();
    let files = [model_file].into_iter().chain(report).chain(json);
    let mut outputs = Outputs::claim(files, &inputs, arguments.force)?;
    let (recording, other) = arguments.columns.read(&arguments.recording, arguments.validate.as_deref())?;

    let options = arguments.options();
    let begin = Instant::now();
    let fit = with_bar(searches(options.starts), |progress| {
        identification::identify(&recording.problem(), &options, progress)
    })
    .map_err(|source| unidentified(&recording, source))?;
    let seconds = begin.elapsed().as_secs_f64();
    let heldout = match &other {
        Some(other) => Some(HeldOut {
            recording: source(other),
            from_s: None,
            figures: other.figures(&identification::simulate(&fit.model, &other.drive.input.values)),
        }),
        None if arguments.no_holdout => None,
        None => {
            with_bar(searches(options.starts), |progress| later_cycles(&recording, &options, progress)).map(
                |(from_s, figures)| HeldOut { recording: source(&recording), from_s: Some(from_s), figures },
            )
        }
    };

    let identification = identification_of(&recording, &fit, heldout);
    let model = ModelFile {
        input: recording.drive.input.channel.clone(),
        output: recording.output.channel.clone(),
        density: fit.density,
        parameters: fit.parameters.clone(),
        model: fit.model.clone(),
        identification: Some(identification.clone()),
    };
    outputs.stage(model_file, model.to_toml().as_bytes())?;
    if let Some(file) = report {
        let simulated = &fit.simulated;
        let (identification, uncertainty) = (&identification, &fit.uncertainty);
        let report =
            Identified { model: &model, identification, recording: &recording, simulated, uncertainty };
        outputs.stage(file, report.to_html()?.as_bytes())?;
    }
    if let Some(file) = json {
        let text = format!("{:#}\n", identified_json::to_json(&model, &identification, &fit, seconds));
        outputs.stage(file, text.as_bytes())?;
    }
    outputs.commit()?;
    print_summary(&recording, &identification, &model.names(), &fit, seconds);
    warn_of_poor_fit(&recording, &identification.training);
    Ok(())
}

impl Arguments {
    /// A choice of envelope for a model that has none, or two, would be ignored.
    fn check_envelope(&self) -> Result<(), Error> {
        let has = match self.model {
            Model::Mgpi | Model::Sgpi => return Ok(()),
            Model::Cpi | Model::Mpi => "has none",
            Model::Agpi | Model::Egpi => "has two tanh",
        };
        match self.envelope {
            None => Ok(()),
            Some(_) => Err(Error::Usage(format!(
                "--envelope is for the models mgpi and sgpi; {} {has}",
                Kind::from(self.model)
            ))),
        }
    }

    fn options(&self) -> Options {
        let Effort { starts, seed, threads } = self.effort;
        Options {
            model: self.model.into(),
            weights: self.weights.into(),
            knots: matches!(self.envelope, Some(Envelope::Pl)).then_some(self.knots),
            plays: self.plays,
            dead_zones: self.dead_zones,
            starts,
            seed,
            threads,
        }
    }
}

fn source(recording: &Recording) -> Source {
    Source { file: recording.drive.file.display().to_string(), sha256: recording.drive.sha256.clone() }
}

fn identification_of(recording: &Recording, fit: &Fit, heldout: Option<HeldOut>) -> Identification {
    let errors = fit.uncertainty.estimates.iter();
    let errors =
        errors.filter_map(|estimate| Some((estimate.parameter.name.clone(), estimate.standard_error?)));
    Identification {
        tool: TOOL.to_owned(),
        recording: source(recording),
        scored_rows: recording.drive.scored.iter().filter(|&&scored| scored).count(),
        stroke: recording.stroke(),
        training: recording.figures(&fit.simulated),
        heldout,
        starts: fit.starts,
        termination: fit.termination.to_string(),
        standard_errors: errors.collect(),
    }
}

fn print_summary(
    recording: &Recording,
    identification: &Identification,
    names: &Names,
    fit: &Fit,
    seconds: f64,
) {
    let Recording { drive, output } = recording;
    let (timing, unit, stroke) = (&drive.timing, output.channel.unit, identification.stroke);
    say!("model         {}: {}, from {}", fit.parameters.kind(), recording.columns(), drive.file.display());
    say!("rows          {}, of which {} are scored", drive.time_s.len(), identification.scored_rows);
    say!("time steps    {:.4} s, {}", timing.median_step_s, gaps(timing));
    say!("stroke        {stroke:.3} {unit}");
    say!("training      {}", identification.training.in_words(stroke, unit));
    match &identification.heldout {
        Some(HeldOut { figures, from_s: Some(from_s), .. }) => say!(
            "held out      {} (a model of the rows before {from_s:.2} s, on the rows from there on)",
            figures.in_words(stroke, unit)
        ),
        Some(HeldOut { figures, recording, .. }) => {
            say!("held out      {} ({})", figures.in_words(stroke, unit), recording.file);
        }
        None => say!("held out      nothing: no second half of cycles, and no other recording (--validate)"),
    }
    say!("termination   {}", identification.termination);
    say!(
        "invertible    smallest slope {:.3e} of the plays, {:.3e} {} of what follows",
        fit.model.smallest_play_slope(),
        fit.model.smallest_output_slope(),
        names.unit(slope_dimension(fit.parameters.kind()))
    );
    if let Some(groups) = fit.uncertainty.hardly_separable() {
        say!("separable     hardly: {groups}");
    }
    say!("time          {seconds:.2} s, {:.3} s a start", seconds / identification.starts as f64);
}

fn gaps(timing: &Timing) -> String {
    let Timing { gaps, largest_step_s, largest_step_at_s, .. } = timing;
    match gaps {
        0 => "no gaps".to_owned(),
        _ => format!("{gaps} gaps, the largest {largest_step_s:.4} s at {largest_step_at_s:.4} s"),
    }
}
