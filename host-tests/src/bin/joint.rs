//! What the control of joints comes to, joint by joint: angle, stiffness, cross-talk.

use anyhow::Result;
use clap::Parser;
use host_tests::joint::{Tried, tried};

/// Identifies joints of the rig, controls them, and prints what that comes to.
#[derive(Parser)]
struct Arguments {
    /// Seed of the first joint
    #[arg(long, default_value_t = 1)]
    first: u64,
    /// How many joints, each of the next seed
    #[arg(long, default_value_t = 8)]
    joints: u64,
}

/// Frequencies of the reference, Hz.
const FREQUENCIES_HZ: [f64; 3] = [0.1, 0.25, 0.5];

fn main() -> Result<()> {
    let Arguments { first, joints } = Arguments::parse();
    println!(
        "| joint | angle at 0.1, 0.25, 0.5 Hz, RMSE in % of range | stiffness off by at most, % | \
         cross-talk at most, % of range | least tension, N | ticks limited: angle, stiffness |"
    );
    println!("|---|---|---|---|---|---|");
    for seed in first..first + joints {
        let Tried { rmse_percent, stiffness_percent, cross_talk_percent, slackest_n, limited, .. } =
            tried(seed, &FREQUENCIES_HZ)?;
        let rmse: Vec<String> = rmse_percent.iter().map(|percent| format!("{percent:.3}")).collect();
        println!(
            "| {seed} | {} | {stiffness_percent:.1} | {cross_talk_percent:.3} | {slackest_n:.0} | {}, {} |",
            rmse.join(", "),
            limited.0,
            limited.1
        );
    }
    Ok(())
}
