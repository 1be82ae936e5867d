//! Several recordings of one muscle one behind the other.
//!
//! - [`Recording::joined`]: for what is said and drawn of them together. No model is driven by
//!   that: for it each recording begins from rest.
//! - [`Recording::joined_at_rest`]: as one recording that a model may be driven by. Between two of
//!   them the muscle is let down to the lowest input of all and left there.

use std::path::PathBuf;

use crate::left_out::LeftOut;
use crate::table::{DataError, DataProblem, Place};
use crate::unit::Channel;
use crate::{Drive, Recording, Timing};

/// The pause between two recordings, in steps of the slower one: a gap, for whoever looks at steps.
const PAUSE_STEPS: f64 = 10.0;

/// What the muscle does between two recordings that become one: it is let down within a gap of
/// time, and left there. Two rows, which are not scored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest {
    /// The input meanwhile. Input unit.
    pub input: f64,
    /// How long it is left. How long it was is not known; with as long a rest as the longest
    /// recording, what fades within one has faded. Unit: s.
    pub pause_s: f64,
}

impl Rest {
    /// That between these recordings.
    pub fn between<'a>(recordings: impl IntoIterator<Item = &'a Recording>) -> Self {
        let rest = Self { input: f64::INFINITY, pause_s: 0.0 };
        recordings.into_iter().fold(rest, |Self { input, pause_s }, Recording { drive, .. }| Self {
            input: drive.input.values.iter().copied().fold(input, f64::min),
            pause_s: pause_s.max(drive.time_s.last().copied().unwrap_or_default() - drive.time_s[0]),
        })
    }

    /// Puts the values of a column that is not the input behind those before: between them what
    /// was read last, and what is read next.
    pub fn append(before: &mut Vec<f64>, after: &[f64]) {
        before.extend(before.last().copied().into_iter().chain(after.first().copied()));
        before.extend_from_slice(after);
    }
}

impl Recording {
    /// Recordings of one muscle, one behind the other, the times going on. What is not known of
    /// the past of each is said by itself.
    ///
    /// # Errors
    /// There is none; one has another input or output than the first, or another unit of it; one
    /// comes twice.
    pub fn joined(recordings: &[Self]) -> Result<Self, DataError> {
        Self::one_behind_the_other(recordings, None)
    }

    /// The same as one recording that a model may be driven by, with this between two of them.
    ///
    /// # Errors
    /// As of [`Self::joined`].
    pub fn joined_at_rest(recordings: &[Self], rest: Rest) -> Result<Self, DataError> {
        Self::one_behind_the_other(recordings, Some(rest))
    }

    fn one_behind_the_other(recordings: &[Self], between: Option<Rest>) -> Result<Self, DataError> {
        let [first, others @ ..] = recordings else {
            return Err(Place::file("recordings".as_ref()).error(DataProblem::Empty));
        };
        let mut all = first.clone();
        for (place, other) in others.iter().enumerate() {
            other.check_beside(&recordings[..=place])?;
            all.append(other, between);
        }
        Ok(all)
    }

    /// Whether it may stand beside those before it.
    fn check_beside(&self, before: &[Self]) -> Result<(), DataError> {
        let channels = |of: &Self| [of.drive.input.channel.clone(), of.output.channel.clone()];
        let first = &before[0];
        for (is, wanted) in channels(self).into_iter().zip(channels(first)) {
            if is != wanted {
                let place = Place { column: Some(is.name.clone()), ..Place::file(&self.drive.file) };
                return Err(place.error(DataProblem::OtherColumn {
                    is: in_words(&is),
                    first: first.drive.file.clone(),
                    wanted: in_words(&wanted),
                }));
            }
        }
        match before.iter().find(|other| other.drive.sha256 == self.drive.sha256) {
            Some(same) => {
                Err(Place::file(&self.drive.file).error(DataProblem::SameFile(same.drive.file.clone())))
            }
            None => Ok(()),
        }
    }

