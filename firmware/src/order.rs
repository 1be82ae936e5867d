//! From a request of the host to an order that the tick's owner can carry out at once.

use model_core::Mode;
use wire::{BoardTracking, CaptureOrder, Configuration, Protection, Refusal, Request, VERSION};

use crate::monitors::survey::{Survey, survey};

/// A controller that has been looked at.
#[derive(Clone, Debug)]
pub struct Installation {
    /// The controller.
    pub tracking: BoardTracking,
    /// What was found about its model.
    pub survey: Survey,
    /// Time from sample to sample. Unit: s, above 0.
    pub period_s: f32,
}

/// Something for [`crate::Control::apply`], already checked as far as that needs no state.
#[derive(Clone, Debug)]
// The controller is the one large order; boxing it needs a heap, which the board does not have.
#[allow(clippy::large_enum_variant)]
pub enum Order {
    /// Say who and how the board is.
    Identify,
    /// Put this controller in.
    Install(Installation),
    /// Start from rest.
    Start(Mode),
    /// Go on in another mode.
    SetMode(Mode),
    /// Stop and vent.
    Stop,
    /// The reference of the next ticks. Unit: mm.
    Reference(f32),
    /// Take these limits.
    Protect(Protection),
    /// Release the latched fault.
    Acknowledge,
    /// Drive the valve by a code. Unit: DAC code.
    Service(u16),
    /// Say what was counted and measured.
    Telemetry,
    /// Say what the first fault was.
    FaultRecord,
    /// Record the loop, or read from the recording.
    Capture(CaptureOrder),
    /// Be ready to start.
    Arm,
    /// The host lives, if this is another number than the one before.
    Heartbeat(u16),
}

/// Checks a request and makes an order of it.
///
/// # Errors
/// A configuration of another version, or with an invalid parameter; limits that are none; a tick,
/// which only an emulated board takes, and takes before it comes here.
// Not inlined, like what it calls: what they need of the stack is then not needed at once.
#[inline(never)]
pub fn prepare(request: &Request) -> Result<Order, Refusal> {
    Ok(match *request {
        Request::Identify => Order::Identify,
        Request::Configure(ref configuration) => return installation(configuration),
        Request::Start(mode) => Order::Start(mode),
        Request::SetMode(mode) => Order::SetMode(mode),
        Request::Stop => Order::Stop,
        Request::Reference(reference_mm) => Order::Reference(reference_mm),
        Request::Tick(_) => return Err(Refusal::NotHere),
        Request::Protect(protection) => return protection.checked().map(Order::Protect),
        Request::Acknowledge => Order::Acknowledge,
        Request::Service(code) => Order::Service(code),
        Request::Telemetry => Order::Telemetry,
        Request::FaultRecord => Order::FaultRecord,
        Request::Capture(order) => Order::Capture(order),
        Request::Arm => Order::Arm,
        Request::Heartbeat(number) => Order::Heartbeat(number),
    })
}

/// A controller whose model has been surveyed.
// Not inlined, for the stack's sake, as above.
#[inline(never)]
fn installation(configuration: &Configuration) -> Result<Order, Refusal> {
    if configuration.version != VERSION {
        return Err(Refusal::Version(VERSION));
    }
    let parameters = &configuration.tracking;
    // Looked at where it was made, and moved once: each move more takes the stack of a controller.
    let made = BoardTracking::try_new(parameters);
    let tracking = made.as_ref().map_err(|error| Refusal::from(*error))?;
    let survey = survey(&parameters.model, tracking.inverse()).map_err(Refusal::from)?;
    let period_s = parameters.period_s;
    match made {
        Ok(tracking) => Ok(Order::Install(Installation { tracking, survey, period_s })),
        Err(error) => Err(error.into()),
    }
}
