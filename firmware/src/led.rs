//! What the status light shows: the state by its rhythm, a fault by its number.
//!
//! | state | light |
//! |---|---|
//! | `Off` | a flash every 2 s |
//! | `SelfTest` | flicker |
//! | `Ready` | half a second on, half a second off |
//! | `Tracking`, `Holding` | on |
//! | `Service` | two flashes every second |
//! | `Fault` | the number's tens as long flashes, its ones as short ones, then a pause |

use wire::{Fault, State};

/// A flash with its pause. Unit: tick.
const FLASH: u32 = 300;
const SHORT: u32 = 100;
const LONG: u32 = 250;
/// The pause after a number, in flashes.
const PAUSE: u32 = 5;

/// Whether the light is on in a tick.
pub fn is_lit(state: State, fault: Option<Fault>, tick: u32) -> bool {
    match state {
        State::Off => tick % 2000 < 50,
        State::SelfTest => tick % 100 < 50,
        State::Ready => tick % 1000 < 500,
        State::Tracking | State::Holding => true,
        State::Service => tick % 1000 < 50 || (200..250).contains(&(tick % 1000)),
        State::Fault => fault.is_none_or(|fault| flashes(fault.code().into(), tick)),
    }
}

fn flashes(number: u32, tick: u32) -> bool {
    let (tens, ones) = (number / 10, number % 10);
    let place = tick % ((tens + ones + PAUSE) * FLASH);
    let (flash, within) = (place / FLASH, place % FLASH);
    flash < tens + ones && within < if flash < tens { LONG } else { SHORT }
}
