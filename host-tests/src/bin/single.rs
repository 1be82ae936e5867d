//! Single failures by the thousand: a part of the board or of its valves fails while the rig is
//! driven, and the muscle has to be empty in the time that `docs/safety.md` promises.

use std::process::ExitCode;

use clap::Parser;
use host_tests::single::{EMPTY_BAR, End, Failure, run};
use rayon::prelude::*;

/// Runs the rig with one part that fails, once a seed, and tells the longest time until the muscle
/// was empty.
#[derive(Parser)]
struct Cli {
    /// Number of runs
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    runs: u64,
    /// The first seed
    #[arg(long, default_value_t = 1)]
    first_seed: u64,
}

fn main() -> ExitCode {
    let Cli { runs, first_seed } = Cli::parse();
    let ends: Vec<(u64, End)> =
        (first_seed..first_seed.saturating_add(runs)).into_par_iter().map(|seed| (seed, run(seed))).collect();
    println!("{:<16} {:>6} {:>6} {:>12} {:>12}", "failure", "runs", "kept", "longest, ms", "promised, ms");
    for failure in Failure::ALL {
        let of: Vec<_> = ends.iter().filter(|(_, end)| end.failure == failure).collect();
        let kept = of.iter().filter(|(_, end)| end.is_kept()).count();
        let longest = of.iter().filter_map(|(_, end)| end.empty_after).max().unwrap_or(0);
        let name = format!("{failure:?}");
        println!("{name:<16} {:>6} {kept:>6} {longest:>12} {:>12}", of.len(), failure.within_ticks());
    }
    let missed: Vec<_> = ends.iter().filter(|(_, end)| !end.is_kept()).collect();
    missed.iter().for_each(|(seed, end)| println!("seed {seed}: {end:?}"));
    println!(
        "{} of {runs} runs: below {EMPTY_BAR} bar in the time that is promised",
        ends.len() - missed.len()
    );
    if missed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
