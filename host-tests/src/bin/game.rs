//! The command behind `cargo xtask game`: plays the sealed game and fails where the verdicts stay under their
//! bounds.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::{Parser, ValueEnum};
use host_tests::game::case::{Case, only, sample, whole};
use host_tests::game::finder::DiagnoseCommand;
use host_tests::game::score::Score;
use host_tests::game::table::{FalseNames, Figures, Played};
use host_tests::game::{judged::Judgement, play, zoo};
use indicatif::{ProgressBar, ProgressStyle};
use rig::zoo::family::Part;
use serde_json::Value;

/// Games of the zoo in the sample.
const SAMPLE_OF_ZOO: usize = 10;

/// Hides causes in simulated plants and holds the diagnosis to finding them.
#[derive(Parser)]
struct Cli {
    /// Play a small sample only
    #[arg(long)]
    sample: bool,
    /// Which plants are played on
    #[arg(long, default_value = "all")]
    plants: Plants,
    /// The two old plants: seeds for each cause
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=1000))]
    seeds: u64,
    /// The two old plants: the first seed
    #[arg(long, default_value_t = 1)]
    first_seed: u64,
    /// The two old plants: play only what has this in its name, such as `creep`, or `--plant mgpi`
    #[arg(long, value_name = "TEXT", allow_hyphen_values = true)]
    only: Option<String>,
    /// The zoo: the first seed
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The zoo: how many games
    #[arg(long, default_value_t = 300)]
    games: usize,
    /// The zoo: which families
    #[arg(long, default_value = "all")]
    families: Families,
    /// The zoo: play this many recordings with nothing hidden in place of games, and print how often something is named
    #[arg(long, value_name = "N")]
    none: Option<usize>,
    /// Print games of sealed families one by one too, which is for the final judge
    #[arg(long)]
    judge: bool,
    /// Also write every game as JSON, those of sealed families only with `--judge`
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
    /// The program that diagnoses [default: `mgpi` beside this one]
    #[arg(long, value_name = "PROGRAM")]
    program: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Plants {
    /// The two old ones
    Old,
    /// The zoo
    Zoo,
    /// Both
    All,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Families {
    Development,
    Validation,
    Sealed,
    All,
}

impl Families {
    fn parts(self) -> &'static [Part] {
        match self {
            Self::Development => &[Part::Development],
            Self::Validation => &[Part::Validation],
            Self::Sealed => &[Part::Sealed],
            Self::All => &Part::ALL,
        }
    }
}

fn main() -> ExitCode {
    match game(&Cli::parse()) {
        Ok(failures) if failures.is_empty() => ExitCode::SUCCESS,
        Ok(failures) => {
            failures.iter().for_each(|failure| eprintln!("under its bound: {failure}"));
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

fn game(cli: &Cli) -> Result<Vec<String>> {
    let program = match &cli.program {
        Some(program) => program.clone(),
        None => std::env::current_exe().context("where is this program?")?.with_file_name("mgpi"),
    };
    let finder = DiagnoseCommand { program };
    let parts = cli.families.parts();
    if let Some(games) = cli.none {
        let played = of_zoo(&zoo::sound(cli.seed, games, parts), &finder, cli.judge)?;
        write_json(cli.json.as_deref(), &played, cli.judge)?;
        println!("{}\n{}", Figures(&played), FalseNames(&played));
        return Ok(Vec::new());
    }
    let (mut played, mut failures) = (Vec::new(), Vec::new());
    if cli.plants != Plants::Zoo {
        let cases = if cli.sample { sample(cli.first_seed) } else { whole(cli.first_seed, cli.seeds) };
        failures = of_old(&only(cases, cli.only.as_deref())?, &finder, cli.sample, &mut played)?;
    }
    if cli.plants != Plants::Old {
        let games = if cli.sample { SAMPLE_OF_ZOO } else { cli.games };
        played.extend(of_zoo(&zoo::games(cli.seed, games, parts), &finder, cli.judge)?);
    }
    write_json(cli.json.as_deref(), &played, cli.judge)?;
    println!("{}", Figures(&played));
    Ok(failures)
}

/// Plays the two old plants; what stays under its bound.
fn of_old(
    cases: &[Case],
    finder: &DiagnoseCommand,
    is_sample: bool,
    all: &mut Vec<Played>,
) -> Result<Vec<String>> {
    let bar = bar(cases.len())?;
    let outcomes = play(cases, finder, |outcome| {
        if !outcome.is_right() {
            let said = outcome.found.as_ref().map_or_else(Clone::clone, ToString::to_string);
            bar.suspend(|| println!("{}: {said}", outcome.case));
        }
        bar.inc(1);
    });
    bar.finish_and_clear();
    let score = if is_sample { Score::of_sample(&outcomes) } else { Score::of_whole(&outcomes) };
    println!("{score}");
    all.extend(outcomes.iter().map(host_tests::game::score::Outcome::played));
    Ok(score.failures())
}

/// Plays games of the zoo, and prints those that are not exact.
fn of_zoo(
    exhibits: &[rig::zoo::exhibit::Exhibit],
    finder: &DiagnoseCommand,
    judge: bool,
) -> Result<Vec<Played>> {
    let bar = bar(exhibits.len())?;
    let played = zoo::play(exhibits, finder, |played| {
        if played.judgement() != Judgement::Exact && (judge || !played.is_sealed) {
            bar.suspend(|| println!("{played}"));
        }
        bar.inc(1);
    });
    bar.finish_and_clear();
    Ok(played)
}

fn bar(games: usize) -> Result<ProgressBar> {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} games, {eta} left")?;
    Ok(ProgressBar::new(games as u64).with_style(style))
}

/// Writes every game that may be looked at.
fn write_json(file: Option<&Path>, played: &[Played], judge: bool) -> Result<()> {
    let Some(file) = file else { return Ok(()) };
    let games: Vec<Value> =
        played.iter().filter(|played| judge || !played.is_sealed).map(Played::to_json).collect();
    std::fs::write(file, serde_json::to_vec_pretty(&games)?)
        .with_context(|| format!("cannot write {}", file.display()))
}
