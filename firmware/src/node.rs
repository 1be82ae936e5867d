//! The board as those see it that are asked from outside: the service link and the bus.

use wire::{Request, Response};

use crate::control::Control;
use crate::order::prepare;
use crate::store::Parameters;

/// What a request works on.
pub trait Node {
    /// Works on the control, between two ticks; a tick that is due waits meanwhile.
    fn control<R>(&mut self, work: impl FnOnce(&mut Control) -> R) -> R;

    /// The raw set behind what the control has.
    fn parameters(&self) -> &Parameters;

    /// Keeps a set that the control has taken, without power too where there is a store.
    fn keep(&mut self, parameters: Parameters);
}

/// Carries a request out: prepared outside the control's lock, and kept if it changes what the board keeps.
// Not inlined, like what follows: what they need of the stack is then not needed at once, nor by their callers' other work.
#[inline(never)]
pub fn carry_out(node: &mut impl Node, request: &Request) -> Response {
    let response = apply(node, request);
    if response == Response::Accepted {
        keep(node, request);
    }
    response
}

/// Carries a request out without keeping what it changes.
#[inline(never)]
pub fn apply(node: &mut impl Node, request: &Request) -> Response {
    prepare(request).map_or_else(Response::Refused, |order| node.control(|control| control.apply(order)))
}

#[inline(never)]
fn keep(node: &mut impl Node, request: &Request) {
    if let Some(changed) = node.parameters().changed_by(request) {
        node.keep(changed);
    }
}
