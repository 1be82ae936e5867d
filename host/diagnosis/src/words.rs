//! A diagnosis in words: the verdict in a sentence, and the experiment that is left to be made.

use super::causes::Cause;
use super::extend::Written;
use super::fitted::Parameters;
use super::poor::Poor;
use super::reject::Unexplained;
use super::shown::quantity;
use super::slips::Slips;
use super::stuck::Stuck;
use super::{Diagnosis, Verdict};
use recording::model_file::names::Names;
use recording::numbers::legible;
use recording::numbers::significant;
use recording::unit::Unit;
use recording::worth::DEPLOYABLE;

/// The verdict in a sentence.
pub fn in_a_sentence(diagnosis: &Diagnosis, unit: Unit) -> String {
    let names: Vec<&str> = diagnosis.causes.iter().map(|named| named.cause.name()).collect();
    let none = match diagnosis.unexamined.is_empty() {
        true => "None of the causes",
        false => "None of the causes that this recording can show",
    };
    match diagnosis.verdict {
        Verdict::Adequate if diagnosis.unexamined.is_empty() => {
            "The operator model describes the recording; no cause is named.".to_owned()
        }
        Verdict::Adequate => format!(
            "The operator model describes what this recording can show, and no cause is named; but {} would explain a part of the \
             error, and whether it is there this recording cannot show.",
            alternatives(&diagnosis.unexamined)
        ),
        Verdict::Explained => {
            format!("What the operator model gets wrong is explained by {}.", names.join(" and "))
        }
        Verdict::Confounded => format!(
            "{} would explain it, and so would other causes; this recording does not tell them apart.",
            names.join(" and ")
        ),
        Verdict::Unexplained => match &diagnosis.unexplained {
            Some(Unexplained::Outliers { rows, largest }) => {
                format!(
                    "{none}: {rows} single rows are off their neighbours, by up to {} {unit}.",
                    legible(*largest, 2)
                )
            }
            Some(Unexplained::Stuck(Stuck { rows, longest_s })) => format!(
                "{none}: in {rows} rows the same value is read again while the muscle goes on, for up to {longest_s:.2} s."
            ),
            Some(Unexplained::Slips(Slips { jump, .. })) => format!(
                "{none}: the reading sticks and jumps, by about {} {unit}, while the muscle moves.",
                legible(*jump, 2)
            ),
            Some(Unexplained::Poor(poor)) => described_poorly(poor, unit),
            Some(Unexplained::NotSimulated) => {
                format!("{none}: no model with those that fit best can be simulated.")
            }
            Some(Unexplained::NoGain { before, after }) => format!(
                "{none}: simulated with those that fit best a model is off by {} {unit}, without them by {} {unit}.",
                legible(*after, 3),
                legible(*before, 3)
            ),
            Some(Unexplained::NotRepeatable { pure_error, tones_hz }) => {
                let tones: Vec<String> = tones_hz.iter().map(|hz| format!("{hz:.3} Hz")).collect();
                let tones = if tones.is_empty() {
                    "without a tone".to_owned()
                } else {
                    format!("with peaks at {}", tones.join(", "))
                };
                format!(
                    "{none}: visits to the same state differ by {} {unit}, {tones}; \
                     something acts that no column shows.",
                    legible(*pure_error, 2)
                )
            }
            None => format!("{none} explains it."),
        },
    }
}

/// Causes of which each is enough.
fn alternatives(causes: &[Cause]) -> String {
    let names: Vec<&str> = causes.iter().map(|cause| cause.name()).collect();
    names.join(" or ")
}

/// How far the model that is written is off, and from what that shows.
fn described_poorly(Poor { rmse, percent_of_stroke, better, limit }: &Poor, unit: Unit) -> String {
    let why = limit.map_or(String::new(), |limit| format!(" In this recording {}.", limit.reason()));
    let off = format!(
        "The operator model is off by {} {unit}, {percent_of_stroke:.1} % of the stroke",
        legible(*rmse, 3)
    );
    match better {
        Some((better, rmse)) => format!(
            "{off}, and {} by {} {unit}: this kind of model does not describe the recording.{why}",
            better.words(),
            legible(*rmse, 3)
        ),
        None => format!(
            "{off}, more than the {:.0} % up to which a model may drive a valve: none of the causes explains that.{why}",
            100.0 * DEPLOYABLE
        ),
    }
}

/// What causes would do that the recording cannot show; None where there are none.
pub fn unexamined(diagnosis: &Diagnosis) -> Option<String> {
    let Diagnosis { unexplained, unexamined, examinable, .. } = diagnosis;
    let is_unseen =
        |cause: &&Cause| examinable.iter().any(|judged| judged.cause == **cause && !judged.examinable);
    let unseen: Vec<&str> = unexamined.iter().filter(is_unseen).map(|cause| cause.name()).collect();
    let all: Vec<&str> = unexamined.iter().map(|cause| cause.name()).collect();
    let does = match unexplained.is_none() {
        true => "would do as well as what is named, or better",
        false => "would leave nothing unexplained, perhaps others like it too",
    };
    // Beside an adequate model the verdict's own sentence says it.
    (!all.is_empty() && diagnosis.verdict != Verdict::Adequate).then(|| {
        format!("{} {does}; but this recording cannot show {}", all.join(" and "), unseen.join(" and "))
    })
}

/// The command that writes an excitation which separates what is confounded, or what is named from what the recording does not tell
/// apart from it.
pub fn experiment(diagnosis: &Diagnosis) -> Option<String> {
    let Diagnosis { verdict, causes, alternatives, inseparable, unexamined, .. } = diagnosis;
    let mut names: Vec<&str> = Vec::new();
    if *verdict == Verdict::Confounded {
        names.extend(causes.iter().map(|named| named.cause.name()));
        names.extend(alternatives.iter().flatten().map(|cause| cause.name()));
    }
    let is_named = matches!(verdict, Verdict::Confounded | Verdict::Explained);
    if is_named && causes.iter().any(|named| inseparable.causes.contains(&named.cause)) {
        names.extend(inseparable.causes.iter().map(|cause| cause.name()));
    }
    names.extend(unexamined.iter().map(|cause| cause.name()));
    names.sort_unstable();
    names.dedup();
    (!names.is_empty()).then(|| format!("mgpi plan --causes {} -o plan.csv", names.join(",")))
}

/// The model that is written, and what it is worth beside the plain one.
pub fn written(written: &Written, units: Names) -> String {
    let Written { model, from_command, .. } = written;
    let unit = units.output;
    let (rmse, plain_rmse) = (legible(written.rmse, 3), legible(written.plain_rmse, 3));
    let from = if *from_command { " from the command" } else { "" };
    let form = model.form();
    if !written.is_extended() {
        return format!("{form} without extensions; {rmse} {unit}");
    }
    let extensions: Vec<String> = written.extensions().iter().map(|all| extension(all, units)).collect();
    let zero = model.jump.map_or("", |_| "; written with the zero behind the jump");
    format!(
        "{form} with {}; {rmse} {unit} instead of {plain_rmse} {unit}{from}{zero}",
        extensions.join(" and ")
    )
}

/// A cause with the first of its parameters.
fn extension((cause, parameters): &(Cause, Parameters), units: Names) -> String {
    let Some((name, value)) = parameters.first() else { return cause.name().to_owned() };
    let (words, unit) = quantity(name, units);
    format!("{} ({words} {} {unit})", cause.name(), significant(*value))
}
