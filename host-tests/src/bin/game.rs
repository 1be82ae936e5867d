//! The command behind `cargo xtask game`: plays the sealed game and fails where the verdicts stay under their
//! bounds.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::Parser;
use host_tests::game::case::{only, sample, whole};
use host_tests::game::finder::DiagnoseCommand;
use host_tests::game::play;
use host_tests::game::score::Score;
use indicatif::{ProgressBar, ProgressStyle};

/// Hides causes in simulated plants and holds the diagnosis to finding them.
#[derive(Parser)]
struct Cli {
    /// Play a small sample only
    #[arg(long)]
    sample: bool,
    /// Seeds for each cause
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=1000))]
    seeds: u64,
    /// The first seed
    #[arg(long, default_value_t = 1)]
    first_seed: u64,
    /// Play only what has this in its name, such as `creep`, or `--plant mgpi`
    #[arg(long, value_name = "TEXT", allow_hyphen_values = true)]
    only: Option<String>,
    /// The program that diagnoses [default: `mgpi` beside this one]
    #[arg(long, value_name = "PROGRAM")]
    program: Option<PathBuf>,
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
    let cases = if cli.sample { sample(cli.first_seed) } else { whole(cli.first_seed, cli.seeds) };
    let cases = only(cases, cli.only.as_deref())?;
    let program = match &cli.program {
        Some(program) => program.clone(),
        None => std::env::current_exe().context("where is this program?")?.with_file_name("mgpi"),
    };
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} games, {eta} left")?;
    let bar = ProgressBar::new(cases.len() as u64).with_style(style);
    let outcomes = play(&cases, &DiagnoseCommand { program }, |outcome| {
        if !outcome.is_right() {
            let said = outcome.found.as_ref().map_or_else(Clone::clone, ToString::to_string);
            bar.suspend(|| println!("{}: {said}", outcome.case));
        }
        bar.inc(1);
    });
    bar.finish_and_clear();
    let score = if cli.sample { Score::of_sample(&outcomes) } else { Score::of_whole(&outcomes) };
    println!("{score}");
    Ok(score.failures())
}
