//! The emulated firmware against the same control code on the host: bit for bit.
//!
//! Skipped, in so many words, where emulator or firmware are missing; `cargo xtask test` provides both.

use std::process::Command;

use host_tests::{HostBoard, configuration, raised_cosines, rig, run};
use libtest_mimic::{Arguments, Failed, Trial};
use model_core::{Mode, paper};
use workbench::child::Stop;
use workbench::emulator::{Emulator, image};
use workbench::pil::results::log;

fn main() {
    let missing = missing();
    if let Some(reason) = &missing {
        println!("the tests of the emulated firmware are skipped: {reason}");
    }
    let trial = |name: &str, test: fn() -> Result<(), Failed>| {
        Trial::test(name, test).with_ignored_flag(missing.is_some())
    };
    let trials = vec![
        trial("the_emulated_firmware_logs_the_hosts_run_bit_for_bit_in_every_mode", bit_for_bit),
        trial("the_emulated_firmware_repeats_itself_bit_for_bit", repeatable),
    ];
    libtest_mimic::run(&Arguments::from_args(), trials).exit()
}

/// What is missing for these tests.
fn missing() -> Option<String> {
    if Command::new("qemu-system-arm").arg("--version").output().is_err() {
        return Some("no qemu-system-arm; `cargo xtask setup` installs it".to_owned());
    }
    image::find(None).err().map(|error| error.to_string())
}

/// The log of a run of the paper's model on the rig: three seconds up and down, in every kind of arithmetic that
/// the tick has.
fn emulated_log(mode: Mode, reference_mm: &[f64]) -> Result<String, Failed> {
    let mut board = Emulator::start(&image::find(None)?, &Stop::default())?;
    let configuration = configuration(&paper::mgpi()?);
    Ok(log(&run(&mut board, &mut rig(3), &configuration, mode, reference_mm)?))
}

/// 8 s that reach both ends of the range and turn in between.
fn reference_mm() -> Vec<f64> {
    raised_cosines(0.0, &[140.0])
        .into_iter()
        .step_by(6)
        .chain((0..4000).map(|k| f64::from(k % 700) / 5.0))
        .collect()
}

fn bit_for_bit() -> Result<(), Failed> {
    let reference_mm = reference_mm();
    let configuration = configuration(&paper::mgpi()?);
    for mode in [Mode::Both, Mode::FeedforwardOnly, Mode::FeedbackOnly] {
        let host = run(&mut HostBoard::default(), &mut rig(3), &configuration, mode, &reference_mm)?;
        let (host, emulated) = (log(&host), emulated_log(mode, &reference_mm)?);
        if let Some((row, (host, emulated))) =
            host.lines().zip(emulated.lines()).enumerate().find(|(_, (host, emulated))| host != emulated)
        {
            return Err(format!("{mode:?}, row {row}: host {host}, emulated {emulated}").into());
        }
        if host.len() != emulated.len() {
            return Err(format!("{mode:?}: the logs differ in length").into());
        }
    }
    Ok(())
}

fn repeatable() -> Result<(), Failed> {
    let reference_mm = reference_mm();
    let (one, other) = (emulated_log(Mode::Both, &reference_mm)?, emulated_log(Mode::Both, &reference_mm)?);
    if one == other { Ok(()) } else { Err("two runs of the emulator differ".into()) }
}
