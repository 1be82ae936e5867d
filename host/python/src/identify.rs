//! One model from one recording or several.

use numpy::PyArray1;
use pyo3::prelude::*;

use crate::error::{self, IdentificationError};
use crate::model::Model;
use crate::recording::{Recording, array};
use crate::work::interruptible;
use diagnosis::diagnosed::Examined;
use identification::identified::{self, NotIdentified, Trial};
use identification::json::to_json;
use identification::{CONVERGED, Loss, Options, Weights};
use model_core::Kind;
use recording::model_file::ModelFile;
use report::identified::Identified as Report;

/// An identified model.
#[pyclass(frozen, module = "mgpi._native")]
pub struct Identified {
    found: identified::Identified,
    model: ModelFile,
}

#[pymethods]
impl Identified {
    /// The model.
    #[getter]
    fn model(&self) -> Model {
        Model { file: self.model.clone() }
    }

    /// Its answer to the recordings, one behind the other.
    #[getter]
    fn simulated<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        array(py, self.found.fit.simulated.clone())
    }

    /// What `mgpi identify --json` writes.
    fn to_json(&self) -> String {
        to_json(&self.found).to_string()
    }

    /// What `mgpi identify --report` writes.
    fn to_html(&self) -> PyResult<String> {
        let identified::Identified { model, identification, fit, recording, tried, .. } = &self.found;
        let report = Report {
            model,
            identification,
            recording,
            simulated: &fit.simulated,
            heldout: tried.as_ref().map(|(recording, simulated)| (recording, &simulated[..])),
            uncertainty: &fit.uncertainty,
        };
        report.to_html().map_err(error::model)
    }
}

/// Identifies a model of recordings, and tries it on what is held out.
#[pyfunction]
#[pyo3(signature = (recordings, validate, *, model, plays, dead_zones, weights, knots, loss, starts, seed, threads,
                    holdout, progress))]
#[allow(clippy::too_many_arguments, reason = "keywords of Python's; identifier.py has the defaults")]
pub fn identify(
    py: Python<'_>,
    recordings: Vec<PyRef<'_, Recording>>,
    validate: Option<PyRef<'_, Recording>>,
    model: &str,
    plays: usize,
    dead_zones: usize,
    weights: &str,
    knots: Option<usize>,
    loss: &str,
    starts: usize,
    seed: u64,
    threads: usize,
    holdout: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<Identified> {
    let kind = Kind::ALL.into_iter().find(|kind| kind.name() == model);
    let options = Options {
        model: kind.ok_or_else(|| unknown("model", model, &Kind::ALL.map(Kind::name)))?,
        weights: one_of(
            "weights",
            weights,
            [("exponential", Weights::Exponential), ("free", Weights::Free)],
        )?,
        loss: one_of("loss", loss, [("squares", Loss::Squares), ("huber", Loss::Huber)])?,
        knots,
        plays,
        dead_zones,
        starts,
        seed,
        threads,
        tolerance: CONVERGED,
    };
    // Of several recordings each would show its own.
    let columns = match &recordings[..] {
        [one] => {
            let channels = (&one.recording.drive.input.channel, &one.recording.output.channel);
            let choice = one.choice.clone().like(channels.0, channels.1);
            Some(Examined::of(&one.table, &choice).map_err(|error| error::data(&error))?.columns)
        }
        _ => None,
    };
    let recordings: Vec<recording::Recording> = recordings.iter().map(|one| one.recording.clone()).collect();
    let validate = validate.map(|one| one.recording.clone());
    let trial = match &validate {
        Some(other) => Trial::Another(other),
        None if holdout => Trial::Part,
        None => Trial::Nothing,
    };
    let found = interruptible(py, progress.as_ref(), |tell| {
        identified::identified(&recordings, &options, trial, &|share| tell(share, "identifying"))
    })?;
    let with_recorded = |found: identified::Identified| {
        let mut model = found.model.clone();
        model.recorded = columns.and_then(|columns| columns.recorded(&model).ok());
        Identified { found, model }
    };
    found.map(with_recorded).map_err(|error| match error {
        NotIdentified::Data(error) => error::data(&error),
        NotIdentified::Identification(found) => {
            let (recording, why) = *found;
            let file = recording.drive.file.display();
            IdentificationError::new_err(format!("{file}, {}: {why}", recording.columns()))
        }
    })
}

fn one_of<T: Copy>(what: &str, name: &str, known: [(&str, T); 2]) -> PyResult<T> {
    let found = known.iter().find(|(word, _)| *word == name).map(|(_, value)| *value);
    found.ok_or_else(|| unknown(what, name, &known.map(|(word, _)| word)))
}

fn unknown(what: &str, name: &str, known: &[&str]) -> PyErr {
    IdentificationError::new_err(format!("{what}={name:?} is not known; known are {}", known.join(", ")))
}
