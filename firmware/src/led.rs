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
//!
//! Of a joint, `Starting` is as `Service`, and a hundred of a fault's number is a flicker before
//! its tens.

use wire::joint::{JointBoardState, JointFault};
use wire::{Fault, State};

/// A flash with its pause. Unit: tick.
const FLASH: u32 = 300;
const SHORT: u32 = 100;
const LONG: u32 = 250;
/// The pause after a number, in flashes.
const PAUSE: u32 = 5;

/// The flicker, on and off. Unit: tick.
const FLICKER: u32 = 50;

/// Whether the light is on in a tick.
pub fn is_lit(state: State, fault: Option<Fault>, tick: u32) -> bool {
    shows(state, fault.map(|fault| fault.code().into()), tick)
}

/// The same of a joint.
pub fn is_lit_of_joint(state: JointBoardState, fault: Option<JointFault>, tick: u32) -> bool {
    let state = match state {
        JointBoardState::Off => State::Off,
        JointBoardState::Ready => State::Ready,
        JointBoardState::Starting | JointBoardState::Service => State::Service,
        JointBoardState::Tracking => State::Tracking,
        JointBoardState::Fault => State::Fault,
    };
    shows(state, fault.map(|fault| fault.code().into()), tick)
}

fn shows(state: State, number: Option<u32>, tick: u32) -> bool {
    match state {
        State::Off => tick % 2000 < 50,
        State::SelfTest => tick % 100 < 50,
        State::Ready => tick % 1000 < 500,
        State::Tracking | State::Holding => true,
        State::Service => tick % 1000 < 50 || (200..250).contains(&(tick % 1000)),
        State::Fault => number.is_none_or(|number| flashes(number, tick)),
    }
}

fn flashes(number: u32, tick: u32) -> bool {
    let (hundreds, tens, ones) = (number / 100, number / 10 % 10, number % 10);
    let all = hundreds + tens + ones;
    let place = tick % ((all + PAUSE) * FLASH);
    let (flash, within) = (place / FLASH, place % FLASH);
    let is_on = within < LONG && within % (2 * FLICKER) < FLICKER;
    if flash < hundreds {
        is_on
    } else {
        flash < all && within < if flash < hundreds + tens { LONG } else { SHORT }
    }
}
