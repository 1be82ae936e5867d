//! The file of an update: both images, that for the place A and that for B, each with its signature
//! behind it.
//!
//! ```text
//! "MGPI-IMG"   length of A (u32, little-endian)   A   length of B   B
//! ```

use std::path::{Path, PathBuf};
use std::{fs, io};

use thiserror::Error;
use wire::image::{Head, Place, SIGNATURE_BYTES};

const MAGIC: &[u8; 8] = b"MGPI-IMG";

/// Both images, as they stand in the flash, with their signatures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Package {
    /// That for the place A, and for B.
    pub images: [Vec<u8>; 2],
}

/// Why a file is no update.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum PackageError {
    #[error("{}: {problem}", file.display())]
    Io { file: PathBuf, problem: io::Error },
    #[error("{}: is not a file of `cargo xtask image`: it does not begin with MGPI-IMG", .0.display())]
    Other(PathBuf),
    #[error("{}, byte {at}: an image of {bytes} bytes, {left} are left: the file is cut off, or has something behind it", file.display())]
    Length { file: PathBuf, at: usize, bytes: usize, left: usize },
    #[error("{}, byte {at}: no image for the place {place:?}", file.display())]
    Image { file: PathBuf, at: usize, place: Place },
}

impl Package {
    /// Reads it.
    ///
    /// # Errors
    /// It cannot be read, or is something else.
    pub fn read(file: &Path) -> Result<Self, PackageError> {
        let problem = |problem| PackageError::Io { file: file.to_owned(), problem };
        Self::of_bytes(&fs::read(file).map_err(problem)?, file)
    }

    fn of_bytes(bytes: &[u8], file: &Path) -> Result<Self, PackageError> {
        let mut left = bytes.strip_prefix(MAGIC).ok_or_else(|| PackageError::Other(file.to_owned()))?;
        let mut images = [vec![], vec![]];
        for (place, image) in Place::BOTH.into_iter().zip(&mut images) {
            let at = bytes.len() - left.len();
            let (length, behind) = left.split_first_chunk().unwrap_or((&[0xFF; 4], &[]));
            let length = u32::from_le_bytes(*length) as usize;
            let cut =
                || PackageError::Length { file: file.to_owned(), at, bytes: length, left: behind.len() };
            let (content, behind) = behind.split_at_checked(length).ok_or_else(cut)?;
            let is_whole = Head::of(content).is_some_and(|head| {
                head.place == [place.begin(), (length - SIGNATURE_BYTES.min(length)) as u32]
            });
            if !is_whole || length > place.bytes() as usize || !length.is_multiple_of(4) {
                return Err(PackageError::Image { file: file.to_owned(), at: at + 4, place });
            }
            (*image, left) = (content.to_vec(), behind);
        }
        if left.is_empty() {
            return Ok(Self { images });
        }
        Err(PackageError::Length {
            file: file.to_owned(),
            at: bytes.len() - left.len(),
            bytes: 0,
            left: left.len(),
        })
    }

    /// As it stands in a file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        for image in &self.images {
            bytes.extend((image.len() as u32).to_le_bytes());
            bytes.extend(image);
        }
        bytes
    }

    /// The image for a place.
    pub fn image(&self, place: Place) -> &[u8] {
        let [a, b] = &self.images;
        match place {
            Place::A => a,
            Place::B => b,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wire::image::{HEAD_OFFSET, Linked, RANGES};

    fn image(place: Place) -> Vec<u8> {
        let linked = Linked {
            kind: 1,
            revisions: [0, 1],
            release: [0, 1, 0],
            wire: 9,
            layout: 5,
            is_modified: false,
            commit: [0; 10],
        };
        let mut image = vec![0xFF; 0x400 + SIGNATURE_BYTES];
        let words = [&linked.words()[..], &Head::sealed([place.begin(), 0x400], [[0; 2]; RANGES])].concat();
        for (index, word) in words.iter().enumerate() {
            image[HEAD_OFFSET + 4 * index..][..4].copy_from_slice(&word.to_le_bytes());
        }
        image
    }

    #[test]
    fn a_package_is_read_as_written_and_nothing_else_is() {
        let package = Package { images: Place::BOTH.map(image) };
        let (bytes, file) = (package.to_bytes(), Path::new("x.mgpi-image"));
        assert_eq!(Package::of_bytes(&bytes, file).unwrap(), package);
        for length in 0..bytes.len() {
            assert!(Package::of_bytes(&bytes[..length], file).is_err(), "{length} bytes");
        }
        assert!(Package::of_bytes(&[&bytes[..], &[0]].concat(), file).is_err());
        let swapped = Package { images: [image(Place::B), image(Place::A)] };
        assert!(matches!(Package::of_bytes(&swapped.to_bytes(), file), Err(PackageError::Image { .. })));
    }
}
