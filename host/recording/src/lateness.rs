//! How much later than predicted something came in a recording, and how noisy it was.
//!
//! What follows a signal b as a first-order lag, or as a delay that is short, obeys b − a = θ ȧ,
//! and over any window the mean of b − a is θ times how far a went, over the window's length. So θ
//! is found by least squares of the first on the second, in windows that are long beside the noise.
//! Beside it stand what a wrong model of the hysteresis leaves, which changes with the direction
//! and with the place: a polynomial of the place for either direction. The standard error is that
//! of the jackknife over blocks of time, since neighbouring windows are off alike. Under an input
//! of one speed the direction and a delay look alike in such windows: then, and where they show
//! less, the lateness of the muscle is what its turns show (`transients`).

use crate::model_file::ModelFile;
use crate::model_file::control::{Late, Recorded, SeenValve};
use crate::noise;
use crate::numbers::range;
use crate::simulation::Rows;
use crate::transients::Transients;
use crate::{valve_order, viscosity};
use model_core::ParameterError;
use thiserror::Error;

/// Blocks of the jackknife.
const BLOCKS: usize = 12;
/// Length of a window. Unit: s; short beside the swings of a recording, and long enough for a
/// sensor's noise not to count as movement.
const WINDOW_S: f64 = 0.2;
/// Windows begin so many times in the length of one.
const OVERLAP: usize = 4;
/// Length of a stretch whose slope is looked at, as a share of the stroke, and the share of all
/// stretches that has to be within the slope's factor.
const STRETCH: f64 = 0.02;
const MOST: f64 = 0.95;
/// The largest factor that is told.
const WILD: f64 = 100.0;
/// How far a signal may go beyond the ends of a window and still not turn, as a share of its way in
/// it: what the noise of a pressure makes of a steady move.
const BACK: f64 = 0.01;
/// The least variance of an input's speeds over their mean square for which it has more than one:
/// that of two speeds for equal times, one twice the other.
const SPEEDS: f64 = 0.1;
/// Times that what a rate tells beside direction and place has to be above its noise: less, and
/// noise would be taken for it.
const ABOVE_NOISE: f64 = 10.0;
/// The standard error of a lateness that a recording at one speed leaves open. Unit: s.
const OPEN_S: f64 = 1.0;
/// A signal stands still while it would take so long for its whole range. Unit: s.
const SLOWEST_S: f64 = 1000.0;
/// Unknowns: the lateness, and a cubic for either direction.
const UNKNOWNS: usize = 9;
/// Fewest rows of which anything is said.
const LEAST_ROWS: usize = 10 * BLOCKS;

/// A recording, a value a row.
#[derive(Clone, Copy, Debug)]
pub struct Recording<'a> {
    /// What drives the model.
    pub rows: Rows<'a>,
    /// Which rows count.
    pub scored: &'a [bool],
    /// As measured. Output unit.
    pub output: &'a [f64],
    /// Beside an input that is the pressure, where it was recorded. Input unit.
    pub command: Option<&'a [f64]>,
}

/// What a recording shows beside its model.
///
/// # Errors
/// The parameters make no valid model, or the model refuses a row: the first such one.
pub fn recorded(file: &ModelFile, recording: &Recording<'_>) -> Result<Recorded, NotSimulated> {
    let Recording { rows, scored, output, command } = *recording;
    let simulated = rows.answer(&file.extended()?).map_err(|(row, _)| NotSimulated::Row(row))?;
    let kept = |values: &[f64]| -> Vec<f64> {
        values.iter().zip(scored).filter(|(_, scored)| **scored).map(|(value, _)| *value).collect()
    };
    let seen = Transients { time_s: rows.time_s, scored, output };
    let floor = noise::floor(&kept(rows.time_s), &kept(output));
    let open = Late { mean_s: 0.0, error_s: OPEN_S };
    let late_s = has_speeds(rows.time_s, scored, rows.input)
        .then(|| late(rows.time_s, scored, &simulated, output, Between::Line));
    let surer = |one: Late, other: Late| if other.error_s < one.error_s { other } else { one };
    let valve = command.map(|command| {
        let lag_s = file.extensions.valve_lag.map_or(0.0, |lag| lag.time_constant_s);
        let expected = lagged(rows.time_s, command, lag_s);
        let late = late(rows.time_s, scored, &expected, rows.input, Between::of_lag(lag_s));
        let order = valve_order::Rows { time_s: rows.time_s, scored, command, pressure: rows.input };
        SeenValve { late, shares: order.shares(lag_s + late.mean_s) }
    });
    Ok(Recorded {
        step_s: noise::steps(rows.time_s).0,
        noise: floor.deviation,
        steeper: steeper((scored, &simulated, output), floor.deviation),
        late: late_s.into_iter().chain(seen.late(&simulated, floor.deviation)).fold(open, surer),
        split: viscosity::split(file, &rows, &simulated, &seen)?,
        valve,
    })
}

