//! Building the firmware. It has a target directory of its own: the compiler for the board may be
//! another one than the host's, and in one directory the two would rebuild each other's work.

use std::fs::File;
use std::path::PathBuf;
use std::time::SystemTime;

use anyhow::Result;

use crate::board_compiler::{BoardCompiler, TARGET};
use crate::run;
use crate::seal::seal;

/// The image that looks at its own checksum.
const PRODUCTION: &str = "stm32f405";
/// What the images are built from.
const SOURCES: [&str; 7] =
    ["firmware", "wire", "model-core", "Cargo.toml", "Cargo.lock", "memory.x", ".cargo/config.toml"];

/// Builds both images.
///
/// # Errors
/// When cargo fails.
pub fn build(compiler: &BoardCompiler) -> Result<()> {
    let had_image = emulated_elf().exists();
    run::step("firmware", || build_images(compiler, "emulated,stm32f405"))?;
    if !had_image {
        // `mgpi` takes the image in, and cannot watch a file that is not there.
        let script = run::root().join("host/board-client/build.rs");
        File::options().append(true).open(script)?.set_modified(SystemTime::now())?;
    }
    Ok(())
}

/// Builds the images that need no more than these features of the package.
///
/// # Errors
/// When cargo fails.
pub fn build_images(compiler: &BoardCompiler, features: &str) -> Result<()> {
    let mut cargo = run::cargo(&["build", "--package", "images", "--profile", "firmware", "--bins"]);
    cargo.args(["--features", features, "--target", TARGET]);
    cargo.arg("--target-dir").arg(run::target_dir().join("firmware"));
    compiler.apply(&mut cargo);
    cargo.env("MGPI_SOURCE", source());
    run::succeed(&mut cargo)?;
    if features.split(',').any(|feature| feature == PRODUCTION) { seal(&elf(PRODUCTION)) } else { Ok(()) }
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
