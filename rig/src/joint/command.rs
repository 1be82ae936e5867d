//! The commands of `rig joint`: `record` writes a recording of two muscles at a joint, `plant` is
//! such a joint on standard input and output.

use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, Subcommand};

use super::protocol::JointProtocol;
use super::recording::{RATE_HZ, record};
use super::{ANGLE_NOISE_DEG, JointMeasurement, JointPlant};
use crate::output::write_whole;
use crate::parameters::PRESSURE_NOISE_BAR;
use crate::serve::answer_lines;

/// What the simulated joint is asked for.
#[derive(Debug, Subcommand)]
pub enum JointCommand {
    /// Record both pressures, the angle and a torque from outside
    Record(RecordArgs),
    /// Be a joint: `time_s command_a_bar command_b_bar` a line on standard input, `pressure_a_bar
    /// pressure_b_bar angle_deg` on standard output
    Plant(JointArgs),
}

/// Arguments of a command.
#[derive(Args, Debug)]
pub struct JointArgs {
    /// Seed of the joint's constants and noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Sensors that tell the truth
    #[arg(long)]
    no_noise: bool,
}

/// Arguments of a command.
#[derive(Args, Debug)]
pub struct RecordArgs {
    #[command(flatten)]
    joint: JointArgs,
    /// The file to write
    #[arg(short, long, value_name = "FILE.csv")]
    output: PathBuf,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
}

impl JointCommand {
    /// Does what it says.
    ///
    /// # Errors
    /// A file that exists or cannot be written; a line that is not a command.
    pub fn run(&self) -> Result<()> {
        match self {
            Self::Record(RecordArgs { joint, output, force }) => {
                let seed = joint.seed;
                let noise = if joint.no_noise {
                    "no noise".to_owned()
                } else {
                    format!("noise {PRESSURE_NOISE_BAR} bar, {ANGLE_NOISE_DEG} degrees")
                };
                let quiet = if joint.no_noise { " --no-noise" } else { "" };
                let made_by = [
                    format!(
                        "two muscles at a joint, seed {seed}, rig {}, simulated; {noise}",
                        env!("CARGO_PKG_VERSION")
                    ),
                    format!("rig joint record --seed {seed}{quiet}"),
                ];
                let (protocol, mut plant) = (JointProtocol::new(seed), joint.plant());
                write_whole(output, *force, |out| record(out, &made_by, &protocol, &mut plant, RATE_HZ))
            }
            Self::Plant(joint) => {
                let (input, output) = (std::io::stdin().lock(), std::io::stdout().lock());
                let mut plant = joint.plant();
                answer_lines(input, output, ["command_a_bar", "command_b_bar"], |commands_bar, dt_s| {
                    let JointMeasurement { pressures_bar: [a, b], angle_deg } =
                        plant.step(commands_bar, dt_s);
                    format!("{a} {b} {angle_deg}")
                })
            }
        }
    }
}

impl JointArgs {
    fn plant(&self) -> JointPlant {
        JointPlant::new(self.seed, !self.no_noise)
    }
}
