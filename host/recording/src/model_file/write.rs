//! Writing of format 1.

use toml::{Table, Value};

use super::names::Names;
use super::values::{count, table};
use super::{
    BY_RECORDING, FORMAT, FROM, FURTHER, HeldOut, Identification, LIMITED_BY, ModelFile, PRECONDITIONED,
    extensions, parameters,
};
use crate::Source;
use crate::figures::Figures;
use crate::model::HostParameters;
use crate::model::named::named;
use crate::unit::Unit;

/// The text of a model file.
pub fn to_toml(file: &ModelFile) -> String {
    let names = file.names();
    let mut top = Table::new();
    top.insert("format".into(), count(FORMAT));
    top.insert("kind".into(), file.parameters.kind().name().into());
    top.insert("input".into(), table([("column", file.input.name.as_str().into())]));
    top.insert("output".into(), table([("column", file.output.name.as_str().into())]));
    top.insert("validity".into(), validity(&file.parameters, &names));
    parameters::write(&file.parameters, Some(&file.density), &names, &mut top);
    extensions::write(&file.extensions, &names, &mut top);
    if let Some(identification) = &file.identification {
        top.insert("identification".into(), identified(file, identification));
    }
    if let Some(recorded) = &file.recorded {
        recorded.write(&names, &mut top);
    }
    if let Some(tuning) = &file.tuning {
        tuning.write(&names, &mut top);
    }
    top.to_string()
}

/// The inputs that a model is valid for, and whether its muscle has been through them.
pub(super) fn validity(parameters: &HostParameters, names: &Names) -> Value {
    let input = names.input.suffix();
    let (lowest, highest) = parameters.input();
    table([
        (&format!("input_min_{input}"), lowest.into()),
        (&format!("input_max_{input}"), highest.into()),
        (PRECONDITIONED, parameters.is_preconditioned().into()),
    ])
}

fn identified(file: &ModelFile, identification: &Identification) -> Value {
    let unit = file.output.unit;
    let mut section = source(&identification.recording);
    if !identification.further.is_empty() {
        let further = identification.further.iter().map(|one| Value::Table(source(one)));
        section.insert(FURTHER.into(), Value::Array(further.collect()));
    }
    section.insert("tool".into(), identification.tool.as_str().into());
    section.insert("scored_rows".into(), count(identification.scored_rows));
    section.insert(format!("stroke_{}", unit.suffix()), identification.stroke.into());
    section.extend(identification.limit.map(|limit| (LIMITED_BY.to_owned(), limit.key().into())));
    section.insert("starts".into(), count(identification.starts));
    section.insert("termination".into(), identification.termination.as_str().into());
    section.insert("training".into(), Value::Table(figures(&identification.training, unit)));
    if let Some(HeldOut { recording, from_s, by_recording, figures: on_heldout }) = &identification.heldout {
        let mut heldout = source(recording);
        heldout.extend(from_s.map(|from_s| (FROM.to_owned(), from_s.into())));
        heldout.extend(by_recording.then(|| (BY_RECORDING.to_owned(), true.into())));
        heldout.extend(figures(on_heldout, unit));
        section.insert("heldout".into(), Value::Table(heldout));
    }
    let mut errors = Table::new();
    for parameter in named(&file.parameters, &file.density) {
        if let Some((name, error)) =
            identification.standard_errors.iter().find(|(name, _)| *name == parameter.name)
        {
            errors.insert(file.names().key(name, parameter.dimension), (*error).into());
        }
    }
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
