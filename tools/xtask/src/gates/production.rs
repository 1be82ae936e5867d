//! The tick of the unmodified production image, with everything it checks: from its interrupt's
//! first instruction to the return of the function that writes the valve, and to its last; and the
//! most stack that the image can take ([`super::deepest`]), which is no less than what it has taken
//! meanwhile.
//!
//! Each run goes through all samples from the start: what a tick costs hangs on all of the past,
//! since extensions remember travel and slow states, so that neither one sample nor some before it
//! tell the most. The references come over the image's link, one after the other as it acknowledges
//! them, several ticks each: the memory of the plays takes the same course as with one a tick. The
//! samples are put in by the debug stub ([`probe`]).
//!
//! # Limits
//! What stands in for the read of the converter is 4 instructions; the function itself, which is
//! not run here, has no loop, and all its instructions are added.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread;

use anyhow::{Context, Result, anyhow, bail, ensure};
use board_models::{extended_parameters, paper_parameters};
use firmware::{AdcCode, Samples, scaling};
use model_core::{Mode, Surroundings};
use probe::Production;
use wire::{BoardParameters, Configuration, Protection, Refusal, Request, Response, VERSION};

use super::bounds::Figure;
use super::costs;
use super::counted::{Cost, plugin_option, read_costs};
use super::deepest::Depths;
use super::elf::Image;
use super::inputs::Sample;

/// Where the image starts.
const MAIN: &str = "main";
/// What takes stack in an image that drives valves, by its functions' names.
struct Tasks {
    title: &'static str,
    /// What runs while no interrupt does.
    supervisor: &'static str,
    /// The interrupts of the tasks of link and bus, which do not interrupt each other.
    messages: &'static [&'static str],
    /// The interrupts that move their bytes, which do not interrupt each other, but the tick.
    movers: &'static [&'static str],
}
const ONE_CHANNEL: Tasks = Tasks {
    title: "stm32f405",
    supervisor: "stm32f405::program::app::supervise",
    messages: &["SPI1", "SPI2"],
    movers: &["USART1", "USART2"],
};
const JOINT: Tasks = Tasks {
    title: "stm32f405_joint",
    supervisor: "stm32f405_joint::app::supervise",
    messages: &["SPI2"],
    movers: &["USART2"],
};
/// The interrupt of low voltage, which interrupts all others.
const LOW_VOLTAGE: &str = "PVD";
/// The interrupt of the tick, which interrupts them.
const TICK: &str = "SysTick";
/// The function that reads the converter.
const SCAN: &str = "adc_scan";
/// The function that writes the valve.
const WRITE: &str = "dac_write";
/// The counter's name of the way from one to the other.
const WAY: &str = "to_dac_write";
/// A period of the tick. Unit: cycle of the core.
const PERIOD_CYCLES: f64 = 168_000.0;

/// Instructions of the dearest ticks with the paper's model, without extensions and with all, and
/// bytes of stack.
///
/// # Errors
/// The image does not start, track or answer.
pub fn figures(image: &Image, emulated: &Image, plugin: &Path, samples: &[Sample]) -> Result<Vec<Figure>> {
    let models = [
        ("image stm32f405", paper_parameters()?),
        ("image stm32f405, every extension", extended_parameters()?),
    ];
    // What is counted here has to be what was tested there.
    for (title, parameters) in &models {
        costs::of_halves(plugin, emulated, parameters, samples).with_context(|| (*title).to_owned())?;
    }
    let runs = thread::scope(|scope| {
        let begin = |(number, (title, parameters))| {
            let results = image.path.with_extension(format!("{number}.counts"));
            scope.spawn(move || Ok((title, run(image, plugin, parameters, samples, results)?)))
        };
        let threads: Vec<_> = models.into_iter().enumerate().map(begin).collect();
        let end = |thread: thread::ScopedJoinHandle<'_, Result<_>>| {
            thread.join().map_err(|_| anyhow!("a run of the production image has panicked"))?
        };
        threads.into_iter().map(end).collect::<Result<Vec<_>>>()
    })?;
    let mut figures = Vec::new();
    let (mut stack, mut room) = (0, 0);
    for (title, (costs, [used, of])) in runs {
        (stack, room) = (stack.max(used), of);
        for (way, Cost { calls, most }) in
            ["whole tick", "tick from interrupt to valve"].into_iter().zip(costs)
        {
            let most = most + image.function(SCAN)?.instructions as u64;
            figures.push(Figure {
                name: format!("{way} of the {title}, most instructions"),
                value: most,
                remark: format!(
                    "in {calls} ticks; {:.2} % of 1 ms at 168 MHz, were each a cycle",
                    100.0 * most as f64 / PERIOD_CYCLES
                ),
            });
        }
    }
    let mut deepest = deepest_stack(image, &ONE_CHANNEL)?;
    ensure!(u64::from(stack) <= deepest.value, "the runs took {stack} bytes of stack, {}", deepest.remark);
    deepest.remark += &format!("; {stack} in these runs; beyond {room} is no memory");
    figures.push(deepest);
    Ok(figures)
}

