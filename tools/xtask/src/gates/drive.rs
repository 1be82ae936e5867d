//! The samples through the images in the emulator, and through the same code on the host, which has to answer the same,
//! bit for bit: what is counted is what was tested.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;

use anyhow::{Context, Result, bail, ensure};
use firmware::law::{controller_step, inverse_step};
use firmware::order::{BoardTracking, prepare};
use firmware::sized::{self, SizedInverse};
use firmware::{Control, LockStepBoard, scaling};
use model_core::{InverseHysteresis, Mode, TrackingParameters};
use wire::{
    Configuration, DEAD_ZONES, FRAME_BYTES, PLAYS, Protection, Receiver, Request, Response, TickRequest,
    VERSION,
};

use super::inputs::Sample;

/// Model, gains and limits of the board.
pub type Parameters = TrackingParameters<f32, PLAYS, DEAD_ZONES>;

/// Drives the image `emulated` in lock-step.
///
/// # Errors
/// It does not answer, or otherwise than the same code does on the host.
pub fn emulated(link: &UnixStream, parameters: &Parameters, samples: &[Sample]) -> Result<()> {
    let mut receiver = Receiver::new();
    receive(link, &mut receiver).context("its greeting")?;
    let mut board = |request: &Request| {
        let mut buffer = [0; FRAME_BYTES];
        let frame = wire::encode(request, &mut buffer)?;
        let mut link = link;
        link.write_all(frame)?;
        receive(link, &mut receiver)
    };
    let mut control = Control::simulated(Box::leak(Box::default()), Box::leak(Box::default()));
    let mut lock_step = LockStepBoard::new();
    let mut host = |request: &Request| match request {
        Request::Tick(tick) => Response::Tick(lock_step.tick(&mut control, *tick)),
        other => prepare(other).map_or_else(Response::Refused, |order| control.apply(order)),
    };
    let mut demand = |request: &Request| -> Result<Response> {
        let (answer, expected) = (board(request)?, host(request));
        ensure!(answer == expected, "the board answers {answer:?}, the host {expected:?}");
        Ok(answer)
    };

    // The samples come from no muscle: the monitors of one would end the run.
    demand(&Request::Protect(Protection::SIMULATED)).context("its protection")?;
    let configuration = Configuration { version: VERSION, tracking: parameters.clone() };
    demand(&Request::Configure(configuration)).context("its configuration")?;
    let mut mode = Mode::Both;
    demand(&Request::Start(mode)).context("its start")?;
    for (number, sample) in samples.iter().enumerate() {
        let place = || format!("sample {number}, {sample:?}");
        if sample.mode != mode {
            mode = sample.mode;
            demand(&Request::SetMode(mode)).with_context(place)?;
        }
        demand(&Request::Tick(tick(sample))).with_context(place)?;
    }
    Ok(())
}

fn tick(sample: &Sample) -> TickRequest {
    TickRequest {
        reference_mm: Some(sample.reference_mm),
        // Looked at for plausibility only.
        pressure_code: scaling::PRESSURE.code(0.0),
        contraction_code: scaling::CONTRACTION.code(sample.contraction_mm),
        // Measured, each in every second sample, anywhere.
        load_n: (sample.reference_mm > 60.0).then_some(sample.contraction_mm),
        temperature_c: (sample.reference_mm < 90.0).then_some(sample.contraction_mm),
    }
}

fn receive(mut link: &UnixStream, receiver: &mut Receiver) -> Result<Response> {
    let mut byte = [0];
    loop {
        link.read_exact(&mut byte).context("no answer")?;
        if let Some(response) = receiver.push(byte[0]) {
            return Ok(response?);
        }
    }
}

/// Drives the image `control_law` by its own protocol; `envelope` is that protocol's number for the one of `parameters`.
///
/// # Errors
/// It does not answer, or otherwise than the same code does on the host.
pub fn control_law(
    mut link: &UnixStream,
    envelope: u8,
    parameters: &Parameters,
    samples: &[Sample],
) -> Result<()> {
    link.read_exact(&mut [0]).context("it is not ready")?;
    link.write_all(&[envelope])?;
    let tracking = BoardTracking::try_new(parameters)?;
    let inverse = tracking.inverse();
    let (mut inverse_state, mut state) = (inverse.rest_state(), tracking.rest_state(Mode::Both));
    let mut sized = SizedInverse::paper(envelope != 0)?;
    let (law, mut law_state) = sized::paper_law()?;
    for (number, sample) in samples.iter().enumerate() {
        let Sample { mode, reference_mm, contraction_mm, .. } = *sample;
        let mode_number = match mode {
            Mode::Both => 0,
            Mode::FeedforwardOnly => 1,
            Mode::FeedbackOnly => 2,
            Mode::Hold => 3,
        };
        let [reference, contraction] = [reference_mm, contraction_mm].map(f32::to_le_bytes);
        link.write_all(&[&[mode_number][..], &reference, &contraction].concat())?;
        let mut answers = [[0; 4]; 4];
        link.read_exact(answers.as_flattened_mut())
            .with_context(|| format!("sample {number}, {sample:?}: no answer"))?;
        let expected = [
            inverse_step(inverse, &mut inverse_state, reference_mm)?,
            sized.step(reference_mm)?,
            controller_step(&tracking, &mut state, mode, reference_mm, contraction_mm.into())?.command,
            sized::law_step(&law, &mut law_state, reference_mm, contraction_mm)?,
        ];
        let answers = answers.map(f32::from_le_bytes);
        if answers.map(f32::to_bits) != expected.map(f32::to_bits) {
            bail!("sample {number}, {sample:?}: the board answers {answers:?}, the host {expected:?}");
        }
    }
    Ok(())
}
