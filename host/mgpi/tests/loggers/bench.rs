//! The recording that all files are of, and what reads them.

use std::path::Path;

use recording::table::Table;
use recording::{Choice, Recording};

/// Rows of the recording.
pub const ROWS: usize = 300;
/// Rows a second.
pub const RATE_HZ: f64 = 20.0;

/// Time (s), pressure (bar) and contraction (mm) of a row.
pub fn row(row: usize) -> [f64; 3] {
    let swing = (row % 80).min(80 - row % 80) as f64 / 40.0;
    [
        row as f64 / RATE_HZ,
        (6000.0 * swing).round() / 1000.0,
        (60_000.0 * swing * swing).round() / 1000.0 - 1.25,
    ]
}

/// A file: a header, and a line a row.
pub fn file(header: &str, line: impl Fn(usize, [f64; 3]) -> String) -> String {
    let lines = (0..ROWS).map(|place| line(place, row(place)));
    std::iter::once(header.to_owned()).chain(lines).map(|line| line + "\n").collect()
}

/// The usual file.
pub fn usual() -> String {
    file("time_s,pressure_bar,contraction_mm", |_, [t, p, x]| format!("{t},{p},{x}"))
}

/// A number with a decimal comma.
pub fn comma(value: f64) -> String {
    value.to_string().replace('.', ",")
}

/// What reads the file, with the options of the command.
pub fn read(bytes: &[u8], options: &str) -> Result<Recording, String> {
    let mut choice = Choice { has_options: true, ..Choice::default() };
    let words: Vec<&str> = options.split_whitespace().collect();
    for pair in words.chunks(2) {
        let [option, value] = pair else { panic!("{options}: an option without a value") };
        let list = || value.split(',');
        match *option {
            "--time" => choice.naming.time = Some((*value).to_owned()),
            "--input" => choice.input = Some((*value).to_owned()),
            "--output" => choice.output = Some((*value).to_owned()),
            "--columns" => choice.naming.columns.extend(list().map(|text| text.parse().expect(text))),
            "--units" => choice.naming.units.extend(list().map(|text| text.parse().expect(text))),
            "--rest-length" => choice.rest_length_mm = Some(value.parse().expect("a number")),
            other => panic!("{other}: no such option"),
        }
    }
    let read = Table::parse(Path::new("rec.csv"), bytes).and_then(|mut table| {
        table.name(&choice.naming)?;
        Recording::of(&table, &choice)
    });
    read.map_err(|error| error.to_string())
}

/// The file is read with these columns, and values that are so many times bar and mm; all that was
/// done to it is said by notes that hold these words.
pub fn reads(bytes: impl AsRef<[u8]>, options: &str, columns: [(&str, f64); 2], notes: &[&str]) {
    let recording = read(bytes.as_ref(), options).expect("it is read");
    assert_eq!(recording.drive.time_s.len(), ROWS);
    compare(&recording, columns, |place| place);
    said(&recording, notes);
}

/// The usual columns, see [`reads`].
pub fn reads_usual(bytes: impl AsRef<[u8]>, notes: &[&str]) {
    reads(bytes, "", USUAL, notes);
}

/// The usual columns.
pub const USUAL: [(&str, f64); 2] = [("pressure_bar", 1.0), ("contraction_mm", 1.0)];

/// Compares rows with those that they are of; times are counted from the first one.
pub fn compare(recording: &Recording, columns: [(&str, f64); 2], source: impl Fn(usize) -> usize) {
    let Recording { drive, output, .. } = recording;
    assert_eq!([&drive.input.channel.name, &output.channel.name], columns.map(|(name, _)| name));
    let [first_s, ..] = row(source(0));
    for (place, time_s) in drive.time_s.iter().enumerate() {
        let [t, p, x] = row(source(place));
        let is_near = |found: f64, wanted: f64| (found - wanted).abs() < 1e-6 * (1.0 + wanted.abs());
        assert!(is_near(time_s - drive.time_s[0], t - first_s), "row {place}: {time_s} s");
        assert!(
            is_near(drive.input.values[place], p * columns[0].1),
            "row {place}: {}",
            drive.input.values[place]
        );
        if drive.scored[place] {
            assert!(is_near(output.values[place], x * columns[1].1), "row {place}: {}", output.values[place]);
        }
    }
}

/// Each note has its words, and there is no other one.
pub fn said(recording: &Recording, notes: &[&str]) {
    let found = &recording.drive.notes;
    assert_eq!(found.len(), notes.len(), "{found:?}");
    for (found, words) in found.iter().zip(notes) {
        assert!(found.contains(words), "{found}");
    }
}

/// The file is refused with a message that has these words; with the options that it names it is
/// read, if there are any.
pub fn refuses(bytes: impl AsRef<[u8]>, words: &str, cure: &str, columns: [(&str, f64); 2]) {
    let message = read(bytes.as_ref(), "").expect_err("it is refused");
    assert!(message.contains(words), "{message}");
    if !cure.is_empty() {
        let recording = read(bytes.as_ref(), cure).expect("the cure helps");
        compare(&recording, columns, |place| place);
    }
}
