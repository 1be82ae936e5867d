//! Report of a diagnosis: before, the misfit, the causes with the evidence for and against them, after.
//!
//! | file | what it does |
//! |---|---|
//! | `view` | the scored rows as lines over time and over the input |
//! | `misfit` | the anatomy of the error, as pictures |
//! | `causes` | what is named, with its parameters |
//! | `evidence` | the named causes against none and against their rivals, as bars |

mod causes;
mod evidence;
mod misfit;
mod view;

use maud::{Markup, html};

use self::view::View;
use super::bars::significant;
use super::page::{explained, page};
use crate::diagnosis::anatomy::examinable::Inseparable;
use crate::diagnosis::extend::{Extended, HeldOutGain};
use crate::diagnosis::words::{experiment, in_a_sentence, unexamined, unknown_past};
use crate::diagnosis::{Diagnosis, Verdict};
use crate::recording::Recording;

/// An extended model and what it gains.
pub struct Gained<'a> {
    /// The model.
    pub extended: &'a Extended,
    /// The gain.
    pub gain: &'a HeldOutGain,
    /// The recording that it was counted on, if that is another.
    pub other: Option<String>,
}

/// The report as an HTML file; `gained` where there is a model that runs free.
pub fn to_html(diagnosis: &Diagnosis, recording: &Recording, gained: Option<&Gained<'_>>) -> String {
    let Recording { drive, output } = recording;
    let view = View::new(diagnosis, recording, gained.map(|gained| &gained.extended.simulated[..]));
    let body = html! {
        p.verdict { (in_a_sentence(diagnosis, output.channel.unit)) }
        (before(&view))
        (misfit::section(&view))
        (causes::section(diagnosis))
        (evidence::section(diagnosis, output.channel.unit))
        (confounded(diagnosis))
        (after(&view, gained))
        (unseen(diagnosis))
    };
    let file = drive.file.file_name().unwrap_or_default().display().to_string();
    let title =
        format!("Diagnosis of {file}: {} over {}", output.channel.words(), drive.input.channel.words());
    page(&title, &body, &format!("Recording with SHA-256 {}", drive.sha256))
}

fn before(view: &View<'_>) -> Markup {
    let plots = [
        (
            view.traces("Before: over time", &view.before),
            "The muscle, and what the model says for the same input.",
        ),
        (
            view.loops("Before: as a loop", &view.before),
            "Where the two lines part, the model has the wrong shape, or something else than the input acts.",
        ),
    ];
    html! {
        h2 { "Before: the best operator model" }
        p { "A model of hysteresis alone: it knows the way of the input, but no speed, no time, no load and no temperature. \
            It may take the form of any such hysteresis, so what it gets wrong is not a matter of its shape." }
        (explained(&plots))
    }
}

/// The model with the named causes: what it says, and what it gains.
fn after(view: &View<'_>, gained: Option<&Gained<'_>>) -> Markup {
    if view.diagnosis.causes.is_empty() {
        return html! {
            h2 { "After" }
            p { "No cause is named, so nothing is added to the model." }
        };
    }
    let (before, after) =
        gained.map_or(view.diagnosis.heldout, |gained| (gained.gain.before.rmse, gained.gain.after.rmse));
    let noise = view.diagnosis.anatomy.noise.deviation;
    let share = 100.0 * (before - after) / (before - noise).max(f64::MIN_POSITIVE);
    let plots = [
        (view.traces("After: over time", &view.after), "The muscle, and the model with the named causes."),
        (view.loops("After: as a loop", &view.after), "What is left between the lines is not explained."),
        (view.errors(), "What the named causes take away, and what they leave."),
    ];
    html! {
        h2 { "After: with the named causes" }
        @match gained {
            Some(Gained { gain, other, .. }) => {
                p { "An operator model with the named causes as extensions, of the kind that runs on the board. It runs free: from \
                    its input and the recorded columns alone, never from the measured output. The errors are those on "
                    @match other {
                        Some(other) => { "the recording " (other) ", which took no part in anything." }
                        None => { "the rows from " (format!("{:.0}", gain.from_s)) " s on, by models of the rows before." }
                    }
                }
            }
            None => p { "The model with the named causes added, fitted together. The errors are those on blocks of time that \
                the fit has not seen." },
        }
        (view.heldout_bars("Held-out error", &[("before", before), ("after", after)], noise))
        p {
            @if after < before {
                "Of what could be gained, down to the noise of the sensor, that is " (format!("{share:.0}")) " %"
            } @else {
                "That is no gain: on what it has not seen, the model is no better with the causes than without"
            }
            @if let Some(Gained { gain, .. }) = gained {
                " (the difference is sure within " (with_unit(gain.gain_error, view.unit())) ")"
            }
            "."
            @if gained.is_some_and(|gained| !gained.gain.is_sure()) {
                " Chance may do as much: try the extended model on another recording before it is used for one."
            }
        }
        (explained(&plots))
    }
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

fn unseen(diagnosis: &Diagnosis) -> Markup {
    let (seen, unseen): (Vec<_>, Vec<_>) = diagnosis.examinable.iter().partition(|judged| judged.examinable);
    let seen: Vec<&str> = seen.iter().map(|judged| judged.cause.name()).collect();
    html! {
        h2 { "What this recording could not show" }
        p { "Examined were: " (seen.join(", ")) "." }
        @if let Some(past) = unknown_past(diagnosis) {
            p { "Not scored is " (past) "." }
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
