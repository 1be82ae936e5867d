//! Writing of format 1.

use model_core::envelope::TanhParameters;
use toml::{Table, Value};

use super::{FORMAT, Identification, KIND, ModelFile, Source};
use crate::figures::Figures;
use crate::unit::Unit;

/// The text of a model file.
pub fn to_toml(file: &ModelFile) -> String {
    let names = file.names();
    let (input, output) = (names.input.suffix(), names.output.suffix());
    let parameters = &file.parameters;
    let mut top = Table::new();
    top.insert("format".into(), count(FORMAT));
    top.insert("kind".into(), KIND.into());
    top.insert("input".into(), table([("column", file.input.name.as_str().into())]));
    top.insert("output".into(), table([("column", file.output.name.as_str().into())]));
    let validity = [("input_min", parameters.input_min), ("input_max", parameters.input_max)];
    top.insert(
        "validity".into(),
        Value::Table(
            validity.map(|(name, limit)| (format!("{name}_{input}"), limit.into())).into_iter().collect(),
        ),
    );
    let TanhParameters { c0, c1, c2, c3 } = parameters.envelope;
    top.insert(
        "envelope".into(),
        table([
            ("kind", "tanh".into()),
            ("c0", c0.into()),
            (&names.key("c1"), c1.into()),
            ("c2", c2.into()),
            ("c3", c3.into()),
        ]),
    );
    top.insert(
        "plays".into(),
        table([
            ("density", "exponential".into()),
            ("count", count(parameters.plays.thresholds.len())),
            ("q", parameters.plays.q.into()),
            ("rho", file.density.rho.into()),
            ("tau", file.density.tau.into()),
            ("alpha", file.density.alpha.into()),
        ]),
    );
    top.insert(
        "dead_zones".into(),
        table([
            ("thresholds", list(&parameters.dead_zones.thresholds)),
            (&format!("weights_{output}"), list(&parameters.dead_zones.weights)),
            (&names.key("offset"), parameters.dead_zones.offset.into()),
        ]),
    );
    if let Some(identification) = &file.identification {
        top.insert("identification".into(), identified(file, identification));
    }
    top.to_string()
}

fn identified(file: &ModelFile, identification: &Identification) -> Value {
    let unit = file.output.unit;
    let mut section = source(&identification.recording);
    section.insert("tool".into(), identification.tool.as_str().into());
    section.insert("scored_rows".into(), count(identification.scored_rows));
    section.insert(format!("stroke_{}", unit.suffix()), identification.stroke.into());
    section.insert("starts".into(), count(identification.starts));
    section.insert("termination".into(), identification.termination.as_str().into());
    section.insert("training".into(), Value::Table(figures(&identification.training, unit)));
    if let Some((recording, on_heldout)) = &identification.heldout {
        let mut heldout = source(recording);
        heldout.extend(figures(on_heldout, unit));
        section.insert("heldout".into(), Value::Table(heldout));
    }
    let errors = identification.standard_errors.iter();
    let errors = errors.map(|(name, error)| (file.names().key(name), (*error).into())).collect();
    section.insert("standard_errors".into(), Value::Table(errors));
    Value::Table(section)
}

fn source(source: &Source) -> Table {
    Table::from_iter([
        ("recording".to_owned(), source.file.as_str().into()),
        ("sha256".to_owned(), source.sha256.as_str().into()),
    ])
}

fn figures(figures: &Figures, unit: Unit) -> Table {
    figures.keyed(unit).map(|(key, value)| (key, value.into())).into_iter().collect()
}

fn table<const N: usize>(entries: [(&str, Value); N]) -> Value {
    Value::Table(entries.map(|(key, value)| (key.to_owned(), value)).into_iter().collect())
}

fn list(numbers: &[f64]) -> Value {
    Value::Array(numbers.iter().copied().map(Value::Float).collect())
}

/// TOML's integers are signed; no count of rows or operators comes near their limit.
fn count(count: usize) -> Value {
    Value::Integer(i64::try_from(count).unwrap_or(i64::MAX))
}
