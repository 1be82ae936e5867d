//! An identified model for programs: what `mgpi identify --json` writes.

use std::iter;

use model_core::Hysteresis;
use serde_json::{Map, Value, json};

use crate::identified::Identified;
use recording::Source;
use recording::model::named::{Dimension, slope_dimension};
use recording::model_file::Identification;

/// Figures and parameters of an identification; the keys carry the units of the model's columns.
pub fn to_json(found: &Identified) -> Value {
    let Identified { model, identification, fit, recording, seconds, .. } = found;
    let Identification { recording: first, further, .. } = identification;
    let (names, unit) = (model.names(), model.output.unit);
    let known = &fit.uncertainty;
    let parameters = known.estimates.iter().map(|estimate| {
        json!({
            "name": estimate.parameter.name,
            "value": estimate.parameter.value,
            "standard_error": estimate.standard_error,
            "interval": estimate.interval,
            "identifiable": known.is_identifiable(estimate),
            "unit": names.unit(estimate.parameter.dimension),
        })
    });
    let correlation = known.correlation.row_iter().map(|row| row.iter().copied().collect::<Vec<f64>>());
    let recordings = iter::once(first).chain(further);
    let recordings = recordings.map(|Source { file, sha256 }| json!({"file": file, "sha256": sha256}));
    let range = fit.model.input_range();
    let keyed = |entries: [(&str, Dimension, f64); 2]| -> Map<String, Value> {
        entries
            .map(|(name, dimension, value)| (names.key(name, dimension), value.into()))
            .into_iter()
            .collect()
    };
    let mut json = json!({
        "recordings": recordings.collect::<Vec<_>>(),
        "training": identification.training.to_json(unit),
        "heldout": identification.heldout.as_ref().map(|heldout| heldout.figures.to_json(unit)),
        "heldout_from_s": identification.heldout.as_ref().and_then(|heldout| heldout.from_s),
        "worth": identification.worth().to_json(),
        "parameters": parameters.collect::<Vec<_>>(),
        // In the order of the parameters; serialisation makes null of what is not a number.
        "correlation": correlation.collect::<Vec<_>>(),
        "collinear": known.collinear,
        "residual_memory_rows": known.memory,
        "outlier_rows": fit.outliers,
        "left_out": recording.left_out.to_json(),
        "validity": keyed([
            ("input_min", Dimension::Input, range.min()),
            ("input_max", Dimension::Input, range.max()),
        ]),
        "smallest_slope": keyed([
            ("plays", Dimension::One, fit.model.smallest_play_slope()),
            ("output", slope_dimension(fit.parameters.kind()), fit.model.smallest_output_slope()),
        ]),
        "preconditioned": fit.parameters.is_preconditioned(),
        // A fit without an exact inverse does not get here: it is an error of the identification.
        "invertible": true,
        "starts": identification.starts,
        "termination": identification.termination,
        "notes": recording.drive.notes,
        "seconds": seconds,
    });
    json[format!("stroke_{}", unit.suffix())] = identification.stroke.into();
    json
}
