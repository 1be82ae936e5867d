//! A board whose samples come from a host, one tick at a time.
//!
//! The emulated image uses it behind its serial port, and the host to repeat a run bit for bit.

use model_core::Surroundings;
use wire::{Flags, TickReply, TickRequest};

use crate::board::{AcquisitionError, AdcCode, Board, DacCode, Samples};
use crate::control::{Control, TickOutcome};
use crate::order::Order;
use crate::scaling::VENT;

/// What the inputs read that a simulation has no part in: 8 bar before the valve, 25 °C.
pub(crate) const AROUND: Samples = Samples {
    pressure: AdcCode(0),
    contraction: AdcCode(0),
    supply: AdcCode(3030),
    temperature: AdcCode(943),
    output: None,
    reference: None,
    surroundings: Surroundings { load: None, temperature: None },
};

/// Samples in, valve code out.
#[derive(Debug)]
pub struct LockStepBoard {
    samples: Samples,
    output: DacCode,
}

impl LockStepBoard {
    /// A board without samples, the valve vented.
    pub const fn new() -> Self {
        Self { samples: AROUND, output: VENT }
    }

    /// What was last written to the valve.
    pub fn output(&self) -> DacCode {
        self.output
    }

    /// Lays the samples of the next tick in, and gives the control its reference, if it comes with
    /// them.
    pub fn feed(&mut self, control: &mut Control, request: TickRequest) {
        self.samples = Samples {
            pressure: AdcCode(request.pressure_code),
            contraction: AdcCode(request.contraction_code),
            surroundings: Surroundings { load: request.load_n, temperature: request.temperature_c },
            ..AROUND
        };
        if let Some(reference_mm) = request.reference_mm {
            control.apply(Order::Reference(reference_mm));
            // Without the host that has made it there were no tick to be silent in.
            control.live();
        }
    }

    /// A whole tick: [`feed`](Self::feed), then [`Control::tick`].
    pub fn tick(&mut self, control: &mut Control, request: TickRequest) -> TickReply {
        self.feed(control, request);
        reply(control.tick(self))
    }
}

/// What the host is told of a tick.
pub fn reply(outcome: TickOutcome) -> TickReply {
    let TickOutcome { code, feedforward_bar, feedback_bar, .. } = outcome;
    TickReply {
        dac_code: code.0,
        feedforward_bar,
        feedback_bar,
        flags: Flags::default()
            .with(Flags::LIMITED, outcome.is_limited)
            .with(Flags::TRACKING, outcome.is_tracking)
            .with(Flags::FAULT, outcome.is_at_fault)
            .with(Flags::OVERRUN, outcome.is_overrun),
    }
}

impl Default for LockStepBoard {
    fn default() -> Self {
        Self::new()
    }
}

impl Board for LockStepBoard {
    fn read(&mut self) -> Result<Samples, AcquisitionError> {
        Ok(self.samples)
    }

    fn drive(&mut self, code: DacCode) {
        self.output = code;
    }
}
