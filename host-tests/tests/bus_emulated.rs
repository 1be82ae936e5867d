//! Modbus clients that others have written, in real time, against the emulated board and against a
//! line with four boards: `host-tests/bus/clients.py`.
//!
//! Skipped, in so many words, where emulator, firmware or clients are missing; `cargo xtask test`
//! provides them. With `MGPI_EACH_BOARD` set every board of the line is asked, else one.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;

use board_client::emulator::line::Line;
use board_client::emulator::{Emulator, image, real_time};
use board_client::pil::lock_step::protect;
use board_client::stop::Stop;
use board_models::{extended_parameters, paper_parameters};
use fleet::{Fleet, Setting, line_name};
use host_tests::rig;
use libtest_mimic::{Arguments, Failed, Trial};
use tempfile::TempDir;
use wire::registers::{UNIT, UPLOAD_BYTES};
use wire::{Configuration, Protection, VERSION};

/// The environment variable that names the Python which has the clients.
const VARIABLE: &str = "MGPI_BUS_PYTHON";
/// The boards of a line.
const UNITS: [u8; 4] = [1, 2, 3, 4];

fn main() {
    let missing = missing();
    if let Some(reason) = &missing {
        println!("the tests with Modbus clients are skipped: {reason}");
    }
    let trials = vec![
        Trial::test("pymodbus_and_mbpoll_read_write_and_are_refused_as_documented", emulated),
        Trial::test("a_board_among_four_on_a_line_does_the_same_and_the_others_stay_as_they_are", among_four),
    ];
    let trials = trials.into_iter().map(|trial| trial.with_ignored_flag(missing.is_some())).collect();
    libtest_mimic::run(&Arguments::from_args(), trials).exit()
}

/// What is missing for these tests.
fn missing() -> Option<String> {
    for (program, argument) in [("qemu-system-arm", "--version"), ("mbpoll", "-V")] {
        if Command::new(program).arg(argument).output().is_err() {
            return Some(format!("no {program}; `cargo xtask setup` installs it"));
        }
    }
    if std::env::var_os(VARIABLE).is_none() {
        return Some(format!("{VARIABLE} names no Python with pymodbus; `cargo xtask test` makes one"));
    }
    image::find(None).err().map(|error| error.to_string())
}

fn emulated() -> Result<(), Failed> {
    let directory = prepared()?;
    let port = directory.path().join("port");
    let stop = Stop::default();
    let (mut board, bus) = Emulator::start_with_bus(&image::find(None)?, &stop)?;
    // The clients are silent for longer than a board with a muscle bears.
    protect(&mut board, Protection::SIMULATED)?;
    let _line = Line::open(&port, bus)?;
    thread::scope(|scope| {
        let running =
            scope.spawn(|| real_time::run(&mut board, &mut rig(3), &stop, |late| println!("{late:?} late")));
        let asked = ask(&directory, &port, 1000, &[UNIT]);
        stop.request();
        // A request to stop may come in the middle of a tick.
        match running.join() {
            Ok(Ok(()) | Err(board_client::pil::PilError::Stopped)) => asked,
            ended => asked.and(Err(format!("the board: {ended:?}").into())),
        }
    })
}

fn among_four() -> Result<(), Failed> {
    let directory = prepared()?;
    let setting = Setting { boards: 4, lines: 1, seed: 1, hide: None, protection: Protection::SIMULATED };
    let asked = if std::env::var_os("MGPI_EACH_BOARD").is_some() { &UNITS[..] } else { &UNITS[2..3] };
    let fleet = Fleet::start(directory.path(), &setting)?;
    for &unit in asked {
        let others = UNITS.into_iter().filter(|other| *other != unit);
        let units: Vec<u8> = [unit].into_iter().chain(others).collect();
        ask(&directory, &line_name(directory.path(), 1), 100, &units)?;
    }
    drop(fleet);
    Ok(())
}

/// A directory with two configurations.
fn prepared() -> Result<TempDir, Failed> {
    let directory = tempfile::tempdir()?;
    for (file, tracking) in
        [("configuration", paper_parameters()?), ("configuration.other", extended_parameters()?)]
    {
        let mut buffer = [0; UPLOAD_BYTES];
        let content = postcard::to_slice(&Configuration { version: VERSION, tracking }, &mut buffer)?;
        fs::write(directory.path().join(file), content)?;
    }
    Ok(directory)
}

/// Runs the clients against the first of these boards; the others are on the same line.
fn ask(directory: &TempDir, port: &Path, random_frames: u32, units: &[u8]) -> Result<(), Failed> {
    let ran = Command::new(std::env::var_os(VARIABLE).unwrap_or_default())
        .arg(source("bus/clients.py"))
        .args([port, &source("../docs/registers.csv"), &directory.path().join("configuration")])
        .arg(random_frames.to_string())
        .args(units.iter().map(u8::to_string))
        .output()?;
    let said = [ran.stdout, ran.stderr].map(|said| String::from_utf8_lossy(&said).into_owned()).concat();
    print!("{said}");
    if ran.status.success() { Ok(()) } else { Err(said.into()) }
}

fn source(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}
