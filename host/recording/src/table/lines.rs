//! The lines of a text that count: neither blank nor a comment.

use std::io::{self, Read};
use std::ops::Range;

use super::pieces::Pieces;

/// What a comment begins with: shell and Python, MATLAB, C.
const COMMENTS: [&str; 3] = ["#", "%", "//"];

/// A line that counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line<'a> {
    /// Counted from 1, among all lines of the file.
    pub number: usize,
    /// Without its end.
    pub text: &'a str,
}

/// Takes the lines of a text one after the other; a line ends in CR LF, LF or CR.
#[derive(Clone, Debug)]
pub struct Lines<'a> {
    rest: &'a str,
    number: usize,
}

impl<'a> Lines<'a> {
    /// From the first line on.
    pub fn of(text: &'a str) -> Self {
        Self { rest: text, number: 0 }
    }

    /// How many bytes are left, and the number of the last line.
    pub fn position(&self) -> (usize, usize) {
        (self.rest.len(), self.number)
    }

    /// The next line, whatever it is.
    pub fn next_of_all(&mut self) -> Option<Line<'a>> {
        if self.rest.is_empty() {
            return None;
        }
        let (line, behind) = first(self.rest);
        let text = &self.rest[..line];
        self.rest = &self.rest[behind..];
        self.number += 1;
        Some(Line { number: self.number, text })
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        loop {
            let line = self.next_of_all()?;
            if counts(line.text) {
                return Some(line);
            }
        }
    }
}

/// How long a text's first line is, and with its end.
fn first(text: &str) -> (usize, usize) {
    let end = text.find(['\n', '\r']).unwrap_or(text.len());
    let behind = &text[end..];
    (end, end + if behind.starts_with("\r\n") { 2 } else { behind.len().min(1) })
}

/// Whether a line counts.
fn counts(line: &str) -> bool {
    let text = line.trim_start();
    !text.is_empty() && comment(text).is_none()
}

/// The text of a comment; `None` for any other line.
pub fn comment(line: &str) -> Option<&str> {
    COMMENTS.iter().find_map(|mark| line.strip_prefix(mark))
}

/// The lines of a text that count, from one of them on, of which a piece is held at a time; for the
/// reader of separated values a stream that remembers where they stand in the file.
pub struct Stream<'a> {
    pieces: Pieces<'a>,
    /// How much of the piece has been read.
    at: usize,
    /// The number of the last line, from 1.
    line: usize,
    /// What of the line has not been copied yet, in the piece.
    pending: Range<usize>,
    is_ended: bool,
    count: usize,
    /// Where the numbers of lines jump: how many lines counted before, and the number in the file.
    jumps: Vec<(usize, usize)>,
}

impl<'a> Stream<'a> {
    /// The lines of a text behind its first bytes, which are so many lines and lie in the first
    /// piece.
    pub fn of(pieces: Pieces<'a>, bytes: usize, lines: usize) -> Self {
        Self { pieces, at: bytes, line: lines, pending: 0..0, is_ended: true, count: 0, jumps: Vec::new() }
    }

    /// The next line that counts.
    ///
    /// # Errors
    /// The text cannot be read.
    pub fn next_line(&mut self) -> io::Result<Option<Line<'_>>> {
        Ok(self.advance()?.map(|text| Line { number: self.line, text: &self.pieces.text()[text] }))
    }

    /// Goes to the next line that counts: where it lies in the piece.
    fn advance(&mut self) -> io::Result<Option<Range<usize>>> {
        loop {
            if self.at == self.pieces.text().len() {
                self.at = 0;
                if !self.pieces.advance()? {
                    return Ok(None);
                }
            }
            let from = self.at;
            let rest = &self.pieces.text()[from..];
            let (line, behind) = first(rest);
            let does_count = counts(&rest[..line]);
            self.at += behind;
            self.line += 1;
            if does_count {
                return Ok(Some(from..from + line));
            }
        }
    }

    /// The number in the file of the line that is so many lines behind the stream's first.
    pub fn number(&self, place: usize) -> usize {
        number(&self.jumps, place)
    }
}

/// The number in the file of the line that is so many lines behind the first; `jumps` are those of
/// a [`Stream`].
pub fn number(jumps: &[(usize, usize)], place: usize) -> usize {
    match jumps[..jumps.partition_point(|(from, _)| *from <= place)].last() {
        Some((from, number)) => number + place - from,
        None => place + 1,
    }
}

impl Read for Stream<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut filled = 0;
        while filled < buffer.len() {
            if self.pending.is_empty() && !self.is_ended {
                buffer[filled] = b'\n';
                filled += 1;
                self.is_ended = true;
                continue;
            }
            if self.pending.is_empty() {
                let Some(text) = self.advance()? else { break };
                let expected = number(&self.jumps, self.count);
                if expected != self.line {
                    self.jumps.push((self.count, self.line));
                }
                self.count += 1;
                (self.pending, self.is_ended) = (text, false);
                continue;
            }
            let taken = self.pending.len().min(buffer.len() - filled);
            let to = self.pending.start + taken;
            buffer[filled..filled + taken]
                .copy_from_slice(&self.pieces.text().as_bytes()[self.pending.start..to]);
            self.pending.start = to;
            filled += taken;
        }
        Ok(filled)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_that_count_keep_their_numbers() {
        let text = "# one\r\na,b\r\n\r\n1,2\n% five\n3,4\r5,6";
        let found: Vec<(usize, &str)> = Lines::of(text).map(|line| (line.number, line.text)).collect();
        assert_eq!(found, [(2, "a,b"), (4, "1,2"), (6, "3,4"), (7, "5,6")]);
        // In pieces of few bytes, and read by few of them.
        for most in 1..text.len() {
            let mut stream = Stream::of(Pieces::of_at_most(text.as_bytes(), most), 0, 0);
            let mut read = String::new();
            let mut buffer = [0; 3];
            while let Ok(count @ 1..) = stream.read(&mut buffer) {
                read += std::str::from_utf8(&buffer[..count]).expect("ASCII");
            }
            assert_eq!(read, "a,b\n1,2\n3,4\n5,6\n", "pieces of {most}");
            assert_eq!([0, 1, 2, 3].map(|place| stream.number(place)), [2, 4, 6, 7]);
        }
    }
}
