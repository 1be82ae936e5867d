//! A text out of bytes, of which a piece of whole lines is held at a time.

use std::borrow::Cow;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use encoding_rs::{CoderResult, Decoder, Encoding};

use crate::input;

/// How many bytes are read at a time: of lines of 50 bytes some 20,000.
const PIECE: usize = 1 << 20;

/// Bytes that can be read again from the beginning.
#[derive(Clone, Debug)]
pub enum Source<'a> {
    /// The first so many bytes of a file: what is added meanwhile is left for the next time.
    File(Arc<File>, u64),
    /// Bytes in memory.
    Bytes(Cow<'a, [u8]>),
}

impl<'a> Source<'a> {
    /// The bytes of a file, or of standard input; held only where they can be read once.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn of(file: &Path) -> io::Result<Self> {
        if input::is_standard(file) || !fs::metadata(file)?.is_file() {
            return Ok(Self::Bytes(input::bytes(file)?.into()));
        }
        Self::of_file(Arc::new(File::open(file)?))
    }

    /// The bytes of a file, none of which are held.
    ///
    /// # Errors
    /// Its length is not known.
    pub fn of_file(file: Arc<File>) -> io::Result<Self> {
        let length = file.metadata()?.len();
        Ok(Self::File(file, length))
    }

    /// The bytes behind the first `skipped` ones.
    pub fn open(&self, skipped: usize) -> Box<dyn Read + '_> {
        match self {
            Self::File(file, length) => {
                let skipped = skipped as u64;
                Box::new(input::FromPlace::new(file, skipped).take(length.saturating_sub(skipped)))
            }
            Self::Bytes(bytes) => Box::new(bytes.get(skipped..).unwrap_or_default()),
        }
    }
}

/// A text, a piece after the other.
///
/// A field in quotes may have ends of lines in it, and lie in two pieces.
pub struct Pieces<'a> {
    bytes: Box<dyn Read + 'a>,
    decoder: Decoder,
    /// The piece, and behind it what has been read of the next one.
    text: String,
    /// How long the piece is.
    length: usize,
    is_ended: bool,
    /// How many bytes are read at a time.
    most: usize,
}

impl<'a> Pieces<'a> {
    /// A text in this encoding, without its byte-order mark; as yet its piece is empty.
    pub fn of(bytes: Box<dyn Read + 'a>, encoding: &'static Encoding) -> Self {
        let decoder = encoding.new_decoder_with_bom_removal();
        Self { bytes, decoder, text: String::new(), length: 0, is_ended: false, most: PIECE }
    }

    /// UTF-8 that is read by few bytes at a time.
    #[cfg(test)]
    pub fn of_at_most(bytes: &'a [u8], most: usize) -> Self {
        Self { most, ..Self::of(Box::new(bytes), encoding_rs::UTF_8) }
    }

    /// The piece.
    pub fn text(&self) -> &str {
        &self.text[..self.length]
    }

    /// Goes to the next piece, which ends where a line ends, or the text; `false`, and an empty
    /// piece, behind the last one.
    ///
    /// # Errors
    /// The bytes cannot be read.
    pub fn advance(&mut self) -> io::Result<bool> {
        self.text.drain(..self.length);
        self.length = 0;
        let mut from = 0;
        while !self.is_ended {
            if let Some(end) = last_end(&self.text, from) {
                self.length = end;
                return Ok(true);
            }
            from = self.text.len().saturating_sub(1);
            self.read()?;
        }
        self.length = self.text.len();
        Ok(self.length > 0)
    }

    /// Reads on.
    fn read(&mut self) -> io::Result<()> {
        let mut bytes = Vec::with_capacity(self.most);
        self.bytes.by_ref().take(self.most as u64).read_to_end(&mut bytes)?;
        self.is_ended = bytes.len() < self.most;
        let mut rest = &bytes[..];
        loop {
            // As much as a decoder asks for to go on.
            self.text.reserve(rest.len() + 16);
            let (result, read, _) = self.decoder.decode_to_string(rest, &mut self.text, self.is_ended);
            rest = &rest[read..];
            if result == CoderResult::InputEmpty {
                return Ok(());
            }
        }
    }
}

/// Where the last line ends that has an end; no line ends before `from`. A line feed may still
/// follow a carriage return that is the last character.
fn last_end(text: &str, from: usize) -> Option<usize> {
    let bytes = text.as_bytes();
    let end = |place: &usize| match bytes[*place] {
        b'\n' => true,
        b'\r' => bytes.get(place + 1).is_some_and(|next| *next != b'\n'),
        _ => false,
    };
    (from..bytes.len()).rev().find(end).map(|place| place + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_whole_lines_and_together_the_text() {
        let text = "\u{feff}one\r\ntwo µm\rthree\n\nfour";
        for most in 1..text.len() {
            let mut pieces = Pieces::of_at_most(text.as_bytes(), most);
            let mut found = String::new();
            while pieces.advance().expect("in memory") {
                let piece = pieces.text();
                found += piece;
                let is_last = found.len() + '\u{feff}'.len_utf8() == text.len();
                assert!(is_last || piece.ends_with(['\n', '\r']), "{piece:?} of pieces of {most}");
                assert!(!text[3 + found.len()..].starts_with('\n') || !piece.ends_with('\r'));
            }
            assert_eq!(found, &text[3..]);
            assert!(!pieces.advance().expect("in memory"));
        }
    }
}
