//! Keys and signatures. A key is 32 bytes in 64 hexadecimal digits, in a file that only its owner
//! reads; beside it, in `.pub`, stands its public half, which the firmware is built with.

use std::fs::{self, File, OpenOptions};
use std::io::{Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use board_client::update::Package;
use ed25519_dalek::{Signer, SigningKey};
use sha2::{Digest, Sha256};
use wire::image::{HEAD_WORDS, Head, Linked, Place, signed};

use crate::seal::{checksum, flat, put};

/// Bytes of a small image, and where its code is.
const SMALL: usize = 0x400;
const CODE: usize = 0x300;

/// Makes a key, and writes both halves.
///
/// # Errors
/// One of the files is there already, or cannot be written.
pub fn new_key(file: &Path) -> Result<PathBuf> {
    let public = public_file(file);
    let mut seed = [0; 32];
    File::open("/dev/urandom").and_then(|mut source| source.read_exact(&mut seed)).context("no chance")?;
    ensure!(!public.exists(), "{} is there already", public.display());
    let mut private = OpenOptions::new();
    let private = private.write(true).create_new(true).mode(0o600).open(file);
    let mut private = private.with_context(|| format!("cannot make {}", file.display()))?;
    writeln!(private, "{}", digits(&seed))?;
    fs::write(&public, digits(SigningKey::from_bytes(&seed).verifying_key().as_bytes()) + "\n")?;
    Ok(public)
}

/// Where the public half of a key stands.
fn public_file(file: &Path) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(".pub");
    name.into()
}

/// A key, and its public half in digits, as the firmware is built with it.
///
/// # Errors
/// The file holds none.
pub fn read_key(file: &Path) -> Result<(SigningKey, String)> {
    let text = fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
    let seed =
        bytes(text.trim()).with_context(|| format!("{}: not 64 hexadecimal digits", file.display()))?;
    let key = SigningKey::from_bytes(&seed);
    let public = digits(key.verifying_key().as_bytes());
    Ok((key, public))
}

/// Both images, signed, as `mgpi update` takes them. `elves`: that for the place A, and for B.
///
/// # Errors
/// A file is no image.
pub fn package(elves: [&Path; 2], key: &SigningKey) -> Result<Package> {
    let [a, b] = elves.map(|elf| flat(elf).map(|(_, image)| with_signature(image, key)));
    Ok(Package { images: [a?, b?] })
}

/// An image, with its signature behind it.
fn with_signature(image: Vec<u8>, key: &SigningKey) -> Vec<u8> {
    let message = signed(Sha256::digest(&image).into());
    [image, key.sign(&message).to_bytes().to_vec()].concat()
}

/// What an image is linked with.
///
/// # Errors
/// The file is no image.
pub fn linked(elf: &Path) -> Result<Linked> {
    Ok(Head::of(&flat(elf)?.1).context("the image has no head")?.linked)
}

/// A program of a few instructions as an image, with its signature behind it: for tests.
///
/// # Errors
/// It is longer than there is room for.
pub fn small(place: Place, linked: &Linked, key: &SigningKey, code: &[u8]) -> Result<Vec<u8>> {
    ensure!(code.len() <= SMALL - CODE, "{} bytes of code", code.len());
    let begin = place.begin();
    let mut image = vec![0xFF; SMALL];
    // The begin of the stack, of memory.x, and the address of the code, in Thumb.
    image[..4].copy_from_slice(&0x2001_5000_u32.to_le_bytes());
    image[4..8].copy_from_slice(&(begin + CODE as u32 + 1).to_le_bytes());
    image[CODE..CODE + code.len()].copy_from_slice(code);
    let ranges = [[begin, 8], [begin + CODE as u32, code.len() as u32], [begin, 0], [begin, 0]];
    put(&mut image, 0, &[&linked.words()[..], &Head::sealed([begin, SMALL as u32], ranges)].concat());
    let sum = checksum(&image, begin)?;
    put(&mut image, HEAD_WORDS - 1, &[sum]);
    Ok(with_signature(image, key))
}

fn digits(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn bytes(digits: &str) -> Option<[u8; 32]> {
    let is_whole = digits.len() == 64 && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    let mut bytes = [0; 32];
    for (place, byte) in bytes.iter_mut().enumerate() {
        *byte = u8::from_str_radix(digits.get(2 * place..2 * place + 2)?, 16).ok()?;
    }
    is_whole.then_some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_read_as_it_was_made_is_its_owners_alone_and_replaces_none() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("own.key");
        let public = new_key(&file).unwrap();
        let (_, digits) = read_key(&file).unwrap();
        assert_eq!(fs::read_to_string(&public).unwrap().trim(), digits);
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
        assert!(new_key(&file).is_err());
        fs::remove_file(&file).unwrap();
        assert!(new_key(&file).is_err(), "the public half of another key is replaced");
        assert!(!file.exists());
    }
}
