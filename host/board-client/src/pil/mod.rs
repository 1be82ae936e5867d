//! The processor in the loop: the firmware, in the emulator, tracks a reference with a plant that
//! is a program.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | `bench` | the runs, with emulator and plant |
//! | [`followed`] | whether a run has followed its reference, and why not |
//! | [`lock_step`] | one run: reference and measurement to the board, its command to the plant, tick by tick |
//! | `plant` | a plant that is a program, line by line |
//! | [`mod@reference`] | what is to be tracked |
//! | [`results`] | log, figures |
//!
//! Three runs, each of the firmware from its start with a plant of its own: feed-forward and
//! feedback, feed-forward only, feedback only. They go on side by side; the first that fails stops
//! the others.
//!
//! # Contract
//! Lock-step: neither board nor plant goes on before the other has answered, so that the results do
//! not depend on how fast either is. The same inputs give the same results, bit for bit.

#[cfg(unix)]
pub mod bench;
pub mod followed;
pub mod lock_step;
#[cfg(unix)]
pub mod plant;
pub mod reference;
pub mod results;

use std::path::{Path, PathBuf};

use model_core::pid::PidParameters;
use model_core::{Mode, ParameterError, TrackingParameters};
use thiserror::Error;
use wire::joint::JointFault;
use wire::registers::{Access, Id};
use wire::{Configuration, DEAD_ZONES, Fault, PLAYS, Refusal, VERSION};

use crate::bus::error::{in_full, row};
#[cfg(unix)]
use crate::emulator::EmulatorError;
#[cfg(unix)]
use plant::PlantError;
use recording::model_file::ModelFile;
use recording::model_file::control::Tuning;
use recording::table::DataError;
use recording::unit::Unit;
use reference::MOST_TICKS;

/// Fastest change of the command: an eighth of a second through the whole range, faster than
/// proportional regulators of this size are. Unit: bar/s.
pub(crate) const SLEW_BAR_PER_S: f32 = 50.0;

/// Why a run of the firmware does not come to its end.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum PilError {
    #[cfg(unix)]
    #[error(transparent)]
    Emulator(EmulatorError),
    #[cfg(unix)]
    #[error(transparent)]
    Plant(PlantError),
    #[error(transparent)]
    Reference(#[from] DataError),
    #[error("{}: {ticks} ticks; a run takes at most {MOST_TICKS}", file.display())]
    TooLong { file: PathBuf, ticks: f64 },
    #[error("{}: its {channel} is in {found}; the valve board needs {needed}", model.display())]
    Unit { model: PathBuf, channel: &'static str, found: String, needed: &'static str },
    #[error("{}: no model for the board: {problem}", model.display())]
    Capacity { model: PathBuf, problem: ParameterError },
    #[error("the board refuses: {}", in_words(.0))]
    Refused(Refusal),
    #[error("the board speaks version {board} of the messages, this program version {program}")]
    Version { board: u16, program: u16 },
    #[error("the board answers what was not asked")]
    OutOfTurn,
    #[error(
        "at {time_s} s the plant answers {quantity} {value} {unit}, outside what the board's sensor measures, \
         {min} to {max} {unit}"
    )]
    OutsideSensor { time_s: f64, quantity: &'static str, value: f64, min: f32, max: f32, unit: &'static str },
    #[error("at {time_s} s the board has vented the valve: {}", cause(*.fault))]
    Vented { time_s: f64, fault: Option<Fault> },
    #[error("the run {}: {problem}", with(*.mode))]
    Run { mode: Mode, problem: Box<PilError> },
    #[error("{time_s:.3} s after the begin the board has vented the joint: {fault}")]
    Joint { time_s: f64, fault: JointFault },
    #[error(transparent)]
    Parameters(#[from] ParameterError),
    #[error("interrupted")]
    Stopped,
}

/// What a run is made with, in words.
fn with(mode: Mode) -> &'static str {
    match mode {
        Mode::Both => "with feed-forward and feedback",
        Mode::FeedforwardOnly => "with feed-forward only",
        Mode::FeedbackOnly => "with feedback only",
        Mode::Hold => "that holds the valve",
    }
}

