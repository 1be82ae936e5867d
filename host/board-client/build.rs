//! Takes the firmware for the emulator into the program, where `cargo xtask firmware` has built it:
//! an installed `mgpi` then needs nothing beside it.
//!
//! That this file has changed is how `cargo xtask firmware` says that there is an image where there
//! was none.

use std::path::PathBuf;
use std::{env, fs};

/// Where the image is built, in the target directory.
const BUILT: &str = "firmware/thumbv7em-none-eabihf/firmware/emulated";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    let image = out.ancestors().map(|directory| directory.join(BUILT)).find(|image| image.is_file());
    let code = image.map(|image| {
        println!("cargo::rerun-if-changed={}", image.display());
        format!("Some(include_bytes!({image:?}))")
    });
    let code = code.unwrap_or_else(|| "None".to_owned());
    fs::write(out.join("built_in.rs"), code).expect("cargo has made the directory");
}
