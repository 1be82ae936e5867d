//! The plant, for the commands that run a board in the loop.

use std::time::Duration;

use clap::Args;

use crate::pil::plant::Program;

/// What the board drives.
#[derive(Args, Clone, Debug)]
pub struct PlantArguments {
    /// The built-in plant, with an effect hidden in it or without [default: rig]
    #[arg(long, value_name = "rig[:EFFECT]", value_parser = rig)]
    plant: Option<Rig>,
    /// Any plant: a command line that answers `time_s command_bar` with `pressure_bar contraction_mm`, line by line
    #[arg(long, value_name = "COMMAND", conflicts_with = "plant")]
    plant_command: Option<String>,
    /// Longest time for an answer of the plant in s
    #[arg(long, default_value_t = 5.0, value_name = "S", value_parser = positive)]
    plant_timeout_s: f64,
}

/// The built-in plant.
#[derive(Clone, Debug, Default)]
struct Rig {
    effect: Option<String>,
}

impl PlantArguments {
    /// The program that is the plant.
    pub fn program(&self) -> Program {
        let limit = Duration::from_secs_f64(self.plant_timeout_s);
        match (&self.plant_command, &self.plant) {
            (Some(line), _) => Program::shell(line, limit),
            (None, rig) => Program::rig(rig.as_ref().and_then(|rig| rig.effect.as_deref()), limit),
        }
    }
}

fn rig(text: &str) -> Result<Rig, String> {
    match text.split_once(':') {
        None if text == "rig" => Ok(Rig::default()),
        Some(("rig", effect)) if !effect.is_empty() => Ok(Rig { effect: Some(effect.to_owned()) }),
        _ => Err("there is the plant rig, or rig:EFFECT; for any other there is --plant-command".to_owned()),
    }
}

/// A number above 0 that a time span can be made of.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number <= 1e6 => Ok(number),
        _ => Err("a number above 0, at most 1e6, is needed".to_owned()),
    }
}
