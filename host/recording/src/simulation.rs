//! The answer of a model with its extensions to what a recording holds.
//!
//! | extension | column that it needs |
//! |---|---|
//! | `load` | `load_n` |
//! | `temperature` | `temperature_c` |
//! | those of the valve | the model's input, unless that is a pressure: the valve then stands beside the model |
//!
//! The first row finds the muscle standing still.

use model_core::extension::Sample;
use model_core::{ExtendedModel, InputError, ParameterError, Surroundings};
use thiserror::Error;

use crate::model_file::ModelFile;
use crate::table::{DataError, DataProblem, Table};
use crate::unit::Unit;
use crate::{Drive, TIME};

/// Why a model does not answer a recording.
#[derive(Debug, Error)]
pub enum SimulationError {
    /// The recording lacks a column, or a row cannot follow another.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The file's parameters are no model with these extensions.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}

/// The model's output for every row.
///
/// # Errors
/// A column that an extension needs is missing; rows too near each other for a delay.
pub fn simulate(model: &ModelFile, table: &Table, drive: &Drive) -> Result<Vec<f64>, SimulationError> {
    let column = |needed: bool, name, unit| match needed {
        true => {
            let found = drive.beside(table, name, unit)?;
            found.map(|found| Some(found.values)).ok_or_else(|| table.missing(name, String::new()))
        }
        false => Ok(None),
    };
    let load = column(model.extensions.load.is_some(), "load_n", Unit::N)?;
    let temperature = column(model.extensions.temperature.is_some(), "temperature_c", Unit::CELSIUS)?;
    let (load, temperature) = (load.as_deref(), temperature.as_deref());
    let rows = Rows { time_s: &drive.time_s, input: &drive.input.values, load, temperature };
    let refuse = |(row, error)| table.place(drive.rows.source(row), TIME).error(DataProblem::Refused(error));
    Ok(rows.answer(&model.extended()?).map_err(refuse)?)
}

/// Steps of time that differ by no more are the same: the roundings of differences of times. Unit:
/// s.
pub const SAME_STEP_S: f64 = 1e-9;

/// The step of time after another one: that one, where they are the same, for what a model makes of
/// a step it makes once. All: s.
pub fn same_step(last_s: f64, dt_s: f64) -> f64 {
    if (dt_s - last_s).abs() > SAME_STEP_S { dt_s } else { last_s }
}

/// What drives an extended model, a value a row.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a> {
    /// Strictly increasing. Unit: s.
    pub time_s: &'a [f64],
    /// Command or pressure. Input unit.
    pub input: &'a [f64],
    /// If it is measured. Unit: N.
    pub load: Option<&'a [f64]>,
    /// If it is measured. Unit: °C.
    pub temperature: Option<&'a [f64]>,
}

impl Rows<'_> {
    /// The model's output for every row, simulated from the input alone.
    ///
    /// # Errors
    /// The first row that the model refuses, and why.
    pub fn answer<const N: usize, const M: usize>(
        &self,
        model: &ExtendedModel<f64, N, M>,
    ) -> Result<Vec<f64>, (usize, InputError)> {
        let (mut state, mut step_s) = (model.rest_state(), 0.0);
        let at = |values: Option<&[f64]>, row: usize| values.map(|values| values[row]);
        let answer = |row: usize| {
            let surroundings =
                Surroundings { load: at(self.load, row), temperature: at(self.temperature, row) };
            let dt_s = if row == 0 { 0.0 } else { self.time_s[row] - self.time_s[row - 1] };
            step_s = same_step(step_s, dt_s);
            let sample = Sample { input: self.input[row], surroundings, dt_s: step_s };
            model.step(&mut state, &sample).map(|output| output.contraction).map_err(|error| (row, error))
        };
        (0..self.time_s.len()).map(answer).collect()
    }
}
