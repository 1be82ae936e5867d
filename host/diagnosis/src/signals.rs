//! The recording as the search sees it: columns, what is derived from them once, and which rows count how.
//!
//! # Design
//! The measured contraction is smoothed by a local cubic, from which come its rate and acceleration; they enter the
//! extensions of the search only (what is claimed as gain is measured on a model that runs free of them). All that is derived
//! comes from all rows; then as many are kept as scoring needs, no farther apart than 20 ms, by which the memory of an operator
//! loses nothing: where it turns its input moves slowly. Blocks of time make the folds: a row near a block of another fold
//! does not teach what is tried there.

use std::sync::Arc;

use super::Columns;
use super::anatomy::spectrum::InputLines;
use super::basis::Basis;
use super::command::Command;
use super::low_pass::low_pass;
use super::misfit::Misfits;
use super::rates::{JERK_WINDOW, Rate, WINDOW, local_cubic, speed};
pub use super::row::{FOLDS, Row};
use super::thinning::Thinning;
use recording::drop_out::DropOut;
use recording::noise::NoiseFloor;
use recording::noise::steps;
use recording::numbers::{quantiles, range, root_mean_square, travel};

/// Most rows that are scored in the search.
const SCORED_ROWS: usize = 4000;
/// Kept rows are no farther apart, where the recording's are not: as far as the window goes that rates are taken in. Unit: s.
const KEPT_STEP_S: f64 = 0.02;
/// Most of them where only a rank comes out.
const RANKED_ROWS: usize = 2000;
/// Blocks of time, in all.
const BLOCKS: f64 = 16.0;
/// Least and greatest length of a block. Unit: s.
const BLOCK_S: (f64, f64) = (4.0, 30.0);
/// What a block keeps away from the next, as a share of a block.
const GAP: f64 = 0.1;
/// Tents over the contraction that an effect's strength is made of.
pub const TENTS: usize = 3;
/// Contractions at which it is known how steep the contraction rises, and by how much it may differ from that at mid stroke.
const STIFFNESS: usize = 21;
const STIFFEST: f64 = 10.0;
/// Time constants of a creep, at most.
const CREEP: usize = 6;

/// What is quicker than kept rows show.
#[derive(Debug)]
pub struct Recorded {
    /// Of all rows up to the last kept one. Unit: s.
    pub time_s: Vec<f64>,
    /// Input unit.
    pub input: Vec<f64>,
    /// Size of its rate above the noise. Unit: input unit/s.
    pub input_speed: Vec<f64>,
    /// The strong lines of the input.
    pub input_lines: InputLines,
    /// Of all rows that may be scored. Unit: s.
    pub scored_s: Vec<f64>,
    /// Output unit.
    pub scored: Vec<f64>,
}

/// A recording, prepared. Each list has a value a kept row.
#[derive(Clone, Debug)]
pub struct Signals {
    /// The rows of the recording that are kept.
    kept: Vec<usize>,
    /// What they are kept of, all of it.
    pub recorded: Arc<Recorded>,
    /// What the sensors did not measure.
    pub drop_outs: Vec<DropOut>,
    /// Unit: s.
    pub time_s: Vec<f64>,
    /// What the muscle is modelled from.
    pub input: Vec<f64>,
    /// Measured contraction.
    pub output: Vec<f64>,
    /// Its smoothed rate. Unit: output unit/s.
    pub rate: Vec<f64>,
    /// Its smoothed acceleration. Unit: output unit/s².
    pub acceleration: Vec<f64>,
    /// The derivative of that, over a wider window. Unit: output unit/s³.
    pub jerk: Vec<f64>,
    /// Speeds of input and contraction: sizes of their rates above the noise. Units: those of the columns a second.
    speeds: [Vec<f64>; 2],
    /// Root mean squares of the speeds.
    typical_speeds: [f64; 2],
    /// Highest less lowest input. Input unit.
    pub input_span: f64,
    /// The command, where that is the input.
    pub command: Option<Command>,
    /// Time constants that a creep is made of, on a logarithmic grid. Unit: s.
    pub creep_s: Vec<f64>,
    /// What has not come yet of the output, by a low-pass of each: a value a scored row. Output unit.
    pub slow: Vec<Vec<f64>>,
    /// Way of the contraction so far. Output unit.
    pub travel: Vec<f64>,
    /// The recorded load less its mean. Unit: N.
    pub load: Option<Vec<f64>>,
    /// The recorded temperature less its mean. Unit: K.
    pub temperature: Option<Vec<f64>>,
    /// Weights of the tents over the contraction. They are taken where a model of the input alone says that the
    /// contraction is: at the measured one a residual would explain a part of itself.
    pub tents: Vec<[f64; TENTS]>,
    /// The same at the smoothed contraction itself, times [`Self::stiffer`], for what is driven by its motion.
    pub moving_tents: Vec<[f64; TENTS]>,
    /// The smoothed contraction. Output unit.
    smooth: Vec<f64>,
    /// How much more input a change of contraction takes than at mid stroke, evenly spaced between the outer knots.
    stiffness: [f64; STIFFNESS],
    /// Where the tents stand. Output unit.
    pub knots: [f64; TENTS],
    /// The rows that are scored.
    pub rows: Vec<Row>,
    /// What the baseline gets wrong in the same way at every visit to a state, of a fresh muscle and of one that has been through its
    /// range; none before it is asked for.
    misfits: Option<[Arc<Misfits>; 2]>,
    /// Number of blocks.
    pub blocks: usize,
    /// Median step of the recording. Unit: s.
    pub step_s: f64,
    /// The same of the kept rows. Unit: s.
    kept_step_s: f64,
    /// Noise of the output in the scored rows. Output unit.
    pub noise_floor: NoiseFloor,
    /// Its standard deviation. Output unit.
    pub noise: f64,
    /// Noise of the input. Input unit.
    pub input_noise: f64,
    /// What the true model would differ by from the output: the noise of both, as far as the loop's slope passes the input's on,
    /// root mean square. Output unit.
    pub least_error: f64,
}

