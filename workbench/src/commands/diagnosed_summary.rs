//! What `mgpi diagnose` prints.

use std::path::Path;

use crate::diagnosis::anatomy::examinable::Inseparable;
use crate::diagnosis::extend::{Extended, HeldOutGain, Written};
use crate::diagnosis::verdict::Named;
use crate::diagnosis::words::{experiment, in_a_sentence, unexamined, written as what_is_written};
use crate::diagnosis::{Diagnosis, Smoothing, Verdict};
use crate::recording::Recording;

/// Prints a diagnosis of a file, with the file that the model went to, if one was asked for.
pub fn print(
    (file, model_file): (&Path, Option<&Path>),
    (diagnosis, recording): (&Diagnosis, &Recording),
    (extended, gain, written): (&Extended, &HeldOutGain, &Written),
    seconds: f64,
) {
    let unit = recording.output.channel.unit;
    say!("{}: {}", file.display(), diagnosis.verdict.name());
    say!("{}", in_a_sentence(diagnosis, unit));
    if let Some(given) = extended.given.filter(|given| given.is_of_another_muscle()) {
        say!(
            "another muscle  the given model errs by {:.3} {unit}, its form fitted to this recording by {:.3} {unit}",
            given.rmse,
            given.refitted_rmse
        );
    }
    errors((diagnosis, recording), (extended, gain, written));
    let words = what_is_written(written, unit);
    match model_file {
        Some(model_file) => say!("written       {}: {words}", model_file.display()),
        None => say!("best model    {words}; -o writes it"),
    }
    for named in &diagnosis.causes {
        cause(named.cause.name(), named);
    }
    for named in &diagnosis.best_fit {
        cause(&format!("({})", named.cause.name()), named);
    }
    for set in &diagnosis.alternatives {
        let names: Vec<&str> = set.iter().map(|cause| cause.name()).collect();
        say!("as well       {}", names.join(" and "));
    }
    if let Some(Smoothing { noise, left }) = diagnosis.smoothing {
        let channel = &recording.drive.input.channel;
        say!(
            "smoothed      {}: its noise of {noise:.3} {} would pass for movement; {left:.3} {} of it are left",
            channel.name,
            channel.unit,
            channel.unit
        );
    }
    recording.left_out.say();
    let Inseparable { causes, why } = &diagnosis.inseparable;
    if !causes.is_empty() {
        let names: Vec<&str> = causes.iter().map(|cause| cause.name()).collect();
        say!("not told apart {}: {}", names.join(", "), why.join("; "));
    }
    if let Some(words) = unexamined(diagnosis) {
        say!("not excluded  {words}");
    }
    if let Some(command) = experiment(diagnosis) {
        let what = if diagnosis.verdict == Verdict::Unexplained { "to see it" } else { "to separate" };
        say!("{what:<14}{command}");
    }
    for judged in diagnosis.examinable.iter().filter(|judged| !judged.examinable) {
        say!("not examined  {}: {}", judged.cause, judged.why);
    }
    say!("{seconds:.1} s");
}

/// The errors of the simulated models: with and without the named causes, or of the one that is written.
fn errors(
    (diagnosis, recording): (&Diagnosis, &Recording),
    (extended, gain, written): (&Extended, &HeldOutGain, &Written),
) {
    let unit = recording.output.channel.unit;
    let percent = |rmse: f64| 100.0 * rmse / recording.stroke();
    if diagnosis.causes.is_empty() {
        let (rmse, held, noise) = (written.rmse, written.gain.after.rmse, written.gain.noise_floor);
        let from = if written.from_command { ", from the command" } else { "" };
        say!("simulated     RMSE {rmse:.3} {unit} ({:.2} % of stroke){from}", percent(rmse));
        say!("held out      RMSE {held:.3} {unit}; noise {noise:.3} {unit}");
        return;
    }
    let (before, after) = (extended.baseline_rmse, extended.extended_rmse);
    say!(
        "simulated     RMSE {before:.3} {unit} without, {after:.3} {unit} ({:.2} % of stroke) with the causes",
        percent(after)
    );
    say!(
        "held out      RMSE {:.3} {unit} without, {:.3} {unit} with the causes (+- {:.3}); noise {:.3} {unit}",
        gain.before.rmse,
        gain.after.rmse,
        gain.gain_error,
        gain.noise_floor
    );
    if !extended.gains(gain) {
        say!(
            "no sure gain  on the other recording the causes gain no more than chance; the model is written without them"
        );
    }
}

/// A cause with its parameters and what speaks for it.
fn cause(name: &str, named: &Named) {
    let parameters: Vec<String> =
        named.parameters.iter().map(|(name, value)| format!("{name} {value:.4}")).collect();
    say!("{name:<22}{}", parameters.join(", "));
    for words in &named.evidence {
        say!("{:<22}{words}", "");
    }
}
