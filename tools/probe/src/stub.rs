//! The emulator's debug stub, by the remote serial protocol of GDB, as far as it is needed.
//!
//! A packet is `$`, text, `#` and two hexadecimal digits of the sum of the text's bytes.
//! Acknowledgements are left out: the connection loses nothing, and the stub takes the next packet
//! for one. Requests may be sent in one go; a byte that is sent while the processor runs would stop
//! it, so that none is.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;

use anyhow::{Context, Result, bail, ensure};

/// The number of a register in the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Register {
    /// The first result.
    R0 = 0,
    /// The second half of a result of two words.
    R1 = 1,
    /// Free for a function to use.
    R2 = 2,
    /// As R2.
    R3 = 3,
    /// The next instruction.
    Pc = 15,
}

/// A stopped processor.
pub struct Stub {
    connection: UnixStream,
    received: Vec<u8>,
}

impl Stub {
    /// Takes a connection to a processor that does not run yet.
    ///
    /// # Errors
    /// The stub does not answer.
    pub fn connect(connection: UnixStream) -> Result<Self> {
        let mut stub = Self { connection, received: Vec::new() };
        // Without having been asked for them, the stub gives no registers away.
        stub.ask("qXfer:features:read:target.xml:0,ffb")?;
        Ok(stub)
    }

    /// Stops before the instruction at an address, whenever it is reached.
    ///
    /// # Errors
    /// The stub refuses.
    pub fn break_at(&mut self, address: u32) -> Result<()> {
        self.command(&format!("Z0,{address:x},2"))
    }

    /// Sets registers and lets the processor run until it stops.
    ///
    /// # Errors
    /// The stub refuses, or the processor does not stop at a breakpoint.
    pub fn resume(&mut self, registers: &[(Register, u32)]) -> Result<()> {
        let set = |&(register, value): &(Register, u32)| {
            packet(&format!("P{:x}={}", register as u8, digits_of(&value.to_le_bytes())))
        };
        let packets: String = registers.iter().map(set).chain([packet("c")]).collect();
        self.connection.write_all(packets.as_bytes())?;
        for _ in registers {
            let answer = self.answer()?;
            ensure!(answer == "OK", "a register is refused: {answer}");
        }
        let stop = self.answer()?;
        ensure!(stop.starts_with("T05") || stop.starts_with("S05"), "stopped by {stop}");
        Ok(())
    }

    /// Memory.
    ///
    /// # Errors
    /// The stub does not tell.
    pub fn read(&mut self, address: u32, length: u32) -> Result<Vec<u8>> {
        let mut memory = Vec::new();
        for offset in (0..length).step_by(CHUNK) {
            let size = (length - offset).min(CHUNK as u32);
            let answer = self.ask(&format!("m{:x},{size:x}", address + offset))?;
            memory.extend(bytes_of(&answer).with_context(|| format!("no memory: {answer}"))?);
        }
        Ok(memory)
    }

    /// Writes memory.
    ///
    /// # Errors
    /// The stub refuses.
    pub fn write(&mut self, address: u32, memory: &[u8]) -> Result<()> {
        for (place, chunk) in (address..).step_by(CHUNK).zip(memory.chunks(CHUNK)) {
            self.command(&format!("M{place:x},{:x}:{}", chunk.len(), digits_of(chunk)))?;
        }
        Ok(())
    }

    fn command(&mut self, text: &str) -> Result<()> {
        let answer = self.ask(text)?;
        ensure!(answer == "OK", "`{text}` is answered by `{answer}`");
        Ok(())
    }

    fn ask(&mut self, text: &str) -> Result<String> {
        self.connection.write_all(packet(text).as_bytes())?;
        self.answer()
    }

    /// The next packet.
    fn answer(&mut self) -> Result<String> {
        loop {
            if let Some((text, length)) = first_packet(&self.received)? {
                self.received.drain(..length);
                return Ok(text);
            }
            let mut bytes = [0; 4096];
            let count = self.connection.read(&mut bytes).context("the debug stub is silent")?;
            ensure!(count > 0, "the emulator has ended");
            self.received.extend_from_slice(&bytes[..count]);
        }
    }
}

/// Memory in a packet. Unit: byte.
const CHUNK: usize = 1024;

fn packet(text: &str) -> String {
    format!("${text}#{:02x}", checksum(text.as_bytes()))
}

fn checksum(text: &[u8]) -> u8 {
    text.iter().fold(0, |sum, byte| sum.wrapping_add(*byte))
}

/// The text of the first complete packet, and how many bytes there are up to its end.
fn first_packet(received: &[u8]) -> Result<Option<(String, usize)>> {
    let Some(start) = received.iter().position(|byte| *byte == b'$') else { return Ok(None) };
    let Some(end) = received[start..].iter().position(|byte| *byte == b'#').map(|end| start + end) else {
        return Ok(None);
    };
    let Some(sum) = received.get(end + 1..end + 3) else { return Ok(None) };
    let text = &received[start + 1..end];
    if sum != format!("{:02x}", checksum(text)).as_bytes() {
        bail!("a packet is damaged: {}", String::from_utf8_lossy(text));
    }
    Ok(Some((String::from_utf8_lossy(text).into_owned(), end + 3)))
}

fn digits_of(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn bytes_of(hexadecimal: &str) -> Option<Vec<u8>> {
    let digit = |index: usize| char::from(*hexadecimal.as_bytes().get(index)?).to_digit(16);
    (0..hexadecimal.len() / 2).map(|i| Some((digit(2 * i)? << 4 | digit(2 * i + 1)?) as u8)).collect()
}

#[cfg(test)]
mod tests {
    use super::{bytes_of, digits_of, first_packet, packet};

    #[test]
    fn a_packet_is_found_behind_acknowledgements_once_it_is_complete() {
        let bytes = format!("++{}", packet("OK"));
        assert_eq!(bytes, "++$OK#9a");
        for length in 0..bytes.len() {
            assert_eq!(first_packet(&bytes.as_bytes()[..length]).expect("undamaged"), None);
        }
        assert_eq!(first_packet(bytes.as_bytes()).expect("undamaged"), Some(("OK".to_owned(), 8)));
        assert!(first_packet(b"$OK#9b").is_err());
    }

    #[test]
    fn hexadecimal_digits_are_bytes_and_errors_are_none() {
        assert_eq!(bytes_of("00ff1A"), Some(vec![0, 255, 26]));
        assert_eq!(digits_of(&[0, 255, 26]), "00ff1a");
        assert_eq!(bytes_of("E.14"), None);
    }
}
