//! Identifies a model from a recording and prints the loop that it describes.
//!
//! `cargo run --release -p identification --example identify_csv -- recordings/rig-fig8.csv`

use std::path::PathBuf;

use identification::{Options, Problem, identify, simulate};
use recording::{Choice, Recording};

/// Steps of the input from one end of the loop to the other.
const STEPS: usize = 12;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args_os().nth(1).map_or_else(|| "recordings/rig-fig8.csv".into(), PathBuf::from);
    let recording = Recording::read(&file, &Choice::default())?;
    let fit = identify(&Problem::from(&recording), &Options::default(), &|_| ())?;
    let (input, output) = (&recording.drive.input.channel, &recording.output.channel);
    let figures = recording.figures(&fit.simulated);
    println!("{}", figures.in_words(recording.stroke(), output.unit));

    let (low, high) = fit.parameters.input();
    let at = |step: usize| low + (high - low) * step as f64 / STEPS as f64;
    let up = (0..=STEPS).map(at);
    let there_and_back: Vec<f64> = up.clone().chain(up.rev()).collect();
    let answer = simulate(&fit.model, &there_and_back);
    println!("{:>14} {:>14} {:>14}", input.name, "rising", "falling");
    for step in 0..=STEPS {
        println!("{:14.2} {:14.2} {:14.2}", at(step), answer[step], answer[2 * STEPS + 1 - step]);
    }
    Ok(())
}
