//! The commands of `rig joint`: `record` writes a recording of two muscles at a joint, `plant` is
//! such a joint on standard input and output.

use std::io::{BufRead, ErrorKind, Write};
use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};
use clap::{Args, Subcommand};

use super::protocol::JointProtocol;
use super::recording::record;
use super::{ANGLE_NOISE_DEG, JointPlant};
use crate::output::write_whole;
use crate::parameters::PRESSURE_NOISE_BAR;
use crate::serve::finite;

/// Rows a second, Hz.
const RATE_HZ: f64 = 100.0;

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
                serve(std::io::stdin().lock(), std::io::stdout().lock(), &mut joint.plant())
            }
        }
    }
}

impl JointArgs {
    fn plant(&self) -> JointPlant {
        JointPlant::new(self.seed, !self.no_noise)
    }
}

/// Answers every line of `input` on `output`, each flushed. The first line sets the clock.
fn serve(input: impl BufRead, mut output: impl Write, joint: &mut JointPlant) -> Result<()> {
    let mut last_s = None;
    for (number, line) in (1u64..).zip(input.lines()) {
        let line = line.context("cannot read the commands")?;
        let [time_s, a, b] = parse(&line).with_context(|| format!("line {number}"))?;
        let start_s = last_s.replace(time_s).unwrap_or(time_s);
        ensure!(
            number == 1 || time_s > start_s,
            "line {number}: time_s is {time_s} s, not after the previous line's {start_s} s"
        );
        let measured = joint.step([a, b], time_s - start_s);
        let [pressure_a, pressure_b] = measured.pressures_bar;
        match writeln!(output, "{pressure_a} {pressure_b} {}", measured.angle_deg)
            .and_then(|()| output.flush())
        {
            // A controller that has gone is the end, as the end of its commands is.
            Err(error) if error.kind() == ErrorKind::BrokenPipe => break,
            written => written.context("cannot answer")?,
        }
    }
    Ok(())
}

/// The three numbers of a line.
fn parse(line: &str) -> Result<[f64; 3]> {
    let fields: Vec<&str> = line.split_whitespace().collect();
    let [time, a, b] = fields[..] else {
        bail!("three numbers expected, `time_s command_a_bar command_b_bar`, found {line:?}");
    };
    Ok([finite("time_s", time)?, finite("command_a_bar", a)?, finite("command_b_bar", b)?])
}
