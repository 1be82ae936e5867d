//! The commands of `rig`: `record` writes a recording, `plant` is a plant on standard input and
//! output, `reference` writes a reference to track. They are those of `mgpi rig` too.

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::{Args, Subcommand, ValueEnum};

use crate::effect::Hide;
use crate::effects::Effects;
use crate::joint::command::JointCommand;
use crate::output::write_whole;
use crate::parameters::{
    CONTRACTION_NOISE_MM, DEAD_LOAD_N, LOAD_LIMIT_N, NOMINAL_LENGTH_MM, PRESSURE_NOISE_BAR,
};
use crate::plant::{Kind, Plant, Setup};
use crate::protocol::Protocol;
use crate::recording::{self, RaisedCosines, write_recording, write_reference};
use crate::sensor::Columns;
use crate::serve::serve;
use crate::zoo::exhibit::Exhibit;
use crate::zoo::family::Part;

/// Rows a second where nothing else is asked for, Hz.
const RATE_HZ: f64 = 200.0;

/// What the simulated muscle is asked for.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Play a protocol on the plant and write a recording
    Record(RecordArgs),
    /// Be a plant: `time_s command_bar` a line on standard input, `pressure_bar contraction_mm` on
    /// standard output
    Plant(PlantArgs),
    /// Write a reference of raised cosines
    Reference(ReferenceArgs),
    /// Two muscles at a joint: recordings and a plant
    #[command(subcommand)]
    Joint(JointCommand),
    /// Write the recording of one plant of the zoo, drawn by the seed, and its truth
    Zoo(ZooArgs),
}

/// Arguments of a command.
#[derive(Args, Debug)]
pub struct ZooArgs {
    /// The seed that plant, experiment and what is hidden follow from
    #[arg(long)]
    seed: u64,
    /// The folder to write SEED.csv and SEED.json to; it is made where there is none
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Hide nothing
    #[arg(long)]
    none: bool,
    /// Also write what is of a sealed family, which is for the final judge
    #[arg(long)]
    sealed: bool,
    /// Replace existing files
    #[arg(long)]
    force: bool,
}

/// Arguments of a command.
#[derive(Args, Debug)]
pub struct PlantArgs {
    /// Seed of everything random
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Dead load, N
    #[arg(long, default_value_t = DEAD_LOAD_N, value_parser = load_n)]
    load_n: f64,
    /// Sensors that tell the truth
    #[arg(long)]
    no_noise: bool,
    /// What to hide in the plant: effects joined by `+`, `none`, `random` or `random-pair`; load
    /// and temperature are then told too
    #[arg(long, value_name = "EFFECT[+EFFECT]")]
    hide: Option<Hide>,
    /// How strongly: 1 is plainly visible, 0.33 just so
    #[arg(long, default_value_t = 1.0, value_parser = strength)]
    strength: f64,
    /// The muscle in the plant
    #[arg(long, default_value = "rig")]
    plant: KindName,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum KindName {
    /// A balance of forces
    Rig,
    /// The paper's operator model, its parameters varied by the seed
    Mgpi,
}

impl PlantArgs {
    fn plant(&self) -> Plant {
        let hidden = self.hide.as_ref().map(|hide| hide.effects(self.seed)).unwrap_or_default();
        Plant::new(&Setup {
            kind: match self.plant {
                KindName::Rig => Kind::Rig,
                KindName::Mgpi => Kind::Mgpi,
            },
            effects: Effects::drawn(&hidden, self.strength, self.seed),
            seed: self.seed,
            load_n: self.load_n,
            noise: !self.no_noise,
        })
    }

    fn columns(&self) -> Columns {
        if self.hide.is_some() { Columns::All } else { Columns::Muscle }
    }

