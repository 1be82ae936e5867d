//! Building the firmware. It has a target directory of its own: the compiler for the board may be
//! another one than the host's, and in one directory the two would rebuild each other's work.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::SystemTime;

use anyhow::{Context, Result};
use packing::{package, read_key, seal};

use crate::board_compiler::{BoardCompiler, TARGET};
use crate::run;

/// The production image, for both places of the flash, and the name of that for a coil.
const PRODUCTION: &str = "stm32f405";
const OTHER_PLACE: &str = "stm32f405_b";
const OF_COIL: &str = "stm32f405_coil";
/// The production image of two channels at a joint, which has the same starter.
const OF_JOINT: &str = "stm32f405_joint";
/// The key that images are signed with where nobody says another: everybody has it.
const TEST_KEY: &str = "firmware/keys/tests-only.key";
/// What the images are built from.
const SOURCES: [&str; 7] =
    ["firmware", "wire", "model-core", "Cargo.toml", "Cargo.lock", "memory.x", ".cargo/config.toml"];

/// Builds the images, with the key of the tests.
///
/// # Errors
/// When cargo fails.
pub fn build(compiler: &BoardCompiler) -> Result<()> {
    build_for(compiler, None)
}

/// Builds the images. `key`: that by whose images they let themselves be replaced.
///
/// # Errors
/// When cargo fails, or there is no such key.
pub fn build_for(compiler: &BoardCompiler, key: Option<&Path>) -> Result<()> {
    let had_images = ["emulated", "emulated_joint"].iter().all(|image| elf(image).exists());
    let public = key.map(read_key).transpose()?.map(|(_, public)| public);
    run::step("firmware", || {
        build_with(compiler, "emulated,emulated_joint,stm32f405,stm32f405_joint,bring_up", public.as_deref())
    })?;
    if !had_images {
        // `mgpi` takes the images in, and cannot watch files that are not there.
        let script = run::root().join("host/board-client/build.rs");
        File::options().append(true).open(script)?.set_modified(SystemTime::now())?;
    }
    Ok(())
}

/// Builds the production image for a board with a coil, which tests of the chip need. Before the
/// others: it has the name of that for a regulator until it has its own.
///
/// # Errors
/// When cargo fails.
pub fn build_for_coil(compiler: &BoardCompiler) -> Result<()> {
    run::step("firmware for a coil", || {
        let mut cargo = command(compiler, &format!("{PRODUCTION},solenoid"), None);
        run::succeed(cargo.args(["--bin", PRODUCTION, "--bin", "starter"]))?;
        seal(&elf(PRODUCTION))?;
        Ok(fs::rename(elf(PRODUCTION), elf(OF_COIL))?)
    })
}

/// Builds the images, and packs them for `mgpi update`.
///
/// # Errors
/// When cargo fails, there is no such key, or the package cannot be written.
pub fn pack(compiler: &BoardCompiler, key: Option<&Path>, output: &Path) -> Result<()> {
    build_for(compiler, key)?;
    let (signer, _) = read_key(&key_file(key))?;
    let [a, b] = [PRODUCTION, OTHER_PLACE].map(elf);
    let bytes = package([&a, &b], &signer)?.to_bytes();
    fs::write(output, &bytes).with_context(|| format!("cannot write {}", output.display()))?;
    println!("{}: {} bytes, for both places", output.display(), bytes.len());
    if key.is_none() {
        println!(
            "signed with the key of the tests, which everybody has: cargo xtask key makes one of your own"
        );
    }
    Ok(())
}

fn key_file(key: Option<&Path>) -> PathBuf {
    key.map_or_else(|| run::root().join(TEST_KEY), Path::to_owned)
}

/// Builds the images that need no more than these features of the package.
///
/// # Errors
/// When cargo fails.
pub fn build_images(compiler: &BoardCompiler, features: &str) -> Result<()> {
    build_with(compiler, features, None)
}

/// The same with the public half of a key, that of the tests where there is none.
fn build_with(compiler: &BoardCompiler, features: &str, key: Option<&str>) -> Result<()> {
    run::succeed(command(compiler, features, key).arg("--bins"))?;
    let sealed = |feature| match feature {
        PRODUCTION => [Some(PRODUCTION), Some(OTHER_PLACE)],
        OF_JOINT => [Some(OF_JOINT), None],
        _ => [None; 2],
    };
    features.split(',').flat_map(sealed).flatten().try_for_each(|image| seal(&elf(image)))
}

/// What builds images; those that are meant are still to be said.
fn command(compiler: &BoardCompiler, features: &str, key: Option<&str>) -> Command {
    let mut cargo = run::cargo(&["build", "--package", "images", "--profile", "firmware"]);
    cargo.args(["--features", features, "--target", TARGET]);
    cargo.arg("--target-dir").arg(run::target_dir().join("firmware"));
    compiler.apply(&mut cargo);
    cargo.env("MGPI_SOURCE", source());
    key.into_iter().for_each(|key| {
        cargo.env("MGPI_UPDATE_KEY", key);
    });
    cargo
}

/// The git commit that last changed what the images are built from, with a `+` behind it where the
/// files differ from that; empty where that is not known. Other commits leave the images as they
/// are.
fn source() -> String {
    let git = |arguments: &[&str]| {
        let root = run::root().display().to_string();
        run::output("git", &[&["-C", &root], arguments, &["--"], &SOURCES].concat())
    };
    let commit = git(&["log", "-1", "--format=%H"]).unwrap_or_default();
    let is_modified = git(&["status", "--porcelain"]).is_some_and(|changed| !changed.is_empty());
    if is_modified && !commit.is_empty() { commit + "+" } else { commit }
}

/// The ELF file of the image for the emulator.
pub fn emulated_elf() -> PathBuf {
    elf("emulated")
}

/// The ELF file of an image.
pub fn elf(image: &str) -> PathBuf {
    run::target_dir().join("firmware").join(TARGET).join("firmware").join(image)
}
