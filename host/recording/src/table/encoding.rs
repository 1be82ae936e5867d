//! From bytes to text: UTF-8, UTF-16, and Windows-1252 as the last resort.

use std::io::Read;

use encoding_rs::{Decoder, DecoderResult, Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};

use super::DataProblem;

/// The byte-order mark of UTF-8.
const UTF_8_MARK: &[u8] = b"\xef\xbb\xbf";
/// How many bytes are looked at together.
const PIECE: usize = 1 << 20;
/// How many bytes tell UTF-16 without a mark from what is no text.
const LOOKED_AT: usize = 64;

/// How a file is written.
#[derive(Clone, Copy, Debug)]
pub struct Written {
    /// Its encoding.
    pub encoding: &'static Encoding,
    /// So many bytes before the text are a mark that the encoding does not know.
    pub mark: usize,
    /// What has to be said of that.
    pub note: Option<&'static str>,
}

/// Looks through all of a file, and shows each piece of it to `see` on the way.
///
/// # Errors
/// It cannot be read, or is no text.
pub fn of(mut bytes: impl Read, mut see: impl FnMut(&[u8])) -> Result<Written, DataProblem> {
    let mut piece = Vec::with_capacity(PIECE);
    let mut read = |piece: &mut Vec<u8>| {
        piece.clear();
        let count = bytes.by_ref().take(PIECE as u64).read_to_end(piece);
        see(piece);
        count.map_err(DataProblem::Unreadable)
    };
    read(&mut piece)?;
    let mut looked = Looked::new(utf_16(&piece).unwrap_or(UTF_8));
    let is_marked = piece.starts_with(UTF_8_MARK);
    while !piece.is_empty() {
        looked.at(&piece);
        read(&mut piece)?;
    }
    looked.written(is_marked)
}

/// The kind of UTF-16 that a file's beginning is, by its mark or since every other byte is 0.
fn utf_16(begin: &[u8]) -> Option<&'static Encoding> {
    if let Some((encoding, _)) = Encoding::for_bom(begin) {
        return (encoding != UTF_8).then_some(encoding);
    }
    let begin = &begin[..begin.len().min(LOOKED_AT) & !1];
    let zeros = |place: usize| begin.len() >= 2 && begin.iter().skip(place).step_by(2).all(|&byte| byte == 0);
    match (zeros(0), zeros(1)) {
        (false, true) => Some(UTF_16LE),
        (true, false) => Some(UTF_16BE),
        _ => None,
    }
}

/// What has been seen of a file.
struct Looked {
    encoding: &'static Encoding,
    decoder: Decoder,
    /// The piece as a text.
    text: String,
    /// How many bytes have been looked at.
    bytes: usize,
    /// Where the first byte of 0 is.
    nul: Option<usize>,
    /// Where what is not in the encoding begins, at the latest.
    malformed: Option<usize>,
    /// Control characters, which are in no text of any encoding.
    has_controls: bool,
}

impl Looked {
    fn new(encoding: &'static Encoding) -> Self {
        let decoder = encoding.new_decoder_with_bom_removal();
        let text = String::new();
        Self { encoding, decoder, text, bytes: 0, nul: None, malformed: None, has_controls: false }
    }

    fn at(&mut self, piece: &[u8]) {
        if self.encoding == UTF_8 {
            let is_control =
                |byte: &u8| *byte < b' ' && !matches!(byte, b'\t' | b'\r' | b'\n') || *byte == 0x7f;
            self.has_controls |= piece.iter().any(is_control);
            let nul = || piece.iter().position(|&byte| byte == 0).map(|place| self.bytes + place);
            self.nul = self.nul.or_else(nul);
        }
        if self.malformed.is_none() {
            self.decode(piece, false);
        }
        self.bytes += piece.len();
    }

