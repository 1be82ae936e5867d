//! Gates: what a tick costs on the board's processor, how large image and stack are, and that
//! neither control law nor tick can panic. Everything here is exact, the same in every run with the
//! same compiler.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | [`production`] | tick and stack of the production image |
//! | [`longest`] | the longest way through a function, over all its branches |
//! | [`deepest`] | the most stack that a function can take, over all calls |
//! | [`thumb`] | the instructions that both follow |
//! | [`elf`] | functions, sizes and panics of an image |
//! | [`inputs`] | the samples that the controller is driven with |
//! | [`costs`] | what each kind of model costs, for `mgpi compare`; no gate |
//! | [`counted`], [`drive`] | an image in the emulator under the instruction counter, checked against the same code on the host |
//! | [`joint`] | the tick of two channels, in the emulator |
//! | [`bounds`] | what the figures have to be |
//!
//! # Limits
//! Instructions are not cycles: the emulator has no cycle counter. One run at a time in a target
//! directory: the spoilt image for the check of the check has the name of the good one.

mod bounds;
mod costs;
mod counted;
mod deepest;
mod drive;
mod elf;
mod inputs;
mod joint;
mod longest;
mod production;
mod thumb;

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use model_core::{Hysteresis, Mgpi, paper};

use crate::board_compiler::BoardCompiler;
use crate::{firmware as images, run};
use bounds::{Bounds, Figure};
use elf::Image;

/// The law of compiled size, and its name in the table: the inverse with the paper's envelope and
/// with a piecewise-linear one, and the law as a whole.
const SIZED: [(&str, &str); 3] = [
    ("law_and_tick::sized::tanh_step", "inverse of compiled size"),
    ("law_and_tick::sized::piecewise_step", "inverse of compiled size, piecewise-linear envelope"),
    ("law_and_tick::sized::law_step", "control law of compiled size (inverse, PID, limits)"),
];
/// The controller in two halves, as the tick has it.
const HALVES: [&str; 2] = ["firmware::law::controller_prepare", "firmware::law::controller_act"];

/// Measures, prints the table, and holds the figures against `gates.toml`; with `bless`, rewrites
/// that first, and what each kind of model costs.
///
/// # Errors
/// A figure outside its bounds; a panic in law or tick, or one on purpose that is not found;
/// anything that cannot be built or run.
pub fn gates(compiler: &BoardCompiler, bless: bool) -> Result<()> {
    run::step("the check for panics, checked", || find_deliberate_panic(compiler))?;
    let linked = run::step("control law and tick", || build_panic_free(compiler, ""))?;
    images::build(compiler)?;
    let plugin = run::step("instruction counter", build_plugin)?;
    let [emulated, stm32f405] =
        [images::emulated_elf(), images::elf("stm32f405")].map(|elf| Image::read(&elf));
    let (emulated, stm32f405) = (emulated?, stm32f405?);

    let samples = inputs::samples(Mgpi::try_new(&paper::mgpi()?)?.output_range());
    let mut figures =
        run::step("production image", || production::figures(&stm32f405, &emulated, &plugin, &samples))?;
    let emulated_joint = Image::read(&images::elf("emulated_joint"))?;
    figures.extend(run::step("two channels", || joint::figures(&emulated_joint, &plugin))?);
    figures.extend(sizes("stm32f405", &stm32f405));
    let of_joint = Image::read(&images::elf("stm32f405_joint"))?;
    figures.push(production::stack_of_joint(&of_joint)?);
    figures.extend(sizes("stm32f405_joint", &of_joint));
    figures.extend(run::step("longest ways", || longest_ways(&linked))?);
    if bless {
        run::step("instructions of each model", || costs::write(&plugin, &emulated, &samples))?;
    }

    let mut problems = judge(&compiler.version(), &figures, bless)?;
    let panics = linked.panics();
    println!("\ncontrol law and tick: {} panicking functions among {}", panics.len(), linked.functions.len());
    problems.extend(panics.into_iter().map(|name| format!("control law or tick can end in {name}")));
    problems.iter().for_each(|problem| eprintln!("gate: {problem}"));
    ensure!(problems.is_empty(), "{} gates are not passed", problems.len());
    Ok(())
}

/// A panic put in on purpose has to be found; a check that finds nothing would pass anything.
fn find_deliberate_panic(compiler: &BoardCompiler) -> Result<()> {
    let spoilt = build_panic_free(compiler, ",deliberate_panic")?;
    let found = spoilt.panics().into_iter().find(|name| name.ends_with("panic_bounds_check"));
    let missing = || format!("an index out of bounds, put into {}, is not found", spoilt.path.display());
    println!("   found: {}", found.with_context(missing)?);
    Ok(())
}

/// The image that must not panic. `features`: more of the package's, after a comma.
fn build_panic_free(compiler: &BoardCompiler, features: &str) -> Result<Image> {
    images::build_images(compiler, &format!("law_and_tick{features}"))?;
    let image = Image::read(&images::elf("law_and_tick"))?;
    // An image without law and tick has no panics either.
    for name in HALVES.into_iter().chain(SIZED.map(|(name, _)| name)) {
        image.function(name)?;
    }
    Ok(image)
}

fn build_plugin() -> Result<PathBuf> {
    run::succeed(&mut run::cargo(&["build", "--release", "--package", "instruction-counter"]))?;
    let name = format!("{DLL_PREFIX}instruction_counter{DLL_SUFFIX}");
    Ok(run::target_dir().join("release").join(name))
}

/// What the inverses and the law of compiled size take at most, whatever they are given.
fn longest_ways(linked: &Image) -> Result<Vec<Figure>> {
    let functions = SIZED.iter().map(|(name, _)| linked.function(name)).collect::<Result<Vec<_>>>()?;
    let most = longest::longest(&linked.path, &functions)?;
    let figure = |((_, title), value): (&(&str, &str), u64)| Figure {
        name: format!("{title}, longest way"),
        value,
        remark: "over all branches".to_owned(),
    };
    Ok(SIZED.iter().zip(most).map(figure).collect())
}

fn sizes(title: &str, image: &Image) -> [Figure; 2] {
    let figure = |which, value: u64, remark: &str| Figure {
        name: format!("image {title}, bytes of {which}"),
        value,
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
        let line = format!("{name:<58} {value:>9} {lower:>8} {upper:>8} {goal:>8}  {remark}");
        println!("{}", line.trim_end());
    }
    bounds.missed(figures).iter().for_each(|missed| println!("goal missed: {missed}"));
    if compiler != bounds.compiler {
        println!("the bounds are those of {}, this is {compiler}: not held against them", bounds.compiler);
        return Ok(Vec::new());
    }
    Ok(bounds.violations(figures))
}
