//! Report of a comparison: the table, the errors as bars, the loops of the best model beside those
//! of SGPI.

use maud::{Markup, html};
use model_core::Kind;

use super::bars::{Bar, bars};
use super::model_run::ModelRun;
use super::page::page;
use super::table::{self, grouped_table};
use identification::comparison::{Comparison, Outcome, Row};
use recording::numbers::legible;

/// The report as an HTML file.
pub fn to_html(comparison: &Comparison<'_>) -> String {
    let recording = comparison.recording;
    let (stroke, unit) = (recording.stroke(), recording.output.channel.unit);
    let body = html! {
        p { "Every model was identified from the same recording by the same search. " (comparison.heldout_in_words()) }
        (figures(comparison))
        p { "n plays, m dead zones; parameters: the independent numbers that were found. ME is the largest absolute "
            "error, MAE the mean one, RMSE the root of the mean square; per cent refer to the stroke of "
            (legible(stroke, 2)) " " (unit) ". -pl: a piecewise-linear envelope, else tanh; -free: each play has a weight of its own, else an exponential \
            density. Tick: the most instructions of the controller on the board, where that has been measured \
            (cargo xtask gates)." }
        @for (row, error) in comparison.refused() { p { (row.name()) ": " (error) "." } }
        (errors(comparison))
        (loops(comparison))
    };
    let file = recording.drive.file.file_name().unwrap_or_default().display().to_string();
    let source = format!("Recording with SHA-256 {}", recording.drive.sha256);
    page(&format!("Models of {file}: {}", recording.columns()), &body, &source)
}

fn figures(comparison: &Comparison<'_>) -> Markup {
    let best = comparison.best().map(|(row, _)| row.name());
    let row = |row: &Row| table::Row { cells: comparison.cells(row), is_chosen: Some(row.name()) == best };
    let rows: Vec<table::Row> = comparison.rows.iter().map(row).collect();
    grouped_table(&comparison.headings(), &rows)
}

fn errors(comparison: &Comparison<'_>) -> Markup {
    let unit = comparison.recording.output.channel.unit;
    let rows: Vec<(String, Vec<f64>)> = comparison
        .made()
        .map(|(row, Outcome { training, heldout, .. })| {
            (row.name(), [training.rmse].into_iter().chain(heldout.map(|heldout| heldout.rmse)).collect())
        })
        .collect();
    let best = comparison.best().map(|(row, _)| row.name());
    let rows: Vec<Bar<'_>> = rows
        .iter()
        .map(|(name, values)| Bar { name, values, is_chosen: best.as_ref() == Some(name) })
        .collect();
    html! {
        h2 { "How far each model is from the muscle" }
        (bars(&format!("Root mean square error ({unit})"), &["training", "held out"], &rows, None))
        p { "The shorter, the better. Where the lower line of a model is much longer than the upper one, it has "
            "learnt the recording rather than the muscle." }
    }
}

/// The best model's loops, and beside them those of the symmetric model, if it is another.
fn loops(comparison: &Comparison<'_>) -> Markup {
    let symmetric = |row: &Row| row.options.model == Kind::Sgpi && row.options.knots.is_none();
    let best = comparison.best();
    let other = comparison.made().find(|(row, _)| symmetric(row));
    let other = other.filter(|(row, _)| best.is_none_or(|(best, _)| best.name() != row.name()));
    let runs: Vec<_> = best
        .into_iter()
        .chain(other)
        .map(|(row, outcome)| (row.name(), ModelRun::new(comparison.recording, &outcome.simulated)))
        .collect();
    let plots = runs.iter().map(|(name, run)| run.loops(&format!("Loops of {name}")));
    let plots = plots.chain(runs.iter().map(|(name, run)| run.error(&format!("Error of {name}"))));
    html! {
        h2 { "The best model" @if other.is_some() { ", and the symmetric one" } }
        div.plots { @for plot in plots { (plot.figure()) } }
        p { "Where the two lines of a loop part, the model has the wrong shape there. An error that comes back alike in "
            "every cycle is the model's; one without a pattern is noise." }
    }
}
