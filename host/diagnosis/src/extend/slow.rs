//! What goes so slowly that a recording shows it a few times only: temperature and warm-up.
//!
//! The operator errs otherwise in every part of a recording, and few changes of a temperature, or one muscle that warms up once,
//! do not tell that from what these do: a refinement of all together would make the operator's misfit theirs, and be thrown by
//! it where they are otherwise. The baseline of the search errs by less. So these stay near where it has them: for the models that
//! are compared on held-out rows where it has them by the rows before alone.

use model_core::ExtensionParameters;
use model_core::extension::{ScheduleParameters, WarmUpParameters};

use super::{Split, carry};
use crate::Columns;
use crate::candidate::Candidate;
use crate::fit::fit;
use crate::search::Search;

/// The extensions that go slowly.
pub struct Slow {
    temperature: Option<ScheduleParameters<f64>>,
    warm_up: Option<WarmUpParameters<f64>>,
}

impl Slow {
    /// Of these extensions.
    pub fn of(all: &ExtensionParameters<f64>) -> Self {
        Self { temperature: all.temperature.clone(), warm_up: all.warm_up.clone() }
    }

    /// As the search has them by the rows that teach; None where it has none, or cannot say.
    pub fn taught(columns: &Columns, search: &Search<'_>, set: &Candidate, split: &Split) -> Option<Self> {
        let all = Self::of(&carry::extensions(columns, search, set));
        if all.temperature.is_none() && all.warm_up.is_none() {
            return None;
        }
        let fit = fit(&search.signals.of_rows(|row| split.teaches(row)), &search.basis, &set.fit.effects)?;
        let set = Candidate { fit, ..set.clone() };
        Some(Self::of(&carry::extensions(columns, search, &set)))
    }

    /// Puts them in the place of those that are there.
    pub fn put(self, all: &mut ExtensionParameters<f64>) {
        all.temperature = self.temperature.filter(|_| all.temperature.is_some());
        all.warm_up = self.warm_up.filter(|_| all.warm_up.is_some());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::causes::cause;
    use crate::signals::Signals;

    /// A width, and an offset of 1 mm per K in the first two thirds, of 2 behind.
    fn recorded() -> Columns {
        let time_s: Vec<f64> = (0..3000).map(|row| f64::from(row) * 0.02).collect();
        let of_time = |value: &dyn Fn(f64) -> f64| time_s.iter().map(|&t| value(t)).collect::<Vec<f64>>();
        let height = |t: f64| 3.0 - 0.4 * (t / 3.0).floor().rem_euclid(4.0);
        let input = of_time(&|t| height(t) * (1.0 - (2.0 * (t / 3.0).fract() - 1.0).abs()));
        let temperature = of_time(&|t| 20.0 + 2.0 * (0.7 * t).sin());
        let mut play = 0.0;
        let hysteresis = input.iter().map(|&u| {
            play = f64::clamp(play, u - 0.2, u + 0.2);
            10.0 * (u + play)
        });
        let offset = temperature
            .iter()
            .zip(&time_s)
            .map(|(warm, &t)| (warm - 20.0) * if t < 40.0 { 1.0 } else { 2.0 });
        Columns {
            output: hysteresis.zip(offset).map(|(y, offset)| y + offset).collect(),
            scored: vec![true; time_s.len()],
            temperature_c: Some(temperature),
            time_s,
            input,
            ..Columns::default()
        }
    }

    #[test]
    fn rows_that_do_not_teach_have_no_say_in_what_goes_slowly() {
        let columns = recorded();
        let mut signals = Signals::new(&columns);
        let search = Search::new(&mut signals, vec![cause("temperature")], 0.0).expect("a baseline");
        let (set, _) = search.run(&|_| ());
        assert_eq!(set.causes, [cause("temperature")]);
        let all = carry::extensions(&columns, &search, &set);
        // What is added to the output, or taken off the input.
        let size = |slow: &Slow| {
            let offset = &slow.temperature.as_ref().expect("a schedule").offset;
            offset.values.iter().map(|value| value.abs()).sum::<f64>() / offset.values.len() as f64
        };
        let by_rows = Split::of(&columns, &search.signals.scored());
        let by_all = Split { taught: search.signals.scored(), ..by_rows.clone() };
        let [whole, first] =
            [by_all, by_rows].map(|split| Slow::taught(&columns, &search, &set, &split).expect("a fit"));
        let ratio = size(&whole) / size(&first);
        assert!((1.2..1.8).contains(&ratio), "{ratio}");
        assert!((size(&whole) / size(&Slow::of(&all)) - 1.0).abs() < 0.02);
    }

    #[test]
    fn what_does_not_go_slowly_is_left_alone() {
        let offset = |value| model_core::extension::ProfileParameters::constant(value);
        let schedule = |value| Some(ScheduleParameters { reference: 0.0, offset: offset(value) });
        let there =
            ExtensionParameters { load: schedule(1.0), temperature: schedule(2.0), ..Default::default() };
        let mut put =
            ExtensionParameters { load: schedule(3.0), temperature: schedule(4.0), ..Default::default() };
        Slow::of(&there).put(&mut put);
        assert_eq!((put.load, put.temperature), (schedule(3.0), schedule(2.0)));
    }
}
