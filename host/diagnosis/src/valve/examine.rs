//! The search for the parts of a valve.

use rayon::prelude::*;

use super::set_points::SetPoints;
use super::steps::Following;
use super::{BandForm, ORDINARY_LAG_S, Orifice, Valve, ValveFit, ValvePart};
use crate::Columns;
use crate::command::outside;
use crate::delay::delayed;
use crate::gain::differ_less_than_misfit;
use crate::low_pass::low_pass;
use recording::noise;
use recording::numbers::range;

/// Logarithm of the ratio of errors that an effect has to gain.
const GAIN: f64 = 0.12;
/// Up to here a delay is that of the recording, and not named: a row's command is written behind its sample, and acts by the
/// next. Unit: row.
const RECORDED_DELAY: f64 = 1.0;
/// Rows that are compared, at most.
const ROWS: usize = 20_000;
/// Dead bands that are tried, between these shares of the command's span.
const BANDS: (usize, f64, f64) = (480, 0.003, 0.3);
/// Lags that they are tried with, beside the one found without: that stands in for the band. Unit: s.
const LAGS_S: [f64; 3] = [0.02, 0.05, 0.12];
/// How many of the best bands are refined.
const BEGINNINGS: usize = 4;
/// The least distance between two of them. Unit: place.
const APART: f64 = 8.0;
/// How many places to either side of each are tried where the band holds, and how far apart, ever finer: one command that is wrongly
/// accepted moves all that come after it, until the command stands still.
const CLOSELY: [(i32, f64); 3] = [(60, 0.05), (60, 0.01), (60, 0.002)];
/// How far to either side of the best a band that drags is looked for. Unit: place.
const FINER: [f64; 8] = [6.0, 3.6, 2.0, 1.2, 0.72, 0.4, 0.24, 0.14];
/// The absolute pressure before an orifice is at most this many times that of the highest command: a choice, a bound. It is not below that
/// command, since a supply that is too low is a part of its own. Unit: 1.
pub const BEFORE: f64 = 4.0;
/// The search for it begins at this many times that of the highest command: a choice, a start. Unit: 1.
pub const BEGUN: f64 = 1.2;
/// Iterations for lag, damping, delay and limit.
const ITERATIONS: usize = 12;

/// The task: times, command and pressure.
#[derive(Clone, Copy)]
struct Task<'a> {
    time_s: &'a [f64],
    command: &'a [f64],
    pressure: &'a [f64],
    scored: &'a [bool],
    step_s: f64,
    noise: f64,
    /// The atmosphere's pressure, in the recording's unit; None where that is not a unit of pressure.
    outside: Option<f64>,
    /// The highest command. Unit of the pressure.
    highest: f64,
}

