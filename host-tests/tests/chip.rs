//! The unmodified production image in a model of its chip: `host-tests/chip`, a test of Python's `unittest` each.
//!
//! Skipped, in so many words, where the model's Python or the firmware are missing; `cargo xtask test` provides both.

use std::path::{Path, PathBuf};
use std::process::Command;

use board_client::emulator::image;
use firmware::store::ParameterStore;
use host_tests::flash::MockFlash;
use host_tests::store::{numbered, paper_set};
use libtest_mimic::{Arguments, Conclusion, Failed, Trial};
use wire::State;

/// The environment variable that names a Python which has Unicorn.
const PYTHON: &str = "MGPI_CHIP_PYTHON";
/// The one by which the model finds the image.
const IMAGE: &str = "MGPI_CHIP_IMAGE";
/// The one by which it finds the contents of a flash whose next save erases.
const STORE: &str = "MGPI_CHIP_STORE";
/// Unit: byte.
const SECTOR: usize = 16 * 1024;
/// More than both sectors have room for.
const SETS: u32 = 200;

fn main() -> Result<(), Failed> {
    // Behind the end of `run`, which removes its temporary file.
    run()?.exit_if_failed();
    Ok(())
}

fn run() -> Result<Conclusion, Failed> {
    let store = tempfile::NamedTempFile::new()?;
    std::fs::write(&store, full_store()?)?;
    let trials = match names() {
        Ok(names) => names.into_iter().map(|name| trial(name, store.path().to_owned())).collect(),
        Err(reason) => {
            println!("the tests of the chip are skipped: {reason}");
            vec![
                Trial::test("the_production_image_in_the_model_of_its_chip", || Ok(()))
                    .with_ignored_flag(true),
            ]
        }
    };
    Ok(libtest_mimic::run(&Arguments::from_args(), trials))
}

/// Sectors that are both full, and so erased by the next save.
fn full_store() -> Result<Vec<u8>, Failed> {
    let mut store = ParameterStore::new(MockFlash::<SECTOR>::blank());
    let mut full = None;
    for number in 1001..1001 + SETS {
        let before = store.flash().bytes().to_vec();
        store.save(State::Ready, &numbered(number, paper_set())).map_err(|error| format!("{error:?}"))?;
        let cleared =
            before.iter().zip(store.flash().bytes()).any(|(before, after)| *before == 0 && *after != 0);
        full = if cleared { Some(before) } else { full };
    }
    full.ok_or_else(|| "the sectors are never full".into())
}

/// The tests, as the model's own list tells; or what is missing for them.
fn names() -> Result<Vec<String>, String> {
    if std::env::var_os(PYTHON).is_none() {
        return Err(format!("{PYTHON} names no Python with unicorn; `cargo xtask test` makes one"));
    }
    if !image_file().is_file() {
        return Err(format!("no {}; `cargo xtask firmware` builds it", image_file().display()));
    }
    let listed = python().arg("names.py").output().map_err(|error| error.to_string())?;
    if !listed.status.success() {
        return Err(String::from_utf8_lossy(&listed.stderr).into_owned());
    }
    Ok(String::from_utf8_lossy(&listed.stdout).lines().map(str::to_owned).collect())
}

fn trial(name: String, store: PathBuf) -> Trial {
    let shown = name.replace("test_", "").replace('.', "::");
    Trial::test(shown, move || {
        let ran = python().env(STORE, &store).args(["-m", "unittest", "-q", &name]).output()?;
        let said = String::from_utf8_lossy(&ran.stderr).into_owned();
        if ran.status.success() { Ok(()) } else { Err(Failed::from(said)) }
    })
}

fn python() -> Command {
    let mut command = Command::new(std::env::var_os(PYTHON).unwrap_or_default());
    command.current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("chip"));
    command.env(IMAGE, image_file()).env("PYTHONDONTWRITEBYTECODE", "1");
    command
}

/// The production image, beside that for the emulator.
fn image_file() -> PathBuf {
    image::find(None).map(|image| image.with_file_name("stm32f405")).unwrap_or_default()
}
