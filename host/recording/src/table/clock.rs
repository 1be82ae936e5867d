//! Times that increase, out of what a logger's clock said.
//!
//! # Design
//! A clock that is coarser than the rows gives several rows the same stamp. Where at least half of
//! the stamps have several rows, the rows come so often that their order tells more than the clock:
//!
//! - if one steady rate explains every stamp to within the clock's step, that rate gives the times;
//! - else, if the rows of a stamp differ by no more than one from what the time to the next stamp
//!   lets expect, in all but one of twenty stamps, they are spread evenly over that time;
//! - else nobody knows where between two stamps a row lies, and the rows of a stamp become their
//!   mean.
//!
//! Where fewer stamps come twice the logger has stuttered, and its rows become their mean too.

/// Share of stamps that must have several rows for the clock to be coarse.
const COARSE: f64 = 0.5;
/// Share of stamps whose number of rows may be another one: rows that were lost.
const LOST: f64 = 0.05;
/// A step between stamps that is so many times the middle one is a gap.
const GAP_STEPS: f64 = 1.5;

/// Times that increase.
#[derive(Debug)]
pub struct Increasing {
    /// Unit: s.
    pub time_s: Vec<f64>,
    /// Where rows begin that are brought together, if any are.
    pub begins: Option<Vec<usize>>,
    /// What was done.
    pub note: Option<String>,
}

/// Makes increasing times out of stamps that may repeat (s).
///
/// # Errors
/// The row whose stamp is earlier than the one before.
pub fn increasing(stamps_s: Vec<f64>) -> Result<Increasing, usize> {
    if let Some(row) = stamps_s.windows(2).position(|pair| pair[1] < pair[0]) {
        return Err(row + 1);
    }
    if stamps_s.windows(2).all(|pair| pair[0] < pair[1]) {
        return Ok(Increasing { time_s: stamps_s, begins: None, note: None });
    }
    let begins: Vec<usize> =
        (0..stamps_s.len()).filter(|&row| row == 0 || stamps_s[row] > stamps_s[row - 1]).collect();
    let runs = Runs { stamps_s: &stamps_s, begins: &begins };
    let (rows, stamps) = (stamps_s.len(), begins.len());
    let repeated = (0..stamps).filter(|&run| runs.length(run) > 1).count();
    if stamps > 2 && repeated as f64 >= COARSE * stamps as f64 {
        if let Some((time_s, step_s)) = runs.at_a_steady_rate() {
            let note = format!(
                "{rows} rows share {stamps} time stamps at a steady rate: their times were spread evenly, {step_s:.6} s apart"
            );
            return Ok(Increasing { time_s, begins: None, note: Some(note) });
        }
        if let Some(time_s) = runs.spread() {
            let note = format!(
                "{rows} rows share {stamps} time stamps: the rows of a stamp were spread evenly until the next one"
            );
            return Ok(Increasing { time_s, begins: None, note: Some(note) });
        }
    }
    let again = rows - stamps;
    let rows = if again == 1 {
        "1 row with a repeated time was"
    } else {
        &format!("{again} rows with a repeated time were")
    };
    let note = format!("{rows} averaged with those of the same time");
    let time_s = begins.iter().map(|&row| stamps_s[row]).collect();
    Ok(Increasing { time_s, begins: Some(begins), note: Some(note) })
}

/// Runs of rows with the same stamp.
struct Runs<'a> {
    stamps_s: &'a [f64],
    /// Where each begins.
    begins: &'a [usize],
}

