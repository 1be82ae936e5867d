//! What a board answers to what it received over the link, and what it logs about it: the same for every image.

use firmware::node::{Node, carry_out};
use wire::{FrameError, Refusal, Request, Response, State};

/// The response to a frame, carried out if it is a request.
pub fn answer(received: Result<Request, FrameError>, node: &mut impl Node) -> Response {
    match received {
        Ok(request) => carry_out(node, &request),
        Err(_) => Response::Refused(Refusal::Unreadable),
    }
}

/// Logs a state that is not the one logged last.
pub fn log_change(logged: &mut State, state: State) {
    if state != *logged {
        defmt::info!("state {}", defmt::Debug2Format(&state));
        *logged = state;
    }
}
