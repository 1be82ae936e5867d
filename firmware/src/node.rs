//! The board as those see it that are asked from outside: the service link and the bus.

use wire::{Refusal, Request, Response};

use crate::ceilings;
use crate::control::Control;
use crate::identity::Identity;
use crate::order::prepare;
use crate::store::{Parameters, SaveError};
use crate::update::Images;

/// What a request works on.
pub trait Node {
    /// What it has of images; [`crate::update::NoImages`] where it takes none.
    type Images: Images;

    /// Works on the control, between two ticks; a tick that is due waits meanwhile.
    fn control<R>(&mut self, work: impl FnOnce(&mut Control) -> R) -> R;

    /// The raw set behind what the control has.
    fn parameters(&self) -> &Parameters;

    /// Which board it is.
    fn identity(&self) -> &Identity;

    /// Keeps a set that the control has taken, without power too where there is a store.
    ///
    /// # Errors
    /// It is kept until power is lost only.
    fn keep(&mut self, parameters: Parameters) -> Result<(), SaveError>;

    /// The images in its flash, if it takes new ones over the bus.
    fn images(&mut self) -> Option<&mut Self::Images>;
}

/// Carries a request out: prepared outside the control's lock, and kept if it changes what the
/// board keeps. Accepted is what is carried out and kept.
// Not inlined, like what follows: what they need of the stack is then not needed at once, nor by
// their callers' other work.
#[inline(never)]
pub fn carry_out(node: &mut impl Node, request: &Request) -> Response {
    let response = apply(node, request);
    if response == Response::Accepted && keep(node, request).is_err() {
        return Response::Refused(Refusal::NotStored);
    }
    response
}

/// Carries a request out without keeping what it changes.
#[inline(never)]
pub fn apply(node: &mut impl Node, request: &Request) -> Response {
    let scalings = node.control(|control| control.has_muscle().then_some(*control.scalings()));
    scalings
        .map_or(Ok(()), |scalings| ceilings::check(request, &scalings))
        .and_then(|()| prepare(request))
        .map_or_else(Response::Refused, |order| node.control(|control| control.apply(order)))
}

#[inline(never)]
fn keep(node: &mut impl Node, request: &Request) -> Result<(), SaveError> {
    node.parameters().changed_by(request).map_or(Ok(()), |changed| node.keep(changed))
}
