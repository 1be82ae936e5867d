//! `mgpi plan`: an excitation whose recording separates causes.

use std::path::PathBuf;

use clap::Args;

use super::number::positive;
use crate::Error;
use crate::output::Outputs;
use diagnosis::causes::Cause;
use diagnosis::plan::{Plan, Wish};
use recording::course::Limits;

/// Plans an excitation: a command whose recording separates causes that are still confounded.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The causes to tell apart [default: all but load]
    #[arg(long, value_name = "CAUSE,CAUSE", value_delimiter = ',', value_parser = cause)]
    causes: Vec<Cause>,
    /// Where the command goes: time_s, command_bar
    #[arg(short = 'o', value_name = "PLAN.csv")]
    plan: PathBuf,
    /// Highest command in bar
    #[arg(long, default_value_t = 6.0, value_name = "BAR")]
    max_bar: f64,
    /// Lowest command in bar
    #[arg(long, default_value_t = 0.0, value_name = "BAR", allow_negative_numbers = true)]
    min_bar: f64,
    /// Fastest change of the command in bar/s [default: jumps]
    #[arg(long, value_name = "BAR/S", value_parser = positive)]
    slew_bar_per_s: Option<f64>,
    /// How long it shall take in s [default: as long as the parts need]
    #[arg(long, value_name = "S", value_parser = positive)]
    duration_s: Option<f64>,
    /// Rows a second
    #[arg(long, default_value_t = 100.0, value_name = "HZ", value_parser = positive)]
    rate_hz: f64,
    /// Seed of the random ramps
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    /// Overwrite an existing output
    #[arg(long)]
    force: bool,
}

/// Plans.
///
/// # Errors
/// The wishes do not go together, or the output cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { plan: file, min_bar, max_bar, slew_bar_per_s, .. } = arguments;
    let mut outputs = Outputs::claim([file], &[], arguments.force)?;
    let plan = Plan::new(&Wish {
        causes: arguments.causes.clone(),
        limits: Limits { min_bar: *min_bar, max_bar: *max_bar, slew_bar_per_s: *slew_bar_per_s },
        duration_s: arguments.duration_s,
        rate_hz: arguments.rate_hz,
        seed: arguments.seed,
    })?;
    outputs.stage(file, plan.to_csv().as_bytes())?;
    outputs.commit()?;
    for line in plan.words() {
        say!("{line}");
    }
    say!("{:.1} s at {} rows a second in {}", plan.duration_s(), arguments.rate_hz, file.display());
    Ok(())
}

fn cause(name: &str) -> Result<Cause, String> {
    Cause::of_name(name)
        .ok_or_else(|| format!("known are {}", Cause::ALL.map(|cause| cause.name()).join(", ")))
}
