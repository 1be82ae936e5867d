//! Where the firmware for the emulator is found.

use std::path::{Path, PathBuf};

use thiserror::Error;

/// The environment variable that names it.
pub const VARIABLE: &str = "MGPI_FIRMWARE";
/// Where `cargo xtask firmware` puts it, in the target directory that this program was built in.
const BUILT: &str = "firmware/thumbv7em-none-eabihf/firmware/emulated";

/// No firmware.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum ImageError {
    #[error("{}: no such file; `cargo xtask firmware` builds the firmware", .0.display())]
    NotThere(PathBuf),
    #[error(
        "no firmware: neither --firmware nor {VARIABLE} names it, and the directories above {} have no {BUILT}; \
         `cargo xtask firmware` builds it",
        .0.display()
    )]
    NotFound(PathBuf),
}

/// The firmware's ELF file: the named one, else that of the environment, else the one built beside this program.
///
/// # Errors
/// There is no such file.
pub fn find(named: Option<&Path>) -> Result<PathBuf, ImageError> {
    let of_environment = || std::env::var_os(VARIABLE).map(PathBuf::from);
    match named.map(Path::to_owned).or_else(of_environment) {
        Some(path) if path.is_file() => Ok(path),
        Some(path) => Err(ImageError::NotThere(path)),
        None => {
            let program = std::env::current_exe().unwrap_or_default();
            let built =
                program.ancestors().map(|directory| directory.join(BUILT)).find(|path| path.is_file());
            built.ok_or(ImageError::NotFound(program))
        }
    }
}
