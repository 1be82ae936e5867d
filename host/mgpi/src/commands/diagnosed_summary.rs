//! What `mgpi diagnose` prints.

use std::path::Path;

use super::reading::say_left_out;
use diagnosis::anatomy::examinable::Inseparable;
use diagnosis::diagnosed::Diagnosed;
use diagnosis::shown::key;
use diagnosis::verdict::Named;
use diagnosis::words::{experiment, in_a_sentence, unexamined, written as what_is_written};
use diagnosis::{Smoothing, Verdict};
use recording::model_file::names::Names;
use recording::numbers::legible;

/// Prints a diagnosis of a file, with the file that the model went to, if one was asked for.
pub fn print((file, model_file): (&Path, Option<&Path>), found: &Diagnosed) {
    let Diagnosed { diagnosis, extended, written, examined, seconds, .. } = found;
    let recording = &examined.recording;
    let units = Names::of(recording);
    let unit = units.output;
    say!("{}: {}", file.display(), diagnosis.verdict.name());
    say!("{}", in_a_sentence(diagnosis, unit));
    if let Some(given) = extended.given.filter(|given| given.is_of_another_muscle()) {
        say!(
            "another muscle  the given model is off by {} {unit}, its form fitted to this recording by {} {unit}",
            legible(given.rmse, 3),
            legible(given.refitted_rmse, 3)
        );
    }
    errors(found);
    let on = if diagnosis.smoothing.is_some() { " on the input as measured" } else { "" };
    let words = format!("{}{on}", what_is_written(written, units));
    match model_file {
        Some(model_file) => say!("written       {}: {words}", model_file.display()),
        None => say!("best model    {words}; -o writes it"),
    }
    for named in &diagnosis.causes {
        cause(named.cause.name(), named, units);
    }
    for named in &diagnosis.best_fit {
        cause(&format!("({})", named.cause.name()), named, units);
    }
    for set in &diagnosis.alternatives {
        let names: Vec<&str> = set.iter().map(|cause| cause.name()).collect();
        say!("as well       {}", names.join(" and "));
    }
    if let Some(Smoothing { noise, left }) = diagnosis.smoothing {
        let channel = &recording.drive.input.channel;
        say!(
            "smoothed      {}: its noise of {} {} would pass for movement; {} {} of it are left",
            channel.name,
            legible(noise, 3),
            channel.unit,
            legible(left, 3),
            channel.unit
        );
    }
    say_left_out(&recording.left_out);
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

/// The errors of the simulated models: with and without the named causes, or of the one that is
/// written.
fn errors(found: &Diagnosed) {
    let Diagnosed { diagnosis, extended, gain, written, examined, .. } = found;
    let recording = &examined.recording;
    let unit = recording.output.channel.unit;
    let percent = |rmse: f64| 100.0 * rmse / recording.stroke();
    if diagnosis.causes.is_empty() {
        let [rmse, held, noise] =
            [written.rmse, written.gain.after.rmse, written.gain.noise_floor].map(|error| legible(error, 3));
        let from = if written.from_command { ", from the command" } else { "" };
        say!("simulated     RMSE {rmse} {unit} ({:.2} % of stroke){from}", percent(written.rmse));
        say!("held out      RMSE {held} {unit}; noise {noise} {unit}");
        return;
    }
    let (before, after) = (extended.baseline_rmse, extended.extended_rmse);
    say!(
        "simulated     RMSE {} {unit} without, {} {unit} ({:.2} % of stroke) with the causes",
        legible(before, 3),
        legible(after, 3),
        percent(after)
    );
    say!(
        "held out      RMSE {} {unit} without, {} {unit} with the causes (+- {}); noise {} {unit}",
        legible(gain.before.rmse, 3),
        legible(gain.after.rmse, 3),
        legible(gain.gain_error, 3),
        legible(gain.noise_floor, 3)
    );
    if !extended.gains(gain) {
        say!(
            "no sure gain  on the other recording the causes gain no more than chance; the model is written without them"
        );
    }
}

/// A cause with its parameters and what speaks for it.
fn cause(name: &str, named: &Named, units: Names) {
    let words = |(name, value): &(&str, f64)| format!("{} {}", key(name, units), legible(*value, 4));
    let parameters: Vec<String> = named.parameters.iter().map(words).collect();
    say!("{name:<22}{}", parameters.join(", "));
    for words in &named.evidence {
        say!("{:<22}{words}", "");
    }
}
