//! Reading of format 1.

use std::fs;
use std::path::Path;

use model_core::Invertible;
use model_core::ParameterError;
use model_core::dead_zone::DeadZoneParameters;
use model_core::envelope::TanhParameters;
use model_core::play::PlayParameters;

use super::names::Names;
use super::section::{KeyError, Section};
use super::{FORMAT, Identification, KIND, ModelFile, Problem, Source};
use crate::figures::Figures;
use crate::identification::{DEAD_ZONES, Density, HostModel, HostParameters, PLAYS};
use crate::unit::{Channel, Unit};

/// Reads and checks a model file.
pub fn read(path: &Path) -> Result<ModelFile, Problem> {
    let text = fs::read_to_string(path)?;
    let table = text.parse::<toml::Table>().map_err(|error| {
        let end = error.span().map_or(text.len(), |span| span.start.min(text.len()));
        let line = 1 + text.as_bytes()[..end].iter().filter(|&&byte| byte == b'\n').count();
        Problem::Syntax { line, message: error.message().replace('\n', ", ") }
    })?;
    let mut top = Section::top(table);
    let format = top.count("format")?;
    if format != FORMAT {
        return Err(Problem::Format(format));
    }
    top.fixed_text("kind", KIND)?;
    let input = channel(top.section("input")?)?;
    let output = channel(top.section("output")?)?;
    let names = Names { input: input.unit, output: output.unit };
    let [input_min, input_max] = validity(top.section("validity")?, input.unit)?;
    let envelope = envelope(top.section("envelope")?, &names)?;
    let (plays, density) = plays(top.section("plays")?, &names)?;
    let dead_zones = dead_zones(top.section("dead_zones")?, &names)?;
    let identification = match top.optional_section("identification")? {
        Some(section) => Some(identification(section, &names, dead_zones.weights.len())?),
        None => None,
    };
    top.finish()?;
    let parameters = HostParameters { envelope, plays, dead_zones, input_min, input_max };
    let model = HostModel::try_new(&parameters).map_err(|error| names.problem(&error))?;
    model.inverse().map_err(|error| names.problem(&error))?;
    Ok(ModelFile { input, output, density, parameters, model, identification })
}

impl Names {
    /// The problem of parameters that are not valid, in the file's units.
    fn problem(&self, error: &ParameterError) -> Problem {
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

fn validity(mut section: Section, unit: Unit) -> Result<[f64; 2], KeyError> {
    let limits = [
        section.number(&format!("input_min_{}", unit.suffix()))?,
        section.number(&format!("input_max_{}", unit.suffix()))?,
    ];
    section.finish()?;
    Ok(limits)
}

fn envelope(mut section: Section, names: &Names) -> Result<TanhParameters<f64>, KeyError> {
    section.fixed_text("kind", "tanh")?;
    let parameters = TanhParameters {
        c0: section.number("c0")?,
        c1: section.number(&names.key("c1"))?,
        c2: section.number("c2")?,
        c3: section.number("c3")?,
    };
    section.finish()?;
    Ok(parameters)
}

fn plays(mut section: Section, names: &Names) -> Result<(PlayParameters<f64, PLAYS>, Density), Problem> {
    section.fixed_text("density", "exponential")?;
    let count = section.count("count")?;
    let q = section.number("q")?;
    let density =
        Density { rho: section.number("rho")?, tau: section.number("tau")?, alpha: section.number("alpha")? };
    section.finish()?;
    let plays = PlayParameters::exponential(count, q, density.rho, density.tau, density.alpha);
    Ok((plays.map_err(|error| names.problem(&error))?, density))
}

fn dead_zones(mut section: Section, names: &Names) -> Result<DeadZoneParameters<f64, DEAD_ZONES>, KeyError> {
    let parameters = DeadZoneParameters {
        thresholds: list(&mut section, "thresholds")?.into_iter().collect(),
        weights: list(&mut section, &format!("weights_{}", names.output.suffix()))?.into_iter().collect(),
        offset: section.number(&names.key("offset"))?,
    };
    section.finish()?;
    Ok(parameters)
}

/// At most as many numbers as a model holds.
fn list(section: &mut Section, key: &str) -> Result<Vec<f64>, KeyError> {
    let numbers = section.numbers(key)?;
    if numbers.len() > DEAD_ZONES {
        return Err(section.error(key, &format!("{} numbers, must be at most {DEAD_ZONES}", numbers.len())));
    }
    Ok(numbers)
}

fn identification(
    mut section: Section,
    names: &Names,
    dead_zones: usize,
) -> Result<Identification, KeyError> {
    let recording = source(&mut section)?;
    let mut training = section.section("training")?;
    let heldout = match section.optional_section("heldout")? {
        Some(mut heldout) => {
            let on_heldout = (source(&mut heldout)?, figures(&mut heldout, names)?);
            heldout.finish()?;
            Some(on_heldout)
        }
        None => None,
    };
    let identification = Identification {
        tool: section.text("tool")?,
        recording,
        scored_rows: section.count("scored_rows")?,
        stroke: section.number(&format!("stroke_{}", names.output.suffix()))?,
        training: figures(&mut training, names)?,
        heldout,
        starts: section.count("starts")?,
        termination: section.text("termination")?,
        standard_errors: standard_errors(section.section("standard_errors")?, names, dead_zones)?,
    };
    training.finish()?;
    section.finish()?;
    Ok(identification)
}

fn source(section: &mut Section) -> Result<Source, KeyError> {
    Ok(Source { file: section.text("recording")?, sha256: section.text("sha256")? })
}

fn figures(section: &mut Section, names: &Names) -> Result<Figures, KeyError> {
    let mut figure = |name: &str| section.number(&format!("{name}_{}", names.output.suffix()));
    Ok(Figures { rmse: figure("rmse")?, mae: figure("mae")?, max_error: figure("max_error")? })
}

fn standard_errors(
    mut section: Section,
    names: &Names,
    dead_zones: usize,
) -> Result<Vec<(String, f64)>, KeyError> {
    let mut errors = Vec::new();
    for name in Names::all(dead_zones) {
        let key = names.key(&name);
        if section.has(&key) {
            errors.push((name, section.number(&key)?));
        }
    }
    section.finish()?;
    Ok(errors)
}
