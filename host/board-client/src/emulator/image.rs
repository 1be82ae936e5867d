//! Where the firmware for the emulator is found: named, in the target directory, or in this
//! program.

use std::fs::File;
use std::io::{self, Write};
use std::ops::Deref;
use std::os::fd::AsRawFd;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// The environment variable that names it.
pub const VARIABLE: &str = "MGPI_FIRMWARE";
/// Where `cargo xtask firmware` puts it, in the target directory that this program was built in.
const BUILT: &str = "firmware/thumbv7em-none-eabihf/firmware/emulated";

/// The image that was built when this program was.
const BUILT_IN: Option<&[u8]> = include!(concat!(env!("OUT_DIR"), "/built_in.rs"));

/// No firmware.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum ImageError {
    #[error("{}: no such file; `cargo xtask firmware` builds the firmware", .0.display())]
    NotThere(PathBuf),
    #[error(
        "this program was built without firmware, and neither --firmware nor {VARIABLE} names one; `cargo xtask install`, in \
         the sources, installs mgpi with it"
    )]
    NotFound,
    #[error("the firmware in this program cannot be laid out for the emulator: {0}")]
    Unpacked(#[from] io::Error),
}

/// The firmware's ELF file, as long as this is kept.
#[derive(Debug)]
pub struct Image {
    path: PathBuf,
    /// An unnamed file, which goes with its descriptor however this program ends.
    _unpacked: Option<File>,
}

impl Deref for Image {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.path
    }
}

/// The firmware's ELF file: the named one, else that of the environment, else the one built beside
/// this program, else the one in this program.
///
/// # Errors
/// There is none.
pub fn find(named: Option<&Path>) -> Result<Image, ImageError> {
    let of_environment = || std::env::var_os(VARIABLE).map(PathBuf::from);
    let file = match named.map(Path::to_owned).or_else(of_environment) {
        Some(path) if !path.is_file() => return Err(ImageError::NotThere(path)),
        Some(path) => Some(path),
        None => beside(),
    };
    match (file, BUILT_IN) {
        (Some(path), _) => Ok(Image { path, _unpacked: None }),
        (None, Some(bytes)) => Ok(unpacked(bytes)?),
        (None, None) => Err(ImageError::NotFound),
    }
}

/// In the target directory that this program was built in.
fn beside() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    program.ancestors().map(|directory| directory.join(BUILT)).find(|path| path.is_file())
}

/// The image in a file that other programs can read.
fn unpacked(bytes: &[u8]) -> io::Result<Image> {
    let mut file = tempfile::tempfile()?;
    file.write_all(bytes)?;
    let path = format!("/proc/{}/fd/{}", std::process::id(), file.as_raw_fd()).into();
    Ok(Image { path, _unpacked: Some(file) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_in_this_program_is_a_file_for_others_that_leaves_nothing() {
        let image = unpacked(b"firmware").expect("unpacked");
        assert_eq!(std::fs::read(&*image).expect("readable"), b"firmware");
        let path = image.to_owned();
        drop(image);
        // Another test may have opened a file of its own by the same number since.
        assert!(std::fs::read(&path).map_or(true, |other| other != b"firmware"));
    }
}
