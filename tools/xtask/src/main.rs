//! `cargo xtask …`: the commands of the README. Each does the set-up it needs before its own work,
//! so that a fresh clone needs nothing done beforehand. Exit status 2: the machine lacks something
//! that could not be installed; the message says what.

mod arrows;
mod board_compiler;
mod book;
mod causes;
mod circles;
mod comments;
mod demo;
mod faults;
mod figures;
mod firmware;
mod fuzz;
mod gates;
mod host;
mod python;
mod registers;
mod run;
mod schematic;
mod setup;
mod workflow;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Set-up, demo, tests and emulator of the valve controller.
#[derive(Parser)]
#[command(name = "cargo xtask")]
struct Cli {
    #[command(subcommand)]
    task: Task,
}

#[derive(Clone, Subcommand)]
enum Task {
    /// Install what is missing: a compiler for the board, and the emulator.
    Setup,
    /// Build the firmware's images.
    Firmware {
        /// Whose images the board shall take over the bus: a file of `cargo xtask key` [default:
        /// the key of the tests, which everybody has].
        #[arg(long)]
        key: Option<PathBuf>,
    },
    /// Build the firmware, and pack it, signed, for `mgpi update`.
    Image {
        /// The key that the board's firmware was built with: a file of `cargo xtask key` [default:
        /// that of the tests, which everybody has].
        #[arg(long)]
        key: Option<PathBuf>,
        /// The package.
        #[arg(short, long)]
        output: PathBuf,
    },
    /// Make a key for images: its private half into a file, the public one beside it, into .pub.
    Key {
        /// The file; it must not be there yet.
        file: PathBuf,
    },
    /// Put its checksum into an image that was built by other means.
    Seal {
        /// The image's ELF file.
        elf: PathBuf,
    },
    /// Install the command mgpi with the emulator's firmware in it; needs nothing of this folder
    /// afterwards.
    Install {
        /// Where, in its folder `bin` [default: as `cargo install` does, ~/.cargo].
        #[arg(long)]
        root: Option<PathBuf>,
    },
    /// Identify a muscle, run the firmware against it in closed loop, and write a report (about two
    /// minutes).
    Demo,
    /// Go the whole way over the emulated board's bus: capture, identify, diagnose, deploy, track
    /// (about two minutes).
    Workflow,
    /// Run every command of the book in docs, in order, with an mgpi that is installed for it.
    Book,
    /// Run every test, on the host and in the emulator.
    Test,
    /// Run the firmware in the emulator by hand, or with --port PATH as a board on a bus, with a
    /// plant.
    Emulate {
        /// What `mgpi emulate` is told; `--help` behind `--` tells.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    /// Hide causes in simulated plants and hold `mgpi diagnose` to finding them.
    Game {
        /// What to play; `--help` behind `--` tells.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    /// Count instructions and bytes, look for panics, and hold the figures against gates.toml.
    Gates {
        /// Rewrite the bounds around the measured figures.
        #[arg(long)]
        bless: bool,
    },
    /// Build the Python package, and run its README, its notebook and its tests.
    Python,
    /// Hold the crates against the table of which may build on which.
    Arrows,
    /// Hold comments to 100 columns and to plain words.
    Comments,
    /// Hold the diagnosis to naming each cause in its own file alone.
    Causes,
    /// Give mutated inputs to every parser of bytes from outside.
    Fuzz {
        /// How long, all targets together. Unit: s.
        #[arg(long, default_value_t = 60)]
        seconds: u64,
    },
    /// Rewrite docs/faults.md from the firmware's tables.
    Faults {
        /// Write nothing; fail where the page is out of date.
        #[arg(long)]
        check: bool,
    },
    /// Rewrite docs/registers.md and docs/registers.csv from the table of registers.
    Registers {
        /// Write nothing; fail where a file is out of date.
        #[arg(long)]
        check: bool,
    },
    /// Redraw the figures of docs/figures, and the schematic.
    Figures {
        /// Write nothing; fail where a figure is out of date.
        #[arg(long)]
        check: bool,
    },
}

fn main() -> ExitCode {
    match perform(Cli::parse().task) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(if error.is::<setup::Missing>() { 2 } else { 1 })
        }
    }
}

fn perform(task: Task) -> anyhow::Result<()> {
    match task {
        Task::Setup => {
            setup::ensure()?;
            setup::offer_test_tools();
            println!("setup: nothing is missing");
        }
        Task::Firmware { key } => firmware::build_for(&setup::ensure()?, key.as_deref())?,
        Task::Image { key, output } => firmware::pack(&setup::ensure()?, key.as_deref(), &output)?,
        Task::Key { file } => {
            let public = packing::new_key(&file)?;
            println!("{}: to sign with, keep it; {}: what boards know", file.display(), public.display());
        }
        Task::Seal { elf } => packing::seal(&elf)?,
        Task::Install { root } => {
            firmware::build(&setup::ensure()?)?;
            host::install(root.as_deref(), host::Build::Release)?;
        }
        Task::Demo => {
            firmware::build(&setup::ensure()?)?;
            demo::demo()?;
        }
        Task::Workflow => {
            firmware::build(&setup::ensure()?)?;
            workflow::workflow()?;
        }
        Task::Book => {
            firmware::build(&setup::ensure()?)?;
            book::book()?;
        }
        Task::Test => {
            let compiler = setup::ensure()?;
            firmware::build_for_coil(&compiler)?;
            firmware::build(&compiler)?;
            setup::offer_test_tools();
            host::test()?;
        }
        Task::Emulate { arguments } => {
            firmware::build(&setup::ensure()?)?;
            host::emulate(&arguments)?;
        }
        Task::Game { arguments } => host::game(&arguments)?,
        Task::Python => python::python()?,
        Task::Arrows => arrows::check()?,
        Task::Comments => comments::check()?,
        Task::Causes => causes::check()?,
        Task::Gates { bless } => gates::gates(&setup::ensure()?, bless)?,
        Task::Fuzz { seconds } => fuzz::fuzz(seconds)?,
        Task::Faults { check } => faults::faults(check)?,
        Task::Registers { check } => registers::registers(check)?,
        Task::Figures { check } => {
            figures::figures(check)?;
            schematic::schematic(check)?;
        }
    }
    Ok(())
}
