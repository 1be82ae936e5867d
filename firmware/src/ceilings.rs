//! What is compiled into a board with a muscle: no request by link, and nothing that was stored,
//! exceeds the limits of the registers, as none by the bus can.
//!
//! A board whose ticks come by the link drives a simulation, which cannot be hurt and may have any
//! unit and any range: it has no ceilings but on its bus.

use wire::registers::{Access, HIGHEST_BAR, Id, Value, fields};
use wire::{Refusal, Request, text};

use crate::scaling::Scalings;

/// Whether a request keeps to what is compiled in.
///
/// # Errors
/// The first value that exceeds it, by name and limits.
// Not inlined: what it needs of the stack is not needed by what follows.
#[inline(never)]
pub fn check(request: &Request, scalings: &Scalings) -> Result<(), Refusal> {
    match request {
        Request::Protect(protection) => refused(fields::excess_of_protection(protection)),
        Request::Configure(configuration) => refused(fields::excess(&mut configuration.tracking.clone())),
        Request::Service(code) if *code > scalings.command_code(HIGHEST_BAR as f32).0 => {
            let bar = scalings.command.value(*code);
            Err(Refusal::parameter(format_args!("the code is {bar} bar, must be 0 to {HIGHEST_BAR}")))
        }
        _ => Ok(()),
    }
}

/// The refusal of a value that exceeds its register's limits.
pub fn refused(excess: Option<(Id, Value)>) -> Result<(), Refusal> {
    let Some((id, value)) = excess else { return Ok(()) };
    let (register, value) = (id.register(), value.number());
    Err(Refusal::Parameter(match register.access {
        Access::Write(min, max) => text(format_args!("{} is {value}, must be {min} to {max}", register.name)),
        Access::Read => text(format_args!("{} is {value}", register.name)),
    }))
}
