//! A tracking run as plots.

use super::plot::{Line, Plot, Style};
use crate::figures::Figures;
use crate::pil::lock_step::{Run, Sample};
use crate::table::{DataError, Table};

/// A tracking run: the columns of its log that the plots need, a value a tick.
pub struct Tracking {
    time_s: Vec<f64>,
    reference_mm: Vec<f64>,
    contraction_mm: Vec<f64>,
    pressure_bar: Vec<f64>,
    errors_mm: Vec<f64>,
}

impl Tracking {
    /// Takes the run from a log.
    ///
    /// # Errors
    /// A column is missing.
    pub fn of_log(log: &Table) -> Result<Self, DataError> {
        let column = |name| log.first_column(&[name]).map(|(_, values)| values.to_vec());
        Ok(Self::new(
            column("time_s")?,
            column("reference_mm")?,
            column("contraction_mm")?,
            column("pressure_bar")?,
        ))
    }

    /// Takes the run as it was made.
    pub fn of_run(run: &Run) -> Self {
        let column = |value: fn(&Sample) -> f64| run.samples.iter().map(value).collect();
        Self::new(
            column(|sample| sample.time_s),
            column(|sample| sample.reference_mm),
            column(|sample| sample.measured.contraction_mm),
            column(|sample| sample.measured.pressure_bar),
        )
    }

    fn new(
        time_s: Vec<f64>,
        reference_mm: Vec<f64>,
        contraction_mm: Vec<f64>,
        pressure_bar: Vec<f64>,
    ) -> Self {
        let errors_mm = reference_mm.iter().zip(&contraction_mm).map(|(wanted, is)| wanted - is).collect();
        Self { time_s, reference_mm, contraction_mm, pressure_bar, errors_mm }
    }

    /// How far the muscle is from its reference. Unit: mm.
    pub fn figures(&self) -> Figures {
        Figures::of(&self.reference_mm, &self.contraction_mm, &vec![true; self.time_s.len()])
    }

    /// Desired and actual contraction over time.
    pub fn response(&self, title: &str) -> Plot<'_> {
        let line = |name, style, y| Line { name, style, x: &self.time_s, y };
        let lines = vec![
            line("actual", Style::Measured, &self.contraction_mm),
            line("desired", Style::Model, &self.reference_mm),
        ];
        plot(title, "time (s)", "contraction (mm)", lines)
    }

    /// Desired less actual contraction over time.
    pub fn error(&self, title: &str) -> Plot<'_> {
        let line = Line { name: "error", style: Style::Error, x: &self.time_s, y: &self.errors_mm };
        plot(title, "time (s)", "desired less actual (mm)", vec![line])
    }

    /// The loops that the muscle is driven around.
    pub fn loops(&self, title: &str) -> Plot<'_> {
        let line =
            Line { name: "measured", style: Style::Measured, x: &self.pressure_bar, y: &self.contraction_mm };
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
}

fn plot<'a>(title: &str, x: &str, y: &str, lines: Vec<Line<'a>>) -> Plot<'a> {
    Plot { title: title.to_owned(), x: x.to_owned(), y: y.to_owned(), lines, ..Plot::default() }
}
