//! `mgpi identify`: from a recording, or several of one muscle, to a model.

use std::path::{Path, PathBuf};
use std::slice;

use clap::{Args, ValueEnum};
use model_core::Kind;

use super::number::positive;
use super::reading::say_left_out;
use super::search::{Columns, Effort, HeldOutArguments, unidentified, warn_of_poor_fit, with_bar};
use super::{instructions, joint_identify, recorded};
use crate::Error;
use crate::output::Outputs;
use diagnosis::diagnosed::Examined;
use identification::comparison::{self, Comparison, choice};
use identification::holdout;
use identification::identified::{Identified, NotIdentified, Trial, identified};
use identification::json::to_json;
use identification::{CONVERGED, Loss, Options, Strays, Weights};
use recording::input::is_standard;
use recording::model::named::slope_dimension;
use recording::model_file::HeldOut;
use recording::numbers::legible;
use recording::{Recording, Timing};
use report::identified::Identified as Report;

/// Identifies a model from a recording, or one model from several recordings of one muscle.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The recording; several of one muscle, each from rest, are fitted together
    #[arg(value_name = "REC.csv", required = true)]
    recordings: Vec<PathBuf>,
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
    /// How a residual counts
    #[arg(long, value_enum, default_value = "squares")]
    loss: ResidualLoss,
    #[command(flatten)]
    columns: Columns,
    #[command(flatten)]
    held_out: HeldOutArguments,
    #[command(flatten)]
    effort: Effort,
    /// The recording is one of two muscles at a joint: commands, pressures, angle, torque; of
    /// several one has a known torque that the others have not
    #[arg(
        long,
        conflicts_with_all = ["model", "plays", "weights", "dead_zones", "envelope", "knots", "loss",
            "validate", "no_holdout", "starts", "seed", "threads", "input", "output", "input_range", "rest_length"]
    )]
    joint: bool,
    /// Half the swing that the stiffness of a joint is for, in degrees
    #[arg(long, default_value_t = 3.0, value_name = "DEG", value_parser = positive, requires = "joint")]
    swing_deg: f64,
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
    /// Whichever of them does best on cycles that it has not seen
    Auto,
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

/// How a residual counts.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum ResidualLoss {
    /// By its square
    Squares,
    /// Outliers by their size only; they are listed
    Huber,
}

impl From<ResidualLoss> for Loss {
    fn from(loss: ResidualLoss) -> Self {
        match loss {
            ResidualLoss::Squares => Self::Squares,
            ResidualLoss::Huber => Self::Huber,
        }
    }
}

impl From<PlayWeights> for Weights {
    fn from(weights: PlayWeights) -> Self {
        match weights {
            PlayWeights::Exponential => Self::Exponential,
            PlayWeights::Free => Self::Free,
        }
    }
}

impl Model {
    /// The kind; None where it is to be chosen.
    fn kind(self) -> Option<Kind> {
        Some(match self {
            Self::Cpi => Kind::Cpi,
            Self::Sgpi => Kind::Sgpi,
            Self::Agpi => Kind::Agpi,
            Self::Mpi => Kind::Mpi,
            Self::Egpi => Kind::Egpi,
            Self::Mgpi => Kind::Mgpi,
            Self::Auto => return None,
        })
    }
}

