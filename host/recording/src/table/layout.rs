//! Where the header and the rows of a file are, and what separates their fields.

use std::borrow::Cow;

use super::cell::Cell;
use super::heading::{Heading, is_unit};
use super::lines::{Line, Lines, comment};
use super::stamp::Clock;
use super::{DataProblem, VALID};

/// What may separate fields, the usual first.
const SEPARATORS: [u8; 5] = *b",;\t| ";
/// How many lines are looked at for the header.
const LOOKED_AT: usize = 200;
/// The end of each header of LabVIEW's measurement files (.lvm).
const LABVIEW_END: &str = "***End_of_Header***";

/// How a file is laid out.
#[derive(Debug)]
pub struct Layout<'a> {
    /// What separates the fields.
    pub separator: u8,
    /// The line of the header, from 1.
    pub header_line: usize,
    /// The columns.
    pub headings: Vec<Heading>,
    /// The fields of the header, to find it again below.
    pub header: Vec<String>,
    /// The lines from the first row on.
    pub rows: Lines<'a>,
    /// What was done that a strict reader would not.
    pub notes: Vec<String>,
}

/// A line with the place behind it.
struct Seen<'a> {
    line: Line<'a>,
    behind: Lines<'a>,
}

impl<'a> Layout<'a> {
    /// Finds the layout of a text.
    pub fn of(text: &'a str) -> Result<Self, DataProblem> {
        let mut notes = Vec::new();
        let start = match behind_labview(text) {
            Some((start, number)) => {
                notes.push(format!("{number} lines of a LabVIEW header were skipped"));
                start
            }
            None => Lines::of(text),
        };
        let mut lines = start.clone();
        let mut seen = Vec::new();
        while seen.len() < LOOKED_AT
            && let Some(line) = lines.next()
        {
            seen.push(Seen { line, behind: lines.clone() });
        }
        let Some(first) = seen.first() else { return Err(DataProblem::Empty) };
        if let Some(separator) =
            SEPARATORS.into_iter().find(|&separator| is_row(&split(first.line.text, separator)))
        {
            return Self::of_comment(start, first, separator, notes);
        }
        let (place, separator) = header(&seen).unwrap_or((0, widest(first.line.text)));
        if place > 0 {
            notes.push(format!("{place} lines above the header were skipped"));
        }
        let Seen { line, behind } = &seen[place];
        let header = owned(split(line.text, separator));
        if header.len() < 2 {
            return Err(DataProblem::OneColumn);
        }
        let mut headings: Vec<Heading> = header.iter().map(|name| Heading::of(name)).collect();
        let mut rows = behind.clone();
        if let Some(next) = seen.get(place + 1)
            && let units = split(next.line.text, separator)
            && are_units(&units)
        {
            headings.iter_mut().zip(&units).for_each(|(heading, unit)| heading.add_unit(unit));
            rows = next.behind.clone();
            notes.push("the row below the header was read as units".to_owned());
        }
        if separator == b' ' {
            notes.push("the fields are separated by blanks".to_owned());
        }
        Ok(Self { separator, header_line: line.number, headings, header, rows, notes })
    }

    /// The layout of a file that begins with a row: its last comment before may be the header, as
    /// NumPy writes it.
    fn of_comment(
        mut lines: Lines<'a>,
        first: &Seen<'a>,
        separator: u8,
        mut notes: Vec<String>,
    ) -> Result<Self, DataProblem> {
        let (rows, mut above) = (lines.clone(), None);
        while let Some(line) = lines.next_of_all()
            && line.number < first.line.number
        {
            above = comment(line.text.trim_start()).map(|text| (line.number, text)).or(above);
        }
        let width = split(first.line.text, separator).len();
        let names = above.map(|(number, text)| (number, owned(split(text.trim(), separator))));
        match names.filter(|(_, names)| names.len() == width && are_names(names)) {
            Some((header_line, header)) => {
                notes.push("the comment above the first row was read as the header".to_owned());
                let headings = header.iter().map(|name| Heading::of(name)).collect();
                Ok(Self { separator, header_line, headings, header, rows, notes })
            }
            None => Err(DataProblem::NoHeader { line: first.line.text.trim().chars().take(80).collect() }),
        }
    }
}

