//! Gates: what the control law costs on the board's processor, how large the images are, what single precision loses,
//! and that the law cannot panic. Everything here is exact, the same in every run with the same compiler.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | [`inputs`] | the samples that the law is driven with |
//! | [`drive`] | the samples through an image, checked against the same code on the host |
//! | [`counted`] | an image in the emulator under the instruction counter |
//! | [`longest`] | the longest way through a function, over all its branches |
//! | [`deepest`] | the most stack that a function can take, over all calls |
//! | [`thumb`] | the instructions that both follow |
//! | [`elf`] | functions, sizes and panics of an image |
//! | [`accuracy`] | `f32` against `f64` |
//! | [`models`] | the models whose tick is counted |
//! | [`production`] | tick and stack of the production image |
//! | [`bounds`] | what the figures have to be |
//!
//! The inverse and the controller are counted in the image `control_law`, the tick around them in the others: there the
//! controller comes in two halves, either side of the valve's write.
//!
//! # Limits
//! Instructions are not cycles: the emulator has no cycle counter. One run at a time in a target directory: the spoilt
//! image for the check of the check has the name of the good one.

mod accuracy;
mod bounds;
mod counted;
mod deepest;
mod drive;
mod elf;
mod inputs;
mod longest;
mod models;
mod production;
mod thumb;

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use firmware::law::{paper_parameters, piecewise_parameters};
use model_core::{Hysteresis, Mgpi, paper};

use crate::board_compiler::BoardCompiler;
use crate::{firmware as images, run};
use bounds::{Bounds, Figure};
use counted::Cost;
use drive::Parameters;
use elf::Image;
use inputs::Sample;

/// The library functions whose cost is measured, and the task around them.
const INVERSE: &str = "firmware::law::inverse_step";
const CONTROLLER: &str = "firmware::law::controller_step";
/// The inverse of compiled size, with the paper's envelope and with a piecewise-linear one.
const SIZED: [&str; 2] = ["firmware::sized::tanh_step", "firmware::sized::piecewise_step"];
/// The control law of compiled size.
const SIZED_LAW: &str = "firmware::sized::law_step";
/// Their names in the table.
const SIZED_TITLES: [&str; 3] = [
    "inverse of compiled size",
    "inverse of compiled size, piecewise-linear envelope",
    "control law of compiled size (inverse, PID, limits)",
];
/// The controller in two halves, as the tick has it.
const HALVES: [&str; 2] = ["firmware::law::controller_prepare", "firmware::law::controller_act"];
const TICK: &str = "TIM2";

/// Measures, prints the table, and holds the figures against `gates.toml`; with `bless`, writes that anew first.
///
/// # Errors
/// A figure outside its bounds; a panic in the control law, or one on purpose that is not found; anything that cannot
/// be built or run.
pub fn gates(compiler: &BoardCompiler, bless: bool) -> Result<()> {
    run::step("the check for panics, checked", || find_deliberate_panic(compiler))?;
    let [law, tick] = run::step("control law and tick", || build_unpanicking(compiler, ""))?;
    images::build(compiler)?;
    let plugin = run::step("instruction counter", build_plugin)?;
    let (emulated, stm32f405) =
        (Image::read(&images::emulated_elf())?, Image::read(&images::elf("stm32f405"))?);

    let parameters = paper_parameters()?;
    let range_mm = Mgpi::try_new(&paper::mgpi()?)?.output_range();
    let samples = inputs::samples(range_mm);
    let mut figures = run::step("instructions", || costs(&plugin, &law, &emulated, &parameters, &samples))?;
    figures.extend(run::step("longest ways", || longest_ways(&law))?);
    figures
        .extend(run::step("instructions of each model", || costs_of_models(&plugin, &emulated, &samples))?);
    figures.extend(run::step("production image", || production::figures(&stm32f405, &plugin, &samples))?);
    figures.extend(sizes("emulated", &emulated));
    figures.extend(sizes("stm32f405", &stm32f405));
    let (error, sample) = accuracy::inverse_error(&parameters, &samples)?;
    figures.push(Figure {
        name: "inverse, error of f32, 1e-9 of full scale".to_owned(),
        value: 1e9 * error,
        remark: place(sample, &samples),
    });

    let mut problems = judge(&compiler.version(), &figures, bless)?;
    println!();
    for (title, image) in [("the control law", &law), ("the tick", &tick)] {
        problems.extend(image.panics().into_iter().map(|name| format!("{title} can end in {name}")));
        println!("{title}: {} panicking functions among {}", image.panics().len(), image.functions.len());
    }
    problems.iter().for_each(|problem| eprintln!("gate: {problem}"));
    ensure!(problems.is_empty(), "{} gates are not passed", problems.len());
    Ok(())
}

/// A panic put in on purpose has to be found; a check that finds nothing would pass anything.
fn find_deliberate_panic(compiler: &BoardCompiler) -> Result<()> {
    for spoilt in build_unpanicking(compiler, ",deliberate_panic")? {
        let found = spoilt.panics().into_iter().find(|name| name.ends_with("panic_bounds_check"));
        let missing = || format!("an index out of bounds, put into {}, is not found", spoilt.path.display());
        println!("   found: {}", found.with_context(missing)?);
    }
    Ok(())
}

/// The images that must not panic: the control law, and the tick. `features`: more of the package's, after a comma.
fn build_unpanicking(compiler: &BoardCompiler, features: &str) -> Result<[Image; 2]> {
    images::build_images(compiler, &format!("control_law,control_tick{features}"))?;
    let (law, tick) = (Image::read(&images::elf("control_law"))?, Image::read(&images::elf("control_tick"))?);
    // An image without the law has no panics either.
    law.function(INVERSE).and(law.function(CONTROLLER)).and(tick.function(HALVES[1]))?;
    Ok([law, tick])
}

