//! Modbus clients that others have written, against the emulated board in real time:
//! `host-tests/bus/clients.py`.
//!
//! Skipped, in so many words, where emulator, firmware or clients are missing; `cargo xtask test`
//! provides them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;

use board_client::emulator::line::Line;
use board_client::emulator::{Emulator, image, real_time};
use board_client::pil::lock_step::protect;
use board_client::stop::Stop;
use board_models::{extended_parameters, paper_parameters};
use host_tests::rig;
use libtest_mimic::{Arguments, Failed, Trial};
use wire::registers::UPLOAD_BYTES;
use wire::{Configuration, Protection, VERSION};

/// The environment variable that names the Python which has the clients.
const VARIABLE: &str = "MGPI_BUS_PYTHON";

fn main() {
    let missing = missing();
    if let Some(reason) = &missing {
        println!("the tests with Modbus clients are skipped: {reason}");
    }
    let trials = vec![
        Trial::test("pymodbus_and_mbpoll_read_write_and_are_refused_as_documented", clients)
            .with_ignored_flag(missing.is_some()),
    ];
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

fn clients() -> Result<(), Failed> {
    let directory = tempfile::tempdir()?;
    let (port, configuration) = (directory.path().join("port"), directory.path().join("configuration"));
    for (file, tracking) in [
        (configuration.clone(), paper_parameters()?),
        (directory.path().join("configuration.other"), extended_parameters()?),
    ] {
        let mut buffer = [0; UPLOAD_BYTES];
        fs::write(file, postcard::to_slice(&Configuration { version: VERSION, tracking }, &mut buffer)?)?;
    }
    let stop = Stop::default();
    let (mut board, bus) = Emulator::start_with_bus(&image::find(None)?, &stop)?;
    // The clients are silent for longer than a board with a muscle bears.
    protect(&mut board, Protection::SIMULATED)?;
    let _line = Line::open(&port, bus)?;
    thread::scope(|scope| {
        let running =
            scope.spawn(|| real_time::run(&mut board, &mut rig(3), &stop, |late| println!("{late:?} late")));
        let ran = Command::new(std::env::var_os(VARIABLE).unwrap_or_default())
            .arg(source("bus/clients.py"))
            .args([&port, &source("../docs/registers.csv"), &configuration])
            .output();
        stop.request();
        // A request to stop may come in the middle of a tick.
        let ended = running.join();
        let ran = ran?;
        let said = [ran.stdout, ran.stderr].map(|said| String::from_utf8_lossy(&said).into_owned()).concat();
        print!("{said}");
        match (ran.status.success(), ended) {
            (true, Ok(Ok(()) | Err(board_client::pil::PilError::Stopped))) => Ok(()),
            (true, ended) => Err(format!("the board: {ended:?}").into()),
            (false, _) => Err(said.into()),
        }
    })
}

fn source(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}
