//! A board's sensors and regulator against what a gauge or a ruler shows: points taken, lines
//! written.

use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use wire::registers::{Command, Id, Value, fields};
use wire::{Calibration, Input, Inputs, Line, Signal, State};

use super::board::Board;
use super::client::BusError;
use super::error::BoardError;
use super::upload::message;

/// How often a reading is taken.
const EACH: Duration = Duration::from_millis(20);
/// Readings of a point.
const READINGS: usize = 50;
/// What counts as settled: so many readings within [`SETTLED_CODES`].
const SETTLED: usize = 15;
/// Unit: code, between the highest and the lowest: the noise of the mean of eight conversions, and
/// a pressure that still creeps.
const SETTLED_CODES: f64 = 6.0;
/// A muscle, or a gauge's reader, takes no longer.
const PATIENCE: Duration = Duration::from_secs(20);
/// Unit: s.
const DAY_S: u64 = 86_400;

/// What is calibrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The sensor of the pressure in the muscle.
    Pressure,
    /// The sensor of the contraction.
    Contraction,
    /// The sensor of the pressure before the valve.
    Supply,
    /// The regulator: what it makes of a command, by the pressure sensor.
    Regulator,
}

impl Part {
    /// The register that shows it.
    const fn shown(self) -> Id {
        match self {
            Self::Pressure | Self::Regulator => Id::PressureBar,
            Self::Contraction => Id::ContractionMm,
            Self::Supply => Id::SupplyBar,
        }
    }

    /// Its unit.
    pub const fn unit(self) -> &'static str {
        self.shown().register().unit
    }

    /// Least difference of its two points: below it the reader's error weighs too much. Unit: that
    /// of the part.
    pub const fn least_apart(self) -> f32 {
        match self {
            Self::Contraction => 10.0,
            _ => 1.0,
        }
    }

    /// How its sensor is connected; none of the regulator.
    pub const fn input(self, inputs: &mut Inputs) -> Option<&mut Input> {
        match self {
            Self::Pressure => Some(&mut inputs.pressure),
            Self::Contraction => Some(&mut inputs.contraction),
            Self::Supply => Some(&mut inputs.supply),
            Self::Regulator => None,
        }
    }

    /// Its line.
    pub const fn line(self, calibration: &mut Calibration) -> &mut Line {
        match self {
            Self::Pressure => &mut calibration.pressure,
            Self::Contraction => &mut calibration.contraction,
            Self::Supply => &mut calibration.supply,
            Self::Regulator => &mut calibration.command,
        }
    }
}

/// A point, as the board has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Mean of the readings. Unit: ADC code.
    pub code: f64,
    /// Their standard deviation. Unit: ADC code.
    pub deviation_codes: f64,
    /// What the board made of it until now. Unit: that of the part.
    pub shown: f64,
    /// What was put out to the valve. Unit: DAC code.
    pub written_code: f64,
}

/// What the board has; `None` of one whose firmware is older than these registers.
///
/// # Errors
/// No answer.
pub fn read_if_kept(board: &mut Board) -> Result<Option<Calibration>, BusError> {
    match read(board) {
        Err(error) if error.exception().is_some() => Ok(None),
        calibration => calibration.map(Some),
    }
}

/// What the board has.
///
/// # Errors
/// No answer, or a board whose firmware is older than these registers.
pub fn read(board: &mut Board) -> Result<Calibration, BusError> {
    let block = board.read(Id::CalibratedPressureZero, Id::CalibrationChecksum)?;
    let line = Line { zero_code: 0.0, codes_per_unit: 1.0 };
    let inputs = read_inputs(board)?.unwrap_or(Inputs::STANDARD);
    let mut calibration =
        Calibration { pressure: line, contraction: line, supply: line, command: line, day: 0, inputs };
    for id in fields::CALIBRATION {
        if let (Some(field), Some(value)) = (fields::of_calibration(&mut calibration, id), block.value(id)) {
            field.set(value);
        }
    }
    Ok(calibration)
}

/// How its sensors are connected; `None` of one whose firmware is older than these registers, and
/// knows ratiometric sensors only.
///
/// # Errors
/// No answer.
pub fn read_inputs(board: &mut Board) -> Result<Option<Inputs>, BusError> {
    let block = match board.read(Id::PressureInput, Id::InputsChecksum) {
        Err(error) if error.exception().is_some() => return Ok(None),
        block => block?,
    };
    let mut inputs = Inputs::STANDARD;
    for id in fields::INPUTS {
        if let (Some(field), Some(value)) = (fields::of_inputs(&mut inputs, id), block.value(id)) {
            field.set(value);
        }
    }
    Ok(Some(inputs))
}

/// Tells the board how its sensors are connected, and lets it keep that; it is read back. A sensor
/// whose connection changes begins by the line of its range.
///
/// # Errors
/// It refuses, or has others afterwards.
pub fn connect(board: &mut Board, inputs: &Inputs) -> Result<(), BoardError> {
    write_registers(board, Id::PressureInput, &fields::INPUTS, Id::InputsChecksum, |id| inputs.value(id))?;
    if read_inputs(board)? == Some(*inputs) { Ok(()) } else { Err(BoardError::CalibrationReadBack) }
}