fn build_plugin() -> Result<PathBuf> {
    run::succeed(&mut run::cargo(&["build", "--release", "--package", "instruction-counter"]))?;
    let name = format!("{DLL_PREFIX}instruction_counter{DLL_SUFFIX}");
    Ok(run::target_dir().join("release").join(name))
}

/// The instructions of the inverse, the controller and the whole tick, in the samples.
fn costs(
    plugin: &Path,
    law: &Image,
    emulated: &Image,
    parameters: &Parameters,
    samples: &[Sample],
) -> Result<Vec<Figure>> {
    let (inverse, controller, tick) =
        (law.function(INVERSE)?, law.function(CONTROLLER)?, emulated.function(TICK)?);
    let sized_law = law.function(SIZED_LAW)?;
    let [sized, sized_piecewise] = [law.function(SIZED[0])?, law.function(SIZED[1])?];
    let of_law = |functions: &[&elf::Function], envelope, parameters: &Parameters| {
        counted::run(law, plugin, functions, |link| drive::control_law(link, envelope, parameters, samples))
    };
    let mut costs = of_law(&[inverse, sized, controller, sized_law], 0, parameters)?;
    costs.extend(of_law(&[inverse, sized_piecewise], 1, &piecewise_parameters()?)?);
    costs.extend(counted::run(emulated, plugin, &[tick], |link| drive::emulated(link, parameters, samples))?);
    let titles = [
        "inverse",
        SIZED_TITLES[0],
        "controller (inverse, PID, limits)",
        SIZED_TITLES[2],
        "inverse, piecewise-linear envelope",
        SIZED_TITLES[1],
        "whole tick of the image emulated",
    ];
    let mut figures = Vec::new();
    for (title, cost) in titles.into_iter().zip(costs) {
        ensure!(cost.calls == samples.len(), "{title}: {} calls in {} samples", cost.calls, samples.len());
        figures.extend(instructions(title, &cost, samples));
    }
    Ok(figures)
}

/// What the inverses and the law of compiled size take at most, whatever they are given.
fn longest_ways(law: &Image) -> Result<Vec<Figure>> {
    let functions = [law.function(SIZED[0])?, law.function(SIZED[1])?, law.function(SIZED_LAW)?];
    let figure = |(title, most): (&str, u64)| Figure {
        name: format!("{title}, longest way"),
        value: most as f64,
        remark: "over all branches".to_owned(),
    };
    let most = longest::longest(&law.path, &functions)?;
    Ok(SIZED_TITLES.into_iter().zip(most).map(figure).collect())
}

/// The most instructions of the controller with each model of the family, of either half, in the dearest samples;
/// `mgpi compare` shows them.
fn costs_of_models(plugin: &Path, emulated: &Image, samples: &[Sample]) -> Result<Vec<Figure>> {
    let halves = [emulated.function(HALVES[0])?, emulated.function(HALVES[1])?];
    let samples: Vec<Sample> = inputs::dearest(samples).copied().collect();
    let mut figures = Vec::new();
    for (name, parameters) in models::models()? {
        let costs =
            counted::run(emulated, plugin, &halves, |link| drive::emulated(link, &parameters, &samples))
                .with_context(|| name.clone())?;
        let most: Vec<f64> = costs.iter().map(|cost| cost.max).collect();
        figures.push(Figure {
            name: format!("controller with {name}, most instructions"),
            value: most.iter().sum(),
            remark: format!("{most:?} in its halves, not in one sample"),
        });
    }
    Ok(figures)
}

fn instructions(title: &str, cost: &Cost, samples: &[Sample]) -> [Figure; 3] {
    let figure =
        |which, value, remark| Figure { name: format!("{title}, {which} instructions"), value, remark };
    [
        figure("least", cost.min, String::new()),
        figure("mean", cost.mean, format!("over {} samples", samples.len())),
        figure("most", cost.max, place(cost.max_call, samples)),
    ]
}

fn place(number: usize, samples: &[Sample]) -> String {
    format!("first in sample {number}, {}", samples[number].phase)
}

fn sizes(title: &str, image: &Image) -> [Figure; 2] {
    let figure = |which, value: u64, remark: &str| Figure {
        name: format!("image {title}, bytes of {which}"),
        value: value as f64,
        remark: remark.to_owned(),
    };
    [figure("flash", image.flash, ""), figure("RAM", image.ram, "without the stack")]
}

/// Prints the table, and answers what is outside the bounds.
fn judge(compiler: &str, figures: &[Figure], bless: bool) -> Result<Vec<String>> {
    let file = run::root().join("gates.toml");
    let mut bounds = Bounds::read(&file)?;
    if bless {
        bounds = bounds.blessed(compiler, figures);
        bounds.write(&file, figures)?;
    }
    println!("\n{:<58} {:>9} {:>8} {:>8} {:>8}", "", "measured", "lower", "upper", "goal");
    for Figure { name, value, remark } in figures {
        let bound = bounds.figures.get(name);
        let cell = |number: Option<u64>| number.map_or_else(|| "-".to_owned(), |number| number.to_string());
        let [lower, upper] = [bound.map(|bound| bound.lower), bound.map(|bound| bound.upper)].map(cell);
        let goal = cell(bound.and_then(|bound| bound.goal));
        let line = format!("{name:<58} {value:>9.1} {lower:>8} {upper:>8} {goal:>8}  {remark}");
        println!("{}", line.trim_end());
    }
    bounds.missed(figures).iter().for_each(|missed| println!("goal missed: {missed}"));
    if compiler != bounds.compiler {
        println!("the bounds are those of {}, this is {compiler}: not held against them", bounds.compiler);
        return Ok(Vec::new());
    }
    Ok(bounds.violations(figures))
}
