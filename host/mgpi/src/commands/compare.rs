//! `mgpi compare`: the models side by side, on any recording.

use std::path::{Path, PathBuf};

use clap::Args;
use model_core::Kind;

use super::instructions;
use super::reading::say_left_out;
use super::search::{Columns, Effort, HeldOutArguments, unidentified, warn_of_poor_fit, with_bar};
use crate::Error;
use crate::output::Outputs;
use identification::comparison::{Comparison, FREE_WEIGHTS, HeldOut, PIECEWISE_LINEAR, has_dead_zones};
use identification::{CONVERGED, DEAD_ZONES, Loss, Options, PLAYS, Weights};
use recording::Recording;
use recording::numbers::legible;
use report::comparison::to_html;

/// Compares models and sizes on a recording, or on several of one muscle, as the paper's Tables 3
/// and 4 do.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The recording; of several of one muscle, each from rest, one model is made of all
    #[arg(value_name = "REC.csv", required = true)]
    recordings: Vec<PathBuf>,
    /// Models; -pl: with a piecewise-linear envelope (mgpi, sgpi); -free: with free weights of the
    /// plays
    #[arg(
        long,
        value_name = "MODEL,…",
        value_delimiter = ',',
        value_parser = model,
        default_value = "cpi,sgpi,agpi,mpi,egpi,mgpi,mgpi-pl,mgpi-pl-free"
    )]
    models: Vec<Contender>,
    /// Sizes: plays/dead zones; models without dead zones leave the second number out
    #[arg(long, value_name = "N/M,…", value_delimiter = ',', value_parser = size, default_value = "10/10,20/10,10/14")]
    sizes: Vec<(usize, usize)>,
    /// Number of knots of piecewise-linear envelopes
    #[arg(long, default_value_t = 12, value_name = "K")]
    knots: usize,
    #[command(flatten)]
    held_out: HeldOutArguments,
    /// Also write the table as CSV
    #[arg(short = 'o', value_name = "TABLE.csv")]
    table: Option<PathBuf>,
    /// Also write a report (one HTML file)
    #[arg(long, value_name = "REPORT.html")]
    report: Option<PathBuf>,
    /// Also write the table as JSON
    #[arg(long, value_name = "TABLE.json")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
    #[command(flatten)]
    effort: Effort,
    /// Overwrite existing outputs
    #[arg(long)]
    force: bool,
}

/// A model by its name.
#[derive(Clone, Copy, Debug)]
struct Contender {
    kind: Kind,
    is_piecewise_linear: bool,
    weights: Weights,
}

fn model(text: &str) -> Result<Contender, String> {
    let end = |text, end| str::strip_suffix(text, end).map_or((text, false), |name| (name, true));
    let (name, is_free) = end(text, FREE_WEIGHTS);
    let (name, is_piecewise_linear) = end(name, PIECEWISE_LINEAR);
    let can_be = |kind: &Kind| !is_piecewise_linear || matches!(kind, Kind::Sgpi | Kind::Mgpi);
    let kind = Kind::ALL.into_iter().filter(can_be).find(|kind| kind.name() == name).ok_or_else(|| {
        let names = Kind::ALL.map(Kind::name).join(", ");
        format!(
            "known are {names}, sgpi{PIECEWISE_LINEAR}, mgpi{PIECEWISE_LINEAR}, and each with {FREE_WEIGHTS}"
        )
    })?;
    let weights = if is_free { Weights::Free } else { Weights::Exponential };
    Ok(Contender { kind, is_piecewise_linear, weights })
}

/// Numbers of plays and of dead zones.
fn size(text: &str) -> Result<(usize, usize), String> {
    let size = text.split_once('/').and_then(|(n, m)| Some((n.parse().ok()?, m.parse().ok()?)));
    size.filter(|(n, m)| (1..=PLAYS).contains(n) && (1..=DEAD_ZONES).contains(m)).ok_or_else(|| {
        format!("two numbers N/M are needed: 1 to {PLAYS} plays, 1 to {DEAD_ZONES} dead zones")
    })
}

/// Compares.
///
/// # Errors
/// A recording is not what it should be, no model can be made of it, or an output cannot be
/// written.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { recordings: recording_files, held_out, table, report, json, .. } = arguments;
    let inputs: Vec<&Path> = recording_files.iter().chain(&held_out.validate).map(PathBuf::as_path).collect();
    let files = table.iter().chain(report).chain(json);
    let mut outputs = Outputs::claim(files, &inputs, arguments.force)?;
    let (recordings, other) = arguments.columns.read(recording_files, held_out.validate.as_deref())?;
    let recording = Recording::joined(&recordings)?;
    let heldout = match &other {
        Some(other) => HeldOut::Recording(other),
        None if held_out.no_holdout => HeldOut::Nothing,
        None if recordings.len() > 1 => HeldOut::EachByOthers,
        None => HeldOut::LaterCycles,
    };

    let models = arguments.models();
    let comparison = with_bar("comparing", |progress| {
        Comparison::of((&recordings, &recording), heldout, &models, instructions::of_tick, progress)
    })
    .map_err(|source| unidentified(&recording, source))?;

    if let Some(file) = table {
        outputs.stage(file, comparison.to_csv().as_bytes())?;
    }
    if let Some(file) = report {
        outputs.stage(file, to_html(&comparison).as_bytes())?;
    }
    if let Some(file) = json {
        outputs.stage(file, format!("{:#}\n", comparison.to_json()).as_bytes())?;
    }
    outputs.commit()?;
    say!("{}, from {}", recording.columns(), recording.drive.file.display());
    say!("stroke {} {}", legible(recording.stroke(), 3), recording.output.channel.unit);
    say_left_out(&recording.left_out);
    say!("{}", comparison.heldout_in_words());
    say!("\n{}", comparison.to_text().trim_end());
    if let Some((_, best)) = comparison.best() {
        warn_of_poor_fit(&recording, &best.worth(&recording));
    }
    Ok(())
}

impl Arguments {
    /// Every model in every size, but none twice.
    fn models(&self) -> Vec<Options> {
        let mut models: Vec<Options> = Vec::new();
        let Effort { starts, seed, threads } = self.effort;
        for &Contender { kind, is_piecewise_linear, weights } in &self.models {
            let knots = is_piecewise_linear.then_some(self.knots);
            for &(plays, dead_zones) in &self.sizes {
                let is_same = |other: &Options| {
                    let same_zones = !has_dead_zones(kind) || other.dead_zones == dead_zones;
                    (other.model, other.knots, other.weights, other.plays) == (kind, knots, weights, plays)
                        && same_zones
                };
                if !models.iter().any(is_same) {
                    models.push(Options {
                        model: kind,
                        knots,
                        plays,
                        weights,
                        loss: Loss::Squares,
                        dead_zones,
                        starts,
                        seed,
                        threads,
                        tolerance: CONVERGED,
                    });
                }
            }
        }
        models
    }
}
