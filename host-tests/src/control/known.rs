//! What the desk makes of a plant's recording, as `mgpi identify` and `mgpi diagnose` do: a model
//! file.

use std::path::Path;

use anyhow::{Context, Result};
use diagnosis::diagnose_and_extend;
use diagnosis::diagnosed::Examined;
use diagnosis::extend::Extension;
use identification::{Options, identify};
use model_core::ExtensionParameters;
use recording::Choice;
use recording::model::HostModel;
use recording::model_file::{Identification, ModelFile};
use recording::simulation::Rows;
use recording::table::Table;

/// Starts of an identification: enough for the best of them within some percent.
const STARTS: usize = 8;

/// Which command of the desk makes the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Desk {
    /// `mgpi identify`: hysteresis alone.
    Identify,
    /// `mgpi diagnose`: extended by the named causes.
    Diagnose,
}

/// The model of a recording.
///
/// # Errors
/// The text is not a recording, or no model can be identified from it.
pub fn model(csv: &[u8], desk: Desk) -> Result<ModelFile> {
    let file = Path::new("recording.csv");
    let choice = Choice::default();
    let mut table = Table::parse(file, csv)?;
    table.name(&choice.naming)?;
    let Examined { columns, recording, .. } = Examined::of(&table, &choice)?;
    let (extension, starts, termination) = match desk {
        Desk::Identify => {
            let options = Options { starts: STARTS, ..Options::default() };
            let fit = identify(&(&recording).into(), &options, &|_| ())?;
            let extensions = ExtensionParameters::default();
            let (parameters, density) = (fit.parameters, fit.density);
            let extension = Extension { parameters, density, extensions, jump: None };
            (extension, fit.starts, fit.termination.to_string())
        }
        Desk::Diagnose => {
            let (_, extended) = diagnose_and_extend(&columns, None, &|_, _| ())?;
            let written = extended.written(&columns.as_measured(), None).context("no model is written")?;
            (written.model.of_muscle(), written.starts, written.termination.to_string())
        }
    };
    let Extension { parameters, density, extensions, .. } = extension;
    let mut model = ModelFile {
        input: recording.drive.input.channel.clone(),
        output: recording.output.channel.clone(),
        density,
        model: HostModel::try_new(&parameters)?,
        parameters,
        extensions,
        identification: None,
        recorded: None,
        tuning: None,
    };
    let measured = columns.as_measured();
    let rows = Rows {
        time_s: &measured.time_s,
        input: &measured.input,
        load: measured.load_n.as_deref(),
        temperature: measured.temperature_c.as_deref(),
    };
    let simulated =
        rows.answer(&model.extended()?).map_err(|(row, error)| anyhow::anyhow!("{row}: {error}"))?;
    model.identification =
        Some(Identification::of(&recording, &simulated, None, starts, termination, Vec::new()));
    model.recorded = Some(columns.recorded(&model)?);
    Ok(model)
}
