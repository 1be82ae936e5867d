//! From a request of the host to an order that the tick's owner can carry out at once.

use core::fmt::Write as _;

use model_core::{Mode, ParameterError, Tracking};
use wire::{Configuration, DEAD_ZONES, PLAYS, Refusal, Request, VERSION};

/// The controller in the board's number type and capacity.
pub type BoardTracking = Tracking<f32, PLAYS, DEAD_ZONES>;

/// Something for [`crate::Control::apply`], already checked as far as that needs no state.
#[derive(Clone, Debug)]
// The controller is the one large order; boxing it needs a heap, which the board does not have.
#[allow(clippy::large_enum_variant)]
pub enum Order {
    /// Say who and how the board is.
    Identify,
    /// Put this controller in.
    Install(BoardTracking),
    /// Start from rest.
    Start(Mode),
    /// Go on in another mode.
    SetMode(Mode),
    /// Stop and vent.
    Stop,
    /// The reference of the next ticks. Unit: mm.
    Reference(f32),
}

/// Checks a request and makes an order of it.
///
/// # Errors
/// A configuration of another version or with an invalid parameter; a tick, which only an emulated board
/// takes, and takes before it comes here.
pub fn prepare(request: Request) -> Result<Order, Refusal> {
    Ok(match request {
        Request::Identify => Order::Identify,
        Request::Configure(configuration) => Order::Install(validate(&configuration)?),
        Request::Start(mode) => Order::Start(mode),
        Request::SetMode(mode) => Order::SetMode(mode),
        Request::Stop => Order::Stop,
        Request::Reference(reference_mm) => Order::Reference(reference_mm),
        Request::Tick(_) => return Err(Refusal::NotHere),
    })
}

fn validate(configuration: &Configuration) -> Result<BoardTracking, Refusal> {
    if configuration.version != VERSION {
        return Err(Refusal::Version(VERSION));
    }
    Tracking::try_new(&configuration.tracking).map_err(|error| Refusal::Parameter(message(&error)))
}

/// The error in words, as far as they fit.
fn message(error: &ParameterError) -> heapless::String<100> {
    let mut text = heapless::String::new();
    // A text that does not fit ends at its last whole part.
    let _ = write!(text, "{error}");
    text
}
