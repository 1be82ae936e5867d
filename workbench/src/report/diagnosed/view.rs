//! The scored rows of a diagnosed recording as lines over time and over the input.

use maud::Markup;

use crate::diagnosis::Diagnosis;
use crate::recording::Recording;
use crate::report::bars::{Bar, Mark, bars};
use crate::report::plot::{Line, Plot, Style};

/// A diagnosis beside its recording. Lists have a value a scored row, and a NaN where rows between are not scored.
pub struct View<'a> {
    /// The diagnosis.
    pub diagnosis: &'a Diagnosis,
    recording: &'a Recording,
    /// Unit: s.
    pub time_s: Vec<f64>,
    input: Vec<f64>,
    measured: Vec<f64>,
    /// What the models say, without and with the named causes. Output unit.
    pub before: Vec<f64>,
    pub after: Vec<f64>,
    /// Measured less these. Output unit.
    pub error_before: Vec<f64>,
    error_after: Vec<f64>,
}

impl<'a> View<'a> {
    /// `extended`: what the extended model says, a value a row of the recording; until there is one, the search's own says
    /// what is after.
    pub fn new(diagnosis: &'a Diagnosis, recording: &'a Recording, extended: Option<&[f64]>) -> Self {
        let places = places(&diagnosis.rows);
        let spread = |value: &dyn Fn(usize) -> f64| -> Vec<f64> {
            places.iter().map(|place| place.map_or(f64::NAN, value)).collect()
        };
        let column = |values: &[f64]| spread(&|i| values[diagnosis.rows[i]]);
        let output = &recording.output.values;
        let simulated = |residual: &[f64]| spread(&|i| output[diagnosis.rows[i]] - residual[i]);
        let after = match extended {
            Some(simulated) => column(simulated),
            None => simulated(&diagnosis.residual_after),
        };
        let measured = column(output);
        Self {
            error_after: measured.iter().zip(&after).map(|(measured, after)| measured - after).collect(),
            diagnosis,
            recording,
            time_s: column(&recording.drive.time_s),
            input: column(&recording.drive.input.values),
            measured,
            before: simulated(&diagnosis.residual_before),
            after,
            error_before: spread(&|i| diagnosis.residual_before[i]),
        }
    }

    /// Name and unit of the input.
    pub fn input_axis(&self) -> String {
        self.recording.drive.input.channel.to_string()
    }

    /// The output's unit.
    pub fn unit(&self) -> String {
        self.recording.output.channel.unit.to_string()
    }

    /// Measured and simulated output over time.
    pub fn traces<'b>(&'b self, title: &str, simulated: &'b [f64]) -> Plot<'b> {
        self.output_plot(title, "time (s)".to_owned(), &self.time_s, simulated)
    }

    /// Measured and simulated output over the input.
    pub fn loops<'b>(&'b self, title: &str, simulated: &'b [f64]) -> Plot<'b> {
        self.output_plot(title, self.input_axis(), &self.input, simulated)
    }

    fn output_plot<'b>(&'b self, title: &str, x: String, over: &'b [f64], simulated: &'b [f64]) -> Plot<'b> {
        let line = |name, style, y| Line { name, style, x: over, y };
        Plot {
            title: title.to_owned(),
            x,
            y: self.recording.output.channel.to_string(),
            lines: vec![
                line("measured", Style::Measured, &self.measured),
                line("model", Style::Model, simulated),
            ],
            ..Plot::default()
        }
    }

    /// The errors without and with the named causes, over time.
    pub fn errors(&self) -> Plot<'_> {
        let line = |name, style, y| Line { name, style, x: &self.time_s, y };
        Plot {
            title: "Error before and after".to_owned(),
            x: "time (s)".to_owned(),
            y: self.error_axis(),
            lines: vec![
                line("before", Style::Model, &self.error_before),
                line("after", Style::Measured, &self.error_after),
            ],
            ..Plot::default()
        }
    }

    /// Name and unit of errors.
    pub fn error_axis(&self) -> String {
        format!("error ({})", self.unit())
    }

    /// Errors with names as bars, beside the noise.
    pub fn heldout_bars(&self, title: &str, errors: &[(&str, f64)], noise: f64) -> Markup {
        let values: Vec<[f64; 1]> = errors.iter().map(|error| [error.1]).collect();
        let groups: Vec<Bar<'_>> = errors
            .iter()
            .zip(&values)
            .map(|((name, _), values)| Bar { name, values, is_chosen: false })
            .collect();
        let mark = Mark { name: "noise of the sensor", value: noise };
        bars(&format!("{title} ({})", self.unit()), &[], &groups, Some(&mark))
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