/// Identifies.
///
/// # Errors
/// A recording is not what it should be, no model can be made of it, or an output cannot be
/// written.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { recordings: files, held_out, model_file, report, json, .. } = arguments;
    arguments.check_choices()?;
    let inputs: Vec<&Path> = files.iter().chain(&held_out.validate).map(PathBuf::as_path).collect();
    let written = [model_file].into_iter().chain(report).chain(json);
    let mut outputs = Outputs::claim(written, &inputs, arguments.force)?;
    if arguments.joint {
        let choice = arguments.columns.choice();
        let (swing_deg, report, json) = (arguments.swing_deg, report.as_deref(), json.as_deref());
        let joint =
            joint_identify::Arguments { recordings: files, choice, swing_deg, model_file, report, json };
        return joint_identify::run(&joint, outputs);
    }
    let (recordings, other) = arguments.columns.read(files, held_out.validate.as_deref())?;

    let options = match arguments.model.kind() {
        Some(model) => arguments.options(model),
        None => arguments.choose(&recordings)?,
    };
    let trial = match &other {
        Some(other) => Trial::Another(other),
        None if held_out.no_holdout => Trial::Nothing,
        None => Trial::Part,
    };
    let found = with_bar("identifying", |progress| identified(&recordings, &options, trial, progress));
    let found = found.map_err(|error| match error {
        NotIdentified::Data(error) => error.into(),
        NotIdentified::Identification(found) => unidentified(&found.0, found.1),
    })?;
    let Identified { model, identification, fit, recording, tried, .. } = &found;
    let mut written_model = model.clone();
    // Of several recordings each would show its own; what is read from a pipe is gone.
    if let [file] = &files[..]
        && !is_standard(file)
    {
        let choice = arguments.columns.choice_of(recording);
        let columns = Examined::of(&choice.table(file)?, &choice)?.columns;
        written_model.recorded = recorded::of_columns(&written_model, &columns);
    }
    outputs.stage(model_file, written_model.to_toml().as_bytes())?;
    if let Some(file) = report {
        let report = Report {
            model,
            identification,
            recording,
            simulated: &fit.simulated,
            heldout: tried.as_ref().map(|(recording, simulated)| (recording, &simulated[..])),
            uncertainty: &fit.uncertainty,
        };
        outputs.stage(file, report.to_html()?.as_bytes())?;
    }
    if let Some(file) = json {
        let text = format!("{:#}\n", to_json(&found));
        outputs.stage(file, text.as_bytes())?;
    }
    outputs.commit()?;
    print_summary(&recordings, &found);
    warn_of_poor_fit(recording, &identification.worth());
    Ok(())
}

impl Arguments {
    /// A choice of envelope or weights for a model that has none, or has it chosen, would be
    /// ignored.
    fn check_choices(&self) -> Result<(), Error> {
        let refused = |option: &str, has: &str| {
            Err(Error::Usage(format!("{option} is for the models mgpi and sgpi; {has}")))
        };
        match (self.model, self.envelope, self.weights) {
            (Model::Cpi, Some(_), _) => refused("--envelope", "cpi has none"),
            (Model::Mpi, Some(_), _) => refused("--envelope", "mpi has none"),
            (Model::Agpi, Some(_), _) => refused("--envelope", "agpi has two tanh"),
            (Model::Egpi, Some(_), _) => refused("--envelope", "egpi has two tanh"),
            (Model::Auto, Some(_), _) => refused("--envelope", "auto tries both"),
            (Model::Auto, _, PlayWeights::Free) => {
                Err(Error::Usage("--weights free is for a model by name; auto tries both".to_owned()))
            }
            _ => Ok(()),
        }
    }

    /// Tries the family, on the part of the recording that is not held out, and says how all of it
    /// did.
    fn choose(&self, recordings: &[Recording]) -> Result<Options, Error> {
        let [recording] = recordings else {
            let message = "--model auto chooses by one recording; of several name the model";
            return Err(Error::Usage(message.to_owned()));
        };
        let seen = if self.held_out.validate.is_some() || self.held_out.no_holdout {
            recording.clone()
        } else {
            holdout::first_part(recording)
        };
        let candidates = choice::candidates(&self.options(Kind::Mgpi), self.knots);
        let heldout = comparison::HeldOut::LaterCycles;
        let comparison = with_bar("comparing", |progress| {
            Comparison::of(
                (slice::from_ref(&seen), &seen),
                heldout,
                &candidates,
                instructions::of_tick,
                progress,
            )
        })
        .map_err(|source| unidentified(recording, source))?;
        say!("{}", comparison.heldout_in_words());
        say!("\n{}\n", comparison.to_text().trim_end());
        let chosen = comparison.chosen().map(|row| (row.name(), row.options));
        let (name, options) = chosen.unwrap_or_else(|| ("mgpi".to_owned(), self.options(Kind::Mgpi)));
        say!("chosen        {name}");
        Ok(options)
    }