/// Finds the valve's effects; None without a command beside the pressure.
pub fn examine(columns: &Columns, noise: f64) -> Option<ValveFit> {
    let rows = columns.time_s.len().min(ROWS);
    let command = columns.command.as_deref()?;
    let task = Task {
        time_s: &columns.time_s[..rows],
        command: &command[..rows],
        pressure: &columns.input[..rows],
        scored: &columns.scored[..rows],
        step_s: noise::steps(&columns.time_s).0,
        noise,
        outside: outside(columns.input_unit),
        highest: range(command).1,
    };
    let ideal_rmse_bar = task.error(task.command);
    let mut best = task.polished(Valve::slow(0.05));
    // No error is less than the noise: near it there is nothing left to gain.
    while (best.1 / noise).ln() > GAIN {
        let next = task.richer(&best.0).into_iter().min_by(|one, other| one.1.total_cmp(&other.1));
        match next {
            Some(next) if (best.1 / next.1).ln() > GAIN => best = next,
            _ => break,
        }
    }
    let (valve, rmse_bar) = best;
    let mut named: Vec<(ValvePart, f64)> = Vec::new();
    let recorded_s = RECORDED_DELAY * task.step_s;
    let later = delayed(task.command, task.time_s, recorded_s);
    for (part, poorer) in valve.poorer() {
        let (fewer, mut without) = task.polished(poorer);
        if part == ValvePart::Delay {
            let is_ordinary = |delay_s| delay_s + valve.lag_s <= ORDINARY_LAG_S;
            if valve.delay_s.is_some_and(|delay_s| delay_s <= recorded_s || is_ordinary(delay_s)) {
                continue;
            }
            without = without.min(Task { command: &later, ..task }.polished(poorer).1);
            without = without.min(task.polished(poorer.of_second_order()).1);
        }
        let (mut with, mut gain) = (rmse_bar, (without / rmse_bar).ln());
        if part == ValvePart::Band {
            // What the command does between two rows nobody knows: where it turns there a band stands in for that.
            [with, without] = [valve, fewer].map(|valve| task.beyond_rows(&valve));
            gain = gain.min((without / with).ln());
        }
        // What is within the misfit of the valve's form may be that form's: a lag that is not quite the valve's looks like a delay, and at one
        // speed like a band.
        let is_of_form = part != ValvePart::Supply && differ_less_than_misfit(with, without, noise);
        if gain > GAIN && !is_of_form {
            named.push((part, gain));
        }
    }
    if valve.lag_s > ORDINARY_LAG_S {
        let at_once = task.error(&task.simulated(&Valve { lag_s: 1e-6, ..valve }));
        named.push((ValvePart::Lag, (at_once / rmse_bar).ln()));
    }
    Some(ValveFit { valve, named, rmse_bar, ideal_rmse_bar, unit: columns.input_unit })
}