    fn decode(&mut self, piece: &[u8], is_last: bool) {
        let mut rest = piece;
        loop {
            self.text.clear();
            self.text.reserve(PIECE);
            let (result, read) =
                self.decoder.decode_to_string_without_replacement(rest, &mut self.text, is_last);
            rest = &rest[read..];
            // UTF-16 with a mark that says otherwise is no text either.
            let has_nul = self.encoding != UTF_8 && self.text.contains('\0');
            match result {
                DecoderResult::Malformed(length, behind) => {
                    let seen = self.bytes + piece.len() - rest.len();
                    self.malformed = Some(seen.saturating_sub(usize::from(length + behind)));
                    return;
                }
                _ if has_nul => {
                    self.malformed = Some(self.bytes);
                    return;
                }
                DecoderResult::InputEmpty => return,
                DecoderResult::OutputFull => {}
            }
        }
    }

    /// How the file is written, when all of it has been looked at.
    fn written(mut self, is_marked: bool) -> Result<Written, DataProblem> {
        if let Some(offset) = self.nul {
            return Err(DataProblem::Nul { offset });
        }
        if self.malformed.is_none() {
            self.decode(&[], true);
        }
        match (self.malformed, self.encoding == UTF_8) {
            (None, true) => Ok(Written { encoding: UTF_8, mark: 0, note: None }),
            (None, false) => {
                Ok(Written { encoding: self.encoding, mark: 0, note: Some("the file was read as UTF-16") })
            }
            (Some(_), false) => Err(DataProblem::NotUtf16),
            (Some(offset), true) if self.has_controls => Err(DataProblem::NotUtf8 { offset }),
            (Some(_), true) => Ok(Written {
                encoding: WINDOWS_1252,
                mark: if is_marked { UTF_8_MARK.len() } else { 0 },
                note: Some("the file is not UTF-8 and was read as Windows-1252"),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::pieces::Pieces;
    use super::*;

    #[test]
    fn every_encoding_gives_the_same_text() {
        let wanted = "time_s,temp [°C]\n0,µ\n";
        let units: Vec<u16> = wanted.encode_utf16().collect();
        let little: Vec<u8> = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
        let big: Vec<u8> = units.iter().flat_map(|unit| unit.to_be_bytes()).collect();
        let latin: Vec<u8> = wanted.chars().map(|letter| letter as u8).collect();
        for (bytes, is_noted) in [
            (wanted.as_bytes().to_vec(), false),
            ([b"\xef\xbb\xbf", wanted.as_bytes()].concat(), false),
            ([&[0xff, 0xfe], &little[..]].concat(), true),
            ([&[0xfe, 0xff], &big[..]].concat(), true),
            ([b"\xef\xbb\xbf", &latin[..]].concat(), true),
            (latin, true),
        ] {
            assert_eq!(text(&bytes).expect("a text"), (wanted.to_owned(), is_noted));
        }
        let ascii: Vec<u8> = "time_s\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(text(&ascii).expect("a text").0, "time_s\n");
    }

    /// The first piece, and whether something is said of the encoding.
    fn text(bytes: &[u8]) -> Result<(String, bool), DataProblem> {
        let written = of(bytes, |_| {})?;
        let mut pieces = Pieces::of(Box::new(&bytes[written.mark..]), written.encoding);
        pieces.advance().map_err(DataProblem::Unreadable)?;
        Ok((pieces.text().to_owned(), written.note.is_some()))
    }

    #[test]
    fn what_is_no_text_is_found_in_any_piece() {
        let mut bytes = vec![b'a'; 3 * PIECE];
        let place = 2 * PIECE + 7;
        bytes[place] = 0;
        assert!(matches!(text(&bytes), Err(DataProblem::Nul { offset }) if offset == place));
        bytes[place] = 0xff;
        assert!(text(&bytes).expect("Windows-1252").1);
        bytes[5] = 1;
        assert!(matches!(text(&bytes), Err(DataProblem::NotUtf8 { offset }) if offset == place));
        // A letter of two bytes on both sides of where a piece ends.
        let mut bytes = vec![b'a'; PIECE - 1];
        bytes.extend("µa".bytes());
        assert!(!text(&bytes).expect("UTF-8").1);
    }

    #[test]
    fn what_is_no_text_is_refused() {
        assert!(matches!(text(b"time_s\0"), Err(DataProblem::Nul { offset: 6 })));
        assert!(matches!(text(b"\x89PNG\r\n\x1a\n"), Err(DataProblem::NotUtf8 { offset: 0 })));
        assert!(matches!(text(b"\xff\xfea"), Err(DataProblem::NotUtf16)));
    }
}
