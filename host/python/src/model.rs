//! A model: its answer to an input, the input for an output, and its file.

use std::io::Write;
use std::path::{Path, PathBuf};

use model_core::{ExtendedInverse, Hysteresis, Surroundings};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::{PyFileExistsError, PyOSError};
use pyo3::prelude::*;

use crate::error::{self, ModelError};
use crate::recording::{Recording, array};
use recording::model::named::named;
use recording::model_file::ModelFile;
use recording::simulation::{Rows, simulate};

/// The period of an inverse that does not depend on it. Unit: s.
const ANY_PERIOD_S: f64 = 0.001;

/// A model of a muscle, with its units and what is known about it.
#[pyclass(frozen, module = "mgpi._native", from_py_object)]
#[derive(Clone)]
pub struct Model {
    /// As its file has it.
    pub file: ModelFile,
}

#[pymethods]
impl Model {
    /// Reads a model file.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        ModelFile::read(&path).map(|file| Self { file }).map_err(error::model)
    }

    /// Reads the text of a model file.
    #[staticmethod]
    fn from_toml(text: &str) -> PyResult<Self> {
        ModelFile::parse(Path::new("text"), text).map(|file| Self { file }).map_err(error::model)
    }

    /// The text of its file.
    fn to_toml(&self) -> String {
        self.file.to_toml()
    }

    /// Writes its file, whole or not at all.
    #[pyo3(signature = (path, *, overwrite = false))]
    fn save(&self, path: PathBuf, overwrite: bool) -> PyResult<()> {
        let unwritable =
            |error| PyOSError::new_err(format!("{}: cannot be written: {error}", path.display()));
        let directory = path.parent().filter(|parent| *parent != Path::new("")).unwrap_or(Path::new("."));
        let mut file = tempfile::Builder::new();
        #[cfg(unix)]
        file.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut file = file.prefix(".mgpi-").tempfile_in(directory).map_err(unwritable)?;
        file.write_all(self.to_toml().as_bytes()).map_err(unwritable)?;
        let kept = if overwrite { file.persist(&path) } else { file.persist_noclobber(&path) };
        kept.map(drop).map_err(|error| match error.error.kind() {
            std::io::ErrorKind::AlreadyExists => PyFileExistsError::new_err(format!(
                "{}: exists already; overwrite=True overwrites it",
                path.display()
            )),
            _ => unwritable(error.error),
        })
    }

    /// mgpi, sgpi, agpi, cpi, mpi or egpi.
    #[getter]
    fn kind(&self) -> &'static str {
        self.file.parameters.kind().name()
    }

    /// Name of the input column.
    #[getter]
    fn input_name(&self) -> &str {
        &self.file.input.name
    }

    /// Name of the output column.
    #[getter]
    fn output_name(&self) -> &str {
        &self.file.output.name
    }

    /// The inputs that it is valid for, lowest and highest.
    #[getter]
    fn input_range(&self) -> (f64, f64) {
        self.file.parameters.input()
    }

    /// The outputs at rest and, from there, at the highest input.
    #[getter]
    fn output_range(&self) -> (f64, f64) {
        self.file.model.output_range()
    }

    /// The causes that it is extended by.
    #[getter]
    fn extensions(&self) -> Vec<String> {
        self.file.causes()
    }

    /// The raw parameters, by name with their unit.
    #[getter]
    fn parameters(&self) -> Vec<(String, f64)> {
        let names = self.file.names();
        let all = named(&self.file.parameters, &self.file.density);
        all.into_iter().map(|one| (names.key(&one.name, one.dimension), one.value)).collect()
    }

    /// What it is worth, as a sentence; None of a model that was not identified from a recording.
    #[getter]
    fn worth(&self) -> Option<String> {
        self.file.worth().map(|worth| worth.to_string())
    }

    /// Its answer to a recording, a value a sample.
    fn simulate_recording<'py>(
        &self,
        py: Python<'py>,
        recording: &Recording,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let answer = py.detach(|| {
            let drive = recording.drive(&self.file)?;
            simulate(&self.file, &recording.table, &drive).map_err(|error| error::simulation(&error))
        })?;
        Ok(array(py, answer))
    }

    /// Its answer to an input at some times, from rest.
    #[pyo3(signature = (input, time_s, load_n, temperature_c))]
    fn simulate_arrays<'py>(
        &self,
        py: Python<'py>,
        input: PyReadonlyArray1<'py, f64>,
        time_s: Option<PyReadonlyArray1<'py, f64>>,
        load_n: Option<PyReadonlyArray1<'py, f64>>,
        temperature_c: Option<PyReadonlyArray1<'py, f64>>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let copied = |values: PyReadonlyArray1<'py, f64>| values.as_array().to_vec();
        let (input, time_s) = (copied(input), time_s.map(copied));
        let (load, temperature) = (load_n.map(copied), temperature_c.map(copied));
        let answer = py.detach(|| {
            let counts =
                [&time_s, &load, &temperature].map(|values| values.as_ref().map_or(input.len(), Vec::len));
            if counts.iter().any(|count| *count != input.len()) {
                return Err(ModelError::new_err("input, time_s, load_n and temperature_c differ in length"));
            }
            let needs = |is_needed: bool, name| match is_needed {
                true => Err(ModelError::new_err(format!("an extension of this model needs {name}"))),
                false => Ok(()),
            };
            let extensions = &self.file.extensions;
            needs(time_s.is_none() && *extensions != Default::default(), "time_s")?;
            needs(load.is_none() && extensions.load.is_some(), "load_n")?;
            needs(temperature.is_none() && extensions.temperature.is_some(), "temperature_c")?;
            // Without extensions no time matters.
            let time_s = time_s.unwrap_or_else(|| (0..input.len()).map(|row| row as f64).collect());
            if let Some(row) = (1..time_s.len()).find(|&row| time_s[row] <= time_s[row - 1]) {
                return Err(ModelError::new_err(format!("row {row}, time_s: time does not increase")));
            }
            let rows = Rows {
                time_s: &time_s,
                input: &input,
                load: load.as_deref(),
                temperature: temperature.as_deref(),
            };
            let model = self.file.extended().map_err(error::model)?;
            rows.answer(&model).map_err(|(row, error)| ModelError::new_err(format!("row {row}: {error}")))
        })?;
        Ok(array(py, answer))
    }

    /// The input that brings the output to what is wanted, sample by sample from rest; with
    /// extensions at a fixed period, and within limits.
    #[pyo3(signature = (wanted, period_s, limits, load_n, temperature_c))]
    fn inverse_arrays<'py>(
        &self,
        py: Python<'py>,
        wanted: PyReadonlyArray1<'py, f64>,
        period_s: Option<f64>,
        limits: Option<(f64, f64)>,
        load_n: Option<PyReadonlyArray1<'py, f64>>,
        temperature_c: Option<PyReadonlyArray1<'py, f64>>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let copied = |values: PyReadonlyArray1<'py, f64>| values.as_array().to_vec();
        let wanted = copied(wanted);
        let (load, temperature) = (load_n.map(copied), temperature_c.map(copied));
        let answer = py.detach(|| {
            let is_extended = self.file.extensions != Default::default();
            let period_s = match period_s {
                None if is_extended => {
                    return Err(ModelError::new_err("an extension of this model needs period_s"));
                }
                period_s => period_s.unwrap_or(ANY_PERIOD_S),
            };
            for (name, values) in [("load_n", &load), ("temperature_c", &temperature)] {
                if values.as_ref().is_some_and(|values| values.len() != wanted.len()) {
                    return Err(ModelError::new_err(format!("wanted and {name} differ in length")));
                }
            }
            let inverse = ExtendedInverse::try_new(
                &self.file.parameters,
                &self.file.acting(),
                period_s,
                limits.unwrap_or_else(|| self.file.parameters.input()),
            );
            let inverse = inverse.map_err(error::model)?;
            let mut state = inverse.rest_state();
            let at = |values: &Option<Vec<f64>>, row: usize| values.as_ref().map(|values| values[row]);
            let step = |row: usize| {
                let surroundings = Surroundings { load: at(&load, row), temperature: at(&temperature, row) };
                let command = inverse.step(&mut state, wanted[row], &surroundings);
                command.map_err(|error| ModelError::new_err(format!("row {row}: {error}")))
            };
            (0..wanted.len()).map(step).collect()
        })?;
        Ok(array(py, answer))
    }

    fn __repr__(&self) -> String {
        let ModelFile { input, output, .. } = &self.file;
        let extended = match &self.extensions()[..] {
            [] => String::new(),
            causes => format!(", extended by {}", causes.join(", ")),
        };
        format!("<mgpi.Model {}: {} to {}{extended}>", self.kind(), input.name, output.name)
    }

    fn __reduce__(&self, py: Python<'_>) -> PyResult<(Py<PyAny>, (String,))> {
        let make = py.get_type::<Self>().getattr("from_toml")?.unbind();
        Ok((make, (self.to_toml(),)))
    }
}
