//! What the controller costs on the board with a model, in the image `emulated`, which is quick to
//! drive: the table of `mgpi compare`, and the check that the image computes what the host does.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use board_models::family;
use wire::BoardParameters;

use super::HALVES;
use super::counted::{self, Cost};
use super::drive;
use super::elf::Image;
use super::inputs::Sample;
use crate::run;

/// What is written above the costs.
const HEADER: &str = "\
# The most instructions of the board's controller with each model, of its two halves together, under the dearest samples.
# Written by `cargo xtask gates --bless`; `mgpi compare` shows them.
";

/// The costs of the controller's two halves in the samples.
///
/// # Errors
/// The image cannot be run.
pub fn of_halves(
    plugin: &Path,
    emulated: &Image,
    parameters: &BoardParameters,
    samples: &[Sample],
) -> Result<Vec<Cost>> {
    let halves = [emulated.function(HALVES[0])?, emulated.function(HALVES[1])?];
    counted::run(emulated, plugin, &halves, |link| drive::emulated(link, parameters, samples))
}

/// Measures the controller with each model of the family, and writes the table.
///
/// # Errors
/// The image cannot be run, or the file not be written.
pub fn write(plugin: &Path, emulated: &Image, samples: &[Sample]) -> Result<()> {
    let mut table = HEADER.to_owned();
    for (name, parameters) in family::models()? {
        let costs = of_halves(plugin, emulated, &parameters, samples).with_context(|| name.clone())?;
        // Writing to a string cannot fail.
        let _ = writeln!(table, "{name:?} = {}", costs.iter().map(|cost| cost.most).sum::<u64>());
    }
    let file = run::root().join("host/mgpi/instructions.toml");
    fs::write(&file, table).with_context(|| format!("cannot write {}", file.display()))
}
