//! The states of the board and how they follow each other: one table, [`next`].
//!
//! The valve is driven in `Tracking`, `Holding` and `Service` only, and none of them is entered but
//! from a tested board by an order of the host, which has armed it before ([`crate::Control`]
//! counts for how long). Every state leads to `Fault` by a fault that vents,
//! and `Fault` leads on only by an acknowledgement, through the self-test.

use wire::State;

/// What moves the board from state to state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// A validated configuration arrives.
    Install,
    /// The self-test is over, and found nothing.
    Tested,
    /// The host wants to track.
    Start,
    /// The host wants another mode in which the command is not held.
    SetMode,
    /// The host wants the command held.
    Hold,
    /// The host wants the valve vented.
    Stop,
    /// The host drives the valve by a code.
    Service,
    /// The host has seen to the fault.
    Acknowledge,
    /// A fault that vents.
    Trip,
    /// The host is about to open the valve.
    Arm,
}

impl Event {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Install,
        Self::Tested,
        Self::Start,
        Self::SetMode,
        Self::Hold,
        Self::Stop,
        Self::Service,
        Self::Acknowledge,
        Self::Trip,
        Self::Arm,
    ];
}

/// What an event does in a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// The state that follows; may be the same.
    To(State),
    /// `SelfTest` with a configuration, `Off` without.
    Home,
    /// Refused; nothing changes.
    Refused,
}

/// What an event does in a state.
pub const fn next(state: State, event: Event) -> Next {
    use Event as E;
    use Next::{Home, Refused, To};
    use State as S;
    match (state, event) {
        (_, E::Trip) => To(S::Fault),

        (S::Off, E::Install) => To(S::SelfTest),
        (S::Off, E::Stop | E::Acknowledge | E::Arm) => To(S::Off),
        (S::Off, E::Service) => To(S::Service),
        (S::Off, _) => Refused,

        (S::SelfTest, E::Install) => To(S::SelfTest),
        (S::SelfTest, E::Tested) => To(S::Ready),
        (S::SelfTest, E::Stop | E::Acknowledge) => To(S::SelfTest),
        (S::SelfTest, _) => Refused,

        (S::Ready, E::Install) => To(S::SelfTest),
        (S::Ready, E::Start) => To(S::Tracking),
        (S::Ready, E::Stop | E::Acknowledge | E::Arm) => To(S::Ready),
        (S::Ready, E::Service) => To(S::Service),
        (S::Ready, _) => Refused,

        (S::Tracking, E::SetMode) => To(S::Tracking),
        (S::Tracking, E::Hold) => To(S::Holding),
        (S::Tracking, E::Stop) => To(S::Ready),
        (S::Tracking, _) => Refused,

        (S::Holding, E::SetMode) => To(S::Tracking),
        (S::Holding, E::Hold) => To(S::Holding),
        (S::Holding, E::Stop) => To(S::Ready),
        (S::Holding, _) => Refused,

        // A board at fault is vented; another configuration may be its cure, but it takes an
        // acknowledgement too.
        (S::Fault, E::Stop | E::Install) => To(S::Fault),
        (S::Fault, E::Acknowledge) => Home,
        (S::Fault, _) => Refused,

        (S::Service, E::Service) => To(S::Service),
        (S::Service, E::Stop) => Home,
        (S::Service, _) => Refused,
    }
}
