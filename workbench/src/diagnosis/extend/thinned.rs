//! A recording of the scored rows, for derivatives: those need not be as exact as what they are of.

use model_core::ExtensionParameters;

use super::refine::Task;
use crate::diagnosis::Columns;
use crate::diagnosis::thinning::Thinning;

/// Rows of a recording.
pub struct Thinned {
    columns: Columns,
    scored: Vec<usize>,
}

impl Thinned {
    /// Of those that a task looks at; None where all are needed, since there is a mass: what rings turns within a few rows. Beside a
    /// width or thresholds that follow its rate, which are dear, every other one has to do.
    pub fn of(task: &Task<'_>, extensions: &ExtensionParameters<f64>) -> Option<Self> {
        let by_contraction =
            extensions.rate_dependent_thresholds.as_ref().is_some_and(|all| all.pressure.is_none());
        let is_dear = by_contraction || extensions.rate_dependent_width.is_some();
        let thinning = match &extensions.inertia {
            None => Thinning::to(task.scored),
            Some(_) if is_dear => Thinning::by(2, task.scored),
            Some(_) => return None,
        };
        let columns = task.columns;
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
        Some(Self { columns, scored: thinning.scored })
    }

    /// A task on these rows alone.
    pub fn task<'a>(&'a self, whole: Task<'a>) -> Task<'a> {
        Task { columns: &self.columns, scored: &self.scored, ..whole }
    }
}
