//! Our errors as exceptions: what is wrong with data knows where.

use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use recording::simulation::SimulationError;
use recording::table;

create_exception!(
    mgpi,
    DataError,
    PyValueError,
    "What is wrong with a recording, and where: file, line (of a file, from 1), row (of arrays, from 0), column."
);
create_exception!(mgpi, IdentificationError, PyValueError, "Why no model can be made of recordings.");
create_exception!(mgpi, DiagnosisError, PyValueError, "Why nothing can be said of a recording.");
create_exception!(mgpi, ModelError, PyValueError, "What is wrong with a model, or its file.");

/// An error of data, with its place as attributes.
pub fn data(error: &table::DataError) -> PyErr {
    let table::Place { file, line, row, column } = &error.place;
    let raised = DataError::new_err(error.to_string());
    let set = |py: Python<'_>| {
        let value = raised.value(py);
        value.setattr("file", file.display().to_string())?;
        value.setattr("line", line)?;
        value.setattr("row", row)?;
        value.setattr("column", column)
    };
    match Python::attach(set) {
        Ok(()) => raised,
        Err(error) => error,
    }
}

/// Why a model does not answer a recording.
pub fn simulation(error: &SimulationError) -> PyErr {
    match error {
        SimulationError::Data(error) => data(error),
        SimulationError::Parameter(error) => ModelError::new_err(error.to_string()),
    }
}

/// An error of a model.
pub fn model(error: impl std::fmt::Display) -> PyErr {
    ModelError::new_err(error.to_string())
}
