//! The samples through the image `emulated`, and through the same code on the host, which has to
//! answer the same, bit for bit: what is counted is what was tested.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;

use anyhow::{Context, Result, ensure};
use firmware::order::prepare;
use firmware::{Control, LockStepBoard, scaling};
use model_core::Mode;
use wire::{
    BoardParameters, Configuration, FRAME_BYTES, Protection, Receiver, Request, Response, TickRequest,
    VERSION,
};

use super::inputs::Sample;

/// Drives the image `emulated` in lock-step.
///
/// # Errors
/// It does not answer, or otherwise than the same code does on the host.
pub fn emulated(link: &UnixStream, parameters: &BoardParameters, samples: &[Sample]) -> Result<()> {
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
    demand(&Request::Arm).context("its arming")?;
    demand(&Request::Start(Mode::Both)).context("its start")?;
    for (number, sample) in samples.iter().enumerate() {
        demand(&Request::Tick(tick(sample))).with_context(|| format!("sample {number}, {sample:?}"))?;
    }
    Ok(())
}

fn tick(sample: &Sample) -> TickRequest {
    TickRequest {
        reference_mm: Some(sample.reference_mm),
        // Looked at for plausibility only.
        pressure_code: scaling::PRESSURE.code(0.0),
        contraction_code: scaling::CONTRACTION.code(sample.contraction_mm),
        // The board measures neither.
        load_n: None,
        temperature_c: None,
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