    /// The arguments that make this plant.
    fn arguments(&self) -> String {
        let mut arguments = format!(" --seed {} --load-n {}", self.seed, self.load_n);
        if self.no_noise {
            arguments += " --no-noise";
        }
        if let Some(hide) = &self.hide {
            arguments += &format!(" --hide {hide} --strength {}", self.strength);
        }
        if self.plant == KindName::Mgpi {
            arguments += " --plant mgpi";
        }
        arguments
    }
}

#[derive(Args, Debug)]
struct OutputArgs {
    /// The file to write
    #[arg(short, long, value_name = "FILE.csv")]
    output: PathBuf,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
    /// Rows a second [default: 200; the protocol `rich`: 100]
    #[arg(long, value_parser = rate_hz)]
    rate_hz: Option<f64>,
}

/// Arguments of a command.
#[derive(Args, Debug)]
pub struct RecordArgs {
    /// The waveform of the command
    #[arg(long)]
    protocol: ProtocolName,
    #[command(flatten)]
    plant: PlantArgs,
    #[command(flatten)]
    output: OutputArgs,
    /// Write what is hidden to this file; nothing else tells it where the hidden is drawn at random
    #[arg(long, value_name = "FILE.json")]
    truth: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum ProtocolName {
    /// Six slow triangles of decreasing amplitude, as in the paper's Fig. 8
    Fig8,
    /// Triangles over the whole range, ever faster
    Rates,
    /// Jumps with holds
    Holds,
    /// Random ramps, by the seed
    Ramps,
    /// Everything a diagnosis needs, 12,000 rows by the seed, with load and temperature
    Rich,
}

/// Arguments of a command.
#[derive(Args, Debug)]
pub struct ReferenceArgs {
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

impl Command {
    /// Does what it says.
    ///
    /// # Errors
    /// A file that exists or cannot be written; a dialogue that is none.
    pub fn run(&self) -> Result<()> {
        match self {
            Self::Record(args) => record(args),
            Self::Plant(args) => {
                serve(std::io::stdin().lock(), std::io::stdout().lock(), &mut args.plant(), args.columns())
            }
            Self::Reference(args) => reference(args),
            Self::Joint(command) => command.run(),
            Self::Zoo(args) => zoo(args),
        }
    }
}

fn record(RecordArgs { protocol: name, plant: args, output, truth }: &RecordArgs) -> Result<()> {
    let protocol = match name {
        ProtocolName::Fig8 => Protocol::decreasing_triangles(),
        ProtocolName::Rates => Protocol::rates(),
        ProtocolName::Holds => Protocol::holds(),
        ProtocolName::Ramps => Protocol::random_ramps(args.seed),
        ProtocolName::Rich => Protocol::rich(args.seed),
    };
    let (rate_hz, columns) = match name {
        ProtocolName::Rich => (100.0, Columns::All),
        _ => (RATE_HZ, args.columns()),
    };
    let rate_hz = output.rate_hz.unwrap_or(rate_hz);
    let name = name.to_possible_value().expect("no protocol is skipped");
    let noise = if args.no_noise {
        "no noise".to_owned()
    } else {
        format!("noise {PRESSURE_NOISE_BAR} bar, {CONTRACTION_NOISE_MM} mm")
    };
    let (name, seed) = (name.get_name(), args.seed);
    let made_by = [
        format!("protocol {name}, seed {seed}, rig {}, simulated; {noise}", env!("CARGO_PKG_VERSION")),
        format!("rig record --protocol {name} --rate-hz {rate_hz}{}", args.arguments()),
    ];
    let mut plant = args.plant();
    if let Some(file) = truth {
        let json = serde_json::to_vec_pretty(&plant.truth())?;
        write_whole(file, output.force, |out| out.write_all(&json))?;
    }
    write_whole(&output.output, output.force, |out| {
        write_recording(out, &made_by, recording::record(&protocol, &mut plant, rate_hz), columns)
    })
}

fn zoo(ZooArgs { seed, output, none, sealed, force }: &ZooArgs) -> Result<()> {
    let exhibit = if *none { Exhibit::sound(*seed) } else { Exhibit::of(*seed) };
    ensure!(
        *sealed || exhibit.family.part() != Part::Sealed,
        "seed {seed} is of a sealed family, of which only totals are looked at; --sealed writes it"
    );
    std::fs::create_dir_all(output).with_context(|| format!("cannot make {}", output.display()))?;
    let file = |ending: &str| output.join(format!("{seed}.{ending}"));
    let json = serde_json::to_vec_pretty(&exhibit.truth())?;
    write_whole(&file("json"), *force, |out| out.write_all(&json))?;
    write_whole(&file("csv"), *force, |out| exhibit.recording().write(out))
}

fn reference(ReferenceArgs { amplitudes_mm, trough_mm, period_s, output }: &ReferenceArgs) -> Result<()> {
    let peaks: Vec<_> = amplitudes_mm.iter().map(f64::to_string).collect();
    let (peaks, rate_hz) = (peaks.join(","), output.rate_hz.unwrap_or(RATE_HZ));
    let made_by = [
        format!("raised cosines, rig {}", env!("CARGO_PKG_VERSION")),
        format!(
            "rig reference --amplitudes-mm {peaks} --trough-mm {trough_mm} --period-s {period_s} --rate-hz {rate_hz}"
        ),
    ];
    let reference =
        RaisedCosines { peaks_mm: amplitudes_mm.clone(), trough_mm: *trough_mm, period_s: *period_s };
    write_whole(&output.output, output.force, |out| write_reference(out, &made_by, &reference, rate_hz))
}

fn rate_hz(text: &str) -> Result<f64, String> {
    within(text, 1.0, 10_000.0, "Hz")
}

fn strength(text: &str) -> Result<f64, String> {
    within(text, 0.0, 3.0, "times the nominal effect")
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