/// By which factor the ways of a measured signal over those of an expected one lie within
/// [`MOST`] of all stretches.
fn steeper((scored, expected, measured): (&[bool], &[f64], &[f64]), noise: f64) -> f64 {
    let (low, high) = range(expected);
    // Of a way of so many deviations noise makes a tenth, at the most.
    let way = (STRETCH * (high - low)).max(20.0 * noise);
    let (mut factors, mut from) = (Vec::new(), 0);
    for row in 0..expected.len() {
        if !scored[row] {
            from = row + 1;
        } else if from < row && (expected[row] - expected[from]).abs() >= way {
            let ratio = (measured[row] - measured[from]) / (expected[row] - expected[from]);
            factors.push(if ratio > 0.0 { ratio.max(ratio.recip()) } else { f64::INFINITY });
            from = row;
        }
    }
    factors.sort_by(f64::total_cmp);
    let place = (MOST * factors.len() as f64) as usize;
    factors.get(place.min(factors.len().saturating_sub(1))).copied().unwrap_or(WILD).min(WILD)
}

/// Why nothing is known of a recording's times.
#[derive(Debug, Error)]
pub enum NotSimulated {
    /// The parameters make no valid model.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A row, from 0 on, cannot follow the one before it.
    #[error("the model does not take row {0} of the recording")]
    Row(usize),
}

/// A signal behind a first-order lag; from its first value on.
fn lagged(time_s: &[f64], values: &[f64], lag_s: f64) -> Vec<f64> {
    let mut last = values.first().copied().unwrap_or_default();
    let mut all = Vec::with_capacity(values.len());
    for (row, &value) in values.iter().enumerate() {
        let dt_s = if row == 0 { 0.0 } else { time_s[row] - time_s[row - 1] };
        // The command of a row has been held since the row before.
        let share = if lag_s > 0.0 { -(-dt_s / lag_s).exp_m1() } else { 1.0 };
        last += share * (value - last);
        all.push(last);
    }
    all
}

/// What a signal does between two rows.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Between {
    /// It moves on.
    Line,
    /// It has been what it is since the row before: a command.
    Held,
}

impl Between {
    /// Behind a lag (s), which makes a line of what is held.
    fn of_lag(lag_s: f64) -> Self {
        if lag_s > 0.0 { Self::Line } else { Self::Held }
    }
}

/// Whether a signal turns round in a window: it goes beyond its ends.
fn turns(values: &[f64]) -> bool {
    let (low, high) = range(values);
    let ends = [values[0], values[values.len() - 1]];
    let (first, last) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
    (first - low).max(high - last) > BACK * (high - low)
}

/// Whether the input moves at more than one speed.
fn has_speeds(time_s: &[f64], scored: &[bool], input: &[f64]) -> bool {
    let whole = window(noise::steps(time_s).0);
    let (mut count, mut sum, mut squares) = (0.0_f64, 0.0, 0.0);
    for from in (0..time_s.len().saturating_sub(whole)).step_by((whole / OVERLAP).max(1)) {
        let to = from + whole;
        if scored[from..=to].contains(&false) || turns(&input[from..=to]) {
            continue;
        }
        let speed = ((input[to] - input[from]) / (time_s[to] - time_s[from])).abs();
        (count, sum, squares) = (count + 1.0, sum + speed, squares + speed * speed);
    }
    // The variance of the speeds over their mean square.
    count > 0.0 && squares > 0.0 && 1.0 - sum * sum / (count * squares) >= SPEEDS
}

/// Rows of a window.
fn window(step_s: f64) -> usize {
    ((WINDOW_S / step_s).ceil() as usize).max(2)
}

