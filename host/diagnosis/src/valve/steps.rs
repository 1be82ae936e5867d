//! What a lag makes of the steps of time of a recording.

use model_core::extension::{ValveLag, ValveLagMemory, ValveLagParameters, ValveLagStep};
use recording::simulation::SAME_STEP_S;

/// Rows that are as far behind the row before: how many, and what a lag makes of that.
pub type Alike = (usize, ValveLagStep<f64>);

/// The steps between rows at these times (s), for a lag; none where it is none of a model.
pub fn steps(time_s: &[f64], lag: &ValveLagParameters<f64>) -> impl Iterator<Item = Alike> {
    let lag = ValveLag::try_new(lag).ok();
    let mut left = if lag.is_some() { time_s } else { &[] };
    std::iter::from_fn(move || {
        let [last, next, ..] = *left else { return None };
        let step_s = next - last;
        let is_alike = |pair: &&[f64]| (pair[1] - pair[0] - step_s).abs() <= SAME_STEP_S;
        let rows = left.windows(2).take_while(is_alike).count();
        left = &left[rows..];
        Some((rows, lag?.step(step_s)))
    })
}

/// Makes the pressure of set points, a value a row, from rest at the pressure at the `start`; not a number where no steps are left.
pub fn follow(steps: impl IntoIterator<Item = Alike>, start: f64, values: &mut [f64]) {
    let Some((first, mut rest)) = values.split_first_mut() else { return };
    *first = start;
    let mut memory = ValveLagMemory::resting(start);
    for (rows, step) in steps {
        let (now, behind) = rest.split_at_mut(rows);
        now.iter_mut().for_each(|value| *value = step.pressure(&mut memory, *value));
        rest = behind;
    }
    rest.fill(f64::NAN);
}
