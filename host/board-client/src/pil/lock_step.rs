//! One run, tick by tick.
//!
//! # Timing
//! At the time of a tick the plant, which has held the command of the tick before until then, is
//! measured; the measurement goes to the board as ADC codes, and its DAC code is the next command.
//! Before the first tick the valve is vented: the plant is measured at rest until the board's
//! self-test is over, in which its time stands still.
//!
//! A model with a delay is given the reference ahead: at each tick the one that is due after the
//! delay. With a tick's measurement goes the reference of the next tick, whose feed-forward the
//! board prepares meanwhile; that of the first goes with a measurement that the board, not started
//! yet, only looks at. Load and temperature go to the board as the plant answers them, and count
//! from the next tick on; one that does not is taken to be at the model's references.

use model_core::{Mode, Surroundings};
use wire::{
    Configuration, Flags, Hello, Protection, Refusal, Request, Response, Scaling, State, TickReply,
    TickRequest, VERSION,
};

use super::PilError;

/// A board that answers requests: the emulated one, or the control code on the host.
pub trait Board {
    /// Sends a request and waits for the response.
    ///
    /// # Errors
    /// There is none.
    fn request(&mut self, request: &Request) -> Result<Response, PilError>;
}

/// What a plant's sensors say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Unit: bar.
    pub pressure_bar: f64,
    /// Unit: mm.
    pub contraction_mm: f64,
    /// Load and temperature, as far as they are measured.
    pub surroundings: Surroundings<f64>,
}

/// What is wanted at a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Unit: s.
    pub time_s: f64,
    /// What the contraction should be now. Unit: mm.
    pub reference_mm: f64,
    /// What it should be after the model's delay. Unit: mm.
    pub ahead_mm: f64,
}

/// A muscle on its valve.
pub trait Plant {
    /// Holds the command until `time_s`, then measures. The first call finds the plant at rest.
    ///
    /// # Errors
    /// It does not answer, or not sensibly.
    fn advance(&mut self, time_s: f64, command_bar: f32) -> Result<Measurement, PilError>;
}

/// A tick in the log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Unit: s.
    pub time_s: f64,
    /// Unit: mm.
    pub reference_mm: f64,
    /// What was measured before the tick.
    pub measured: Measurement,
    /// What the board's DAC has put out. Unit: bar.
    pub command_bar: f32,
    /// Unit: bar.
    pub feedforward_bar: f32,
    /// Unit: bar.
    pub feedback_bar: f32,
}

/// A whole run.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// One a tick.
    pub samples: Vec<Sample>,
    /// Ticks that found the one before unfinished, as the board has counted.
    pub overruns: u32,
}

/// Sets the limits by which the board protects the plant.
///
/// # Errors
/// The board does not take them.
pub fn protect(board: &mut impl Board, protection: Protection) -> Result<(), PilError> {
    demand(board, &Request::Protect(protection))
}

/// Configures the board, tracks the reference, one a tick, in the given mode, and stops.
/// `ticked` is called after each tick.
///
/// # Errors
/// Board or plant do not answer as they should; the board vents.
pub fn run(
    board: &mut impl Board,
    plant: &mut impl Plant,
    configuration: &Configuration,
    mode: Mode,
    reference: impl Iterator<Item = Wanted>,
    ticked: &dyn Fn(),
) -> Result<Run, PilError> {
    let mut samples = Vec::new();
    let overruns = track(board, plant, configuration, mode, reference, &mut samples, ticked)?;
    Ok(Run { samples, overruns })
}

