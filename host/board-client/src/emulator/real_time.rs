//! The emulated board as a board is: ticks that come by themselves, a plant at its valve, set
//! points from its bus.
//!
//! The lock-step of the link, paced by the clock: a tick that is a little late is made up for at
//! once, so that the ticks keep the time of the machine as long as that is fast enough. What is
//! later than 50 ms is not made up for: the board's time then slips, which nobody on the bus
//! notices, while a burst of ticks would run it out of set points. How late they came is told.

use std::thread;
use std::time::{Duration, Instant};

use wire::{Hello, Request, Response, TickReply, TickRequest};

use super::Emulator;
use crate::pil::PilError;
use crate::pil::lock_step::{Measurement, Plant};
use crate::stop::Stop;

/// From tick to tick.
pub const PERIOD: Duration = Duration::from_millis(1);
/// How long it is watched how late ticks are before it is told.
const WATCHED_TICKS: u32 = 10_000;
/// What is made up for, and not worth telling.
const NOT_LATE: Duration = Duration::from_millis(50);

/// Runs board and plant until a stop is requested. `late` is told once, ten seconds after a tick
/// was late, the longest delay until then.
///
/// # Errors
/// Board or plant do not answer as they should.
pub fn run(
    board: &mut Emulator,
    plant: &mut impl Plant,
    stop: &Stop,
    late: impl FnOnce(Duration),
) -> Result<(), PilError> {
    let Response::Hello(hello) = board.request(&Request::Identify)? else {
        return Err(PilError::OutOfTurn);
    };
    let mut begin = Instant::now();
    let mut command_bar = hello.command.value(hello.command.code(0.0));
    let (mut longest, mut late, mut told_at) = (Duration::ZERO, Some(late), None);
    for tick in 0_u32.. {
        if stop.is_requested() {
            break;
        }
        let (due, now) = (begin + tick * PERIOD, Instant::now());
        thread::sleep(due.saturating_duration_since(now));
        let late_by = now.saturating_duration_since(due);
        longest = longest.max(late_by);
        if late_by > NOT_LATE {
            begin += late_by;
            told_at = told_at.or(Some(tick.saturating_add(WATCHED_TICKS)));
        }
        if told_at == Some(tick)
            && let Some(late) = late.take()
        {
            late(longest);
        }
        let measured = plant.advance((tick * PERIOD).as_secs_f64(), command_bar)?;
        let Response::Tick(TickReply { dac_code, .. }) = board.request(&request(&hello, measured))? else {
            return Err(PilError::OutOfTurn);
        };
        command_bar = hello.command.value(dac_code);
    }
    Ok(())
}

/// A tick without a reference: that is the bus's. Beyond what a sensor measures it shows the end of
/// its range.
fn request(hello: &Hello, measured: Measurement) -> Request {
    let Measurement { pressure_bar, contraction_mm, surroundings } = measured;
    Request::Tick(TickRequest {
        reference_mm: None,
        pressure_code: hello.pressure.code(pressure_bar as f32),
        contraction_code: hello.contraction.code(contraction_mm as f32),
        load_n: surroundings.load.map(|load_n| load_n as f32),
        temperature_c: surroundings.temperature.map(|temperature_c| temperature_c as f32),
    })
}
