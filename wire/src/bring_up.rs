//! What a host and the bring-up image say to each other over the service link: lines of ASCII, so
//! that a terminal program will do.
//!
//! # Protocol
//! A request is the line [`RUN`], with [`OUTPUT`] behind it if the valve's output may be driven,
//! and with [`ECHO`] if the receiver of the bus stays on while the board sends. The answer has a
//! line a part:
//!
//! ```text
//! NAME VALUE LOWEST HIGHEST VERDICT
//! ```
//!
//! with the unit at the end of the name. A value that could not be measured is [`NONE`]; so are the
//! limits of one that is a word. The verdict is [`GOOD`] or [`FAULTY`]. The last line is
//!
//! ```text
//! end PARTS FAULTY_PARTS CHECKSUM
//! ```
//!
//! where the checksum is [`CHECKSUM`] over all bytes before this line, as eight hexadecimal digits.

use crc::{CRC_32_ISO_HDLC, Crc};

/// Asks for a run.
pub const RUN: &str = "run";
/// Allows to drive the valve's output.
pub const OUTPUT: &str = "output";
/// The bus hears what it sends.
pub const ECHO: &str = "echo";
/// The first word of the last line.
pub const END: &str = "end";
/// What could not be measured, or has no limits.
pub const NONE: &str = "-";
/// The verdict of a part that is within its limits.
pub const GOOD: &str = "ok";
/// That of another.
pub const FAULTY: &str = "FAULT";
/// The longest line, its end included. Unit: byte.
pub const LINE_BYTES: usize = 96;
/// Of the answer.
pub const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// What is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// The valve's output is driven, and read back.
    pub output: bool,
    /// The bus has to hear what it sends.
    pub echo: bool,
}

impl Wanted {
    /// What a line asks for; none where it is no request.
    pub fn of_line(line: &str) -> Option<Self> {
        let mut words = line.split_ascii_whitespace();
        (words.next() == Some(RUN)).then_some(())?;
        words.try_fold(Self::default(), |wanted, word| match word {
            OUTPUT => Some(Self { output: true, ..wanted }),
            ECHO => Some(Self { echo: true, ..wanted }),
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Wanted;

    #[test]
    fn only_what_is_said_is_asked_for_and_an_unknown_word_asks_for_nothing() {
        let nothing_more = Wanted::default();
        assert_eq!(Wanted::of_line("run"), Some(nothing_more));
        assert_eq!(Wanted::of_line(" run echo\r"), Some(Wanted { echo: true, ..nothing_more }));
        assert_eq!(Wanted::of_line("run output echo"), Some(Wanted { output: true, echo: true }));
        for line in ["", "output", "run outputs", "run output now", "\u{0}run"] {
            assert_eq!(Wanted::of_line(line), None, "{line}");
        }
    }
}