impl Signals {
    /// Prepares a recording.
    pub fn new(columns: &Columns) -> Self {
        let Columns { time_s, input, output, scored, .. } = columns;
        let (step_s, _) = steps(time_s);
        let [smooth, rate, acceleration, _] = local_cubic(time_s, output, step_s, WINDOW);
        let [_, _, _, jerk] = local_cubic(time_s, output, step_s, JERK_WINDOW);
        let noise_floor = columns.noise_floor();
        let (noise, input_noise) = (noise_floor.deviation, columns.input_noise());
        let speeds = [speed(time_s, input, step_s, input_noise), speed(time_s, output, step_s, noise)];
        let (low, high) = quantiles(output, 0.02);
        let knots = std::array::from_fn(|knot| low + (high - low) * knot as f64 / (TENTS - 1) as f64);
        let (stride, every) = strides(columns, step_s);
        let (rows, blocks) = rows(time_s, scored, every);
        let end = rows.last().map_or(0, |row| row.at + 1);
        let recorded = Recorded {
            time_s: time_s[..end].to_vec(),
            input: input[..end].to_vec(),
            input_speed: speeds[Rate::Input as usize][..end].to_vec(),
            input_lines: InputLines::of(time_s, input),
            scored_s: columns.of_scored(time_s),
            scored: columns.of_scored(output),
        };
        let (lowest, highest) = range(input);
        let duration_s = time_s.last().unwrap_or(&0.0) - time_s.first().unwrap_or(&0.0);
        let creep_s = creep_s((5.0 * step_s).max(0.1), duration_s / 3.0);
        let slow = |&tau_s: &f64| -> Vec<f64> {
            let slow = low_pass(output, time_s, tau_s);
            rows.iter().map(|row| slow[row.at] - output[row.at]).collect()
        };
        let whole = Self {
            kept: (0..time_s.len()).collect(),
            recorded: Arc::new(recorded),
            drop_outs: columns.drop_outs.clone(),
            input_span: (highest - lowest).max(1e-9),
            command: Command::of(columns),
            slow: creep_s.iter().map(slow).collect(),
            creep_s,
            travel: travel(&smooth, 4.0 * noise),
            tents: output.iter().map(|&y| hats(&knots, y)).collect(),
            moving_tents: smooth.iter().map(|&y| hats(&knots, y)).collect(),
            smooth,
            stiffness: [1.0; STIFFNESS],
            load: varying(columns.load_n.as_deref()),
            temperature: varying(columns.temperature_c.as_deref()),
            input_noise,
            time_s: time_s.clone(),
            input: input.clone(),
            output: output.clone(),
            rate,
            acceleration,
            jerk,
            typical_speeds: [0, 1].map(|i: usize| root_mean_square(&speeds[i]).max(1e-9)),
            speeds,
            knots,
            rows,
            misfits: None,
            blocks,
            step_s,
            kept_step_s: step_s,
            noise_floor,
            noise,
            least_error: noise,
        };
        let thinning = Thinning::by(stride, &whole.scored());
        whole.thinned_to(thinning, 1)
    }

    /// Says where a model of the input alone sees the contraction, a value a row of the recording.
    pub fn set_simulated(&mut self, simulated: &[f64]) {
        self.tents = simulated.iter().map(|&y| hats(&self.knots, y)).collect();
    }