impl Runs<'_> {
    fn length(&self, run: usize) -> usize {
        self.begins.get(run + 1).copied().unwrap_or(self.stamps_s.len()) - self.begins[run]
    }

    fn stamp_s(&self, run: usize) -> f64 {
        self.stamps_s[self.begins[run]]
    }

    /// Times to the next stamp of all but the last one. Unit: s.
    fn steps_s(&self) -> Vec<f64> {
        (1..self.begins.len()).map(|run| self.stamp_s(run) - self.stamp_s(run - 1)).collect()
    }

    /// Evenly spaced times of which each stamp is the time, cut to the clock's step, and their
    /// distance (s).
    fn at_a_steady_rate(&self) -> Option<(Vec<f64>, f64)> {
        let steps_s = self.steps_s();
        let clock_s = steps_s.iter().copied().fold(f64::INFINITY, f64::min);
        // The first run may be cut short, the last one too: from the second stamp to the last.
        let (from, to) = (self.begins[1], *self.begins.last()?);
        let step_s = (self.stamps_s[to] - self.stamps_s[from]) / (to - from) as f64;
        // The clock shows the last of its steps that has passed: no time is before its stamp.
        let late_s = |row: usize| self.stamps_s[row] - step_s * row as f64;
        let rows = 0..self.stamps_s.len();
        let (least, most) =
            rows.clone().map(late_s).fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), late| {
                (least.min(late), most.max(late))
            });
        let is_steady = most - least < clock_s + step_s;
        is_steady.then(|| (rows.map(|row| most + step_s * row as f64).collect(), step_s))
    }

    /// Times spread evenly between a stamp and the next one.
    fn spread(&self) -> Option<Vec<f64>> {
        let steps_s = self.steps_s();
        let mut sorted = steps_s.clone();
        let median_s = crate::numbers::median(&mut sorted);
        let last = self.begins.len() - 1;
        // Rows a second, of all runs but the last one and those before a gap.
        let is_dense = |run: &usize| steps_s[*run] <= GAP_STEPS * median_s;
        let (rows, time_s) = (0..last)
            .filter(is_dense)
            .fold((0.0, 0.0), |(rows, time_s), run| (rows + self.length(run) as f64, time_s + steps_s[run]));
        let rate_hz = rows / time_s;
        let is_odd = |run: &usize| (self.length(*run) as f64 - rate_hz * steps_s[*run]).abs() > 1.0;
        let inner = 1..last;
        let odd = inner.clone().filter(is_dense).filter(is_odd).count();
        if odd as f64 > LOST * inner.len() as f64 {
            return None;
        }
        let mut time_s = Vec::with_capacity(self.stamps_s.len());
        for run in 0..=last {
            let until_s = steps_s.get(run).map_or(median_s, |step_s| step_s.min(median_s));
            let length = self.length(run);
            time_s
                .extend((0..length).map(|place| self.stamp_s(run) + until_s * place as f64 / length as f64));
        }
        Some(time_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coarse(times_s: &[f64], clock_s: f64) -> Vec<f64> {
        times_s.iter().map(|time_s| (time_s / clock_s + 1e-9).floor() * clock_s).collect()
    }

    fn largest_error(found: &[f64], wanted: &[f64]) -> f64 {
        assert_eq!(found.len(), wanted.len());
        found.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn times_that_increase_stay() {
        let found = increasing(vec![0.0, 0.1, 0.3]).expect("they increase");
        assert_eq!((found.time_s, found.begins, found.note), (vec![0.0, 0.1, 0.3], None, None));
    }

    #[test]
    fn a_coarse_clock_at_a_steady_rate_gives_the_right_times() {
        // Two rows a stamp; 4.5 rows a stamp; 15 or 16 rows a tick of 15.625 ms.
        for (rate_hz, clock_s) in [(20.0, 0.1), (45.0, 0.1), (1000.0, 0.015_625)] {
            let wanted: Vec<f64> = (0..3000).map(|row| f64::from(row) / rate_hz).collect();
            let found = increasing(coarse(&wanted, clock_s)).expect("they do not go back");
            let error_s = largest_error(&found.time_s, &wanted);
            assert!(error_s < 1.5 / rate_hz, "{rate_hz} Hz: {error_s} s");
            assert!(found.begins.is_none() && found.time_s.is_sorted_by(|a, b| a < b));
        }
        let wanted: Vec<f64> = (0..1201).map(|row| f64::from(row) / 20.0).collect();
        let found = increasing(coarse(&wanted, 0.1)).expect("they do not go back");
        assert!(largest_error(&found.time_s, &wanted) < 1e-9);
    }

    #[test]
    fn a_gap_does_not_spoil_coarse_times() {
        let wanted: Vec<f64> =
            (0..2000).map(|row| f64::from(row) / 50.0 + if row < 1000 { 0.0 } else { 7.0 }).collect();
        let found = increasing(coarse(&wanted, 0.1)).expect("they do not go back");
        assert!(largest_error(&found.time_s, &wanted) < 0.02 + 1e-9);
    }

    #[test]
    fn a_logger_that_stutters_has_its_rows_averaged() {
        let mut stamps: Vec<f64> = (0..100).map(|row| f64::from(row) / 100.0).collect();
        stamps.extend([0.99, 1.0, 1.0]);
        let found = increasing(stamps).expect("they do not go back");
        assert_eq!(found.time_s.len(), 101);
        assert!(found.note.is_some_and(|note| note.starts_with("2 rows with a repeated time")));
    }

    #[test]
    fn bursts_without_a_rate_are_averaged() {
        let counts = [1_usize, 9, 2, 7, 1, 12, 3, 8];
        let stamps: Vec<f64> = (0..80)
            .flat_map(|stamp| {
                std::iter::repeat_n(f64::from(stamp) / 10.0, counts[stamp as usize % counts.len()])
            })
            .collect();
        assert_eq!(increasing(stamps).expect("they do not go back").time_s.len(), 80);
    }

    #[test]
    fn a_clock_that_goes_back_is_no_clock() {
        assert_eq!(increasing(vec![0.0, 0.1, 0.0]).expect_err("it goes back"), 2);
    }
}
