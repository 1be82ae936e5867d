//! What a model gets wrong about a recording, and why.

use pyo3::prelude::*;

use crate::error::{self, DiagnosisError};
use crate::model::Model;
use crate::recording::Recording;
use crate::work::interruptible;
use diagnosis::diagnosed::{self, Examined};
use diagnosis::extend::Operator;
use diagnosis::json::to_json;
use diagnosis::words::in_a_sentence;
use report::diagnosed::to_html;

/// A diagnosis, with the model that is written.
#[pyclass(frozen, module = "mgpi._native")]
pub struct Diagnosed {
    found: diagnosed::Diagnosed,
}

#[pymethods]
impl Diagnosed {
    /// The model, extended by the named causes where that is better.
    #[getter]
    fn model(&self) -> PyResult<Model> {
        let mut file = self.found.model().map_err(error::model)?;
        file.recorded = self.found.examined.columns.recorded(&file).ok();
        Ok(Model { file })
    }

    /// What it comes to, in a sentence.
    #[getter]
    fn sentence(&self) -> String {
        in_a_sentence(&self.found.diagnosis, self.found.examined.recording.output.channel.unit)
    }

    /// What `mgpi diagnose --json` writes.
    fn to_json(&self) -> String {
        to_json(&self.found).to_string()
    }

    /// What `mgpi diagnose --report` writes.
    fn to_html(&self) -> String {
        to_html(&self.found)
    }
}

/// Diagnoses a recording.
#[pyfunction]
#[pyo3(signature = (recording, model, validate, progress))]
pub fn diagnose(
    py: Python<'_>,
    recording: PyRef<'_, Recording>,
    model: Option<Model>,
    validate: Option<PyRef<'_, Recording>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Diagnosed> {
    let choice = match &model {
        Some(model) => recording.choice.clone().like(&model.file.input, &model.file.output),
        None => recording.choice.clone(),
    };
    let examined = Examined::of(&recording.table, &choice).map_err(|error| error::data(&error))?;
    let other = validate.map(|other| {
        let channels = (&examined.recording.drive.input.channel, &examined.recording.output.channel);
        Examined::of(&other.table, &other.choice.clone().like(channels.0, channels.1))
    });
    let other = other.transpose().map_err(|error| error::data(&error))?;
    let given =
        model.map(|model| Operator { parameters: model.file.parameters, density: model.file.density });
    let file = recording.recording.drive.file.display().to_string();
    drop(recording);
    let found = interruptible(py, progress.as_ref(), |tell| examined.diagnosed(given.as_ref(), other, tell))?;
    found
        .map(|found| Diagnosed { found })
        .map_err(|error| DiagnosisError::new_err(format!("{file}: {error}")))
}
