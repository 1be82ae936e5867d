//! The lines of a text that count: neither blank nor a comment.

use std::io::{self, Read};

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

    /// The next line, whatever it is.
    pub fn next_of_all(&mut self) -> Option<Line<'a>> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.find(['\n', '\r']).unwrap_or(self.rest.len());
        let (text, behind) = self.rest.split_at(end);
        let ending = if behind.starts_with("\r\n") { 2 } else { behind.len().min(1) };
        self.rest = &behind[ending..];
        self.number += 1;
        Some(Line { number: self.number, text })
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        loop {
            let line = self.next_of_all()?;
            let text = line.text.trim_start();
            if !text.is_empty() && comment(text).is_none() {
                return Some(line);
            }
        }
    }
}

/// The text of a comment; `None` for any other line.
pub fn comment(line: &str) -> Option<&str> {
    COMMENTS.iter().find_map(|mark| line.strip_prefix(mark))
}

/// The lines that count as a stream for the reader of separated values, which remembers where they
/// stand in the file.
#[derive(Debug)]
pub struct Stream<'a> {
    lines: Lines<'a>,
    /// What of the line, and of its end, has not been read yet.
    pending: &'a [u8],
    is_ended: bool,
    count: usize,
    /// Where the numbers of lines jump: how many lines counted before, and the number in the file.
    jumps: Vec<(usize, usize)>,
}

impl<'a> Stream<'a> {
    /// A stream of these lines.
    pub fn of(lines: Lines<'a>) -> Self {
        Self { lines, pending: b"", is_ended: true, count: 0, jumps: Vec::new() }
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
                let Some(line) = self.lines.next() else { break };
                let expected = number(&self.jumps, self.count);
                if expected != line.number {
                    self.jumps.push((self.count, line.number));
                }
                self.count += 1;
                (self.pending, self.is_ended) = (line.text.as_bytes(), false);
                continue;
            }
            let taken = self.pending.len().min(buffer.len() - filled);
            buffer[filled..filled + taken].copy_from_slice(&self.pending[..taken]);
            self.pending = &self.pending[taken..];
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
        let mut stream = Stream::of(Lines::of(text));
        let mut read = String::new();
        // Of few bytes at a time.
        let mut buffer = [0; 3];
        while let Ok(count @ 1..) = stream.read(&mut buffer) {
            read += std::str::from_utf8(&buffer[..count]).expect("ASCII");
        }
        assert_eq!(read, "a,b\n1,2\n3,4\n5,6\n");
        assert_eq!([0, 1, 2, 3].map(|place| stream.number(place)), [2, 4, 6, 7]);
    }
}