/// As [`run`], with the samples of a run that does not come to its end; answers the overruns.
///
/// # Errors
/// As above.
pub fn track(
    board: &mut impl Board,
    plant: &mut impl Plant,
    configuration: &Configuration,
    mode: Mode,
    reference: impl Iterator<Item = Wanted>,
    samples: &mut Vec<Sample>,
    ticked: &dyn Fn(),
) -> Result<u32, PilError> {
    let hello = identify(board)?;
    demand(board, &Request::Configure(configuration.clone()))?;
    samples.reserve(reference.size_hint().0);
    let mut command_bar = hello.command.value(hello.command.code(0.0));
    let mut reference = reference.peekable();
    while let Some(wanted) = reference.next() {
        let Wanted { time_s, reference_mm, ahead_mm } = wanted;
        let measured = plant.advance(time_s, command_bar)?;
        let request = |ahead_mm| tick_request(&hello, time_s, ahead_mm, measured);
        if samples.is_empty() {
            start(board, &request(ahead_mm)?, mode, time_s)?;
        }
        let next_mm = reference.peek().map_or(ahead_mm, |next| next.ahead_mm);
        let reply = tick(board, &request(next_mm)?)?;
        if !reply.flags.contains(Flags::TRACKING) {
            return Err(vented(board, time_s));
        }
        command_bar = hello.command.value(reply.dac_code);
        let TickReply { feedforward_bar, feedback_bar, .. } = reply;
        samples.push(Sample { time_s, reference_mm, measured, command_bar, feedforward_bar, feedback_bar });
        ticked();
    }
    let overruns = identify(board)?.overruns;
    demand(board, &Request::Stop)?;
    Ok(overruns)
}

/// Shows the board the plant at rest until its self-test is over, and starts it.
fn start(board: &mut impl Board, at_rest: &TickRequest, mode: Mode, time_s: f64) -> Result<(), PilError> {
    loop {
        if tick(board, at_rest)?.flags.contains(Flags::FAULT) {
            return Err(vented(board, time_s));
        }
        match demand(board, &Request::Arm) {
            Err(PilError::Refused(Refusal::WrongState(State::SelfTest))) => {}
            armed => return armed.and_then(|()| demand(board, &Request::Start(mode))),
        }
    }
}

/// What has vented the board.
fn vented(board: &mut impl Board, time_s: f64) -> PilError {
    match identify(board) {
        Ok(hello) => PilError::Vented { time_s, fault: hello.fault },
        Err(error) => error,
    }
}

fn tick_request(
    hello: &Hello,
    time_s: f64,
    ahead_mm: f64,
    measured: Measurement,
) -> Result<TickRequest, PilError> {
    let Measurement { pressure_bar, contraction_mm, surroundings } = measured;
    let code = |scaling: &Scaling, quantity, value: f64, unit| {
        let (min, max) = (scaling.value(scaling.code_min), scaling.value(scaling.code_max));
        if (f64::from(min)..=f64::from(max)).contains(&value) {
            Ok(scaling.code(value as f32))
        } else {
            Err(PilError::OutsideSensor { time_s, quantity, value, min, max, unit })
        }
    };
    Ok(TickRequest {
        reference_mm: Some(ahead_mm as f32),
        pressure_code: code(&hello.pressure, "the pressure", pressure_bar, "bar")?,
        contraction_code: code(&hello.contraction, "the contraction", contraction_mm, "mm")?,
        load_n: surroundings.load.map(|load_n| load_n as f32),
        temperature_c: surroundings.temperature.map(|temperature_c| temperature_c as f32),
    })
}

fn identify(board: &mut impl Board) -> Result<Hello, PilError> {
    match board.request(&Request::Identify)? {
        Response::Hello(hello) if hello.version == VERSION => Ok(hello),
        Response::Hello(hello) => Err(PilError::Version { board: hello.version, program: VERSION }),
        _ => Err(PilError::OutOfTurn),
    }
}

fn demand(board: &mut impl Board, request: &Request) -> Result<(), PilError> {
    match board.request(request)? {
        Response::Accepted => Ok(()),
        Response::Refused(refusal) => Err(PilError::Refused(refusal)),
        _ => Err(PilError::OutOfTurn),
    }
}

fn tick(board: &mut impl Board, request: &TickRequest) -> Result<TickReply, PilError> {
    match board.request(&Request::Tick(*request))? {
        Response::Tick(reply) => Ok(reply),
        Response::Refused(refusal) => Err(PilError::Refused(refusal)),
        _ => Err(PilError::OutOfTurn),
    }
}
