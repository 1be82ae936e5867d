//! `mgpi identify`: from a recording to a model.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use model_core::Kind;

use super::identified_json;
use crate::figures::{Figures, stroke};
use crate::holdout;
use crate::identification::named::slope_dimension;
use crate::identification::{self, Fit, Options, Problem, Weights, searches};
use crate::model_file::names::Names;
use crate::model_file::{HeldOut, Identification, ModelFile, Source};
use crate::output::Outputs;
use crate::recording::{Choice, Drive, Recording, Timing};
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
    /// Another recording that the model is tried on [default: hold out the second half of the cycles]
    #[arg(long, value_name = "REC2.csv")]
    validate: Option<PathBuf>,
    /// Hold nothing out where there is no other recording
    #[arg(long, conflicts_with = "validate")]
    no_holdout: bool,
    /// Number of starts of the search
    #[arg(long, default_value_t = 24, value_name = "N")]
    starts: usize,
    /// Seed of the starts
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    /// Threads, 0 for one a core
    #[arg(long, default_value_t = 0, value_name = "N")]
    threads: usize,
    /// Overwrite existing outputs
    #[arg(long)]
    force: bool,
}

/// Share of the stroke that an error has to reach for the fit to be called poor: ten times what a muscle leaves.
const POOR_FIT: f64 = 0.1;

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
    let choice = arguments.choice();
    let recording = Recording::read(&arguments.recording, &choice)?;
    // The same columns, also where the choice was left open and this file offers others.
    let choice = Choice {
        input: Some(recording.drive.input.channel.name.clone()),
        output: Some(recording.output.channel.name.clone()),
        ..choice
    };
    let heldout = arguments.validate.as_deref().map(|file| Recording::read(file, &choice)).transpose()?;

    let begin = Instant::now();
    let fit = fit(&recording, &recording.drive.scored, arguments)?;
    let seconds = begin.elapsed().as_secs_f64();
    let heldout = match heldout {
        Some(other) => Some(HeldOut {
            recording: source(&other),
            from_s: None,
            figures: figures(&other, &identification::simulate(&fit.model, &other.drive.input.values)),
        }),
        None if arguments.no_holdout => None,
        None => hold_out(&recording, arguments)?,
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
    warn_of_poor_fit(&recording, &identification);
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

    fn choice(&self) -> Choice {
        Choice {
            input: self.input.clone(),
            output: self.output.clone(),
            rest_length_mm: self.rest_length,
            input_range: self.input_range,
        }
    }
}

fn range(text: &str) -> Result<(f64, f64), String> {
    let limits = text.split_once(',').and_then(|(low, high)| Some((low.parse().ok()?, high.parse().ok()?)));
    match limits {
        Some((low, high)) if low < high => Ok((low, high)),
        _ => Err("two numbers LOW,HIGH are needed, the lower first".to_owned()),
    }
}

/// A model of the rows with `scored`.
fn fit(recording: &Recording, scored: &[bool], arguments: &Arguments) -> Result<Fit, Error> {
    let problem = Problem { input: &recording.drive.input.values, output: &recording.output.values, scored };
    let options = Options {
        model: arguments.model.into(),
        weights: arguments.weights.into(),
        knots: matches!(arguments.envelope, Some(Envelope::Pl)).then_some(arguments.knots),
        plays: arguments.plays,
        dead_zones: arguments.dead_zones,
        starts: arguments.starts,
        seed: arguments.seed,
        threads: arguments.threads,
    };
    let style = ProgressStyle::with_template("identifying {wide_bar} {pos}/{len} searches, {eta} left");
    let bar = ProgressBar::new(searches(options.starts) as u64)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let fit = identification::identify(&problem, &options, &|done| bar.set_position(done as u64));
    bar.finish_and_clear();
    fit.map_err(|source| Error::Identification {
        file: recording.drive.file.clone(),
        columns: recording.columns(),
        source: Box::new(source),
    })
}

/// The figures of a model of the first cycles on the later ones; None where there are no two parts.
fn hold_out(recording: &Recording, arguments: &Arguments) -> Result<Option<HeldOut>, Error> {
    let Drive { input, scored, time_s, .. } = &recording.drive;
    let Some(first) = holdout::split(&input.values, scored) else { return Ok(None) };
    let part = |is_first: bool| -> Vec<bool> {
        scored.iter().enumerate().map(|(row, &scored)| scored && (row < first) == is_first).collect()
    };
    let fit = match fit(recording, &part(true), arguments) {
        // Half of the rows may be too few where the whole is enough.
        Err(Error::Identification { .. }) => return Ok(None),
        fit => fit?,
    };
    Ok(Some(HeldOut {
        recording: source(recording),
        from_s: Some(time_s[first]),
        figures: Figures::of(&recording.output.values, &fit.simulated, &part(false)),
    }))
}

fn source(recording: &Recording) -> Source {
    Source { file: recording.drive.file.display().to_string(), sha256: recording.drive.sha256.clone() }
}

fn figures(recording: &Recording, simulated: &[f64]) -> Figures {
    Figures::of(&recording.output.values, simulated, &recording.drive.scored)
}

fn identification_of(recording: &Recording, fit: &Fit, heldout: Option<HeldOut>) -> Identification {
    let errors = fit.uncertainty.estimates.iter();
    let errors =
        errors.filter_map(|estimate| Some((estimate.parameter.name.clone(), estimate.standard_error?)));
    Identification {
        tool: TOOL.to_owned(),
        recording: source(recording),
        scored_rows: recording.drive.scored.iter().filter(|&&scored| scored).count(),
        stroke: stroke(&recording.output.values, &recording.drive.scored),
        training: figures(recording, &fit.simulated),
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

/// A plain word where the model does not describe the recording.
fn warn_of_poor_fit(recording: &Recording, identification: &Identification) {
    let share = identification.training.rmse / identification.stroke;
    if share < POOR_FIT {
        return;
    }
    let Recording { drive, output } = recording;
    let (input, output, scored) = (&drive.input.values, &output.values, &drive.scored);
    let reason = if covariance(input, output, scored) < 0.0 {
        "the output falls as the input rises, and these models rise: give one of the columns the other sign"
    } else {
        "the output is not a rising hysteresis curve of the input alone: another column, speed or time acts as well"
    };
    eprintln!(
        "warning: {}: this model does not describe the recording, its error is {:.0} % of the stroke; {reason}",
        drive.file.display(),
        100.0 * share
    );
}

/// Covariance of two columns over the scored rows, in the product of their units.
fn covariance(a: &[f64], b: &[f64], scored: &[bool]) -> f64 {
    let rows: Vec<(f64, f64)> =
        a.iter().zip(b).zip(scored).filter(|(_, scored)| **scored).map(|((a, b), _)| (*a, *b)).collect();
    let count = rows.len() as f64;
    let (mean_a, mean_b) =
        rows.iter().fold((0.0, 0.0), |(sum_a, sum_b), (a, b)| (sum_a + a / count, sum_b + b / count));
    rows.iter().map(|(a, b)| (a - mean_a) * (b - mean_b)).sum::<f64>() / count
}

fn gaps(timing: &Timing) -> String {
    let Timing { gaps, largest_step_s, largest_step_at_s, .. } = timing;
    match gaps {
        0 => "no gaps".to_owned(),
        _ => format!("{gaps} gaps, the largest {largest_step_s:.4} s at {largest_step_at_s:.4} s"),
    }
}