/// The lines behind the last header of a LabVIEW file, and how many there are before.
fn behind_labview(text: &str) -> Option<(Lines<'_>, usize)> {
    if !text.starts_with("LabVIEW Measurement") {
        return None;
    }
    let (mut lines, mut behind) = (Lines::of(text), None);
    for _ in 0..LOOKED_AT {
        let Some(line) = lines.next_of_all() else { break };
        if line.text.starts_with(LABVIEW_END) {
            behind = Some((lines.clone(), line.number));
        }
    }
    behind
}

/// The first line with names above a row of as many fields, and what separates them.
fn header(seen: &[Seen<'_>]) -> Option<(usize, u8)> {
    let found = SEPARATORS.into_iter().filter_map(|separator| {
        let fields: Vec<Vec<Cow<'_, str>>> =
            seen.iter().map(|seen| split(seen.line.text, separator)).collect();
        let is_header = |place: &usize| {
            let names = &fields[*place];
            let below = fields.get(place + 1).filter(|below| are_units(below)).map_or(1, |_| 2);
            let row = fields.get(place + below);
            names.len() >= 2
                && are_names(names)
                && row.is_some_and(|row| is_row(row) && fits(names.len(), row))
        };
        let place = (0..fields.len()).find(is_header)?;
        Some((place, separator))
    });
    found.min_by_key(|(place, _)| *place)
}

/// Whether a row is as wide as a header: a separator at its end does no harm, and a last column may
/// be left out.
fn fits(names: usize, row: &[Cow<'_, str>]) -> bool {
    row.len() == names
        || row.len() + 1 == names
        || row.len() == names + 1 && row.last().is_some_and(|last| last.is_empty())
}

/// Two numbers or times at least.
fn is_row(fields: &[Cow<'_, str>]) -> bool {
    let is_value = |field: &&Cow<'_, str>| Cell::of(field, true).is_number() || Clock::of(field).is_some();
    fields.iter().filter(is_value).count() >= 2
}

/// No number or time, and at least one word.
fn are_names(fields: &[impl AsRef<str>]) -> bool {
    let is_value = |field: &str| Cell::of(field, true).is_number() || Clock::of(field).is_some();
    !fields.iter().any(|field| is_value(field.as_ref()))
        && fields.iter().any(|field| field.as_ref().chars().any(char::is_alphabetic))
}

/// Nothing but units and empty fields.
fn are_units(fields: &[Cow<'_, str>]) -> bool {
    fields.iter().all(|field| field.is_empty() || is_unit(field))
        && fields.iter().any(|field| field.chars().any(char::is_alphabetic))
        && !fields.iter().any(|field| field == VALID)
}

/// What splits a line into the most fields.
fn widest(line: &str) -> u8 {
    // The last of those that are as good counts, so the usual comes last.
    let by_width = SEPARATORS.into_iter().rev().max_by_key(|&separator| split(line, separator).len());
    by_width.unwrap_or(b',')
}

/// The fields of a line without blanks around them.
pub fn split(line: &str, separator: u8) -> Vec<Cow<'_, str>> {
    if separator == b' ' {
        return line.split_whitespace().map(Cow::Borrowed).collect();
    }
    if !line.contains('"') {
        return line.split(char::from(separator)).map(|field| Cow::Borrowed(field.trim())).collect();
    }
    let mut reader =
        csv::ReaderBuilder::new().has_headers(false).delimiter(separator).from_reader(line.as_bytes());
    let record = reader.records().next().and_then(Result::ok).unwrap_or_default();
    record.iter().map(|field| Cow::Owned(field.trim().to_owned())).collect()
}

fn owned(fields: Vec<Cow<'_, str>>) -> Vec<String> {
    fields.into_iter().map(Cow::into_owned).collect()
}
