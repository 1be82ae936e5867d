//! What `mgpi diagnose --json` writes.

use serde_json::{Map, Value, json};

use crate::diagnosis::Diagnosis;
use crate::diagnosis::cause::Cause;
use crate::diagnosis::extend::{Extended, HeldOutGain};
use crate::diagnosis::reject::Unexplained;
use crate::diagnosis::stuck::Stuck;
use crate::diagnosis::words::experiment;
use crate::unit::Unit;

/// A diagnosis; the keys of errors carry the output's unit. The errors are those of the models that run free, if there
/// are any: `heldout` on the rows behind the split, or on another recording.
pub fn to_json(
    diagnosis: &Diagnosis,
    extended: Option<(&Extended, &HeldOutGain)>,
    unit: Unit,
    seconds: f64,
) -> Value {
    let keyed = |entries: &[(&str, f64)]| -> Value {
        let named =
            entries.iter().map(|(name, value)| (format!("{name}_{}", unit.suffix()), (*value).into()));
        Value::Object(named.collect())
    };
    let names = |set: &Vec<Cause>| -> Vec<&str> { set.iter().map(|cause| cause.name()).collect() };
    let causes = diagnosis.causes.iter().map(|named| {
        json!({
            "name": named.cause.name(),
            "parameters": parameters(&named.parameters),
            "share_of_residual": named.share,
            "evidence": named.evidence,
        })
    });
    let (before, after) = extended.map_or(diagnosis.rmse, |(it, _)| (it.baseline_rmse, it.extended_rmse));
    let gained = extended.map(|(_, gain)| {
        keyed(&[
            ("before_rmse", gain.before.rmse),
            ("after_rmse", gain.after.rmse),
            ("noise_floor", gain.noise_floor),
            ("gain_error", gain.gain_error),
        ])
    });
    json!({
        "verdict": diagnosis.verdict.name(),
        "causes": causes.collect::<Vec<_>>(),
        "alternatives": diagnosis.alternatives.iter().map(names).collect::<Vec<_>>(),
        "baseline": keyed(&[("rmse", before)]),
        "extended": keyed(&[("rmse", after)]),
        "heldout": gained,
        "given_model": extended.and_then(|(it, _)| it.given).map(|given| json!({
            "errors": keyed(&[
                ("rmse", given.rmse),
                ("refitted_rmse", given.refitted_rmse),
                ("richer_rmse", given.richer_rmse),
            ]),
            "is_of_another_muscle": given.is_of_another_muscle(),
        })),
        "share_of_gain": extended.and_then(|(_, gain)| gain.share()),
        "pure_error": diagnosis.pure_error.map(|(before, after)| keyed(&[("before", before), ("after", after)])),
        "past_unknown_until_s": diagnosis.past_unknown_until_s,
        "figures_of_misfit": diagnosis.anatomy,
        "examinable": diagnosis.examinable,
        "not_told_apart": names(&diagnosis.inseparable.causes),
        "unexamined": names(&diagnosis.unexamined),
        "unexplained": diagnosis.unexplained.as_ref().map(unexplained),
        "suggested_experiment": experiment(diagnosis),
        "seconds": seconds,
    })
}

/// Parameters by name; a name that comes several times is a list.
fn parameters(all: &[(&str, f64)]) -> Value {
    let mut map = Map::new();
    for (name, value) in all {
        if name.ends_with("time_constants_s") {
            if let Value::Array(list) = map.entry(*name).or_insert_with(|| json!([])) {
                list.push((*value).into());
            }
        } else {
            map.insert((*name).to_owned(), (*value).into());
        }
    }
    Value::Object(map)
}

fn unexplained(seen: &Unexplained) -> Value {
    match seen {
        Unexplained::ZeroStep { time_s, height } => {
            json!({"seen": "zero_step", "time_s": time_s, "height": height})
        }
        Unexplained::Outliers { rows, largest } => {
            json!({"seen": "outliers", "rows": rows, "largest": largest})
        }
        Unexplained::Stuck(Stuck { rows, longest_s }) => {
            json!({"seen": "stuck", "rows": rows, "longest_s": longest_s})
        }
        Unexplained::NoGain { before, after } => {
            json!({"seen": "no_gain", "before_rmse": before, "after_rmse": after})
        }
        Unexplained::NotRepeatable { pure_error, tones_hz } => {
            json!({"seen": "not_repeatable", "pure_error": pure_error, "tones_hz": tones_hz})
        }
    }
}
