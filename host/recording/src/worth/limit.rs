//! What limits a model, as a value that goes with it.

use super::shape::Shape;
use super::{DEPLOYABLE, GOOD, Worth};
use crate::Recording;
use crate::figures::Figures;
use crate::noise;

/// Less of the output's variance that goes with the input is no dependence: a quarter is a
/// correlation of 0.5, which slow signals that have nothing to do with each other come to in a
/// recording of a few cycles.
const DEPENDS: f64 = 0.25;
/// A cause has to make up this share of the squared error to be called what limits the model.
const MOST: f64 = 0.5;
/// Held-out samples have so many times the error of those of the fit where the muscle, or the
/// input's course, has changed.
const CHANGED: f64 = 2.0;

/// What limits a model.
///
/// ```
/// use recording::worth::Limit;
///
/// assert_eq!(Limit::of_key("no such limit"), None);
/// assert!(Limit::keys().split(", ").all(|key| Limit::of_key(key).is_some_and(|limit| limit.key() == key)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// The noise of the measured output.
    Noise,
    /// The output falls as the input rises.
    Falls,
    /// The output does not depend on the input.
    Independent,
    /// The loop is run the other way round: the output leads the input, as if the columns were
    /// swapped.
    Leads,
    /// The output rises with the input and then falls.
    Hill,
    /// The output falls with the input and then rises.
    Valley,
    /// The held-out samples are unlike those of the fit.
    Changed,
    /// What else acts on the output than the input.
    Other,
}

impl Limit {
    const ALL: [Self; 8] = [
        Self::Noise,
        Self::Falls,
        Self::Independent,
        Self::Leads,
        Self::Hill,
        Self::Valley,
        Self::Changed,
        Self::Other,
    ];

    /// What limits a model of a recording, from its figures there and on held-out samples. Output
    /// unit.
    pub fn of(recording: &Recording, training: &Figures, heldout: Option<&Figures>) -> Option<Self> {
        let Recording { drive, output, .. } = recording;
        let of_scored = |values: &[f64]| -> Vec<f64> {
            values.iter().zip(&drive.scored).filter(|(_, scored)| **scored).map(|(value, _)| *value).collect()
        };
        let floor = noise::floor(&of_scored(&drive.time_s), &of_scored(&output.values)).deviation;
        let share = Worth::from_figures(training, heldout, recording.stroke(), None).share;
        if is_most(floor, training.rmse) && share < DEPLOYABLE {
            return Some(Self::Noise);
        }
        let shape = Self::of_shape(&drive.input.values, &output.values, &drive.scored, training.rmse);
        let heldout_differs = heldout.is_some_and(|heldout| heldout.rmse > CHANGED * training.rmse);
        match shape {
            // A loop that is run the other way round is told even where it is narrow.
            Some(shape) if share > GOOD || shape == Self::Leads => Some(shape),
            _ if share <= GOOD => None,
            _ => Some(if heldout_differs { Self::Changed } else { Self::Other }),
        }
    }

    /// What keeps a model of this error from following the output over the input; None where
    /// nothing of the kind does. `scored` are the samples that count. Output unit.
    pub fn of_shape(input: &[f64], output: &[f64], scored: &[bool], rmse: f64) -> Option<Self> {
        let shape = Shape::of(input, output, scored);
        if shape.explained < DEPENDS {
            return Some(Self::Independent);
        }
        if is_most(shape.not_rising, rmse) {
            match shape.turns_at_a_peak() {
                Some(true) => return Some(Self::Hill),
                Some(false) => return Some(Self::Valley),
                None if shape.falls() => return Some(Self::Falls),
                None => {}
            }
        }
        (shape.opening < 0.0 && is_most(shape.half_width, rmse)).then_some(Self::Leads)
    }