    /// Says how steep the contraction rises with the input at a contraction. Unit: output unit/input unit.
    pub fn set_slope(&mut self, slope: impl Fn(f64) -> f64) {
        let (low, high) = (self.knots[0], self.knots[TENTS - 1]);
        let middle = slope(0.5 * (low + high));
        self.stiffness = std::array::from_fn(|i| {
            let there = slope(low + (high - low) * i as f64 / (STIFFNESS - 1) as f64);
            let stiffer = middle / there;
            if stiffer.is_finite() { stiffer.clamp(1.0 / STIFFEST, STIFFEST) } else { 1.0 }
        });
        let passed_on = |row: &Row| middle * self.input_noise / self.stiffer(self.smooth[row.at]);
        let passed_on = root_mean_square(&self.rows.iter().map(passed_on).collect::<Vec<f64>>());
        self.least_error = self.noise.hypot(if passed_on.is_finite() { passed_on } else { 0.0 });
        self.moving_tents = self.smooth.iter().map(|&y| self.moving_tents_at(y)).collect();
    }

    /// How much more input a change of contraction takes than at mid stroke.
    pub fn stiffer(&self, y: f64) -> f64 {
        let (left, share) = between((self.knots[0], self.knots[TENTS - 1]), STIFFNESS, y);
        self.stiffness[left] + share * (self.stiffness[left + 1] - self.stiffness[left])
    }

    /// [`Self::moving_tents`] at a contraction.
    pub fn moving_tents_at(&self, y: f64) -> [f64; TENTS] {
        let stiffer = self.stiffer(y);
        hats(&self.knots, y).map(|hat| hat * stiffer)
    }

    /// Lets the baselines of an input's range be wrong in the same way at every visit to a state.
    pub fn set_misfit(&mut self, [fresh, preconditioned]: [&Basis; 2]) {
        self.misfits = Some([fresh, preconditioned].map(|basis| Arc::new(Misfits::new(basis, &self.rows))));
    }

    /// What a baseline gets wrong so; None before it is asked for.
    pub fn misfits(&self, basis: &Basis) -> Option<&Misfits> {
        Some(&self.misfits.as_ref()?[usize::from(basis.is_preconditioned())])
    }

    /// The same in other rows.
    fn misfits_of(&self, rows: &[Row]) -> Option<[Arc<Misfits>; 2]> {
        Some(self.misfits.as_ref()?.each_ref().map(|all| Arc::new(all.of_rows(rows))))
    }

    /// The same, with rate and acceleration of a contraction that was simulated, a value a row. Output unit.
    pub fn moving_as(&self, simulated: &[f64]) -> Self {
        let [smooth, rate, acceleration, _] = local_cubic(&self.time_s, simulated, self.kept_step_s, WINDOW);
        let [_, _, _, jerk] = local_cubic(&self.time_s, simulated, self.kept_step_s, JERK_WINDOW);
        let moving_tents = smooth.iter().map(|&y| self.moving_tents_at(y)).collect();
        Self { rate, acceleration, jerk, smooth, moving_tents, ..self.clone() }
    }

    /// The scored rows and what leads to them, some of them scored: enough for a rank.
    pub fn thinned(&self) -> Self {
        let scored: Vec<usize> = self.rows.iter().map(|row| row.at).collect();
        self.thinned_to(Thinning::to(&scored), self.rows.len().div_ceil(RANKED_ROWS).max(1))
    }

    /// All kept rows, of the scored ones only those scored of which `counts` says so.
    pub fn of_rows(&self, counts: impl Fn(usize) -> bool) -> Self {
        let counted: Vec<bool> = self.rows.iter().map(|row| counts(row.at)).collect();
        let of =
            |values: &Vec<f64>| values.iter().zip(&counted).filter(|(_, c)| **c).map(|(&v, _)| v).collect();
        let rows: Vec<Row> =
            self.rows.iter().zip(&counted).filter(|(_, c)| **c).map(|(row, _)| *row).collect();
        Self {
            misfits: self.misfits_of(&rows),
            rows,
            slow: self.slow.iter().map(of).collect(),
            ..self.clone()
        }
    }

    /// To these kept rows, every so many of the scored ones scored.
    fn thinned_to(&self, thinning: Thinning, every: usize) -> Self {
        let of = |values: &Vec<f64>| thinning.of(values);
        let places = self.rows.iter().zip(&thinning.scored).step_by(every);
        let time_s = of(&self.time_s);
        let rows: Vec<Row> = places.map(|(row, &at)| Row { at, ..*row }).collect();
        Self {
            misfits: self.misfits_of(&rows),
            rows,
            kept: thinning.of(&self.kept),
            recorded: Arc::clone(&self.recorded),
            drop_outs: self.drop_outs.clone(),
            kept_step_s: steps(&time_s).0,
            time_s,
            input: of(&self.input),
            output: of(&self.output),
            rate: of(&self.rate),
            acceleration: of(&self.acceleration),
            jerk: of(&self.jerk),
            speeds: self.speeds.each_ref().map(of),
            creep_s: self.creep_s.clone(),
            slow: self.slow.iter().map(|slow| slow.iter().copied().step_by(every).collect()).collect(),
            travel: of(&self.travel),
            load: self.load.as_ref().map(of),
            temperature: self.temperature.as_ref().map(of),
            tents: thinning.of(&self.tents),
            moving_tents: thinning.of(&self.moving_tents),
            smooth: of(&self.smooth),
            ..*self
        }
    }

