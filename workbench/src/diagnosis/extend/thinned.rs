//! A recording of the scored rows, for derivatives: those need not be as exact as what they are of.

use super::refine::Task;
use crate::diagnosis::Columns;
use crate::diagnosis::thinning::Thinning;

/// Rows of a recording.
pub struct Thinned {
    columns: Columns,
    scored: Vec<usize>,
}

impl Thinned {
    /// Of those that a task looks at.
    pub fn of(task: &Task<'_>) -> Self {
        let columns = task.columns;
        let thinning = Thinning::to(task.scored);
        let of = |values: &Vec<f64>| thinning.of(values);
        let columns = Columns {
            time_s: of(&columns.time_s),
            input: of(&columns.input),
            input_is_command: columns.input_is_command,
            output: of(&columns.output),
            scored: thinning.of(&columns.scored),
            load_n: columns.load_n.as_ref().map(of),
            temperature_c: columns.temperature_c.as_ref().map(of),
            ..Columns::default()
        };
        Self { columns, scored: thinning.scored }
    }

    /// A task on these rows alone.
    pub fn task<'a>(&'a self, whole: Task<'a>) -> Task<'a> {
        Task { columns: &self.columns, scored: &self.scored, ..whole }
    }
}
