//! A model beside a recording, as plots.

use super::plot::{Line, Plot, Style};
use recording::Recording;
use recording::turning::rising;

/// A recording and the model's output for its input. Rows that are not scored leave gaps.
pub struct ModelRun<'a> {
    recording: &'a Recording,
    simulated: &'a [f64],
    measured_scored: Vec<f64>,
    simulated_scored: Vec<f64>,
    errors: Vec<f64>,
    /// The errors while the input rises, and while it falls.
    errors_by_direction: [Vec<f64>; 2],
}

impl<'a> ModelRun<'a> {
    /// `simulated`: a value a row, output unit.
    pub fn new(recording: &'a Recording, simulated: &'a [f64]) -> Self {
        let scored = |values: &[f64]| -> Vec<f64> {
            let rows = values.iter().zip(&recording.drive.scored);
            rows.map(|(&value, &scored)| if scored { value } else { f64::NAN }).collect()
        };
        let (measured_scored, simulated_scored) = (scored(&recording.output.values), scored(simulated));
        let errors: Vec<f64> = measured_scored.iter().zip(&simulated_scored).map(|(a, b)| a - b).collect();
        let rising = rising(&recording.drive.input.values);
        let errors_by_direction = [true, false].map(|way| {
            let rows = errors.iter().zip(&rising);
            rows.map(|(&error, &rising)| if rising == way { error } else { f64::NAN }).collect()
        });
        Self { recording, simulated, measured_scored, simulated_scored, errors, errors_by_direction }
    }

    /// The input over time.
    pub fn input(&self, title: &str) -> Plot<'_> {
        let input = &self.recording.drive.input;
        let line = self.over_time("", Style::Measured, &input.values);
        self.time_plot(title, input.channel.to_string(), vec![line])
    }

    /// The output over the input.
    pub fn loops(&self, title: &str) -> Plot<'_> {
        let x = &self.recording.drive.input.values;
        let line = |name, style, y| Line { name, style, x, y };
        Plot {
            title: title.to_owned(),
            x: self.recording.drive.input.channel.to_string(),
            y: self.recording.output.channel.to_string(),
            lines: vec![
                line("measured", Style::Measured, &self.measured_scored),
                line("model", Style::Model, &self.simulated_scored),
            ],
            ..Plot::default()
        }
    }

    /// The output over time, with the rows that are not scored.
    pub fn output(&self, title: &str) -> Plot<'_> {
        let output = &self.recording.output;
        let lines = vec![
            self.over_time("measured", Style::Measured, &output.values),
            self.over_time("model", Style::Model, self.simulated),
        ];
        self.time_plot(title, output.channel.to_string(), lines)
    }

    /// Measured less model over time.
    pub fn error(&self, title: &str) -> Plot<'_> {
        let line = self.over_time("measured less model", Style::Error, &self.errors);
        self.time_plot(title, format!("error ({})", self.recording.output.channel.unit), vec![line])
    }

    /// Measured less model over the input, by direction.
    pub fn error_over_input(&self, title: &str) -> Plot<'_> {
        let input = &self.recording.drive.input;
        let line = |name, style, y| Line { name, style, x: &input.values, y };
        let [rising, falling] = &self.errors_by_direction;
        Plot {
            title: title.to_owned(),
            x: input.channel.to_string(),
            y: format!("error ({})", self.recording.output.channel.unit),
            lines: vec![line("rising", Style::Measured, rising), line("falling", Style::Model, falling)],
            ..Plot::default()
        }
    }

    fn over_time<'b>(&'b self, name: &'b str, style: Style, y: &'b [f64]) -> Line<'b> {
        Line { name, style, x: &self.recording.drive.time_s, y }
    }

    fn time_plot<'b>(&self, title: &str, y: String, lines: Vec<Line<'b>>) -> Plot<'b> {
        let clock = self.recording.drive.sha256.clone();
        Plot { title: title.to_owned(), x: "time (s)".to_owned(), y, lines, clock, ..Plot::default() }
    }
}