    /// Where the scored rows are in the recording.
    pub fn scored(&self) -> Vec<usize> {
        self.rows.iter().map(|row| self.kept[row.at]).collect()
    }

    /// What is kept of a column of all rows.
    pub fn kept(&self, values: &[f64]) -> Vec<f64> {
        self.kept.iter().map(|&row| values[row]).collect()
    }

    /// The speed that a width depends on.
    pub fn speed_of(&self, rate: Rate) -> &[f64] {
        &self.speeds[rate as usize]
    }

    /// Root mean square of a speed.
    pub fn typical_speed(&self, rate: Rate) -> f64 {
        self.typical_speeds[rate as usize]
    }

    /// Between the outer knots. Output unit.
    pub fn stroke(&self) -> f64 {
        self.knots[TENTS - 1] - self.knots[0]
    }

    /// From the first to the last time. Unit: s.
    pub fn duration_s(&self) -> f64 {
        self.time_s.last().unwrap_or(&0.0) - self.time_s.first().unwrap_or(&0.0)
    }
}

/// Time constants from the shortest on, two a decade.
fn creep_s(shortest_s: f64, longest_s: f64) -> Vec<f64> {
    (0..CREEP)
        .map(|i| shortest_s * 10f64.powf(0.5 * i as f64))
        .take_while(|&tau_s| tau_s <= longest_s)
        .collect()
}

/// Weights of hat functions on equally spaced knots, constant outside.
pub fn hats<const K: usize>(knots: &[f64; K], value: f64) -> [f64; K] {
    let (left, share) = between((knots[0], knots[K - 1]), K, value);
    let mut weights = [0.0; K];
    weights[left] = 1.0 - share;
    weights[left + 1] = share;
    weights
}

/// The knot to the left of a value, of so many equally spaced ones, and the weight of the one to its right.
fn between((low, high): (f64, f64), knots: usize, value: f64) -> (usize, f64) {
    let last = (knots - 1) as f64;
    let place = ((value - low) * last / (high - low).max(1e-12)).clamp(0.0, last);
    let left = (place as usize).min(knots - 2);
    (left, place - left as f64)
}

/// A column less its mean, if it varies.
fn varying(column: Option<&[f64]>) -> Option<Vec<f64>> {
    let column = column?;
    let mean = column.iter().sum::<f64>() / column.len().max(1) as f64;
    let centred: Vec<f64> = column.iter().map(|value| value - mean).collect();
    let size = centred.iter().map(|value| value.abs()).fold(0.0, f64::max);
    (size > 1e-9 * (1.0 + mean.abs())).then_some(centred)
}

/// Every how many rows are kept, and every how many are scored.
fn strides(columns: &Columns, step_s: f64) -> (usize, usize) {
    let needed = columns.scored.iter().filter(|&&scored| scored).count().div_ceil(SCORED_ROWS).max(1);
    // A command may jump between any two.
    let most = if columns.input_is_command { 1 } else { (1.001 * KEPT_STEP_S / step_s.max(1e-9)) as usize };
    let stride = most.clamp(1, needed);
    (stride, stride * needed.div_ceil(stride))
}

/// Every so many of the rows that may be scored, and the number of blocks they lie in.
fn rows(time_s: &[f64], scored: &[bool], every: usize) -> (Vec<Row>, usize) {
    let all: Vec<usize> = (0..time_s.len()).filter(|&at| scored[at]).collect();
    let (Some(&first), Some(&last)) = (all.first(), all.last()) else { return (Vec::new(), 0) };
    let (start_s, duration_s) = (time_s[first], time_s[last] - time_s[first]);
    let block_s = (duration_s / BLOCKS).clamp(BLOCK_S.0, BLOCK_S.1).min(duration_s / (2 * FOLDS) as f64);
    let blocks = ((duration_s / block_s.max(1e-9)).ceil() as usize).max(1);
    let rows = all
        .iter()
        .step_by(every)
        .map(|&at| {
            let place = (time_s[at] - start_s) / block_s.max(1e-9);
            let block = (place as usize).min(blocks - 1);
            let within = place - block as f64;
            let near = if within > 1.0 - GAP {
                Some((block + 1) % FOLDS)
            } else if within < GAP && block > 0 {
                Some((block - 1) % FOLDS)
            } else {
                None
            };
            Row { at, block, near }
        })
        .collect();
    (rows, blocks)
}