    fn append(&mut self, other: &Self, rest: Option<Rest>) {
        let Drive { file, sha256, time_s, timing, input, scored, notes, .. } = &mut self.drive;
        let file_name = |file: &PathBuf| file.file_name().unwrap_or(file.as_os_str()).display().to_string();
        *file = format!("{} + {}", file_name(file), file_name(&other.drive.file)).into();
        *sha256 = format!("{sha256} + {}", other.drive.sha256);
        let pause_s = PAUSE_STEPS * timing.median_step_s.max(other.drive.timing.median_step_s);
        let mut ends_s = time_s.last().copied().unwrap_or_default();
        if let Some(Rest { input: lowest, pause_s: left_s }) = rest {
            time_s.extend([ends_s + pause_s, ends_s + pause_s + left_s]);
            ends_s += pause_s + left_s;
            input.values.extend([lowest; 2]);
            scored.extend([false; 2]);
            Rest::append(&mut self.output.values, &other.output.values);
        } else {
            self.output.values.extend_from_slice(&other.output.values);
        }
        let rows = time_s.len();
        let later_s = ends_s + pause_s - other.drive.time_s.first().copied().unwrap_or_default();
        time_s.extend(other.drive.time_s.iter().map(|time| time + later_s));
        *timing = Timing::of(time_s);
        input.values.extend_from_slice(&other.drive.input.values);
        scored.extend_from_slice(&other.drive.scored);
        let of_file = other.drive.notes.iter().map(|note| format!("{}: {note}", other.drive.file.display()));
        notes.extend(of_file);
        let LeftOut { drop_outs, unknown_past } = &mut self.left_out;
        drop_outs.extend(other.left_out.drop_outs.iter().cloned().map(|mut drop_out| {
            drop_out.samples = drop_out.samples.start + rows..drop_out.samples.end + rows;
            let (from_s, to_s) = drop_out.time_s;
            drop_out.time_s = (from_s + later_s, to_s + later_s);
            drop_out
        }));
        *unknown_past = None;
    }
}

/// A column with its unit.
fn in_words(channel: &Channel) -> String {
    format!("{} in {}", channel.name, channel.unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Choice;
    use crate::table::Table;

    fn recording(file: &str, text: &str) -> Recording {
        let table = Table::parse(file.as_ref(), text.as_bytes()).expect("a table");
        Recording::of(&table, &Choice::default()).expect("a recording")
    }

    const FIRST: &str = "time_s,pressure_bar,contraction_mm\n0,0,0\n0.1,1,8\n0.2,2,9\n0.3,0,2\n";

    #[test]
    fn times_go_on_behind_a_pause_and_rows_stand_behind_each_other() {
        let later = "time_s,pressure_bar,contraction_mm\n5,0,1\n5.2,2,10\n5.4,0,3\n";
        let all =
            Recording::joined(&[recording("a/x.csv", FIRST), recording("b/y.csv", later)]).expect("one");
        assert_eq!(all.output.values, [0.0, 8.0, 9.0, 2.0, 1.0, 10.0, 3.0]);
        assert!((all.drive.time_s[4] - 2.3).abs() < 1e-9 && (all.drive.time_s[6] - 2.7).abs() < 1e-9);
        assert_eq!((all.drive.scored.len(), all.drive.timing.gaps), (7, 1));
        assert_eq!(all.drive.file.display().to_string(), "x.csv + y.csv");
    }

    #[test]
    fn at_rest_the_muscle_is_let_down_between_and_nothing_of_it_is_scored() {
        let later = "time_s,pressure_bar,contraction_mm\n5,1,1\n5.2,2,10\n5.4,0.5,3\n";
        let parts = [recording("a.csv", FIRST), recording("b.csv", later)];
        let rest = Rest::between(&parts);
        assert_eq!(rest, Rest { input: 0.0, pause_s: rest.pause_s });
        assert!((rest.pause_s - 0.4).abs() < 1e-9);
        let all = Recording::joined_at_rest(&parts, rest).expect("one");
        assert_eq!(all.drive.input.values, [0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 1.0, 2.0, 0.5]);
        assert_eq!(all.output.values, [0.0, 8.0, 9.0, 2.0, 2.0, 1.0, 1.0, 10.0, 3.0]);
        assert_eq!(all.drive.scored.iter().filter(|scored| !**scored).count(), 2);
        assert!((all.drive.time_s[5] - 2.7).abs() < 1e-9 && (all.drive.time_s[6] - 4.7).abs() < 1e-9);
        assert!(all.drive.time_s.windows(2).all(|pair| pair[1] > pair[0]));
    }

    #[test]
    fn another_unit_or_column_and_a_file_that_comes_twice_are_refused_by_name() {
        let refused = |other: Recording| {
            Recording::joined(&[recording("a.csv", FIRST), other]).expect_err("refused").to_string()
        };
        let in_kpa = recording("b.csv", &FIRST.replace("pressure_bar", "pressure_kpa"));
        let message = refused(in_kpa);
        assert!(message.starts_with("b.csv, column pressure_kpa: "), "{message}");
        assert!(message.contains("pressure_bar in bar") && message.contains("a.csv"), "{message}");
        let message = refused(recording("b.csv", &FIRST.replace("pressure", "command")));
        assert!(message.contains("command_bar") && message.contains("pressure_bar"), "{message}");
        let message = refused(recording("b.csv", FIRST));
        assert!(message.contains("the same recording as a.csv"), "{message}");
        assert!(Recording::joined(&[]).is_err());
    }
}
