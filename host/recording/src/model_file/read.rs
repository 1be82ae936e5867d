//! Reading of format 1.

use model_core::{Invertible, Kind, ParameterError};

use super::control::{Recorded, Tuning};
use super::names::Names;
use super::section::{KeyError, Section};
use super::{
    BY_RECORDING, FORMAT, FROM, FURTHER, HeldOut, Identification, LIMITED_BY, ModelFile, PRECONDITIONED,
    Problem, extensions, parameters,
};
use crate::Source;
use crate::figures::Figures;
use crate::model::named::{Named, named};
use crate::model::{HostExtendedModel, HostModel};
use crate::unit::{Channel, Unit};
use crate::worth::Limit;

/// Reads and checks the contents of a model file.
pub fn parse(text: &str) -> Result<ModelFile, Problem> {
    let table = text.parse::<toml::Table>().map_err(|error| {
        let end = error.span().map_or(text.len(), |span| span.start.min(text.len()));
        let line = 1 + text.as_bytes()[..end].iter().filter(|&&byte| byte == b'\n').count();
        Problem::Syntax { line, message: error.message().replace('\n', ", ") }
    })?;
    let mut top = Section::top(table);
    let format = top.count("format")?;
    let kind = kind(&mut top);
    // What is no model of a muscle, as that of a joint, has formats of its own.
    if format != FORMAT && kind.is_ok() {
        return Err(Problem::Format(format));
    }
    let kind = kind?;
    let input = channel(top.section("input")?)?;
    let output = channel(top.section("output")?)?;
    let names = Names { input: input.unit, output: output.unit };
    let (limits, preconditioned) = validity(top.section("validity")?, input.unit)?;
    let (parameters, density) = parameters::read(kind, &mut top, &names, limits)?;
    let density = density
        .ok_or_else(|| top.error("plays", "density \"listed\" is for a board's own model, in its backup"))?;
    let parameters = parameters.with_preconditioned(preconditioned);
    let extensions = extensions::read(&mut top, &names)?;
    let identification = match top.optional_section("identification")? {
        Some(section) => Some(identification(section, &names, &named(&parameters, &density))?),
        None => None,
    };
    let recorded = Recorded::read(&mut top, &names)?;
    let tuning = Tuning::read(&mut top, &names)?;
    top.finish()?;
    let model = HostModel::try_new(&parameters).map_err(|error| names.problem(&error))?;
    model.inverse().map_err(|error| names.problem(&error))?;
    HostExtendedModel::try_new(&parameters, &extensions).map_err(|error| names.problem(&error))?;
    Ok(ModelFile { input, output, density, parameters, extensions, model, identification, recorded, tuning })
}

pub(super) fn kind(top: &mut Section) -> Result<Kind, KeyError> {
    let name = top.text("kind")?;
    Kind::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
        let known = Kind::ALL.map(Kind::name).join(", ");
        top.error("kind", &format!("\"{name}\" is not known; known are {known}"))
    })
}

impl Names {
    /// The problem of parameters that are not valid, in the file's units.
    pub(super) fn problem(&self, error: &ParameterError) -> Problem {
        let message = error.to_string();
        let message = message.replace("output unit", &self.output.to_string());
        Problem::Parameters(message.replace("input unit", &self.input.to_string()))
    }
}

fn channel(mut section: Section) -> Result<Channel, KeyError> {
    let name = section.text("column")?;
    let known = Channel::of_column(&name).ok_or_else(|| {
        let known = Unit::known_suffixes();
        section.error("column", &format!("\"{name}\" does not end in a known unit; known are {known}"))
    })?;
    section.finish()?;
    Ok(known)
}

pub(super) fn validity(mut section: Section, unit: Unit) -> Result<((f64, f64), bool), KeyError> {
    let limits = (
        section.number(&format!("input_min_{}", unit.suffix()))?,
        section.number(&format!("input_max_{}", unit.suffix()))?,
    );
    // Files of the first days have no such key: their muscles are fresh.
    let preconditioned = section.has(PRECONDITIONED) && section.truth(PRECONDITIONED)?;
    section.finish()?;
    Ok((limits, preconditioned))
}

fn identification(
    mut section: Section,
    names: &Names,
    parameters: &[Named],
) -> Result<Identification, KeyError> {
    let recording = source(&mut section)?;
    let mut training = section.section("training")?;
    let heldout = match section.optional_section("heldout")? {
        Some(mut heldout) => {
            let on_heldout = HeldOut {
                recording: source(&mut heldout)?,
                by_recording: heldout.has(BY_RECORDING) && heldout.truth(BY_RECORDING)?,
                from_s: if heldout.has(FROM) { Some(heldout.number(FROM)?) } else { None },
                figures: figures(&mut heldout, names)?,
            };
            heldout.finish()?;
            Some(on_heldout)
        }
        None => None,
    };
    let identification = Identification {
        tool: section.text("tool")?,
        recording,
        further: further(&mut section)?,
        scored_rows: section.count("scored_rows")?,
        stroke: section.number(&format!("stroke_{}", names.output.suffix()))?,
        training: figures(&mut training, names)?,
        heldout,
        limit: limit(&mut section)?,
        starts: section.count("starts")?,
        termination: section.text("termination")?,
        standard_errors: standard_errors(section.section("standard_errors")?, names, parameters)?,
    };
    training.finish()?;
    section.finish()?;
    Ok(identification)
}

/// What limits the model: files of earlier versions do not say it.
fn limit(section: &mut Section) -> Result<Option<Limit>, KeyError> {
    if !section.has(LIMITED_BY) {
        return Ok(None);
    }
    let key = section.text(LIMITED_BY)?;
    let unknown =
        || section.error(LIMITED_BY, &format!("\"{key}\" is not known; known are {}", Limit::keys()));
    Limit::of_key(&key).map(Some).ok_or_else(unknown)
}

fn source(section: &mut Section) -> Result<Source, KeyError> {
    Ok(Source { file: section.text("recording")?, sha256: section.text("sha256")? })
}

/// The recordings behind the first: a model of one recording has none.
fn further(section: &mut Section) -> Result<Vec<Source>, KeyError> {
    if !section.has(FURTHER) {
        return Ok(Vec::new());
    }
    let of_table = |mut one: Section| {
        let source = source(&mut one)?;
        one.finish().map(|()| source)
    };
    section.sections(FURTHER)?.into_iter().map(of_table).collect()
}

fn figures(section: &mut Section, names: &Names) -> Result<Figures, KeyError> {
    let mut figure = |name: &str| section.number(&format!("{name}_{}", names.output.suffix()));
    Ok(Figures { rmse: figure("rmse")?, mae: figure("mae")?, max_error: figure("max_error")? })
}

fn standard_errors(
    mut section: Section,
    names: &Names,
    parameters: &[Named],
) -> Result<Vec<(String, f64)>, KeyError> {
    let mut errors = Vec::new();
    for parameter in parameters {
        let key = names.key(&parameter.name, parameter.dimension);
        if section.has(&key) {
            errors.push((parameter.name.clone(), section.number(&key)?));
        }
    }
    section.finish()?;
    Ok(errors)
}
