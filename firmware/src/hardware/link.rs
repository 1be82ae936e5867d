//! What a board answers to what it received, and what it logs about it: the same for every image.

use firmware::{Order, prepare};
use wire::{FrameError, Refusal, Request, Response, State};

/// The response to a frame. A request that can be carried out goes to `apply`.
pub fn answer(received: Result<Request, FrameError>, apply: impl FnOnce(Order) -> Response) -> Response {
    let order = received.map_err(|_| Refusal::Unreadable).and_then(prepare);
    order.map_or_else(Response::Refused, apply)
}

/// Logs a state that is not the one logged last.
pub fn log_change(logged: &mut State, state: State) {
    if state != *logged {
        defmt::info!("state {}", defmt::Debug2Format(&state));
        *logged = state;
    }
}