/// How much later than `expected`, between whose rows there is what `between` says, came
/// `measured`.
fn late(time_s: &[f64], scored: &[bool], expected: &[f64], measured: &[f64], between: Between) -> Late {
    let unknown = Late { mean_s: 0.0, error_s: SLOWEST_S };
    let (step_s, gap_s) = noise::steps(time_s);
    let whole = window(step_s);
    let (low, high) = range(measured);
    if high <= low {
        return unknown;
    }
    let slow = (high - low) / SLOWEST_S;
    let mut rows = Vec::new();
    for from in (0..time_s.len().saturating_sub(whole)).step_by((whole / OVERLAP).max(1)) {
        let to = from + whole;
        let whole_s = time_s[to] - time_s[from];
        if whole_s > 2.0 * WINDOW_S.max(whole as f64 * gap_s.min(step_s))
            || scored[from..=to].contains(&false)
            || turns(&expected[from.saturating_sub(whole)..=to])
        {
            continue;
        }
        // By trapezoids, since rows may be unevenly apart.
        let mean = |value: &dyn Fn(usize) -> f64| {
            (from..to)
                .map(|row| 0.5 * (value(row) + value(row + 1)) * (time_s[row + 1] - time_s[row]))
                .sum::<f64>()
                / whole_s
        };
        let rate = (measured[to] - measured[from]) / whole_s;
        let direction = if rate.abs() > slow { rate.signum() } else { 0.0 };
        let place = (mean(&|row| measured[row]) - low) / (high - low);
        let (square, cube) = (place * place, place * place * place);
        let regressors = [
            rate,
            1.0,
            place,
            square,
            cube,
            direction,
            direction * place,
            direction * square,
            direction * cube,
        ];
        let expected = match between {
            Between::Line => mean(&|row| expected[row]),
            Between::Held => {
                (from + 1..=to).map(|row| expected[row] * (time_s[row] - time_s[row - 1])).sum::<f64>()
                    / whole_s
            }
        };
        rows.push((regressors, expected - mean(&|row| measured[row])));
    }
    if rows.len() < LEAST_ROWS {
        return unknown;
    }
    let sums: Vec<Sums> = (0..BLOCKS)
        .map(|block| {
            let of = |block: usize| block * rows.len() / BLOCKS;
            rows[of(block)..of(block + 1)].iter().fold(Sums::default(), |sums, row| sums.with(row))
        })
        .collect();
    let without = |left_out: Option<usize>| -> Option<f64> {
        let kept = sums.iter().enumerate().filter(|(block, _)| Some(*block) != left_out);
        kept.fold(Sums::default(), |all, (_, sums)| all.and(sums)).first().map(|(first, _)| first)
    };
    let all = sums.iter().fold(Sums::default(), |all, sums| all.and(sums));
    let noise = noise::floor(time_s, measured).deviation;
    let of_noise = 2.0 * (noise / (whole as f64 * step_s)).powi(2);
    if all.first().is_none_or(|(_, told)| told / rows.len() as f64 <= ABOVE_NOISE * of_noise) {
        return Late { mean_s: 0.0, error_s: OPEN_S };
    }
    let leave_one_out: Option<Vec<f64>> = (0..BLOCKS).map(|block| without(Some(block))).collect();
    let Some((mean_s, others)) = without(None).zip(leave_one_out) else { return unknown };
    let middle = others.iter().sum::<f64>() / BLOCKS as f64;
    let squares: f64 = others.iter().map(|one| (one - middle).powi(2)).sum();
    Late { mean_s, error_s: (squares * (BLOCKS - 1) as f64 / BLOCKS as f64).sqrt() }
}

/// The sums of least squares.
#[derive(Clone, Copy, Default)]
struct Sums {
    products: [[f64; UNKNOWNS]; UNKNOWNS],
    right: [f64; UNKNOWNS],
}

impl Sums {
    fn with(mut self, (regressors, value): &([f64; UNKNOWNS], f64)) -> Self {
        for (i, a) in regressors.iter().enumerate() {
            for (j, b) in regressors.iter().enumerate() {
                self.products[i][j] += a * b;
            }
            self.right[i] += a * value;
        }
        self
    }

    fn and(mut self, other: &Self) -> Self {
        for i in 0..UNKNOWNS {
            for j in 0..UNKNOWNS {
                self.products[i][j] += other.products[i][j];
            }
            self.right[i] += other.right[i];
        }
        self
    }

