//! Redraws Figs. 2, 4 and 5 of the paper into a directory: the operators and properties of its
//! tabled model.
//!
//! `cargo xtask figures` calls it. With `--check` it writes nothing, and fails where a file is not
//! what it would write. The drawings are the same to the byte on every machine, as the models are.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use model_core::dead_zone::{DeadZoneParameters, DeadZones};
use model_core::envelope::{Envelope, TanhEnvelope};
use model_core::play::PlayBank;
use model_core::{Hysteresis, Mgpi, ParameterError, paper};
use report::plot::{Line, Plot, Point, Style, sheet};

/// Samples on each way from one turning point to the next.
const SAMPLES: u32 = 400;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Draws the figures.
#[derive(Parser)]
struct Cli {
    /// Where the figures are.
    directory: PathBuf,
    /// Only compare.
    #[arg(long)]
    check: bool,
}

fn main() -> ExitCode {
    match perform(&Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn perform(cli: &Cli) -> Result<()> {
    let figures = [("fig-2.svg", dead_zones()?), ("fig-4.svg", wiping_out()?), ("fig-5.svg", congruency()?)];
    let figures = figures.map(|(name, drawing)| (cli.directory.join(name), drawing));
    if cli.check {
        let stale =
            |path: &Path, drawing: &str| std::fs::read_to_string(path).ok().as_deref() != Some(drawing);
        return match figures.iter().find(|(path, drawing)| stale(path, drawing)) {
            Some((path, _)) => Err(format!("{} is out of date: cargo xtask figures", path.display()).into()),
            None => Ok(()),
        };
    }
    std::fs::create_dir_all(&cli.directory)?;
    for (path, drawing) in &figures {
        std::fs::write(path, drawing)?;
    }
    Ok(())
}

/// Fig. 2: S(y, d) of equation (13) for thresholds of both signs.
fn dead_zones() -> Result<String> {
    let inputs: Vec<f64> = (-100..=100).map(|k| f64::from(k) / 50.0).collect();
    let stage = |thresholds: &[f64]| {
        DeadZones::<f64, 2>::try_new(&DeadZoneParameters {
            thresholds: thresholds.iter().copied().collect(),
            weights: thresholds.iter().map(|_| 1.0).collect(),
            offset: 0.0,
        })
    };
    let line = stage(&[0.0])?;
    // The stage always has the threshold 0, without which it had no inverse: the operator is what d
    // adds.
    let operator = |thresholds: &[f64]| -> std::result::Result<Vec<f64>, ParameterError> {
        let stage = stage(thresholds)?;
        Ok(inputs.iter().map(|&y| stage.value(y) - line.value(y)).collect())
    };
    let lines = [
        (Style::Model, operator(&[-1.0, 0.0])?),
        (Style::Model, operator(&[-0.5, 0.0])?),
        (Style::Error, inputs.iter().map(|&y| line.value(y)).collect()),
        (Style::Measured, operator(&[0.0, 0.5])?),
        (Style::Measured, operator(&[0.0, 1.0])?),
    ];
    let knees = [
        ("d = -1", (-1.0, 0.0), (-44, -24)),
        ("d = -0.5", (-0.5, 0.0), (-44, -24)),
        ("d = 0", (2.0, 2.0), (-62, -12)),
        ("d = 0.5", (0.5, 0.0), (-22, 8)),
        ("d = 1", (1.0, 0.0), (-12, 8)),
    ];
    let plot = Plot {
        title: "Fig. 2: dead-zone operators".to_owned(),
        x: "input y".to_owned(),
        y: "output z = S(y, d)".to_owned(),
        lines: lines.iter().map(|(style, z)| Line { name: "", style: *style, x: &inputs, y: z }).collect(),
        points: knees.map(|(name, at, offset)| Point { name, at, offset }).into(),
        ..Plot::default()
    };
    Ok(sheet("Dead-zone operators for five thresholds of both signs", &[plot]))
}

/// A path of inputs and what a model answers, sample by sample.
struct Walk {
    time: Vec<f64>,
    input: Vec<f64>,
    output: Vec<f64>,
}

impl Walk {
    /// Through turning points, from the first. One unit of time a way.
    fn through(turns: &[f64], mut answer: impl FnMut(f64) -> f64) -> Self {
        let ways = turns.windows(2).flat_map(|pair| {
            let (from, to) = (pair[0], pair[1]);
            (1..=SAMPLES).map(move |k| from + (to - from) * f64::from(k) / f64::from(SAMPLES))
        });
        let input: Vec<f64> = turns[..1].iter().copied().chain(ways).collect();
        Self {
            time: (0..input.len()).map(|k| k as f64 / f64::from(SAMPLES)).collect(),
            output: input.iter().map(|&x| answer(x)).collect(),
            input,
        }
    }

    /// The samples from one turning point to a later one.
    fn between(turn: usize, later: usize) -> std::ops::RangeInclusive<usize> {
        turn * SAMPLES as usize..=later * SAMPLES as usize
    }

    fn signal(&self) -> Line<'_> {
        Line { name: "", style: Style::Measured, x: &self.time, y: &self.input }
    }

    fn named(&self, names: &[(usize, &'static str, (i32, i32))], over_time: bool) -> Vec<Point<'static>> {
        let point = |&(turn, name, offset): &(usize, &'static str, (i32, i32))| {
            let k = turn * SAMPLES as usize;
            let at = if over_time { (self.time[k], self.input[k]) } else { (self.input[k], self.output[k]) };
            Point { name, at, offset }
        };
        names.iter().map(point).collect()
    }
}

/// The tabled model from rest.
fn tabled() -> Result<impl FnMut(f64) -> f64> {
    let model = Mgpi::<f64, { paper::SIZE }, { paper::SIZE }>::try_new(&paper::mgpi()?)?;
    let mut state = model.rest_state();
    Ok(move |x| model.step(&mut state, x).unwrap_or(f64::NAN))
}

/// Its plays alone, from rest.
fn tabled_plays() -> Result<impl FnMut(f64) -> f64> {
    let envelope = TanhEnvelope::try_new(paper::ENVELOPE)?;
    let bank = PlayBank::try_new(&paper::mgpi()?.plays)?;
    let mut state = bank.rest_state(envelope.value(0.0));
    Ok(move |x| bank.step(&mut state, envelope.value(x)).unwrap_or(f64::NAN))
}

fn plot<'a>(title: &str, x: &str, y: &str, lines: Vec<Line<'a>>, points: Vec<Point<'a>>) -> Plot<'a> {
    Plot { title: title.to_owned(), x: x.to_owned(), y: y.to_owned(), lines, points, ..Plot::default() }
}

const TIME: &str = "time (any unit)";
const PRESSURE: &str = "pressure (bar)";
const CONTRACTION: &str = "contraction (mm)";

/// Fig. 4.
fn wiping_out() -> Result<String> {
    let walk = Walk::through(&[0.0, 4.0, 2.0, 3.0, 1.0, 5.5, 0.0], tabled()?);
    let direct = Walk::through(&[0.0, 5.5, 0.0], tabled()?);
    let signal = walk.named(
        &[
            (1, "p1", (-8, -24)),
            (2, "p2", (-8, 8)),
            (3, "p3", (-8, -24)),
            (4, "p4", (-8, 8)),
            (5, "p5", (8, -12)),
        ],
        true,
    );
    let corners = walk.named(
        &[
            (1, "L1", (2, 8)),
            (2, "L2", (-30, -12)),
            (3, "L3", (8, -2)),
            (4, "L4", (-30, -16)),
            (5, "L5", (-6, 8)),
        ],
        false,
    );
    let loops = vec![
        Line { name: "p1 to p5, then 0", style: Style::Measured, x: &walk.input, y: &walk.output },
        Line { name: "p5 alone, then 0", style: Style::Model, x: &direct.input, y: &direct.output },
    ];
    Ok(sheet(
        "Wiping-out: the input pressure, and the loops that it brings about",
        &[
            plot("Fig. 4 (a) Input pressure", TIME, PRESSURE, vec![walk.signal()], signal),
            plot("(b) Loops: p5 wipes out p1 to p4", PRESSURE, CONTRACTION, loops, corners),
        ],
    ))
}

/// Fig. 5, and what it does not show.
fn congruency() -> Result<String> {
    const TURNS: [f64; 9] = [0.0, 4.0, 2.0, 4.0, 6.0, 2.0, 4.0, 2.0, 0.0];
    let walk = Walk::through(&TURNS, tabled()?);
    let inner = Walk::through(&TURNS, tabled_plays()?);
    let signal = walk.named(
        &[
            (1, "p1", (-8, -24)),
            (2, "p2", (-8, 8)),
            (3, "p3", (8, -2)),
            (5, "p4", (-8, 8)),
            (6, "p5", (-8, -24)),
        ],
        true,
    );
    // Loop 1 falls first, loop 2 rises first: both as rising, then falling.
    let (rising, falling) = (Walk::between(2, 3), Walk::between(1, 2));
    let (rising_2, falling_2) = (Walk::between(5, 6), Walk::between(6, 7));
    let around = |values: &[f64],
                  rising: &std::ops::RangeInclusive<usize>,
                  falling: &std::ops::RangeInclusive<usize>| {
        [&values[rising.clone()], &values[falling.clone()]].concat()
    };
    let pressure = around(&walk.input, &rising, &falling);
    let pair = |values: &[f64]| (around(values, &rising, &falling), around(values, &rising_2, &falling_2));
    let (one, two) = pair(&walk.output);
    // The middle of the differences: the shift that leaves the smallest largest error.
    let shifted = |one: &[f64], two: &[f64]| {
        let differences = || one.iter().zip(two).map(|(a, b)| b - a);
        let middle = (differences().fold(f64::INFINITY, f64::min)
            + differences().fold(f64::NEG_INFINITY, f64::max))
            / 2.0;
        let height = one.iter().copied().fold(f64::NEG_INFINITY, f64::max)
            - one.iter().copied().fold(f64::INFINITY, f64::min);
        let percent: Vec<f64> =
            differences().map(|difference| 100.0 * (difference - middle) / height).collect();
        (two.iter().map(|y| y - middle).collect::<Vec<f64>>(), percent)
    };
    let (two_shifted, misfit) = shifted(&one, &two);
    let (inner_one, inner_two) = pair(&inner.output);
    let (_, inner_misfit) = shifted(&inner_one, &inner_two);

    let loops = vec![
        Line { name: "", style: Style::Ink, x: &walk.input, y: &walk.output },
        Line { name: "loop 1", style: Style::Measured, x: &pressure, y: &one },
        Line { name: "loop 2", style: Style::Model, x: &pressure, y: &two },
    ];
    let overlay = vec![
        Line { name: "loop 1", style: Style::Measured, x: &pressure, y: &one },
        Line { name: "loop 2, shifted", style: Style::Model, x: &pressure, y: &two_shifted },
    ];
    let misfits = vec![
        Line { name: "MGPI output", style: Style::Measured, x: &pressure, y: &misfit },
        Line { name: "its plays", style: Style::Model, x: &pressure, y: &inner_misfit },
    ];
    Ok(sheet(
        "Congruency: the input pressure, two minor loops, one laid over the other, and what is left",
        &[
            plot("Fig. 5 (a) Input pressure", TIME, PRESSURE, vec![walk.signal()], signal),
            plot("(b) Two minor loops between 2 and 4 bar", PRESSURE, CONTRACTION, loops, vec![]),
            plot("(c) Loop 2 laid over loop 1", PRESSURE, CONTRACTION, overlay, vec![]),
            plot("(d) Loop 2 less loop 1", PRESSURE, "misfit (% of height)", misfits, vec![]),
        ],
    ))
}
