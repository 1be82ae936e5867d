//! The scored rows of a diagnosed recording as lines over time and over the input.

use crate::plot::{Line, Plot, Style};
use diagnosis::Diagnosis;
use recording::Recording;

/// A diagnosis beside its recording. Lists have a value a scored row, and a NaN where rows between
/// are not scored.
pub struct View<'a> {
    /// The diagnosis.
    pub diagnosis: &'a Diagnosis,
    recording: &'a Recording,
    places: Vec<Option<usize>>,
    /// Unit: s.
    pub time_s: Vec<f64>,
    /// Input unit.
    pub input: Vec<f64>,
    /// Output unit.
    pub measured: Vec<f64>,
    /// Measured less what the flexible hysteresis of the search simulates. Output unit.
    pub residual: Vec<f64>,
}

impl<'a> View<'a> {
    /// Of a diagnosis of a recording.
    pub fn new(diagnosis: &'a Diagnosis, recording: &'a Recording) -> Self {
        let mut view = Self {
            diagnosis,
            recording,
            places: places(&diagnosis.rows),
            time_s: Vec::new(),
            input: Vec::new(),
            measured: Vec::new(),
            residual: Vec::new(),
        };
        view.time_s = view.rows(&recording.drive.time_s);
        view.input = view.rows(&recording.drive.input.values);
        view.measured = view.rows(&recording.output.values);
        view.residual = view.scored(&diagnosis.residual_before);
        view
    }

    /// A column of the recording, a value a row.
    pub fn rows(&self, column: &[f64]) -> Vec<f64> {
        let rows = &self.diagnosis.rows;
        self.places.iter().map(|place| place.map_or(f64::NAN, |i| column[rows[i]])).collect()
    }

    /// What is known for each scored row.
    pub fn scored(&self, values: &[f64]) -> Vec<f64> {
        self.places.iter().map(|place| place.map_or(f64::NAN, |i| values[i])).collect()
    }

    /// Measured less these. Output unit.
    pub fn measured_less(&self, simulated: &[f64]) -> Vec<f64> {
        self.measured.iter().zip(simulated).map(|(measured, simulated)| measured - simulated).collect()
    }

    /// Name and unit of the input.
    pub fn input_axis(&self) -> String {
        self.recording.drive.input.channel.to_string()
    }

    /// The input's unit.
    pub fn input_unit(&self) -> String {
        self.recording.drive.input.channel.unit.to_string()
    }

    /// The output's unit.
    pub fn unit(&self) -> String {
        self.recording.output.channel.unit.to_string()
    }

    /// Name and unit of errors.
    pub fn error_axis(&self) -> String {
        format!("error ({})", self.unit())
    }

    /// Lines of the output over time.
    pub fn output_over_time<'b>(&'b self, title: &str, lines: Vec<Line<'b>>) -> Plot<'b> {
        self.over_time(title, self.recording.output.channel.to_string(), lines)
    }

    /// Lines of errors over time.
    pub fn errors_over_time<'b>(&'b self, title: &str, lines: Vec<Line<'b>>) -> Plot<'b> {
        self.over_time(title, self.error_axis(), lines)
    }

    /// Lines over time, whose axis is shared by all plots of the recording.
    pub fn over_time<'b>(&'b self, title: &str, y: String, lines: Vec<Line<'b>>) -> Plot<'b> {
        let clock = self.recording.drive.sha256.clone();
        let (title, x) = (title.to_owned(), "time (s)".to_owned());
        Plot { title, x, y, lines, clock, ..Plot::default() }
    }

    /// A line over time.
    pub fn line<'b>(&'b self, name: &'b str, style: Style, y: &'b [f64]) -> Line<'b> {
        Line { name, style, x: &self.time_s, y }
    }

    /// Measured and simulated output over an input.
    pub fn loops<'b>(
        &'b self,
        title: String,
        (x, input): (String, &'b [f64]),
        (name, simulated): (&'b str, &'b [f64]),
    ) -> Plot<'b> {
        let line = |name, style, y| Line { name, style, x: input, y };
        Plot {
            title,
            x,
            y: self.recording.output.channel.to_string(),
            lines: vec![
                line("measured", Style::Measured, &self.measured),
                line(name, Style::Model, simulated),
            ],
            ..Plot::default()
        }
    }
}

/// The places of rows, and a None between two that are farther apart than the nearest two.
fn places(rows: &[usize]) -> Vec<Option<usize>> {
    let step = rows.windows(2).map(|pair| pair[1] - pair[0]).min().unwrap_or(1);
    let mut places = Vec::new();
    for (place, &row) in rows.iter().enumerate() {
        if place > 0 && row - rows[place - 1] > step {
            places.push(None);
        }
        places.push(Some(place));
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_interrupted_where_rows_are_left_out() {
        assert_eq!(places(&[0, 2, 4, 10, 12]), [Some(0), Some(1), Some(2), None, Some(3), Some(4)]);
        assert_eq!(places(&[]), []);
    }
}