/// The most stack of the image of two channels, which is not run here.
///
/// # Errors
/// It has other tasks than it should.
pub fn stack_of_joint(image: &Image) -> Result<Figure> {
    deepest_stack(image, &JOINT)
}

/// The most stack over all calls: while the image starts, where ticks and bytes come but no
/// message; or by a message, with a tick, a byte and low voltage on top. Unit: byte.
fn deepest_stack(image: &Image, tasks: &Tasks) -> Result<Figure> {
    let Tasks { title, supervisor, messages, movers } = tasks;
    let mut depths = Depths::of(image)?;
    let mut deepest = |names: &[&str]| -> Result<u64> {
        names.iter().try_fold(0, |most, name| Ok(most.max(depths.interrupt(image.function(name)?)?)))
    };
    let above = deepest(&[TICK])? + deepest(movers)? + deepest(&[LOW_VOLTAGE])?;
    let message = deepest(messages)?;
    let start = depths.deepest(image.function(MAIN)?)? + above;
    let running = depths.deepest(image.function(supervisor)?)? + message + above;
    Ok(Figure {
        name: format!("image {title}, most bytes of stack over all calls"),
        value: start.max(running),
        remark: format!("{start} at the start, {running} later"),
    })
}

/// Costs of tick and way to the valve; bytes of stack, used and in all. `results`: the counter's
/// file.
fn run(
    image: &Image,
    plugin: &Path,
    parameters: BoardParameters,
    samples: &[Sample],
    results: PathBuf,
) -> Result<([Cost; 2], [u32; 2])> {
    let (tick, write) = (image.function(TICK)?, image.function(WRITE)?);
    let option = plugin_option(image, plugin, &[tick, write], Some([tick, write]), &results);
    let options = ["-plugin".to_owned(), option];
    let mut board = Production::start(&image.path, &[], None, &options)?;
    board.tick(Some(converted(0.0)))?;
    // What watches the plant is at work like the rest, but the plant is no muscle here.
    demand(&mut board, &Request::Protect(Protection::WIDEST), UNSTORED)?;
    let configuration = Configuration { version: VERSION, tracking: parameters };
    demand(&mut board, &Request::Configure(configuration), UNSTORED)?;
    demand(&mut board, &Request::Arm, Response::Accepted)?;
    demand(&mut board, &Request::Start(Mode::Both), Response::Accepted)?;
    for sample in samples {
        board.tick(Some(converted(sample.contraction_mm)))?;
        demand(&mut board, &Request::Reference(sample.reference_mm), Response::Accepted)?;
    }
    let stack = [board.stack_bytes()?, board.stack_room()];
    board.end()?;
    let text = fs::read_to_string(&results).with_context(|| format!("no counts in {}", results.display()))?;
    let [tick, _, way] = read_costs(&text, &[TICK, WRITE, WAY])?[..] else {
        bail!("counts are missing: {text}")
    };
    Ok(([tick, way], stack))
}

fn converted(contraction_mm: f32) -> Samples {
    Samples {
        pressure: AdcCode(scaling::PRESSURE.code(0.0)),
        contraction: AdcCode(scaling::CONTRACTION.code(contraction_mm)),
        supply: AdcCode(scaling::SUPPLY.code(8.0)),
        temperature: AdcCode(scaling::TEMPERATURE.code(25.0)),
        // The emulator has the first two of these not, the board the last.
        output: None,
        reference: None,
        surroundings: Surroundings::default(),
    }
}

/// The answer to a change of what the board keeps: the emulated flash stores nothing.
const UNSTORED: Response = Response::Refused(Refusal::NotStored);

fn demand(board: &mut Production, request: &Request, expected: Response) -> Result<()> {
    let response = board.request(request)?;
    ensure!(response == expected, "the production image answers {response:?} to {request:?}");
    Ok(())
}
