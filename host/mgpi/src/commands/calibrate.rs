//! `mgpi calibrate`: two points a sensor, and the regulator against its sensor; or how a sensor is
//! connected.

use std::io::{self, BufRead};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use clap::{Args, ValueEnum};
use wire::{Input, Line, Signal, State};

use super::deploy::demand_rest;
use super::port::PortArguments;
use crate::Error;
use board_client::bus::calibration::{
    HIGHEST_A, HIGHEST_V, Part, Point, connect, drive, in_words, point, read, read_inputs, write_today,
};
use board_client::bus::{Board, BoardError};

/// While somebody reads a gauge, a sign of life each.
const ALIVE: Duration = Duration::from_millis(100);

/// What is calibrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum What {
    /// The sensor of the pressure in the muscle, against a gauge
    Pressure,
    /// The sensor of the contraction, against a ruler
    Contraction,
    /// The sensor of the pressure before the valve, against a gauge
    Supply,
    /// The regulator's zero and span, against the calibrated pressure sensor
    Regulator,
}

/// Calibrates a sensor by two points, or the regulator against its sensor; the muscle moves.
///
/// For pressure and contraction the board drives the muscle to --low and --high bar, waits until it
/// rests, and asks what the gauge or the ruler shows. For the supply you set the pressure yourself.
/// The regulator needs no reading: calibrate the pressure first. The lines are held against those
/// of the standard sensor, written with the date and a checksum, and read back; the board keeps
/// them without power, whatever model is deployed.
///
/// With --input nothing moves: the board is told how a sensor is connected. Its line is then that
/// of the sensor's range, until two points are taken.
#[derive(Args, Debug)]
pub struct Arguments {
    /// What is calibrated
    what: What,
    /// Command of the low point in bar; 0 vents
    #[arg(long, default_value_t = 0.0, value_name = "BAR")]
    low: f64,
    /// Command of the high point in bar
    #[arg(long, default_value_t = 4.0, value_name = "BAR")]
    high: f64,
    /// What gauge or ruler show at both points, for a script; else it is asked for
    #[arg(long, value_name = "LOW,HIGH", value_parser = pair)]
    readings: Option<[f64; 2]>,
    /// Say what the lines would be, and write nothing
    #[arg(long)]
    dry_run: bool,
    /// Take no points: the sensor of this input puts out that
    #[arg(long, value_enum, value_name = "SIGNAL", conflicts_with_all = ["low", "high", "readings"])]
    input: Option<Puts>,
    /// What the sensor shows at 4 and 20 mA, or at 0 and 10 V, as 0,10
    #[arg(long, value_name = "LOW,HIGH", value_parser = pair, requires = "input")]
    range: Option<[f64; 2]>,
    /// Resistor from the input to ground, for 4 to 20 mA
    #[arg(long, value_name = "OHM", requires = "input")]
    burden_ohm: Option<f64>,
    /// Share of the sensor's voltage that its input gets, for 0 to 10 V
    #[arg(long, value_name = "SHARE", requires = "input")]
    divider: Option<f64>,
    #[command(flatten)]
    port: PortArguments,
}

/// What a sensor puts out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Puts {
    /// A share of the board's 3.3 V, as the standard sensors
    Ratiometric,
    /// 4 to 20 mA
    Current,
    /// 0 to 10 V
    Voltage,
}

impl Arguments {
    /// How the sensor is connected, by what was given of it.
    fn connection(&self, puts: Puts) -> Result<Input, Error> {
        let Self { range, burden_ohm, divider, .. } = self;
        let (signal, pin_v) = match (puts, burden_ohm, divider) {
            (Puts::Ratiometric, None, None) if range.is_none() => return Ok(Input::RATIOMETRIC),
            (Puts::Current, Some(ohm), None) => (Signal::Current, HIGHEST_A * ohm),
            (Puts::Voltage, None, Some(share)) => (Signal::Voltage, HIGHEST_V * share),
            (Puts::Ratiometric, ..) => {
                return Err(Error::Usage(
                    "a ratiometric sensor has no --range, --burden-ohm, --divider".into(),
                ));
            }
            (Puts::Current, ..) => {
                return Err(Error::Usage(
                    "a current needs --burden-ohm, the resistor, and no --divider".into(),
                ));
            }
            (Puts::Voltage, ..) => {
                return Err(Error::Usage("a voltage needs --divider, as 0.3, and no --burden-ohm".into()));
            }
        };
        let [low, high] =
            range.ok_or_else(|| Error::Usage("the sensor's --range is needed, as 0,10".to_owned()))?;
        Ok(Input { signal, pin_v: pin_v as f32, low: low as f32, high: high as f32 })
    }
}

/// Tells the board how a sensor is connected.
fn tell_connection(board: &mut Board, part: Part, input: Input, dry_run: bool) -> Result<(), Error> {
    let Some(mut inputs) = read_inputs(board).map_err(BoardError::from)? else {
        return Err(Error::Usage(
            "the board's firmware knows ratiometric sensors only: flash the firmware of this release"
                .to_owned(),
        ));
    };
    let Some(place) = part.input(&mut inputs) else {
        return Err(Error::Usage("the regulator is no input".to_owned()));
    };
    let before = std::mem::replace(place, input);
    say!("input     {} -> {}", in_words(&before, part.unit()), in_words(&input, part.unit()));
    if dry_run {
        say!("nothing has been changed (--dry-run)");
        return Ok(());
    }
    connect(board, &inputs)?;
    say!("written and read back; the board keeps it without power. Take two points next");
    Ok(())
}