/// The end of the range of a sensor of 4 to 20 mA (IEC 60381-1). Unit: A.
pub const HIGHEST_A: f64 = 20e-3;
/// The end of the range of a sensor of 0 to 10 V (IEC 60381-2). Unit: V.
pub const HIGHEST_V: f64 = 10.0;

/// How a sensor is connected, in words. `unit`: of the sensor.
pub fn in_words(input: &Input, unit: &str) -> String {
    let Input { signal, pin_v, low, high } = *input;
    match signal {
        Signal::Ratiometric => "ratiometric".to_owned(),
        Signal::Current => {
            format!("4 to 20 mA over {:.1} ohm for {low} to {high} {unit}", f64::from(pin_v) / HIGHEST_A)
        }
        Signal::Voltage => {
            format!(
                "0 to 10 V by a divider of {:.3} for {low} to {high} {unit}",
                f64::from(pin_v) / HIGHEST_V
            )
        }
    }
}

/// Writes registers and the checksum behind them at once.
fn write_registers(
    board: &mut Board,
    first: Id,
    registers: &[Id],
    checksum: Id,
    value: impl Fn(Id) -> Option<Value>,
) -> Result<(), BoardError> {
    let ids = registers.iter().copied().chain([checksum]);
    let words: Vec<u16> =
        ids.filter_map(value).flat_map(|value: Value| value.words().collect::<Vec<_>>()).collect();
    match board.write(first, &words) {
        Err(error) if error.exception().is_some() => {
            Err(BoardError::Calibration { error, message: message(board)? })
        }
        done => Ok(done?),
    }
}

/// Lets the board take lines and keep them, dated today; they are read back.
///
/// # Errors
/// It refuses, or has others afterwards.
pub fn write_today(board: &mut Board, calibration: &Calibration) -> Result<(), BoardError> {
    write(board, &Calibration { day: today(), ..*calibration })
}

/// Lets the board take a calibration as it is, sensors connected otherwise first, and keep it; it
/// is read back.
///
/// # Errors
/// It refuses, or has others afterwards.
pub fn write(board: &mut Board, calibration: &Calibration) -> Result<(), BoardError> {
    if read(board)?.inputs != calibration.inputs {
        connect(board, &calibration.inputs)?;
    }
    let first = Id::CalibratedPressureZero;
    write_registers(board, first, &fields::CALIBRATION, Id::CalibrationChecksum, |id| calibration.value(id))?;
    if read(board)? == *calibration { Ok(()) } else { Err(BoardError::CalibrationReadBack) }
}

/// Days since 1970-01-01, by the host's clock.
fn today() -> u32 {
    let elapsed = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    (elapsed.as_secs() / DAY_S) as u32
}

/// Opens the valve for a pressure (bar), without a controller; 0 vents.
///
/// # Errors
/// The board does not go there.
pub fn drive(board: &mut Board, bar: f64) -> Result<(), BoardError> {
    if board.state()?.0 != State::Service {
        board.drive(Command::Service, State::Service)?;
    }
    Ok(board.set(Id::SetpointBar, bar)?)
}

/// Waits until what a part shows has settled, and takes its mean.
///
/// # Errors
/// It does not settle, the board has left its state by a fault, or it does not answer.
pub fn point(board: &mut Board, part: Part) -> Result<Point, BoardError> {
    let mut calibration = read(board)?;
    let command = calibration.command;
    let of_sensor = if part == Part::Regulator { calibration.pressure } else { *part.line(&mut calibration) };
    let began = Instant::now();
    let mut codes: Vec<f64> = Vec::new();
    let last = loop {
        let block = board.read(Id::State, Id::SupplyBar)?;
        if block.state() == State::Fault {
            return Err(BoardError::Fault(board.state()?.1));
        }
        codes.push(
            f64::from(of_sensor.zero_code) + block.number(part.shown()) * f64::from(of_sensor.codes_per_unit),
        );
        let recent = &codes[codes.len().saturating_sub(SETTLED)..];
        let highest = recent.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let spread_codes = highest - recent.iter().copied().fold(f64::INFINITY, f64::min);
        if spread_codes > SETTLED_CODES {
            // It still moves: what was before does not count.
            codes.drain(..codes.len() - 1);
        } else if codes.len() >= READINGS {
            break block;
        }
        if began.elapsed() > PATIENCE {
            return Err(BoardError::Unsettled { spread_codes, limit_codes: SETTLED_CODES });
        }
        thread::sleep(EACH);
    };
    let mean = codes.iter().sum::<f64>() / codes.len() as f64;
    let variance = codes.iter().map(|code| (code - mean).powi(2)).sum::<f64>() / (codes.len() - 1) as f64;
    Ok(Point {
        code: mean,
        deviation_codes: variance.sqrt(),
        shown: (mean - f64::from(of_sensor.zero_code)) / f64::from(of_sensor.codes_per_unit),
        written_code: f64::from(command.zero_code)
            + last.number(Id::CommandBar) * f64::from(command.codes_per_unit),
    })
}
