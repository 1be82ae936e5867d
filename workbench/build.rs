//! Takes the firmware for the emulator into the program, where `cargo xtask firmware` has built it: an installed `mgpi` then needs
//! nothing beside it.

use std::path::{Path, PathBuf};
use std::{env, fs};

/// Names the image. `cargo xtask install` sets it, so that what is known from an earlier build does not count.
const VARIABLE: &str = "MGPI_BUILT_IN_FIRMWARE";
/// Where the image is built, in the target directory.
const BUILT: &str = "firmware/thumbv7em-none-eabihf/firmware/emulated";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed={VARIABLE}");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    let named = env::var_os(VARIABLE).map(PathBuf::from);
    let image = named.or_else(|| built(&out)).map(|image| {
        println!("cargo::rerun-if-changed={}", image.display());
        format!("Some(include_bytes!({image:?}))")
    });
    let code = image.unwrap_or_else(|| "None".to_owned());
    fs::write(out.join("built_in.rs"), code).expect("cargo has made the directory");
}

/// The image in the target directory that this is built in.
fn built(out: &Path) -> Option<PathBuf> {
    out.ancestors().map(|directory| directory.join(BUILT)).find(|image| image.is_file())
}