/// Calibrates.
///
/// # Errors
/// The points are too close, do not settle, or make a line that no working sensor has; the board
/// refuses or does not answer. The valve is vented then, and the lines are as before.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { what, low, high, readings, dry_run, input, port, .. } = arguments;
    let part = match what {
        What::Pressure => Part::Pressure,
        What::Contraction => Part::Contraction,
        What::Supply => Part::Supply,
        What::Regulator => Part::Regulator,
    };
    let connection = input.map(|puts| arguments.connection(puts)).transpose()?;
    let mut board = port.open()?;
    demand_rest(&mut board)?;
    if let Some(input) = connection {
        return tell_connection(&mut board, part, input, *dry_run);
    }
    let mut reader = Reader { given: readings.map(Vec::from).unwrap_or_default().into_iter(), lines: None };
    let taken = points(&mut board, part, [*low, *high], &mut reader);
    // Whatever has happened.
    let vented = board.stop().map_err(BoardError::from);
    let points = taken?;
    vented?;
    let mut calibration = read(&mut board).map_err(BoardError::from)?;
    let line = line(part, points)?;
    let before = std::mem::replace(part.line(&mut calibration), line);
    let unit = part.unit();
    say!("zero      {:.2} -> {:.2} code", before.zero_code, line.zero_code);
    say!("gain      {:.3} -> {:.3} code/{unit}", before.codes_per_unit, line.codes_per_unit);
    if *dry_run {
        say!("nothing has been changed (--dry-run)");
        return Ok(());
    }
    write_today(&mut board, &calibration)?;
    say!("written and read back; the board keeps it without power");
    Ok(())
}

/// Two numbers, as `0.02,4.11`.
fn pair(text: &str) -> Result<[f64; 2], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    let pair = numbers.and_then(|numbers| <[f64; 2]>::try_from(numbers).ok());
    pair.filter(|pair| pair.iter().all(|number| number.is_finite()))
        .ok_or_else(|| "two numbers are needed, as 0.02,4.11".to_owned())
}

/// Both points: what the reader has read, and what the board has of it.
fn points(
    board: &mut Board,
    part: Part,
    commands: [f64; 2],
    reader: &mut Reader,
) -> Result<[(f64, Point); 2], Error> {
    let mut taken = Vec::new();
    for (which, bar) in ["low", "high"].into_iter().zip(commands) {
        if part == Part::Supply {
            say!("{which} point: bring the supply to a {which} pressure");
        } else {
            say!("{which} point: the valve goes to {bar} bar");
            drive(board, bar)?;
        }
        let (reading, point) = if part == Part::Regulator {
            let point = point(board, part)?;
            (point.shown, point)
        } else {
            // Who reads the gauge waits until it rests, so the board is asked behind that.
            let reading = reader.read(board, part)?;
            (reading, point(board, part)?)
        };
        let Point { code, deviation_codes, shown, .. } = point;
        say!(
            "            {reading} {unit}; the board shows {shown:.3} {unit}, code {code:.1} +- {deviation_codes:.1}",
            unit = part.unit()
        );
        taken.push((reading, point));
    }
    <[_; 2]>::try_from(taken).map_err(|_| Error::Usage("two points are needed".to_owned()))
}

/// The line through both points.
fn line(part: Part, points: [(f64, Point); 2]) -> Result<Line, Error> {
    let [(low, at_low), (high, at_high)] = points;
    let apart = part.least_apart();
    let is_apart = (high - low).abs() >= f64::from(apart);
    if !is_apart {
        return Err(Error::Usage(format!(
            "the points are {low} and {high} {unit}, must be at least {apart} {unit} apart",
            unit = part.unit()
        )));
    }
    let code = |point: &Point| point.code as f32;
    let ends = match part {
        // What the sensor shows, and the code that was put out for it.
        Part::Regulator => {
            [(low as f32, at_low.written_code as f32), (high as f32, at_high.written_code as f32)]
        }
        _ => [(low as f32, code(&at_low)), (high as f32, code(&at_high))],
    };
    Line::through(ends).ok_or_else(|| Error::Usage("both points are the same".to_owned()))
}

/// What gauge or ruler show: given before, or asked for.
struct Reader {
    given: std::vec::IntoIter<f64>,
    /// Lines of the standard input, once somebody is asked.
    lines: Option<Receiver<String>>,
}

impl Reader {
    fn read(&mut self, board: &mut Board, part: Part) -> Result<f64, Error> {
        if let Some(reading) = self.given.next() {
            return Ok(reading);
        }
        say!("            what does it show, in {}? (a number, then Enter)", part.unit());
        let lines = self.lines.get_or_insert_with(lines);
        loop {
            match lines.recv_timeout(ALIVE) {
                Ok(line) => match line.trim().parse::<f64>() {
                    Ok(reading) if reading.is_finite() => return Ok(reading),
                    _ => say!("            \"{}\" is no number such as 4.02", line.trim()),
                },
                // The board vents where its host is silent.
                Err(RecvTimeoutError::Timeout) => {
                    let (state, fault) = board.state().map_err(BoardError::from)?;
                    if state == State::Fault {
                        return Err(BoardError::Fault(fault).into());
                    }
                }
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(Error::Usage("the reading was not given: the input has ended".to_owned()));
                }
            }
        }
    }
}

/// The lines of the standard input, as they come.
fn lines() -> Receiver<String> {
    let (sender, lines) = mpsc::channel();
    thread::spawn(move || {
        for line in io::stdin().lock().lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                break;
            }
        }
    });
    lines
}
