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
// Not inlined: what it needs of the stack is then not needed by its callers' other work.
#[inline(never)]
pub fn carry_out(node: &mut impl Node, request: Request) -> Response {
    let changed = node.parameters().changed_by(&request);
    let response =
        prepare(request).map_or_else(Response::Refused, |order| node.control(|control| control.apply(order)));
    if let (Response::Accepted, Some(changed)) = (&response, changed) {
        node.keep(changed);
    }
    response
}