#[cfg(unix)]
impl From<EmulatorError> for PilError {
    fn from(error: EmulatorError) -> Self {
        match error {
            EmulatorError::Stopped => Self::Stopped,
            error => Self::Emulator(error),
        }
    }
}

#[cfg(unix)]
impl From<PlantError> for PilError {
    fn from(error: PlantError) -> Self {
        if error.is_stop() { Self::Stopped } else { Self::Plant(error) }
    }
}

/// The fault with cause and cure.
fn cause(fault: Option<Fault>) -> String {
    fault.and_then(row).map_or_else(|| "it does not say why".to_owned(), in_full)
}

pub(crate) fn in_words(refusal: &Refusal) -> String {
    match refusal {
        Refusal::Parameter(message) => message.as_str().to_owned(),
        Refusal::NotStored => {
            "it is in use, but the board's flash has not kept it: it is lost when power is".to_owned()
        }
        Refusal::NotArmed => "a start takes two steps, and the first was not taken".to_owned(),
        other => format!("{other:?}"),
    }
}

/// The integral gain by default. The paper's 0.01 takes tens of seconds to mend an offset; ten
/// times that settles in seconds and still lies far below what a regulator's lag allows beside the
/// paper's proportional gain. Unit: bar/(mm s).
const INTEGRAL_GAIN: f32 = 0.1;

/// The default gains.
fn default_pid() -> PidParameters<f32> {
    PidParameters { ki: INTEGRAL_GAIN, ..PidParameters::paper() }
}

/// The command's largest rate of change (bar/s): a tuned one as far as a board takes it, or the
/// default.
pub fn slew(tuned_bar_per_s: Option<f64>) -> f32 {
    let Some(bar_per_s) = tuned_bar_per_s else { return SLEW_BAR_PER_S };
    match Id::CommandSlew.register().access {
        Access::Write(min, max) => bar_per_s.clamp(min, max) as f32,
        _ => bar_per_s as f32,
    }
}

/// A model for a board that ticks `rate_hz` times a second, with the gains and leads that were
/// tuned for it at this rate, or else the default gains. The valve's range is the model's.
///
/// # Errors
/// The model, read from `file`, has other units than the board or is too large for it.
pub fn configuration(file: &Path, model: &ModelFile, rate_hz: f64) -> Result<Configuration, PilError> {
    for (channel, found, board, needed) in [
        ("input", model.input.unit, Unit::BAR, "bar or another pressure"),
        ("output", model.output.unit, Unit::MM, "mm or another length"),
    ] {
        if found != board {
            let found = found.to_string();
            return Err(PilError::Unit { model: file.to_owned(), channel, found, needed });
        }
    }
    let tuning = model.tuning.as_ref().filter(|tuning| tuning.is_for(rate_hz.recip()));
    let converted = model.parameters.convert::<f32, PLAYS, DEAD_ZONES>();
    let extensions = match tuning {
        Some(tuning) => tuning.extended(&model.extensions).convert(),
        None => model.extensions.convert(),
    };
    let problem = |problem| PilError::Capacity { model: file.to_owned(), problem };
    let (model, extensions) = (converted.map_err(problem)?, extensions.map_err(problem)?);
    Ok(Configuration {
        version: VERSION,
        tracking: TrackingParameters {
            // A valve cannot suck: noise around 0 bar may have put the model's lower end below.
            command_min: model.input().0.max(0.0),
            command_max: model.input().1,
            model,
            extensions,
            pid: tuning.map_or_else(default_pid, Tuning::pid),
            observer: tuning.map(Tuning::observer).unwrap_or_default(),
            slew_bar_per_s: slew(tuning.and_then(|tuning| tuning.slew_per_s)),
            period_s: (1.0 / rate_hz) as f32,
        },
    })
}

/// How far ahead of time a board of this configuration has to be given its reference. Unit: s.
pub fn preview_s(configuration: &Configuration) -> f64 {
    let TrackingParameters { extensions, period_s, .. } = &configuration.tracking;
    f64::from(extensions.preview_s(*period_s))
}
