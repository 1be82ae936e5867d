//! The plant, for the commands that run a board in the loop.

use std::time::Duration;

use ::rig::effect::{Effect, Hide};
use clap::Args;
use wire::Protection;

use super::number::positive;
use board_client::pil::plant::Program;

/// Longest time for an answer of the plant, if nothing else is said. Unit: s.
const PLANT_TIMEOUT_S: f64 = 5.0;

/// What the board drives.
#[derive(Args, Clone, Debug)]
pub struct PlantArguments {
    /// The built-in plant, with effects hidden in it or without [default: rig]; --help lists them
    #[arg(long, value_name = "rig[:EFFECT]", value_parser = rig, long_help = effects())]
    plant: Option<Rig>,
    /// Any plant: a command line that answers `time_s command_bar` with `pressure_bar
    /// contraction_mm`, line by line
    #[arg(long, value_name = "COMMAND", conflicts_with = "plant")]
    plant_command: Option<String>,
    /// Longest time for an answer of the plant in s
    #[arg(long, default_value_t = PLANT_TIMEOUT_S, value_name = "S", value_parser = positive)]
    plant_timeout_s: f64,
    /// Run the board without the monitors of its plant: pressure, stuck or spiking sensors, a
    /// contraction that does not go with the pressure, a valve that does not follow, too much
    /// feedback, a silent bus
    #[arg(long)]
    no_monitors: bool,
}

/// The built-in plant.
#[derive(Clone, Debug, Default)]
struct Rig {
    hidden: Option<Hide>,
}

impl Rig {
    /// This program, as the plant.
    fn program(&self, limit: Duration) -> Program {
        let mut arguments = vec!["rig".to_owned(), "plant".to_owned()];
        arguments.extend(self.hidden.iter().flat_map(|hidden| ["--hide".to_owned(), hidden.to_string()]));
        this_program(arguments, limit)
    }
}

/// This program with these arguments.
fn this_program(arguments: Vec<String>, limit: Duration) -> Program {
    Program {
        name: format!("mgpi {}", arguments.join(" ")),
        // By its name on the search path, where the system does not tell its place.
        file: std::env::current_exe().unwrap_or_else(|_| "mgpi".into()),
        arguments,
        limit,
    }
}

impl PlantArguments {
    /// The built-in plant, with effects hidden in it or without.
    pub fn built_in(hidden: Option<Hide>, no_monitors: bool) -> Self {
        let plant = Some(Rig { hidden });
        Self { plant, plant_command: None, plant_timeout_s: PLANT_TIMEOUT_S, no_monitors }
    }

    /// By which limits the board protects the plant; its ticks are `period_s` apart.
    pub fn protection(&self, period_s: f32) -> Protection {
        if self.no_monitors { Protection::SIMULATED } else { Protection::STANDARD.for_period(period_s) }
    }

    /// The program that is a joint.
    pub fn joint(&self) -> Program {
        let limit = Duration::from_secs_f64(self.plant_timeout_s);
        let built_in = || this_program(["rig", "joint", "plant"].map(str::to_owned).to_vec(), limit);
        self.plant_command.as_ref().map_or_else(built_in, |line| Program::shell(line, limit))
    }

    /// The program that is the plant.
    pub fn program(&self) -> Program {
        let limit = Duration::from_secs_f64(self.plant_timeout_s);
        match (&self.plant_command, &self.plant) {
            (Some(line), _) => Program::shell(line, limit),
            (None, rig) => rig.clone().unwrap_or_default().program(limit),
        }
    }
}

fn rig(text: &str) -> Result<Rig, String> {
    match text.split_once(':') {
        None if text == "rig" => Ok(Rig::default()),
        Some(("rig", effect)) => Ok(Rig { hidden: Some(effect.parse()?) }),
        _ => Err("there is the plant rig, or rig:EFFECT; for any other there is --plant-command".to_owned()),
    }
}

/// What can be hidden in the built-in plant.
fn effects() -> String {
    let effects = Effect::ALL.map(|effect| format!("\n  {:<22}{}", effect.name(), effect.words()));
    format!(
        "The built-in plant, with effects hidden in it or without [default: rig]. Several effects are joined by `+`; \
         `random` hides one and `random-pair` two, without a word. The effects:\n{}",
        effects.concat()
    )
}
