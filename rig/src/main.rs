//! The command `rig`: `record` writes a recording, `plant` is a plant on standard input and output,
//! `reference` writes a reference to track. Every error is one message on standard error and exit status 2.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Args, Parser, Subcommand, ValueEnum};

use rig::output::write_whole;
use rig::parameters::{
    CONTRACTION_NOISE_MM, DEAD_LOAD_N, LOAD_LIMIT_N, NOMINAL_LENGTH_MM, PRESSURE_NOISE_BAR,
};
use rig::plant::Plant;
use rig::protocol::Protocol;
use rig::recording::{RaisedCosines, write_recording, write_reference};
use rig::sensor::Sensors;
use rig::serve::serve;

/// A pneumatic muscle on its valve, as a balance of forces.
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Play a protocol on the plant and write a recording
    Record(RecordArgs),
    /// Be a plant: `time_s command_bar` a line on standard input, `pressure_bar contraction_mm` on standard
    /// output
    Plant(PlantArgs),
    /// Write a reference of raised cosines
    Reference(ReferenceArgs),
}

#[derive(Args)]
struct PlantArgs {
    /// Seed of everything random
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Dead load, N
    #[arg(long, default_value_t = DEAD_LOAD_N, value_parser = load_n)]
    load_n: f64,
    /// Sensors that tell the truth
    #[arg(long)]
    no_noise: bool,
}

impl PlantArgs {
    fn plant(&self) -> Plant {
        let sensors = if self.no_noise { Sensors::ideal() } else { Sensors::noisy(self.seed) };
        Plant::at_rest(self.load_n, sensors)
    }
}

#[derive(Args)]
struct OutputArgs {
    /// The file to write
    #[arg(short, long, value_name = "FILE.csv")]
    output: PathBuf,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
    /// Rows a second
    #[arg(long, default_value_t = 200.0, value_parser = rate_hz)]
    rate_hz: f64,
}

#[derive(Args)]
struct RecordArgs {
    /// The waveform of the command
    #[arg(long)]
    protocol: ProtocolName,
    #[command(flatten)]
    plant: PlantArgs,
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Clone, Copy, ValueEnum)]
enum ProtocolName {
    /// Six slow triangles of decreasing amplitude, as in the paper's Fig. 8
    Fig8,
    /// Triangles over the whole range, ever faster
    Rates,
    /// Jumps with holds
    Holds,
    /// Random ramps, by the seed
    Ramps,
}

#[derive(Args)]
struct ReferenceArgs {
    /// Peak of each raised cosine, mm
    #[arg(long, value_delimiter = ',', default_value = "110,80,50", value_parser = amplitude_mm)]
    amplitudes_mm: Vec<f64>,
    /// Where each ends and the next begins, mm
    #[arg(long, default_value_t = 10.0, value_parser = amplitude_mm)]
    trough_mm: f64,
    /// Period of each, s
    #[arg(long, default_value_t = 20.0, value_parser = period_s)]
    period_s: f64,
    #[command(flatten)]
    output: OutputArgs,
}

fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Record(args) => record(&args),
        Command::Plant(args) => serve(std::io::stdin().lock(), std::io::stdout().lock(), &mut args.plant()),
        Command::Reference(args) => reference(args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

fn record(RecordArgs { protocol: name, plant, output }: &RecordArgs) -> Result<()> {
    let protocol = match name {
        ProtocolName::Fig8 => Protocol::decreasing_triangles(),
        ProtocolName::Rates => Protocol::rates(),
        ProtocolName::Holds => Protocol::holds(),
        ProtocolName::Ramps => Protocol::random_ramps(plant.seed),
    };
    let name = name.to_possible_value().expect("no protocol is skipped");
    let (noise, no_noise) = if plant.no_noise {
        ("no noise".to_owned(), " --no-noise")
    } else {
        (format!("noise {PRESSURE_NOISE_BAR} bar, {CONTRACTION_NOISE_MM} mm"), "")
    };
    let (name, seed, load_n, rate_hz) = (name.get_name(), plant.seed, plant.load_n, output.rate_hz);
    let made_by = [
        format!("protocol {name}, seed {seed}, rig {}, simulated; {noise}", env!("CARGO_PKG_VERSION")),
        format!("rig record --protocol {name} --rate-hz {rate_hz} --seed {seed} --load-n {load_n}{no_noise}"),
    ];
    write_whole(&output.output, output.force, |out| {
        write_recording(out, &made_by, &protocol, &mut plant.plant(), rate_hz)
    })
}

fn reference(ReferenceArgs { amplitudes_mm, trough_mm, period_s, output }: ReferenceArgs) -> Result<()> {
    let peaks: Vec<_> = amplitudes_mm.iter().map(f64::to_string).collect();
    let (peaks, rate_hz) = (peaks.join(","), output.rate_hz);
    let made_by = [
        format!("raised cosines, rig {}", env!("CARGO_PKG_VERSION")),
        format!(
            "rig reference --amplitudes-mm {peaks} --trough-mm {trough_mm} --period-s {period_s} --rate-hz {rate_hz}"
        ),
    ];
    let reference = RaisedCosines { peaks_mm: amplitudes_mm, trough_mm, period_s };
    write_whole(&output.output, output.force, |out| write_reference(out, &made_by, &reference, rate_hz))
}

fn rate_hz(text: &str) -> Result<f64, String> {
    within(text, 1.0, 10_000.0, "Hz")
}

fn load_n(text: &str) -> Result<f64, String> {
    within(text, 0.0, LOAD_LIMIT_N, "N")
}

fn amplitude_mm(text: &str) -> Result<f64, String> {
    within(text, 0.0, NOMINAL_LENGTH_MM, "mm")
}

fn period_s(text: &str) -> Result<f64, String> {
    within(text, 0.1, 3600.0, "s")
}

/// A number from `low` to `high`, both included.
fn within(text: &str, low: f64, high: f64, unit: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (low..=high).contains(&value) => Ok(value),
        Ok(_) => Err(format!("must be from {low} to {high} {unit}")),
        Err(_) => Err(format!("not a number of {unit}")),
    }
}
