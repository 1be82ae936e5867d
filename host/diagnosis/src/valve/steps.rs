//! What a lag makes of the steps of time of a recording.

use model_core::extension::{ValveLag, ValveLagForm, ValveLagMemory, ValveLagParameters, ValveLagStep};
use recording::simulation::SAME_STEP_S;

/// Rows that are as far behind the row before: how many, and what a lag makes of that.
pub type Alike = (usize, ValveLagStep<f64>);

/// What a lag makes of the steps between rows at these times (s). There are no steps if its parameters are not valid.
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

/// Turns set points, a value a row, into the pressure, which rests at `start` first; rows for which there is no step get NaN.
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

/// A lag that many set points are tried with. That of an orifice takes its time constants from the measured pressure instead of its own: for
/// any set points that are worth a look the two are near each other, and no flow has to be calculated.
pub enum Following {
    /// As it is.
    Own(Vec<Alike>),
    /// The share of its way that the pressure goes in each row, out of the chamber and into it.
    Shares(Vec<[f64; 2]>),
}

/// The way that a share is measured by, as a share of an orifice's supply: next to nothing beside what its flow changes over, and far more
/// than roundings. Unit: 1.
const WAY: f64 = 1e-6;

impl Following {
    /// Of a lag, between rows at these times (s), where the pressure was measured.
    pub fn of(time_s: &[f64], lag: &ValveLagParameters<f64>, pressure: &[f64]) -> Self {
        let steps = steps(time_s, lag);
        let ValveLagForm::Orifice { supply, .. } = lag.form else { return Self::Own(steps.collect()) };
        let way = WAY * supply;
        let share = |step: &ValveLagStep<f64>, from: f64, way: f64| {
            (step.pressure(&mut ValveLagMemory::resting(from), from + way) - from) / way
        };
        let rows = steps.flat_map(|(rows, step)| std::iter::repeat_n(step, rows));
        Self::Shares(
            rows.zip(pressure).map(|(step, &from)| [-way, way].map(|way| share(&step, from, way))).collect(),
        )
    }

    /// As [`follow`].
    pub fn follow(&self, start: f64, values: &mut [f64]) {
        match self {
            Self::Own(steps) => follow(steps.iter().copied(), start, values),
            Self::Shares(shares) => {
                let mut pressure = start;
                let Some((first, rest)) = values.split_first_mut() else { return };
                *first = start;
                for (value, [out, into]) in rest.iter_mut().zip(shares) {
                    let missing = *value - pressure;
                    pressure += missing * if missing > 0.0 { into } else { out };
                    *value = pressure;
                }
                rest.iter_mut().skip(shares.len()).for_each(|value| *value = f64::NAN);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_orifice_along_the_measured_pressure_is_near_the_orifice() {
        let time_s: Vec<f64> = (0..2000).map(|row| 0.01 * f64::from(row)).collect();
        let set_points: Vec<f64> =
            time_s.iter().map(|time_s| [1.0, 4.0, 2.0, 5.0][*time_s as usize % 4]).collect();
        let form = ValveLagForm::Orifice { supply: 7.4, outside: 1.01325 };
        let lag = ValveLagParameters { form, ..ValveLagParameters::new(0.1) };
        let mut measured = set_points.clone();
        follow(steps(&time_s, &lag), 1.0, &mut measured);
        let mut along = set_points.clone();
        Following::of(&time_s, &lag, &measured).follow(1.0, &mut along);
        let off = measured.iter().zip(&along).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
        assert!(off < 1e-3, "{off}");
    }
}
