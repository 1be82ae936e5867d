//! Holds the gain of found extensions against that of the hidden parameters, for every cause of the
//! list at full strength on both plants, and fails where one is below the bound.

use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use host_tests::game::case::{Group, only, whole};
use indicatif::{ProgressBar, ProgressStyle};

/// The share of the gain of the hidden parameters that is asked for.
const BOUND: f64 = 0.9;

/// Holds the held-out gain of what a diagnosis finds against that of what was hidden.
#[derive(Parser)]
struct Cli {
    /// Seeds for each cause
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=1000))]
    seeds: u64,
    /// The first seed
    #[arg(long, default_value_t = 1)]
    first_seed: u64,
    /// Play only what has this in its name, such as `creep`, or `--plant mgpi`
    #[arg(long, value_name = "TEXT", allow_hyphen_values = true)]
    only: Option<String>,
}

fn main() -> ExitCode {
    match gain(&Cli::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

/// Whether all gain enough.
fn gain(cli: &Cli) -> Result<bool> {
    let mut cases = whole(cli.first_seed, cli.seeds);
    cases.retain(|case| case.group() == Group::Strong);
    let cases = only(cases, cli.only.as_deref())?;
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} games, {eta} left")?;
    let bar = ProgressBar::new(cases.len() as u64).with_style(style);
    println!("{:<78} {:>8} {:>8} {:>8} {:>8}", "held-out error, mm", "plain", "found", "hidden", "gain");
    let mut enough = 0;
    for case in &cases {
        let line = match case.gained() {
            Ok(gained) => {
                enough += usize::from(gained.ratio() >= BOUND);
                let [plain, found, hidden] =
                    [gained.found.before.rmse, gained.found.after.rmse, gained.hidden.after.rmse];
                let name = case.to_string();
                format!("{name:<78} {plain:>8.3} {found:>8.3} {hidden:>8.3} {:>8.2}", gained.ratio())
            }
            Err(error) => format!("{case}: {error:#}"),
        };
        bar.suspend(|| println!("{line}"));
        bar.inc(1);
    }
    bar.finish_and_clear();
    println!("{enough} of {} gain at least {BOUND} of what the hidden parameters do", cases.len());
    Ok(enough == cases.len())
}
