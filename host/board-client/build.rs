//! Takes the firmware for the emulator into the program, where `cargo xtask firmware` has built it:
//! an installed `mgpi` then needs nothing beside it.
//!
//! That this file has changed is how `cargo xtask firmware` says that there is an image where there
//! was none.

use std::path::PathBuf;
use std::{env, fs};

/// Where the images are built, in the target directory.
const BUILT: &str = "firmware/thumbv7em-none-eabihf/firmware";
/// That of one muscle, and that of two at a joint.
const IMAGES: [&str; 2] = ["emulated", "emulated_joint"];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    for name in IMAGES {
        let built = |directory: &std::path::Path| directory.join(BUILT).join(name);
        let image = out.ancestors().map(built).find(|image| image.is_file());
        let code = image.map(|image| {
            println!("cargo::rerun-if-changed={}", image.display());
            format!("Some(include_bytes!({image:?}))")
        });
        let code = code.unwrap_or_else(|| "None".to_owned());
        fs::write(out.join(name).with_extension("rs"), code).expect("cargo has made the directory");
    }
}
