//! Report of a diagnosis: before, the misfit, the causes with the evidence for and against them,
//! after.
//!
//! | file | what it does |
//! |---|---|
//! | `view` | the scored rows as lines over time and over the input |
//! | `misfit` | the anatomy of the error, as pictures |
//! | `causes` | what is named, with its parameters |
//! | `evidence` | the named causes against none and against their rivals, as bars |
//! | `valve` | command and pressure, with what the found valve makes of the command |
//! | `after` | the models without and with the named causes on one scale |
//!
//! # Contract
//! What is bold in lists is named by the verdict.

mod after;
mod causes;
mod evidence;
mod misfit;
mod valve;
mod view;

use maud::{Markup, html};

use self::view::View;
use super::page::{explained, page, reading};
use super::plot::Style;
use diagnosis::anatomy::examinable::Inseparable;
use diagnosis::diagnosed::{Diagnosed, Examined};
use diagnosis::extend::{Extended, HeldOutGain, Written};
use diagnosis::words::{experiment, in_a_sentence, unexamined, written as what_is_written};
use diagnosis::{Diagnosis, Verdict};
use recording::Recording;
use recording::model_file::names::Names;
use recording::numbers::significant;

/// An extended model and what it gains.
struct Gained<'a> {
    /// The model.
    extended: &'a Extended,
    /// The gain.
    gain: &'a HeldOutGain,
    /// The model that is written.
    written: &'a Written,
    /// The recording that it was counted on, if that is another.
    other: Option<String>,
}

/// The report as an HTML file.
pub fn to_html(found: &Diagnosed) -> String {
    let Diagnosed { diagnosis, extended, gain, written, examined, other, .. } = found;
    let Examined { columns, recording, .. } = examined;
    let other = other.as_ref().map(|other| other.drive.file.display().to_string());
    let gained = Some(&Gained { extended, gain, written, other });
    let Recording { drive, output, .. } = recording;
    let view = View::new(diagnosis, recording);
    let file = drive.file.file_name().unwrap_or_default().display().to_string();
    let body = html! {
        p.verdict { (in_a_sentence(diagnosis, output.channel.unit)) }
        (reading(&file, &drive.notes))
        (before(&view))
        (misfit::section(&view))
        (causes::section(diagnosis, Names::of(recording)))
        (evidence::section(diagnosis, output.channel.unit))
        (valve::section(&view, columns))
        (confounded(diagnosis))
        (after::section(&view, columns, gained))
        @if let Some(Gained { written, .. }) = gained {
            p { "The model that is written: " (what_is_written(written, Names::of(recording))) "." }
        }
        (unseen(diagnosis, recording))
    };
    let title =
        format!("Diagnosis of {file}: {} over {}", output.channel.words(), drive.input.channel.words());
    page(&title, &body, &format!("Recording with SHA-256 {}", drive.sha256))
}

fn before(view: &View<'_>) -> Markup {
    const NAME: &str = "flexible hysteresis";
    let simulated = view.measured_less(&view.residual);
    let plots = [
        (
            view.output_over_time(
                "Before: over time",
                vec![
                    view.line("measured", Style::Measured, &view.measured),
                    view.line(NAME, Style::Model, &simulated),
                ],
            ),
            "The muscle, and what the model simulates from the same input.",
        ),
        (
            view.loops("Before: as a loop".to_owned(), (view.input_axis(), &view.input), (NAME, &simulated)),
            "Where the two lines part, the model has the wrong shape, or something else than the input acts.",
        ),
    ];
    html! {
        h2 { "Before: the best hysteresis" }
        p { "A model of hysteresis alone: it knows the history of the input, but no speed, no time, no load and no temperature. \
            It may take the form of any such hysteresis, so what it gets wrong is not a matter of its shape. The \
            errors below are measured against it." }
        (explained(&plots))
    }
}

/// Whether the causes of a diagnosis are named by its verdict.
fn are_causes_named(verdict: Verdict) -> bool {
    matches!(verdict, Verdict::Explained | Verdict::Confounded)
}

fn confounded(diagnosis: &Diagnosis) -> Markup {
    html! {
        @let Inseparable { causes, why } = &diagnosis.inseparable;
        @let command = experiment(diagnosis);
        @if command.is_some() || !causes.is_empty() {
            h2 { "What cannot be told apart, and the experiment that would" }
        }
        @if diagnosis.verdict == Verdict::Confounded {
            p { "As well as the named causes do:" }
            ul { @for set in &diagnosis.alternatives { li { (evidence::name(set)) } } }
        }
        @if !causes.is_empty() {
            p { "This recording does not tell apart " (evidence::name(causes)) ": " (why.join("; ")) "." }
        }
        @if let Some(words) = unexamined(diagnosis) {
            p { "Not excluded: " (words) "." }
        }
        @if let Some(command) = command {
            p { "This command writes an excitation whose recording tells more; play it, and diagnose its recording:" }
            p { code { (command) } }
        }
    }
}

fn unseen(diagnosis: &Diagnosis, recording: &Recording) -> Markup {
    let (seen, unseen): (Vec<_>, Vec<_>) = diagnosis.examinable.iter().partition(|judged| judged.examinable);
    let seen: Vec<&str> = seen.iter().map(|judged| judged.cause.name()).collect();
    html! {
        h2 { "What this recording could not show" }
        p { "Examined were: " (seen.join(", ")) "." }
        @for words in recording.left_out.in_words() {
            p { "Not scored: " (words) "." }
        }
        @if unseen.is_empty() {
            p { "Nothing was left out." }
        } @else {
            p { "Not examined, and so neither named nor excluded:" }
            dl { @for judged in &unseen {
                dt { (judged.cause.name()) }
                dd { (judged.cause.meaning()) ". Not examined: " (judged.why) "." }
            } }
        }
    }
}

/// A number with its unit.
fn with_unit(value: f64, unit: impl std::fmt::Display) -> String {
    format!("{} {unit}", significant(value))
}
