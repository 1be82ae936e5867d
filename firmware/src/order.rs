//! From a request of the host to an order that the tick's owner can carry out at once.

use core::fmt::Write as _;

use model_core::{Mode, ParameterError, Tracking};
use wire::{CaptureOrder, Configuration, DEAD_ZONES, PLAYS, Protection, Refusal, Request, VERSION};

use crate::monitors::survey::{Survey, survey};

/// The controller in the board's number type and capacity.
pub type BoardTracking = Tracking<f32, PLAYS, DEAD_ZONES>;

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
}

/// Checks a request and makes an order of it.
///
/// # Errors
/// A configuration of another version, or with an invalid parameter; limits that are none; a tick, which only an emulated
/// board takes, and takes before it comes here.
// Not inlined, like what it calls: what they need of the stack is then not needed at once.
#[inline(never)]
pub fn prepare(request: &Request) -> Result<Order, Refusal> {
    Ok(match *request {
        Request::Identify => Order::Identify,
        Request::Configure(ref configuration) => return validate(configuration),
        Request::Start(mode) => Order::Start(mode),
        Request::SetMode(mode) => Order::SetMode(mode),
        Request::Stop => Order::Stop,
        Request::Reference(reference_mm) => Order::Reference(reference_mm),
        Request::Tick(_) => return Err(Refusal::NotHere),
        Request::Protect(protection) => Order::Protect(check(protection)?),
        Request::Acknowledge => Order::Acknowledge,
        Request::Service(code) => Order::Service(code),
        Request::Telemetry => Order::Telemetry,
        Request::FaultRecord => Order::FaultRecord,
        Request::Capture(order) => Order::Capture(order),
    })
}

#[inline(never)]
fn validate(configuration: &Configuration) -> Result<Order, Refusal> {
    if configuration.version != VERSION {
        return Err(Refusal::Version(VERSION));
    }
    let parameters = &configuration.tracking;
    let refuse = |error: ParameterError| Refusal::Parameter(text(format_args!("{error}")));
    let tracking = Tracking::try_new(parameters).map_err(refuse)?;
    let survey = survey(&parameters.model, tracking.inverse()).map_err(refuse)?;
    Ok(Order::Install(Installation { tracking, survey, period_s: parameters.period_s }))
}

/// Limits that can be compared with: none is NaN or negative, and what has to be above 0 is.
fn check(protection: Protection) -> Result<Protection, Refusal> {
    let Protection { soft_start_bar_per_s, slew_bar_per_s, .. } = protection;
    let at_least_0 = [
        ("vented_bar", protection.vented_bar),
        ("overpressure_hard_bar", protection.overpressure_hard_bar),
        ("overpressure_soft_bar", protection.overpressure_soft_bar),
        ("supply_min_bar", protection.supply_min_bar),
        ("pressure_jump_bar", protection.pressure_jump_bar),
        ("contraction_jump_mm", protection.contraction_jump_mm),
        ("stuck_command_bar", protection.stuck_command_bar),
        ("implausible_share", protection.implausible_share),
        ("following_band_bar", protection.following_band_bar),
        ("following_limit_bar_s", protection.following_limit_bar_s),
        ("authority_bar", protection.authority_bar),
        ("temperature_max_c", protection.temperature_max_c),
    ];
    let above_0 = [("soft_start_bar_per_s", soft_start_bar_per_s), ("slew_bar_per_s", slew_bar_per_s)];
    let too_low = at_least_0.iter().find(|(_, value)| value.is_nan() || *value < 0.0);
    let not_above = above_0.iter().find(|(_, value)| !value.is_finite() || *value <= 0.0);
    match (too_low, not_above) {
        (Some((name, value)), _) => {
            Err(Refusal::Parameter(text(format_args!("{name} is {value}, must be at least 0"))))
        }
        (None, Some((name, value))) => {
            Err(Refusal::Parameter(text(format_args!("{name} is {value}, must be above 0 and finite"))))
        }
        (None, None) => Ok(protection),
    }
}

/// A message, as far as it fits.
pub(crate) fn text(message: core::fmt::Arguments<'_>) -> heapless::String<100> {
    let mut text = heapless::String::new();
    // A text that does not fit ends at its last whole part.
    let _ = text.write_fmt(message);
    text
}