    fn options(&self, model: Kind) -> Options {
        let Effort { starts, seed, threads } = self.effort;
        Options {
            model,
            weights: self.weights.into(),
            loss: self.loss.into(),
            knots: matches!(self.envelope, Some(Envelope::Pl)).then_some(self.knots),
            plays: self.plays,
            dead_zones: self.dead_zones,
            starts,
            seed,
            threads,
            tolerance: CONVERGED,
        }
    }
}

fn print_summary(recordings: &[Recording], found: &Identified) {
    let Identified { model, identification, fit, recording, seconds, .. } = found;
    let Recording { drive, output, .. } = recording;
    let (unit, stroke) = (output.channel.unit, identification.stroke);
    say!("model         {}: {}, from {}", fit.parameters.kind(), recording.columns(), drive.file.display());
    say!("rows          {}, of which {} are scored", drive.time_s.len(), identification.scored_rows);
    let mut from = 0;
    for one in recordings {
        let rows = from..from + one.drive.time_s.len();
        let simulated = &fit.simulated[rows.clone()];
        let outliers: Vec<usize> =
            fit.outliers.iter().filter(|row| rows.contains(row)).map(|row| row - from).collect();
        from = rows.end;
        if recordings.len() > 1 {
            say!("{}: training {}", one.drive.file.display(), one.figures(simulated).in_words(stroke, unit));
        }
        print_samples(one, simulated, &outliers);
    }
    say!("stroke        {} {unit}", legible(stroke, 3));
    say!("training      {}", identification.training.in_words(stroke, unit));
    match &identification.heldout {
        Some(HeldOut { figures, from_s: Some(from_s), .. }) => say!(
            "held out      {} (a model of the rows before {from_s:.2} s, on the rows from there on)",
            figures.in_words(stroke, unit)
        ),
        Some(HeldOut { figures, by_recording: true, .. }) => {
            say!(
                "held out      {} (each recording by a model of the others)",
                figures.in_words(stroke, unit)
            );
        }
        Some(HeldOut { figures, recording, .. }) => {
            say!("held out      {} ({})", figures.in_words(stroke, unit), recording.file);
        }
        None => say!("held out      nothing: no second half of cycles, and no other recording (--validate)"),
    }
    say!("worth         {}", identification.worth());
    say!("termination   {}", identification.termination);
    say!(
        "invertible    smallest slope {:.3e} of the plays, {:.3e} {} of what follows",
        fit.model.smallest_play_slope(),
        fit.model.smallest_output_slope(),
        model.names().unit(slope_dimension(fit.parameters.kind()))
    );
    if let Some(groups) = fit.uncertainty.hardly_separable() {
        say!("separable     hardly: {groups}");
    }
    say!("time          {seconds:.2} s, {:.3} s a start", seconds / identification.starts as f64);
}

/// The samples of a recording: steps of time, what is not scored, what is far from the model.
fn print_samples(recording: &Recording, simulated: &[f64], outliers: &[usize]) {
    let drive = &recording.drive;
    say_left_out(&recording.left_out);
    say!("time steps    {:.4} s, {}", drive.timing.median_step_s, gaps(&drive.timing));
    if let [first, ..] = outliers[..] {
        let (count, first_s) = (outliers.len(), drive.time_s[first]);
        say!(
            "outliers      {count} rows beyond five robust standard deviations, the first at {first_s:.4} s"
        );
    }
    if let Some(strays) = Strays::of(recording, simulated).filter(|_| outliers.is_empty()) {
        say!("hint          {strays}");
    }
}

fn gaps(timing: &Timing) -> String {
    let Timing { gaps, largest_step_s, largest_step_at_s, .. } = timing;
    match gaps {
        0 => "no gaps".to_owned(),
        _ => format!("{gaps} gaps, the largest {largest_step_s:.4} s at {largest_step_at_s:.4} s"),
    }
}
