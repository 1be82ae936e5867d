//! A tracking run as plots.

use maud::{Markup, html};

use super::plot::{Height, Line, Plot, Style};
use board_client::pil::lock_step::{Run, Sample};
use recording::figures::Figures;
use recording::table::{DataError, Table};

/// A tracking run: the columns of its log that the plots need, a value a tick.
pub struct Tracking {
    time_s: Vec<f64>,
    reference_mm: Vec<f64>,
    contraction_mm: Vec<f64>,
    errors_mm: Vec<f64>,
    pressure_bar: Vec<f64>,
    command_bar: Vec<f64>,
    feedforward_bar: Vec<f64>,
    feedback_bar: Vec<f64>,
}

impl Tracking {
    /// Takes the run from a log.
    ///
    /// # Errors
    /// A column is missing.
    pub fn of_log(log: &Table) -> Result<Self, DataError> {
        let column = |name| log.first_column(&[name]).map(|(_, values)| values.to_vec());
        Ok(Self {
            time_s: column("time_s")?,
            reference_mm: column("reference_mm")?,
            contraction_mm: column("contraction_mm")?,
            errors_mm: Vec::new(),
            pressure_bar: column("pressure_bar")?,
            command_bar: column("command_bar")?,
            feedforward_bar: column("feedforward_bar")?,
            feedback_bar: column("feedback_bar")?,
        }
        .with_errors())
    }

    /// Takes the run as it was made.
    pub fn of_run(run: &Run) -> Self {
        let column = |value: fn(&Sample) -> f64| run.samples.iter().map(value).collect();
        Self {
            time_s: column(|sample| sample.time_s),
            reference_mm: column(|sample| sample.reference_mm),
            contraction_mm: column(|sample| sample.measured.contraction_mm),
            errors_mm: Vec::new(),
            pressure_bar: column(|sample| sample.measured.pressure_bar),
            command_bar: column(|sample| sample.command_bar.into()),
            feedforward_bar: column(|sample| sample.feedforward_bar.into()),
            feedback_bar: column(|sample| sample.feedback_bar.into()),
        }
        .with_errors()
    }

    fn with_errors(self) -> Self {
        let rows = self.reference_mm.iter().zip(&self.contraction_mm);
        Self { errors_mm: rows.map(|(wanted, is)| wanted - is).collect(), ..self }
    }

    /// How far the muscle is from its reference. Unit: mm.
    pub fn figures(&self) -> Figures {
        Figures::of(&self.reference_mm, &self.contraction_mm, &vec![true; self.time_s.len()])
    }

    /// Desired and actual contraction over time.
    pub fn response(&self, title: &str) -> Plot<'_> {
        let lines = vec![
            self.over_time("actual", Style::Measured, &self.contraction_mm),
            self.over_time("desired", Style::Model, &self.reference_mm),
        ];
        time_plot(title, "contraction (mm)", lines)
    }

    /// Desired less actual contraction over time.
    pub fn error(&self, title: &str) -> Plot<'_> {
        let line = self.over_time("desired less actual", Style::Error, &self.errors_mm);
        time_plot(title, "error (mm)", vec![line])
    }

    /// Pressure and command over time.
    pub fn pressure(&self, title: &str) -> Plot<'_> {
        let lines = vec![
            self.over_time("measured pressure", Style::Measured, &self.pressure_bar),
            self.over_time("command", Style::Model, &self.command_bar),
        ];
        time_plot(title, "pressure (bar)", lines)
    }

    /// What the command is made of, over time.
    pub fn command(&self, title: &str) -> Plot<'_> {
        let lines = vec![
            self.over_time("feed-forward", Style::Measured, &self.feedforward_bar),
            self.over_time("feedback", Style::Error, &self.feedback_bar),
        ];
        time_plot(title, "command (bar)", lines)
    }

    /// All that a run has over time, plots over each other with one time axis.
    pub fn stack(&self, name: &str) -> Markup {
        let plots = [
            self.response(&format!("{name}: contraction and reference")),
            self.error(&format!("{name}: error")),
            self.pressure(&format!("{name}: pressure and command")),
            self.command(&format!("{name}: feed-forward and feedback")),
        ];
        html! {
            div.stack { @for plot in plots { (Plot { height: Height::Low, ..plot }.figure()) } }
        }
    }

    /// The loops that the muscle is driven around.
    pub fn loops(&self, title: &str) -> Plot<'_> {
        let line = Line { name: "", style: Style::Measured, x: &self.pressure_bar, y: &self.contraction_mm };
        plot(title, "pressure (bar)", "contraction (mm)", vec![line])
    }

    /// Actual over desired contraction.
    pub fn linearity(&self, title: &str) -> Plot<'_> {
        let line = |name, style, y| Line { name, style, x: &self.reference_mm, y };
        let lines = vec![
            line("actual", Style::Measured, &self.contraction_mm),
            line("actual = desired", Style::Model, &self.reference_mm),
        ];
        plot(title, "desired contraction (mm)", "actual contraction (mm)", lines)
    }

    fn over_time<'a>(&'a self, name: &'a str, style: Style, y: &'a [f64]) -> Line<'a> {
        Line { name, style, x: &self.time_s, y }
    }
}

/// Over the time of the reference, which all runs of a page have in common.
fn time_plot<'a>(title: &str, y: &str, lines: Vec<Line<'a>>) -> Plot<'a> {
    Plot { clock: "reference".to_owned(), ..plot(title, "time (s)", y, lines) }
}

fn plot<'a>(title: &str, x: &str, y: &str, lines: Vec<Line<'a>>) -> Plot<'a> {
    Plot { title: title.to_owned(), x: x.to_owned(), y: y.to_owned(), lines, ..Plot::default() }
}