    /// The first unknown, and the sum of squares by which the others do not tell it, by Cholesky's
    /// method; what the rows do not tell is 0. None where they do not tell the first one.
    fn first(&self) -> Option<(f64, f64)> {
        // The first unknown last: the others are taken out of it.
        let order: [usize; UNKNOWNS] = core::array::from_fn(|k| (k + 1) % UNKNOWNS);
        let a = |i: usize, j: usize| self.products[order[i]][order[j]];
        let mut lower = [[0.0; UNKNOWNS]; UNKNOWNS];
        let mut half = [0.0; UNKNOWNS];
        for i in 0..UNKNOWNS {
            for j in 0..i {
                let before: f64 = (0..j).map(|k| lower[i][k] * lower[j][k]).sum();
                lower[i][j] = if lower[j][j] > 0.0 { (a(i, j) - before) / lower[j][j] } else { 0.0 };
            }
            let left = a(i, i) - lower[i][..i].iter().map(|l| l * l).sum::<f64>();
            // A unit of rounding: the rows do not tell it.
            lower[i][i] = if left > 1e-9 * a(i, i) { left.sqrt() } else { 0.0 };
            let before: f64 = (0..i).map(|k| lower[i][k] * half[k]).sum();
            half[i] = if lower[i][i] > 0.0 { (self.right[order[i]] - before) / lower[i][i] } else { 0.0 };
        }
        let last = UNKNOWNS - 1;
        let told = lower[last][last];
        (told > 0.0).then(|| (half[last] / told, told * told))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{Noise, times, triangles};

    /// Ten times 10 s, at speeds from one to four, as seen `late_s` later, in a loop that is
    /// `wider` and with even noise of 0.03.
    fn seen(late_s: f64, wider: f64, speeds: bool) -> Late {
        let time_s: Vec<f64> = (0..10_000).map(|row| 0.01 * f64::from(row)).collect();
        let course = |time_s: f64| {
            let speed = if speeds { 1.0 + (time_s / 25.0).floor().min(3.0) } else { 1.0 };
            let phase = (speed * time_s / 10.0).fract();
            60.0 * (1.0 - (2.0 * phase - 1.0).abs())
        };
        let expected: Vec<f64> = time_s.iter().map(|&time| course(time)).collect();
        let mut seed = 1_u64;
        let measured: Vec<f64> = time_s
            .iter()
            .map(|&time| {
                let is_rising = course(time + 1e-3) > course(time);
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let noise = 0.03 * ((seed >> 33) as f64 / f64::from(1_u32 << 30) - 1.0);
                course(time - late_s) + if is_rising { -wider } else { wider } + noise
            })
            .collect();
        late(&time_s, &vec![true; time_s.len()], &expected, &measured, Between::Line)
    }

    #[test]
    fn a_delay_is_found_beside_a_loop_that_is_too_narrow() {
        for (late_s, wider) in [(0.0, 0.0), (0.02, 0.0), (0.02, 0.5), (0.0, 0.5)] {
            let found = seen(late_s, wider, true);
            assert!((found.mean_s - late_s).abs() < 0.005, "{late_s} {wider}: {found:?}");
            assert!(found.error_s < 0.005, "{found:?}");
        }
    }

    #[test]
    fn at_one_speed_a_delay_is_not_told_from_a_width() {
        let time_s: Vec<f64> = (0..8000).map(|row| 0.01 * f64::from(row)).collect();
        let scored = vec![true; time_s.len()];
        let triangles = |faster: f64| -> Vec<f64> {
            let speed = |time_s: f64| if time_s < 40.0 { 1.0 } else { faster };
            time_s.iter().map(|&time| (2.0 * (speed(time) * time / 10.0).fract() - 1.0).abs()).collect()
        };
        assert!(!has_speeds(&time_s, &scored, &triangles(1.0)));
        assert!(has_speeds(&time_s, &scored, &triangles(2.2)));
        assert_eq!(seen(0.02, 0.5, false).error_s, OPEN_S);
    }

    #[test]
    fn at_one_speed_the_turns_of_a_recording_show_a_delay() {
        let text = include_str!("../../../examples/paper-tables-1-2.toml");
        let file = ModelFile::parse(std::path::Path::new("model.toml"), text).expect("valid");
        let (time_s, mut noise) = (times(6000, 0.01), Noise::new(5));
        let input = |late_s: f64| -> Vec<f64> {
            time_s.iter().map(|time_s| triangles((time_s - late_s).max(0.0), 8.0)).collect()
        };
        let answer = |input: &[f64]| {
            let rows = Rows { time_s: &time_s, input, load: None, temperature: None };
            rows.answer(&file.extended().expect("valid")).expect("finite")
        };
        let output: Vec<f64> = answer(&input(0.03)).iter().map(|value| value + noise.white(0.03)).collect();
        let (input, scored) = (input(0.0), vec![true; time_s.len()]);
        let rows = Rows { time_s: &time_s, input: &input, load: None, temperature: None };
        let recording = Recording { rows, scored: &scored, output: &output, command: None };
        let Late { mean_s, error_s } = recorded(&file, &recording).expect("finite").late;
        assert!((mean_s - 0.03).abs() < 0.002 && error_s < 0.002, "{mean_s} s, {error_s} s");
    }

    #[test]
    fn a_first_order_lag_is_found_from_jumps() {
        let time_s: Vec<f64> = (0..6000).map(|row| 0.01 * f64::from(row)).collect();
        let command: Vec<f64> = (0..6000).map(|row| if row / 200 % 2 == 0 { 1.0 } else { 4.0 }).collect();
        let pressure = lagged(&time_s, &command, 0.08);
        let found = late(&time_s, &vec![true; 6000], &command, &pressure, Between::Held);
        assert!((found.mean_s - 0.08).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn of_a_signal_that_stands_still_nothing_is_known() {
        let time_s: Vec<f64> = (0..1000).map(f64::from).collect();
        let still = vec![3.0; 1000];
        let found = late(&time_s, &vec![true; 1000], &still, &still, Between::Line);
        assert_eq!(found.error_s, SLOWEST_S);
    }
}
