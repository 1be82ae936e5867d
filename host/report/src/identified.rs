//! Report of an identification: loops, time series, errors, the parts of the model, parameters.

use maud::{Markup, html};
use model_core::ParameterError;

use super::model_run::ModelRun;
use super::page::{explained, page, reading};
use super::parameters::parameters;
use super::parts::parts;
use super::table::{Row, table};
use identification::Uncertainty;
use recording::Recording;
use recording::figures::Figures;
use recording::model_file::{HeldOut, Identification, ModelFile};
use recording::numbers::legible;
use recording::worth::Grade;

/// What an identification reports on.
pub struct Identified<'a> {
    /// The identified model.
    pub model: &'a ModelFile,
    /// How it was identified.
    pub identification: &'a Identification,
    /// The recording.
    pub recording: &'a Recording,
    /// The model's output for every row. Output unit.
    pub simulated: &'a [f64],
    /// What it, or a model of the first part alone, was tried on: the held-out rows are those that
    /// are scored; a value a row, output unit.
    pub heldout: Option<(&'a Recording, &'a [f64])>,
    /// What is known about the raw parameters.
    pub uncertainty: &'a Uncertainty,
}

impl Identified<'_> {
    /// The report as an HTML file.
    ///
    /// # Errors
    /// The parameters are not those of a model.
    pub fn to_html(&self) -> Result<String, ParameterError> {
        let run = ModelRun::new(self.recording, self.simulated);
        let (input, output) = (self.model.input.words(), self.model.output.words());
        let plots = [
            (
                run.loops(&format!("Loops: {output} over {input}")),
                "Where the two lines part, the model has the wrong shape.",
            ),
            (
                run.error("Error over time"),
                "What comes back alike in every cycle is the model's fault; what grows with time \
                is drift or creep, which these models do not have.",
            ),
            (
                run.error_over_input("Error over the input"),
                "Apart by direction: the loop has the wrong width there. \
                Both alike: the middle of the loop is wrong. A narrow band about 0 is noise.",
            ),
            (
                run.output(&format!("Output: {output} over time")),
                "Rows that are not scored are shown here, too.",
            ),
            (run.input(&format!("Input: {input} over time")), "What drove the muscle, and the model."),
        ];
        let parts = parts(self.model)?;
        let file = self.recording.drive.file.file_name().unwrap_or_default().display().to_string();
        let body = html! {
            (self.figures())
            (reading(&file, &self.recording.drive.notes))
            (explained(&plots))
            (self.tried())
            h2 { "The parts of the model" }
            (explained(&parts.iter().map(|part| (part.plot(), part.words)).collect::<Vec<_>>()))
            (parameters(self.uncertainty, &self.model.names()))
        };
        let title = format!("Model of {file}: {output} over {input}");
        let source = format!("Recording with SHA-256 {}", self.identification.recording.sha256);
        Ok(page(&title, &body, &source))
    }

    /// The held-out rows.
    fn tried(&self) -> Markup {
        let Some(((recording, simulated), heldout)) = self.heldout.zip(self.identification.heldout.as_ref())
        else {
            return html! {};
        };
        let run = ModelRun::new(recording, simulated);
        let plots = [
            (
                run.loops("Held out: loops"),
                "Wider apart than in training: the model has learnt the recording, not the muscle.",
            ),
            (
                run.error("Held out: error over time"),
                "An error that grows from the first row on is drift or creep; one that comes with new amplitudes is the model's.",
            ),
            (
                run.output("Held out: output over time"),
                "Rows that are not held out, or not scored, are shown here, too.",
            ),
        ];
        html! {
            h2 { "Held out" }
            p { @match heldout.from_s {
                Some(from_s) => {
                    "A model of the rows before " (format!("{from_s:.2}")) " s, on the rows from there on: it has not seen them."
                }
                None if heldout.by_recording => {
                    "Each recording by a model of the others, one behind the other: it has not seen them."
                }
                None => { "The model on " (heldout.recording.file) ", which it has not seen." }
            } }
            (explained(&plots))
        }
    }

    fn figures(&self) -> Markup {
        let Identification { training, heldout, stroke, termination, starts, scored_rows, .. } =
            self.identification;
        let (unit, worth) = (self.model.output.unit, self.identification.worth());
        let headings = [
            "rows".to_owned(),
            format!("RMSE ({unit})"),
            "RMSE (% of stroke)".to_owned(),
            format!("mean absolute error ({unit})"),
            format!("largest error ({unit})"),
        ];
        let row = |(name, figures): (&str, &Figures)| {
            let Figures { rmse, mae, max_error } = figures;
            let percent = format!("{:.2}", 100.0 * rmse / stroke);
            vec![name.to_owned(), legible(*rmse, 4), percent, legible(*mae, 4), legible(*max_error, 4)].into()
        };
        let heldout_figures = heldout.iter().map(|heldout| ("held out", &heldout.figures));
        let rows: Vec<Row> = [("of the fit", training)].into_iter().chain(heldout_figures).map(row).collect();
        html! {
            @match worth.grade() {
                Grade::Poor => {
                    p.verdict.warning role="alert" { "This model does not describe the recording: " (worth) "." }
                }
                _ => { p.verdict { "The model is " (worth) "." } }
            }
            @if worth.limit.is_none() {
                p { "What limits it is not the noise of the sensor, but its form or something else than the input that acts: "
                    code { "mgpi diagnose" } " tells which." }
            }
            (table(&headings, &rows))
            p { "Of the fit: the " (scored_rows) " scored rows."
                @if let Some(HeldOut { recording, from_s, by_recording, .. }) = heldout {
                    " Held out: "
                    @match from_s {
                        Some(from_s) => {
                            "the rows from " (format!("{from_s:.2}")) " s on, by a model of the rows before."
                        }
                        None if *by_recording => { "each recording, by a model of the others." }
                        None => { "the recording " (recording.file) "." }
                    }
                }
                " The stroke is " (legible(*stroke, 2)) " " (unit) ". The best of " (starts) " starts "
                (termination) "."
                @if worth.may_deploy() { " The model is strictly increasing, and so invertible." }
            }
            @for words in self.recording.left_out.in_words() {
                p { "Not scored: " (words) "." }
            }
            @if self.recording.drive.scored.contains(&false) {
                p { "Rows that are not valid are history of the input only: they are not scored, and leave gaps "
                    "in the loops and in the error." }
            }
        }
    }
}
