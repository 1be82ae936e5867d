//! A number by which two sides tell whether they have the same value.

use postcard::ser_flavors::Flavor;
use serde::Serialize;

use crate::registers::CRC;

/// The CRC-32 (ISO-HDLC) of a value's bytes, as a message has them; none of them is kept.
pub fn fingerprint(value: &impl Serialize) -> u32 {
    let mut serializer = postcard::Serializer { output: Digest(CRC.digest()) };
    // Only a buffer could be full, or a sequence of unknown length be there: no message has one.
    let _ = value.serialize(&mut serializer);
    serializer.output.0.finalize()
}

/// Where the bytes go.
struct Digest(crc::Digest<'static, u32>);

impl Flavor for Digest {
    type Output = ();

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.0.update(&[byte]);
        Ok(())
    }

    fn finalize(self) -> postcard::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registers::checksum;

    #[test]
    fn a_fingerprint_is_the_checksum_of_the_bytes_and_another_for_another_value() {
        let mut buffer = [0; 64];
        let value = (1.5_f32, Some(300_u32), [None, Some(2.0_f32)]);
        let bytes = postcard::to_slice(&value, &mut buffer).expect("fits");
        assert_eq!(fingerprint(&value), checksum(bytes));
        assert_ne!(fingerprint(&value), fingerprint(&(1.5_f32, Some(300_u32), [Some(2.0_f32), None])));
    }
}