    /// Its name in files.
    pub fn key(self) -> &'static str {
        match self {
            Self::Noise => "noise",
            Self::Falls => "output_falls",
            Self::Independent => "output_independent_of_input",
            Self::Leads => "output_leads_input",
            Self::Hill => "hill",
            Self::Valley => "valley",
            Self::Changed => "held_out_samples_differ",
            Self::Other => "other_influences",
        }
    }

    /// The one of that name.
    pub fn of_key(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|limit| limit.key() == key)
    }

    /// All names, for messages.
    pub fn keys() -> String {
        Self::ALL.map(Self::key).join(", ")
    }

    /// What it means, and what helps.
    pub fn reason(self) -> &'static str {
        match self {
            Self::Noise => "most of the error is noise of the measured output",
            Self::Falls => {
                "the output falls as the input rises, and these models rise: give one of the columns the other sign"
            }
            Self::Independent => {
                "the output does not depend on the input: is it the right column, and was the sensor connected?"
            }
            Self::Leads => {
                "the output leads the input, where a muscle's output lags: are input and output swapped?"
            }
            Self::Hill => {
                "the output rises with the input and then falls (a hill), and these models only rise: \
                no change of sign helps; use the rising part of the input's range alone"
            }
            Self::Valley => {
                "the output falls with the input and then rises (a valley; with hysteresis a butterfly loop), and \
                these models only rise: no change of sign helps; use one side of the input's range alone"
            }
            Self::Changed => {
                "the error on held-out samples is more than twice that on the samples of the fit: the muscle changes \
                with time, or the held-out samples go where those of the fit have not been"
            }
            Self::Other => {
                "something else than the input's course acts as well (speed, load, temperature or time): \
                `mgpi diagnose` looks for it"
            }
        }
    }
}

/// Whether a part makes up most of an error. Both are root mean squares in one unit.
fn is_most(part: f64, rmse: f64) -> bool {
    part.powi(2) > MOST * rmse.powi(2)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::Choice;
    use crate::table::Table;

    /// What limits a model of an output over six triangles of the input from -1 to 1, 1,800 samples
    /// with little noise; `of` has the input, the input some samples before and the time in cycles.
    fn limit(of: impl Fn(f64, f64, f64) -> f64) -> Option<Limit> {
        limit_beside(0.3, of)
    }

    /// The same beside an error. Unit: share of stroke.
    fn limit_beside(share: f64, of: impl Fn(f64, f64, f64) -> f64) -> Option<Limit> {
        let input = |row: f64| {
            let phase = (row / 300.0).rem_euclid(1.0);
            if phase < 0.5 { 4.0 * phase - 1.0 } else { 3.0 - 4.0 * phase }
        };
        let mut text = "time_s,pressure_bar,contraction_mm\n".to_owned();
        for row in 0..1800 {
            let at = f64::from(row);
            let noise = 0.001 * (at * 2.4).sin();
            let y = of(input(at), input(at - 10.0), at / 300.0) + noise;
            text += &format!("{},{},{}\n", 0.1 * at, input(at), y);
        }
        let table = Table::parse(Path::new("muscle.csv"), text.as_bytes()).expect("a table");
        let recording = Recording::of(&table, &Choice::default()).expect("a recording");
        let figures = Figures { rmse: share * recording.stroke(), mae: 0.3, max_error: 1.0 };
        Limit::of(&recording, &figures, None)
    }

    #[test]
    fn each_shape_that_no_model_has_is_told() {
        assert_eq!(limit(|_, late, _| -late), Some(Limit::Falls));
        assert_eq!(limit(|_, _, cycles| (cycles * 5.1).sin()), Some(Limit::Independent));
        assert_eq!(limit(|_, late, _| -late * late), Some(Limit::Hill));
        assert_eq!(limit(|_, late, _| late * late), Some(Limit::Valley));
        assert_eq!(limit(|x, late, _| x + 8.0 * (x - late)), Some(Limit::Leads));
        assert_eq!(limit(|_, late, cycles| late + 0.3 * cycles), Some(Limit::Other));
    }

    #[test]
    fn a_narrow_loop_that_is_run_the_other_way_round_is_told_of_a_good_model() {
        assert_eq!(limit_beside(0.006, |x, late, _| x + 0.1 * (x - late)), Some(Limit::Leads));
        assert_eq!(limit_beside(0.006, |x, late, _| x - 0.1 * (x - late)), None);
    }

    #[test]
    fn every_limit_has_a_name_of_its_own() {
        for limit in Limit::ALL {
            assert_eq!(Limit::of_key(limit.key()), Some(limit));
        }
        assert_eq!(Limit::of_key("weather"), None);
    }
}
