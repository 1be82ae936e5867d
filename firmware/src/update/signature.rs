//! Who may make images for this board: whoever has the private half of the key that its firmware
//! was built with.

use ed25519_dalek::{Signature, VerifyingKey};
use sha2::{Digest, Sha256};
use wire::image::{SIGNATURE_BYTES, signed};

/// The public half, 64 hexadecimal digits: that of a laboratory, or that of the tests, whose
/// private half everybody has.
const KEY: [u8; 32] = match option_env!("MGPI_UPDATE_KEY") {
    Some(digits) => key(digits),
    None => key(include_str!("../../keys/tests-only.pub")),
};

/// Whether the signature is that of the image.
#[inline(never)]
pub fn is_signed(image: &[u8], signature: &[u8; SIGNATURE_BYTES]) -> bool {
    let message = signed(Sha256::digest(image).into());
    let signature = Signature::from_bytes(signature);
    VerifyingKey::from_bytes(&KEY).is_ok_and(|key| key.verify_strict(&message, &signature).is_ok())
}

/// Reads hexadecimal digits; what is behind them does not count.
#[allow(clippy::panic, reason = "at compile time only")]
const fn key(digits: &str) -> [u8; 32] {
    let (mut digits, mut key, mut place) = (digits.as_bytes(), [0; 32], 0);
    while place < 64 {
        let value = match digits {
            [digit @ b'0'..=b'9', ..] => *digit - b'0',
            [digit @ b'a'..=b'f', ..] => *digit - b'a' + 10,
            _ => panic!("the key for updates is no 64 hexadecimal digits, in lower case"),
        };
        #[allow(clippy::indexing_slicing, reason = "place is below 64; at compile time only")]
        {
            key[place / 2] = key[place / 2] << 4 | value;
        }
        place += 1;
        (_, digits) = digits.split_at(1);
    }
    key
}
