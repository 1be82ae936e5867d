//! Where in its files a muscle of a joint was slack.

use std::path::PathBuf;

use identification::joint::Slack;
use recording::joint::columns::JointRecording;
use serde_json::{Value, json};

/// The rows of several recordings of one joint, as they stand in their files.
pub struct Places(Vec<(String, Vec<f64>)>);

/// A slack stretch in its file.
pub struct SlackAt<'a> {
    pub slack: &'a Slack,
    file: &'a str,
    /// Times of its first and last row in the file. Unit: s.
    from_s: f64,
    to_s: f64,
}

impl Places {
    /// Of recordings that are put behind each other, each with its file.
    pub fn of(recordings: &[JointRecording], files: &[PathBuf]) -> Self {
        let named = recordings.iter().zip(files);
        Self(
            named
                .map(|(read, file)| (recording::input::name(file).into_owned(), read.time_s.clone()))
                .collect(),
        )
    }

    /// Where a stretch is; none goes over from one recording to the next.
    pub fn slack<'a>(&'a self, slack: &'a Slack) -> SlackAt<'a> {
        let mut first = slack.rows.start;
        let mut places = self.0.iter();
        let place = places.find(|(_, time_s)| {
            let is_here = first < time_s.len();
            first -= if is_here { 0 } else { time_s.len() };
            is_here
        });
        let (file, from_s, to_s) = place.map_or(("", f64::NAN, f64::NAN), |(file, time_s)| {
            (file.as_str(), time_s[first], time_s[first + slack.rows.len() - 1])
        });
        SlackAt { slack, file, from_s, to_s }
    }
}

impl SlackAt<'_> {
    fn muscle(&self) -> &'static str {
        ["a", "b"][self.slack.muscle]
    }

    /// For people.
    pub fn in_words(&self) -> String {
        let Self { slack: Slack { below_bar, lowest_bar, rows, .. }, file, from_s, to_s } = self;
        format!(
            "muscle {} below {below_bar:.1} bar, down to {lowest_bar:.2} bar: {} rows from {from_s:.2} to {to_s:.2} s \
             of {file} are left out: it was slack, or the joint at its end",
            self.muscle(),
            rows.len()
        )
    }

    /// For programs.
    pub fn to_json(&self) -> Value {
        let Self { slack: Slack { below_bar, lowest_bar, rows, .. }, file, from_s, to_s } = self;
        json!({
            "muscle": self.muscle(),
            "below_bar": below_bar,
            "lowest_bar": lowest_bar,
            "file": file,
            "from_s": from_s,
            "to_s": to_s,
            "rows": rows.len(),
        })
    }
}