impl Task<'_> {
    /// What a valve makes of the command, from the first pressure on.
    fn simulated(&self, valve: &Valve) -> Vec<f64> {
        valve.simulate(self.start(), self.time_s, self.command)
    }

    /// The pressure that it begins with.
    fn start(&self) -> f64 {
        self.pressure.first().copied().unwrap_or(0.0)
    }

    /// Root mean square of the difference, never less than the pressure's noise.
    fn error(&self, simulated: &[f64]) -> f64 {
        let (mut squares, mut count) = (0.0, 0.0);
        for ((simulated, measured), &scored) in simulated.iter().zip(self.pressure).zip(self.scored) {
            if scored {
                squares += (simulated - measured).powi(2);
                count += 1.0;
            }
        }
        (squares / f64::max(count, 1.0)).sqrt().max(self.noise)
    }

    /// Root mean square of the difference by which a valve is farther off than it can be since commands are known at rows alone: by half
    /// of what the command moves between two, as the valve's lag leaves it. Never less than the pressure's noise.
    fn beyond_rows(&self, valve: &Valve) -> f64 {
        let moves = self.command.windows(2).map(|pair| 0.5 * (pair[1] - pair[0]).abs());
        let moves: Vec<f64> = std::iter::once(0.0).chain(moves).collect();
        let unknown = low_pass(&moves, self.time_s, valve.lag_s);
        let simulated = self.simulated(valve);
        let beyond =
            simulated.iter().zip(self.pressure).zip(unknown).map(|((simulated, measured), unknown)| {
                let off = simulated - measured;
                measured + (off.abs() - unknown).max(0.0).copysign(off)
            });
        self.error(&beyond.collect::<Vec<_>>())
    }

    /// Mean of the absolute difference.
    fn mean_error(&self, simulated: &[f64]) -> f64 {
        let all = simulated.iter().zip(self.pressure).zip(self.scored);
        let scored = all.filter(|(_, scored)| **scored).map(|((one, other), _)| (one - other).abs());
        let (sum, count) = scored.fold((0.0, 0.0), |(sum, count), error| (sum + error, count + 1.0));
        sum / f64::max(count, 1.0)
    }

    /// The valve with each effect that it has not, polished.
    fn richer(&self, valve: &Valve) -> Vec<(Valve, f64)> {
        let mut all = Vec::new();
        if valve.damping_ratio.is_none() && valve.orifice.is_none() {
            all.push(self.polished(valve.of_second_order()));
            all.extend(self.outside.map(|outside| {
                let supply = BEGUN * (self.highest + outside);
                self.polished(Valve { orifice: Some(Orifice { supply, outside }), ..*valve })
            }));
        }
        if valve.delay_s.is_none() {
            all.push(self.polished(Valve { delay_s: Some(2.0 * self.step_s), ..*valve }));
        }
        if valve.supply_bar.is_none() {
            let highest = self.pressure.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            all.push(self.polished(Valve { supply_bar: Some(highest - self.noise), ..*valve }));
        }
        if valve.band.is_none() {
            all.extend(
                [BandForm::Hold, BandForm::HoldBetween, BandForm::Backlash]
                    .into_iter()
                    .filter_map(|form| self.banded(valve, form)),
            );
        }
        all
    }

    /// The valve with a dead band. Its stairs fit at the right band only, and the lag that was found without it stands in for
    /// it: so bands are tried closely, each with several lags, and the best few are refined.
    ///
    /// They are ranked by their mean absolute error: near the right band few commands are wrongly accepted, but what each of them does to
    /// the squares is by chance.
    fn banded(&self, valve: &Valve, form: BandForm) -> Option<(Valve, f64)> {
        let (low, high) = range(self.command);
        let set_points = SetPoints::of(self.time_s, self.command, valve.delay_s);
        let band = |place: f64| {
            let share = BANDS.1 * (BANDS.2 / BANDS.1).powf(place / (BANDS.0 - 1) as f64);
            Some((form, share * (high - low)))
        };
        let at = |place: f64, lag_s: f64| Valve { band: band(place), lag_s, ..*valve };
        let following = |lag_s: f64| Following::of(self.time_s, &at(0.0, lag_s).lag(), self.pressure);
        let error = |lag: &Following, given: &[f64]| {
            let mut pressure = given.to_vec();
            lag.follow(self.start(), &mut pressure);
            self.mean_error(&pressure)
        };
        let lags: Vec<(f64, Following)> =
            LAGS_S.into_iter().chain([valve.lag_s]).map(|lag_s| (lag_s, following(lag_s))).collect();
        let given = |place: f64| set_points.through(band(place), valve.supply_bar);
        let nearest = |place: usize| {
            let given = given(place as f64);
            let errors = lags.iter().map(|(lag_s, lag)| (error(lag, &given), place as f64, *lag_s));
            errors.min_by(|one, other| one.0.total_cmp(&other.0))
        };
        let mut tried: Vec<(f64, f64, f64)> = (0..BANDS.0).into_par_iter().filter_map(nearest).collect();
        tried.sort_by(|one, other| one.0.total_cmp(&other.0));
        let mut begun: Vec<(f64, f64)> = Vec::new();
        for (_, place, lag_s) in tried {
            if begun.iter().all(|(other, _)| (other - place).abs() > APART) {
                begun.push((place, lag_s));
            }
        }
        begun.truncate(BEGINNINGS);
        let polished = |(place, lag_s)| (place, self.polished(at(place, lag_s)));
        let ends = begun.into_par_iter().map(polished).map(|mut end| {
            if form != BandForm::Backlash {
                for (count, apart) in CLOSELY {
                    let lag = following(end.1.0.lag_s);
                    let near = (-count..=count).map(|i| end.0 + f64::from(i) * apart);
                    let near = near.map(|place| (error(&lag, &given(place)), place));
                    let nearest = near.min_by(|one, other| one.0.total_cmp(&other.0));
                    let nearest = nearest.map(|(_, place)| polished((place, end.1.0.lag_s)));
                    end = nearest.filter(|near| near.1.1 < end.1.1).unwrap_or(end);
                }
            }
            end
        });
        let mut best = ends.min_by(|one, other| one.1.1.total_cmp(&other.1.1))?;
        if form == BandForm::Backlash {
            for step in FINER {
                for place in [best.0 - step, best.0 + step] {
                    let other = polished((place, best.1.0.lag_s));
                    best = if other.1.1 < best.1.1 { other } else { best };
                }
            }
        }
        Some(best.1)
    }

    /// Lag, damping, delay and limit by Gauss-Newton with differences.
    fn polished(&self, valve: Valve) -> (Valve, f64) {
        let mut valve = valve;
        let mut simulated = self.simulated(&valve);
        let mut error = self.error(&simulated);
        let least = self.highest + self.outside.unwrap_or(0.0);
        let supplies = (least, BEFORE * least);
        for _ in 0..ITERATIONS {
            let values = valve.smooth();
            let columns: Vec<Vec<f64>> = (0..values.len())
                .map(|i| {
                    let mut moved = values.clone();
                    // Lag and damping are by their logarithms.
                    let logarithms = 1 + usize::from(valve.damping_ratio.is_some());
                    let step = if i < logarithms { 1e-3 } else { 0.1 * self.step_s.min(1e-2) };
                    moved[i] += step;
                    let other = self.simulated(&valve.with_smooth(&moved, self.step_s, supplies));
                    other.iter().zip(&simulated).map(|(a, b)| (a - b) / step).collect()
                })
                .collect();
            let Some(change) = self.step(&columns, &simulated) else { break };
            let mut share = 1.0;
            let before = error;
            for _ in 0..4 {
                let moved: Vec<f64> = values.iter().zip(&change).map(|(v, c)| v + share * c).collect();
                let other = valve.with_smooth(&moved, self.step_s, supplies);
                let next = self.simulated(&other);
                if self.error(&next) < error {
                    (valve, error) = (other, self.error(&next));
                    simulated = next;
                    break;
                }
                share *= 0.3;
            }
            if error > before * (1.0 - 1e-4) {
                break;
            }
        }
        (valve, error)
    }

    fn step(&self, columns: &[Vec<f64>], simulated: &[f64]) -> Option<Vec<f64>> {
        let count = columns.len();
        let mut matrix = nalgebra::DMatrix::<f64>::zeros(count, count);
        let mut right = nalgebra::DVector::<f64>::zeros(count);
        for row in (0..simulated.len()).filter(|&row| self.scored[row]) {
            let residual = self.pressure[row] - simulated[row];
            for i in 0..count {
                right[i] += columns[i][row] * residual;
                for j in 0..=i {
                    matrix[(i, j)] += columns[i][row] * columns[j][row];
                }
            }
        }
        for i in 0..count {
            matrix[(i, i)] = matrix[(i, i)] * (1.0 + 1e-6) + 1e-12;
        }
        Some(nalgebra::Cholesky::new(matrix)?.solve(&right).iter().copied().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_command_does_between_rows_is_no_error_and_a_dead_band_is_one() {
        // Triangles of 4.9 bar/s, simulated every millisecond and seen every tenth one.
        let fine_s: Vec<f64> = (0..60_000).map(|row| 0.001 * f64::from(row)).collect();
        let triangle = |time_s: &f64| 4.0 * (1.0 - (2.0 * (0.617 * time_s).fract() - 1.0).abs());
        let commands: Vec<f64> = fine_s.iter().map(triangle).collect();
        let every = |values: &[f64]| -> Vec<f64> { values.iter().step_by(10).copied().collect() };
        let [time_s, command] = [every(&fine_s), every(&commands)];
        let lag = Valve::slow(0.016);
        let of = |valve: Valve| {
            let pressure = every(&valve.simulate(commands[0], &fine_s, &commands));
            let task = Task {
                time_s: &time_s,
                command: &command,
                pressure: &pressure,
                scored: &vec![true; time_s.len()],
                step_s: 0.01,
                noise: 1e-4,
                outside: None,
                highest: 4.0,
            };
            (task.error(&task.simulated(&lag)), task.beyond_rows(&lag))
        };
        let (error, beyond) = of(lag);
        assert!(error > 0.01 && beyond == 1e-4, "{error} {beyond}");
        for form in [BandForm::Backlash, BandForm::Hold] {
            let (error, beyond) = of(Valve { band: Some((form, 0.2)), ..lag });
            assert!(error > 0.04 && beyond > 0.02, "{error} {beyond}");
        }
    }
}
