//! Figs. 8, 11, 12 and 13 of the paper, redrawn from an own recording, model and tracking run.

use maud::{Markup, html};

use super::DrawingError;
use super::model_run::ModelRun;
use super::page::page;
use super::plot::{Line, Plot, Style};
use crate::figures::Figures;
use crate::recording::Recording;
use crate::table::{DataError, Table};

/// A tracking run: the columns of its log that the figures need, a value a tick.
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
    pub fn of(log: &Table) -> Result<Self, DataError> {
        let column = |name| log.first_column(&[name]).map(|(_, values)| values.to_vec());
        let (reference_mm, contraction_mm) = (column("reference_mm")?, column("contraction_mm")?);
        Ok(Self {
            time_s: column("time_s")?,
            errors_mm: reference_mm.iter().zip(&contraction_mm).map(|(wanted, is)| wanted - is).collect(),
            reference_mm,
            contraction_mm,
            pressure_bar: column("pressure_bar")?,
        })
    }

    fn figures(&self) -> Figures {
        Figures::of(&self.reference_mm, &self.contraction_mm, &vec![true; self.time_s.len()])
    }

    /// Fig. 11.
    fn responses(&self) -> [Plot<'_>; 2] {
        let over_time = |title: &str, y: &str, lines| Plot {
            title: title.to_owned(),
            x: "time (s)".to_owned(),
            y: y.to_owned(),
            lines,
            ..Plot::default()
        };
        let line = |name, style, y| Line { name, style, x: &self.time_s, y };
        [
            over_time(
                "(a) Trajectory tracking response",
                "contraction (mm)",
                vec![
                    line("actual", Style::Measured, &self.contraction_mm),
                    line("desired", Style::Model, &self.reference_mm),
                ],
            ),
            over_time(
                "(b) Error",
                "desired less actual (mm)",
                vec![line("error", Style::Error, &self.errors_mm)],
            ),
        ]
    }

    /// Fig. 12.
    fn loops(&self) -> Plot<'_> {
        Plot {
            title: "Length-pressure loops of the muscle while it tracks".to_owned(),
            x: "pressure (bar)".to_owned(),
            y: "contraction (mm)".to_owned(),
            lines: vec![Line {
                name: "measured",
                style: Style::Measured,
                x: &self.pressure_bar,
                y: &self.contraction_mm,
            }],
            ..Plot::default()
        }
    }

    /// Fig. 13.
    fn linearity(&self) -> Plot<'_> {
        let line = |name, style, y| Line { name, style, x: &self.reference_mm, y };
        Plot {
            title: "Desired and actual length".to_owned(),
            x: "desired contraction (mm)".to_owned(),
            y: "actual contraction (mm)".to_owned(),
            lines: vec![
                line("actual", Style::Measured, &self.contraction_mm),
                line("actual = desired", Style::Model, &self.reference_mm),
            ],
            ..Plot::default()
        }
    }
}

/// The report as an HTML file. `simulated`: the model's output for every row of the recording, output unit.
///
/// # Errors
/// A plot cannot be drawn.
pub fn to_html(
    recording: &Recording,
    simulated: &[f64],
    tracking: &Tracking,
    source: &str,
) -> Result<String, DrawingError> {
    let run = ModelRun::new(recording, simulated);
    let (fit, stroke) = (recording.figures(simulated), recording.stroke());
    let model = [
        run.input("(a) Input"),
        run.loops("(b) Hysteresis loops"),
        run.output("(c) Length"),
        run.error("(d) Error"),
    ];
    let unit = recording.output.channel.unit;
    let missed = tracking.figures();
    let body = html! {
        (section("Fig. 8: the model beside the recording", &model)?)
        p { "The model's figures: " (fit.in_words(stroke, unit)) "." }
        (section("Fig. 11: tracking with the inverse model and feedback", &tracking.responses())?)
        p { "Tracking: " (missed.in_words(stroke, unit)) "." }
        (section("Fig. 12: loops while tracking", &[tracking.loops()])?)
        p { "The hysteresis that the controller drives the muscle around." }
        (section("Fig. 13: desired and actual length", &[tracking.linearity()])?)
        p { "On the dashed line both are equal; what is left of the hysteresis is at most "
            (format!("{:.3} {unit}", missed.max_error)) " from it." }
    };
    Ok(page("The paper's figures from own measurements", &body, source))
}

fn section(title: &str, plots: &[Plot<'_>]) -> Result<Markup, DrawingError> {
    let figures = plots.iter().map(Plot::figure).collect::<Result<Vec<_>, _>>()?;
    Ok(html! {
        h2 { (title) }
        div.plots { @for figure in figures { (figure) } }
    })
}
