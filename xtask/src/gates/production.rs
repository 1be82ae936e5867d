//! The tick of the unmodified production image, from its interrupt's first instruction to its last, with everything it
//! checks and records; and the most stack that the image has used meanwhile.
//!
//! The references come over the image's link, one after the other as it acknowledges them, several ticks each: the memory of
//! the plays takes the same course as with one a tick. The samples are put in by the debug stub ([`probe`]).
//!
//! # Limits
//! What stands in for the read of the converter is 4 instructions; the function itself, which is not run here, is
//! [`SCAN_INSTRUCTIONS`] long, and they are added. The valve is written before the tick ends: trace, capture and timing
//! follow it, so that the figure is above that from interrupt to valve.

use model_core::Surroundings;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use firmware::{AdcCode, Samples, scaling};
use model_core::Mode;
use probe::Production;
use wire::{Configuration, Protection, Request, Response, VERSION};

use super::bounds::Figure;
use super::counted::{Cost, plugin_option, read_costs};
use super::drive::Parameters;
use super::elf::Image;
use super::inputs::Sample;

/// The interrupt of the tick.
const TICK: &str = "SysTick";
/// The function that reads the converter, from its first instruction to its return.
const SCAN_INSTRUCTIONS: f64 = 18.0;
/// The phases that ask the most of the controller.
const PHASES: [&str; 2] = ["full reversals", "nested reversals"];

/// Instructions of the dearest tick, and bytes of stack.
///
/// # Errors
/// The image does not start, track or answer.
pub fn figures(
    image: &Image,
    plugin: &Path,
    parameters: &Parameters,
    samples: &[Sample],
) -> Result<[Figure; 2]> {
    let results = image.path.with_extension("counts");
    let tick = [image.function(TICK)?];
    let options = ["-plugin".to_owned(), plugin_option(image, plugin, &tick, &results)];
    let mut board = Production::start(&image.path, &options)?;
    board.tick(Some(converted(scaling::CONTRACTION.code(0.0))))?;
    // What watches the plant is at work like the rest, but the plant is no muscle here.
    demand(&mut board, &Request::Protect(Protection::SIMULATED))?;
    let configuration = Configuration { version: VERSION, tracking: parameters.clone() };
    demand(&mut board, &Request::Configure(configuration))?;
    demand(&mut board, &Request::Start(Mode::Both))?;
    for sample in samples.iter().filter(|sample| PHASES.contains(&sample.phase)) {
        board.tick(Some(converted(scaling::CONTRACTION.code(sample.contraction_mm))))?;
        demand(&mut board, &Request::Reference(sample.reference_mm))?;
    }
    let stack = board.stack_bytes()?;
    board.end()?;
    let text = fs::read_to_string(&results).with_context(|| format!("no counts in {}", results.display()))?;
    let Cost { calls, max, .. } = read_costs(&text, &tick)?.remove(0);
    Ok([
        Figure {
            name: "tick of the image stm32f405, most instructions".to_owned(),
            value: max + SCAN_INSTRUCTIONS,
            remark: format!(
                "in {calls} ticks; {:.2} % of 1 ms at 168 MHz, were each a cycle",
                (max + SCAN_INSTRUCTIONS) / 1680.0
            ),
        },
        Figure {
            name: "image stm32f405, most bytes of stack".to_owned(),
            value: stack.into(),
            remark: "of 49152; beyond them is no memory".to_owned(),
        },
    ])
}

fn converted(contraction_code: u16) -> Samples {
    Samples {
        pressure: AdcCode(scaling::PRESSURE.code(0.0)),
        contraction: AdcCode(contraction_code),
        supply: AdcCode(scaling::SUPPLY.code(8.0)),
        temperature: AdcCode(scaling::TEMPERATURE.code(25.0)),
        surroundings: Surroundings::default(),
    }
}

fn demand(board: &mut Production, request: &Request) -> Result<()> {
    let response = board.request(request)?;
    ensure!(response == Response::Accepted, "the production image answers {response:?} to {request:?}");
    Ok(())
}
