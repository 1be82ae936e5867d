//! A message as bytes and back: CDR (OMG, Common Data Representation), little-endian, behind the
//! four bytes that say so.

use byteorder::LittleEndian;
use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

/// Plain CDR, little-endian, no options (DDSI-RTPS 2.3, 10.2).
const HEAD: [u8; 4] = [0, 1, 0, 0];

/// Why bytes are no such message.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum BytesError {
    #[error("the message does not begin as CDR does, little-endian")]
    Head,
    #[error("the message is damaged or of another type: {0}")]
    Content(#[from] cdr_encoding::Error),
}

/// The bytes of a message.
///
/// # Errors
/// A text or a list is longer than 32 bits can count.
pub fn of<M: Serialize>(message: &M) -> Result<Vec<u8>, BytesError> {
    let content = cdr_encoding::to_vec::<M, LittleEndian>(message)?;
    Ok([&HEAD[..], &content].concat())
}

/// The message of bytes.
///
/// # Errors
/// They are of another type, of another encoding, or damaged.
pub fn read<M: DeserializeOwned>(bytes: &[u8]) -> Result<M, BytesError> {
    let content = bytes.strip_prefix(&HEAD).ok_or(BytesError::Head)?;
    let (message, _) = cdr_encoding::from_bytes::<M, LittleEndian>(content)?;
    Ok(message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::{Header, JointState};

    #[test]
    fn a_message_comes_back_as_it_was_and_its_numbers_are_aligned() {
        let state = JointState {
            header: Header::at_s(1.5),
            name: vec!["biceps".to_owned()],
            position: vec![0.01],
            ..JointState::default()
        };
        let bytes = of(&state).expect("short");
        // Stamp 8, empty text 4 + 1, filled to 16; a list of one text of 7 bytes; a list of one
        // number, aligned to 8 bytes; two empty lists.
        assert_eq!(&bytes[..12], [0, 1, 0, 0, 1, 0, 0, 0, 0x00, 0x65, 0xcd, 0x1d]);
        assert_eq!(bytes.len(), 4 + 16 + 4 + 4 + 7 + 1 + 4 + 4 + 8 + 4 + 4);
        assert_eq!(read::<JointState>(&bytes).expect("it was one"), state);
    }

    #[test]
    fn what_is_no_such_message_is_refused() {
        let bytes = of(&JointState::default()).expect("short");
        for cut in 0..bytes.len() {
            assert!(read::<JointState>(&bytes[..cut]).is_err(), "{cut}");
        }
        let mut big_endian = bytes;
        big_endian[1] = 0;
        assert!(matches!(read::<JointState>(&big_endian), Err(BytesError::Head)));
    }
}
