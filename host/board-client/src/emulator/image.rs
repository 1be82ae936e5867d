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
/// Where `cargo xtask firmware` puts them, in the target directory that this program was built in.
const BUILT: &str = "firmware/thumbv7em-none-eabihf/firmware";

/// The images that were built when this program was.
const BUILT_IN: Option<&[u8]> = include!(concat!(env!("OUT_DIR"), "/emulated.rs"));
const BUILT_IN_FOR_JOINT: Option<&[u8]> = include!(concat!(env!("OUT_DIR"), "/emulated_joint.rs"));

/// Which firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// Of one muscle.
    Muscle,
    /// Of two at a joint.
    Joint,
}

impl Which {
    const fn name(self) -> &'static str {
        match self {
            Self::Muscle => "emulated",
            Self::Joint => "emulated_joint",
        }
    }
}

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
    find_which(Which::Muscle, named)
}

/// The same of a kind of firmware. The environment names that of one muscle; that of a joint is
/// looked for beside it.
///
/// # Errors
/// No such firmware is found.
pub fn find_which(which: Which, named: Option<&Path>) -> Result<Image, ImageError> {
    let of_environment = || {
        let path = std::env::var_os(VARIABLE).map(PathBuf::from)?;
        Some(if which == Which::Muscle { path } else { path.with_file_name(which.name()) })
    };
    let built_in = if which == Which::Muscle { BUILT_IN } else { BUILT_IN_FOR_JOINT };
    let file = match named.map(Path::to_owned).or_else(of_environment) {
        Some(path) if !path.is_file() => return Err(ImageError::NotThere(path)),
        Some(path) => Some(path),
        None => beside(which),
    };
    match (file, built_in) {
        (Some(path), _) => Ok(Image { path, _unpacked: None }),
        (None, Some(bytes)) => Ok(unpacked(bytes)?),
        (None, None) => Err(ImageError::NotFound),
    }
}

/// In the target directory that this program was built in.
fn beside(which: Which) -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    let image = |directory: &Path| directory.join(BUILT).join(which.name());
    program.ancestors().map(image).find(|path| path.is_file())
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
