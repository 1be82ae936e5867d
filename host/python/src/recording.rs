//! Recordings from files and from arrays.

use std::path::PathBuf;
use std::str::FromStr;

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use serde_json::Value;

use crate::error::{self, DataError};
use recording::table::Table;
use recording::table::naming::{Naming, Renamed, UnitOf};
use recording::{Choice, Drive};

/// A recording: times, an input, an output, and which samples are scored.
#[pyclass(frozen, subclass, module = "mgpi._native")]
pub struct Recording {
    /// All that was recorded, columns beside input and output too.
    pub table: Table,
    /// Which of it is used.
    pub choice: Choice,
    /// That.
    pub recording: recording::Recording,
}

#[pymethods]
impl Recording {
    /// From a file (`columns` is None), or from columns under a name.
    #[new]
    #[pyo3(signature = (name, columns, *, input, output, rest_length_mm, input_range, time, renamed, units, strict))]
    #[allow(
        clippy::too_many_arguments,
        reason = "keywords of Python's; the class in recording.py has the defaults"
    )]
    fn new(
        py: Python<'_>,
        name: PathBuf,
        columns: Option<Vec<(String, PyReadonlyArray1<'_, f64>)>>,
        input: Option<String>,
        output: Option<String>,
        rest_length_mm: Option<f64>,
        input_range: Option<(f64, f64)>,
        time: Option<String>,
        renamed: Vec<String>,
        units: Vec<String>,
        strict: bool,
    ) -> PyResult<Self> {
        let naming = Naming {
            time,
            columns: all::<Renamed>(&renamed)?,
            units: all::<UnitOf>(&units)?,
            known: Vec::new(),
        };
        let choice = Choice {
            input,
            output,
            has_options: true,
            rest_length_mm,
            input_range,
            naming,
            is_strict: strict,
            may_be_sparse: false,
        };
        let columns: Option<Vec<(String, Vec<f64>)>> = columns.map(|columns| {
            let copied = |(name, values): (String, PyReadonlyArray1<'_, f64>)| {
                (name, values.as_array().iter().copied().collect())
            };
            columns.into_iter().map(copied).collect()
        });
        py.detach(|| {
            let table = match &columns {
                None => choice.table(&name),
                Some(columns) => {
                    let borrowed: Vec<(&str, &[f64])> =
                        columns.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
                    Table::of_columns(&name, &borrowed)
                        .and_then(|mut table| table.name(&choice.naming).map(|()| table))
                }
            };
            let table = table.map_err(|error| error::data(&error))?;
            let recording = recording::Recording::of(&table, &choice).map_err(|error| error::data(&error))?;
            Ok(Self { table, choice, recording })
        })
    }

    /// The file, or the name of the arrays.
    #[getter]
    fn file(&self) -> String {
        self.recording.drive.file.display().to_string()
    }

    /// SHA-256 of the file's bytes, or of the columns.
    #[getter]
    fn sha256(&self) -> &str {
        &self.recording.drive.sha256
    }

    /// Times in s.
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.recording.drive.time_s)
    }

    /// The input, in `input_unit`.
    #[getter]
    fn input<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.recording.drive.input.values)
    }

    /// The measured output, in `output_unit`.
    #[getter]
    fn output<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.recording.output.values)
    }

    /// Which samples are scored.
    #[getter]
    fn scored<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        PyArray1::from_slice(py, &self.recording.drive.scored)
    }

    /// Name of the input column.
    #[getter]
    fn input_name(&self) -> &str {
        &self.recording.drive.input.channel.name
    }

    /// Name of the output column.
    #[getter]
    fn output_name(&self) -> &str {
        &self.recording.output.channel.name
    }

    /// Unit of the input.
    #[getter]
    fn input_unit(&self) -> &str {
        self.recording.drive.input.channel.unit.symbol()
    }

    /// Unit of the output.
    #[getter]
    fn output_unit(&self) -> &str {
        self.recording.output.channel.unit.symbol()
    }

    /// Highest less lowest scored output.
    #[getter]
    fn stroke(&self) -> f64 {
        self.recording.stroke()
    }

    /// What was done to read it, a sentence each.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.recording.drive.notes.clone()
    }

    /// Which samples are not scored, and why, as JSON.
    fn left_out_json(&self) -> String {
        self.recording.left_out.to_json().to_string()
    }

    fn __len__(&self) -> usize {
        self.recording.drive.time_s.len()
    }

    /// RMSE, mean and largest absolute error of an answer over the scored samples, as JSON.
    fn figures_json(&self, simulated: PyReadonlyArray1<'_, f64>) -> PyResult<String> {
        let simulated = simulated.as_array().to_vec();
        if simulated.len() != self.__len__() {
            let words = format!("{} values for {} samples", simulated.len(), self.__len__());
            return Err(DataError::new_err(words));
        }
        let figures = self.recording.figures(&simulated);
        Ok(Value::to_string(&figures.to_json(self.recording.output.channel.unit)))
    }
}

impl Recording {
    /// What drives a model of these channels.
    pub fn drive(&self, model: &recording::model_file::ModelFile) -> PyResult<Drive> {
        let choice = self.choice.clone().like(&model.input, &model.output);
        Drive::of(&self.table, &choice).map_err(|error| error::data(&error))
    }
}

/// Options in the words of the command line.
fn all<T: FromStr<Err = String>>(words: &[String]) -> PyResult<Vec<T>> {
    words.iter().map(|words| words.parse().map_err(DataError::new_err)).collect()
}

/// An array that takes over a list.
pub fn array(py: Python<'_>, values: Vec<f64>) -> Bound<'_, PyArray1<f64>> {
    values.into_pyarray(py)
}
