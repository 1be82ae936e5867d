//! A recording of the scored rows, for derivatives: those need not be as exact as what they are of.

use std::ops::Range;

use model_core::ExtensionParameters;

use super::task::Task;
use crate::Columns;
use crate::thinning::Thinning;

/// Where there is a mass, all rows are kept between scored ones from whose straight line the contraction departs by more than so many times
/// its noise: what rings turns within a few rows.
const BENT: f64 = 4.0;

/// Rows of a recording.
pub struct Thinned {
    columns: Columns,
    scored: Vec<usize>,
}

impl Thinned {
    /// Of those that a task looks at.
    pub fn of(task: &Task<'_>, extensions: &ExtensionParameters<f64>) -> Self {
        let columns = task.columns;
        let thinning = match &extensions.inertia {
            None => Thinning::to(task.scored),
            Some(_) => {
                let least = BENT * columns.noise_floor().deviation;
                let step = |way: Range<usize>| if bend(columns, &way) > least { 1 } else { way.len().max(1) };
                Thinning::through(task.scored, step)
            }
        };
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

/// How far the contraction departs from the straight line between the ends of a way. Output unit.
fn bend(Columns { time_s, output, .. }: &Columns, way: &Range<usize>) -> f64 {
    let (first, last) = (way.start, way.end);
    let slope = (output[last] - output[first]) / (time_s[last] - time_s[first]);
    let departs = |row: usize| (output[row] - output[first] - slope * (time_s[row] - time_s[first])).abs();
    way.clone().skip(1).map(departs).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use model_core::extension::ProfileParameters;

    use super::*;

    #[test]
    fn beside_a_mass_all_rows_are_kept_where_the_contraction_turns_within_a_few_and_no_others() {
        // Noise, a straight climb, and 8 Hz from 5 to 6 s; every fourth row is scored.
        let time_s: Vec<f64> = (0..1000).map(|row| f64::from(row) * 0.01).collect();
        let noise = |row: usize| 1e-3 * (((7 * row * row) % 13) as f64 - 6.0);
        let rings =
            |t: f64| if (5.0..6.0).contains(&t) { (16.0 * std::f64::consts::PI * t).sin() } else { 0.0 };
        let output: Vec<f64> =
            time_s.iter().enumerate().map(|(row, &t)| 3.0 * t + rings(t) + noise(row)).collect();
        let scored: Vec<usize> = (0..1000).step_by(4).collect();
        let columns = Columns {
            input: output.clone(),
            scored: vec![true; output.len()],
            output,
            time_s,
            ..Columns::default()
        };
        let task = Task::alone(&columns, &scored);
        let mass = ExtensionParameters {
            inertia: Some(ProfileParameters::constant(1e-3)),
            ..ExtensionParameters::default()
        };
        let rows = |extensions: &ExtensionParameters<f64>| {
            let thinned = Thinned::of(&task, extensions);
            (thinned.columns.time_s.len(), thinned.scored.len())
        };
        assert_eq!(rows(&ExtensionParameters::default()), (250, 250));
        let (kept, scored) = rows(&mass);
        assert_eq!(scored, 250);
        assert!((250 + 60..=250 + 80).contains(&kept), "{kept}");
    }
}
