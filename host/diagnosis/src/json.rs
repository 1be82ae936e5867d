//! A diagnosis for programs: what `mgpi diagnose --json` writes.

use serde_json::{Map, Value, json};

use crate::causes::Cause;
use crate::diagnosed::Diagnosed;
use crate::extend::HeldOutGain;
use crate::poor::Poor;
use crate::reject::Unexplained;
use crate::shown::key;
use crate::slips::Slips;
use crate::stuck::Stuck;
use crate::words::experiment;
use crate::{Named, Smoothing};
use recording::model_file::names::Names;
use recording::worth::Limit;

/// A diagnosis; the keys of errors carry the output's unit. The errors are those of simulated
/// models: `heldout` on the rows behind the split, or on another recording; `written` is the model
/// that `-o` writes, beside the plain one.
pub fn to_json(found: &Diagnosed) -> Value {
    let Diagnosed { diagnosis, extended, gain, written, examined, seconds, .. } = found;
    let recording = &examined.recording;
    let unit = Names::of(recording).output;
    let keyed = |entries: &[(&str, f64)]| -> Value {
        let named =
            entries.iter().map(|(name, value)| (format!("{name}_{}", unit.suffix()), (*value).into()));
        Value::Object(named.collect())
    };
    let names = |set: &Vec<Cause>| -> Vec<&str> { set.iter().map(|cause| cause.name()).collect() };
    let causes = |all: &[Named]| -> Vec<Value> {
        let cause = |named: &Named| {
            json!({
                "name": named.cause.name(),
                "parameters": parameters(&named.parameters, Names::of(recording)),
                "share_of_residual": named.share,
                "evidence": named.evidence,
            })
        };
        all.iter().map(cause).collect()
    };
    let gained = |gain: &HeldOutGain| {
        keyed(&[
            ("before_rmse", gain.before.rmse),
            ("after_rmse", gain.after.rmse),
            ("noise_floor", gain.noise_floor),
            ("gain_error", gain.gain_error),
        ])
    };
    json!({
        "verdict": diagnosis.verdict.name(),
        "causes": causes(&diagnosis.causes),
        "best_fit": causes(&diagnosis.best_fit),
        "alternatives": diagnosis.alternatives.iter().map(names).collect::<Vec<_>>(),
        "baseline": keyed(&[("rmse", extended.baseline_rmse)]),
        "extended": keyed(&[("rmse", extended.extended_rmse)]),
        "heldout": gained(gain),
        "written": json!({
            "kind": written.model.parameters.kind().to_string(),
            "extensions": written.extensions().iter().map(|(cause, _)| cause.name()).collect::<Vec<_>>(),
            "errors": keyed(&[("rmse", written.rmse), ("plain_rmse", written.plain_rmse)]),
            "heldout": gained(&written.gain),
            "from_command": written.from_command,
            "termination": written.termination.to_string(),
        }),
        "input_smoothing": diagnosis.smoothing.map(|Smoothing { noise, left }| json!({
            "noise": noise,
            "left": left,
        })),
        "given_model": extended.given.map(|given| json!({
            "errors": keyed(&[
                ("rmse", given.rmse),
                ("refitted_rmse", given.refitted_rmse),
                ("richer_rmse", given.richer_rmse),
            ]),
            "is_of_another_muscle": given.is_of_another_muscle(),
        })),
        "share_of_gain": gain.share(),
        "pure_error": diagnosis.pure_error.map(|(before, after)| keyed(&[("before", before), ("after", after)])),
        "past_unknown_until_s": diagnosis.past_unknown_until_s,
        "left_out": recording.left_out.to_json(),
        "notes": recording.drive.notes,
        "figures_of_misfit": diagnosis.anatomy,
        "examinable": diagnosis.examinable,
        "not_told_apart": names(&diagnosis.inseparable.causes),
        "unexamined": names(&diagnosis.unexamined),
        "unexplained": diagnosis.unexplained.as_ref().map(unexplained),
        "suggested_experiment": experiment(diagnosis),
        "seconds": seconds,
    })
}

/// Parameters by name, with the recording's units; a name that comes several times is a list.
fn parameters(all: &[(&str, f64)], units: Names) -> Value {
    let mut map = Map::new();
    for (name, value) in all {
        if name.ends_with("time_constants_s") {
            if let Value::Array(list) = map.entry(*name).or_insert_with(|| json!([])) {
                list.push((*value).into());
            }
        } else {
            map.insert(key(name, units), (*value).into());
        }
    }
    Value::Object(map)
}

fn unexplained(seen: &Unexplained) -> Value {
    match seen {
        Unexplained::Outliers { rows, largest } => {
            json!({"seen": "outliers", "rows": rows, "largest": largest})
        }
        Unexplained::Stuck(Stuck { rows, longest_s }) => {
            json!({"seen": "stuck", "rows": rows, "longest_s": longest_s})
        }
        Unexplained::Slips(Slips { jump, skewness }) => {
            json!({"seen": "slips", "jump": jump, "skewness": skewness})
        }
        Unexplained::Poor(Poor { rmse, percent_of_stroke, better, limit }) => json!({
            "seen": "poor_model",
            "rmse": rmse,
            "percent_of_stroke": percent_of_stroke,
            "better": better.map(|(better, _)| better.name()),
            "better_rmse": better.map(|(_, rmse)| rmse),
            "limited_by": limit.map(Limit::key),
        }),
        Unexplained::NotSimulated => json!({"seen": "not_simulated"}),
        Unexplained::NoGain { before, after } => {
            json!({"seen": "no_gain", "before_rmse": before, "after_rmse": after})
        }
        Unexplained::NotRepeatable { pure_error, tones_hz } => {
            json!({"seen": "not_repeatable", "pure_error": pure_error, "tones_hz": tones_hz})
        }
    }
}
