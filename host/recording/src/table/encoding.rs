//! From bytes to text: UTF-8, UTF-16, and Windows-1252 as the last resort.

use std::borrow::Cow;

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};

use super::DataProblem;

/// How many bytes tell UTF-16 without a mark from what is no text.
const LOOKED_AT: usize = 64;

/// The text of a file without its byte-order mark, and what was done to get it.
pub fn text(bytes: &[u8]) -> Result<(Cow<'_, str>, Option<String>), DataProblem> {
    match Encoding::for_bom(bytes) {
        Some((encoding, mark)) if encoding != UTF_8 => return utf_16(encoding, &bytes[mark..]),
        Some((_, mark)) => return utf_8(&bytes[mark..]),
        None => {}
    }
    let begin = &bytes[..bytes.len().min(LOOKED_AT) & !1];
    let zeros = |place: usize| begin.len() >= 2 && begin.iter().skip(place).step_by(2).all(|&byte| byte == 0);
    match (zeros(0), zeros(1)) {
        (false, true) => utf_16(UTF_16LE, bytes),
        (true, false) => utf_16(UTF_16BE, bytes),
        _ => utf_8(bytes),
    }
}

fn utf_16(
    encoding: &'static Encoding,
    bytes: &[u8],
) -> Result<(Cow<'static, str>, Option<String>), DataProblem> {
    let (text, had_errors) = encoding.decode_without_bom_handling(bytes);
    if had_errors || text.contains('\0') {
        return Err(DataProblem::NotUtf16);
    }
    Ok((text.into_owned().into(), Some("the file was read as UTF-16".to_owned())))
}

fn utf_8(bytes: &[u8]) -> Result<(Cow<'_, str>, Option<String>), DataProblem> {
    if let Some(offset) = bytes.iter().position(|&byte| byte == 0) {
        return Err(DataProblem::Nul { offset });
    }
    let offset = match std::str::from_utf8(bytes) {
        Ok(text) => return Ok((text.into(), None)),
        Err(error) => error.valid_up_to(),
    };
    // What has control characters is no text in any encoding.
    let is_control = |byte: &u8| *byte < b' ' && !matches!(byte, b'\t' | b'\r' | b'\n') || *byte == 0x7f;
    match WINDOWS_1252.decode_without_bom_handling_and_without_replacement(bytes) {
        Some(text) if !bytes.iter().any(is_control) => {
            Ok((text, Some("the file is not UTF-8 and was read as Windows-1252".to_owned())))
        }
        _ => Err(DataProblem::NotUtf8 { offset }),
    }
}

#[cfg(test)]
mod tests {
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
            (latin, true),
        ] {
            let (found, note) = text(&bytes).expect("a text");
            assert_eq!((&*found, note.is_some()), (wanted, is_noted));
        }
        let ascii: Vec<u8> = "time_s\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(text(&ascii).expect("a text").0, "time_s\n");
    }

    #[test]
    fn what_is_no_text_is_refused() {
        assert!(matches!(text(b"time_s\0"), Err(DataProblem::Nul { offset: 6 })));
        assert!(matches!(text(b"\x89PNG\r\n\x1a\n"), Err(DataProblem::NotUtf8 { offset: 0 })));
        assert!(matches!(text(b"\xff\xfea"), Err(DataProblem::NotUtf16)));
    }
}
