//! The control law alone: no tasks, no logs, no messages, no states. The image shows two things.
//!
//! * **No panic**: what it is given, the law cannot panic when nothing of the panic machinery is linked. Model, gains,
//!   mode, reference and contraction are all unknown to the compiler.
//! * **Cost of the inverse alone**, which the other images contain only as a part of the controller.
//!
//! # Protocol
//! A zero byte on USART2 says that the board is ready. The host answers by a byte for the envelope, 0 for the paper's and 1
//! for the piecewise-linear one. Then, for each sample, it sends mode (one byte, 0 to 3 as in [`MODES`]), reference and
//! contraction (mm), and gets back (bar) the inverse's answer, that of the inverse of compiled size, the controller's command,
//! and that of the law of compiled size; numbers are `f32`, little-endian. A refused sample is answered by NaN.
//!
//! # Limits
//! The waits for the port are unbounded: it stands for the host's program and is no part of the law. A model that is
//! refused stops the image before the first sample.
#![no_std]
#![no_main]

mod port;

use core::hint::black_box;
use core::panic::PanicInfo;

use firmware::law::{controller_step, inverse_step, paper_parameters, piecewise_parameters};
use firmware::order::BoardTracking;
use firmware::sized::{SizedInverse, SizedLaw, SizedLawState, law_step, paper_law};
use model_core::{HysteresisState, InverseHysteresis, Mode, ParameterError, TrackingState};
use wire::PLAYS;

use port::Port;

/// By the number that stands for them on the port.
const MODES: [Mode; 4] = [Mode::Both, Mode::FeedforwardOnly, Mode::FeedbackOnly, Mode::Hold];

/// The law with what it remembers.
struct Law {
    /// Of the controller's own inverse, beside it.
    inverse_state: HysteresisState<f32, PLAYS>,
    sized: SizedInverse,
    tracking: BoardTracking,
    state: TrackingState<f32, PLAYS>,
    sized_law: (SizedLaw, SizedLawState),
}

impl Law {
    /// The paper's model and gains, at rest. Apart, so that its temporaries leave the stack.
    #[inline(never)]
    fn paper(piecewise: bool) -> Result<Self, ParameterError> {
        let tracking = paper_tracking(piecewise)?;
        Ok(Self {
            inverse_state: tracking.inverse().rest_state(),
            state: tracking.rest_state(Mode::Both),
            sized: SizedInverse::paper(piecewise)?,
            sized_law: paper_law()?,
            tracking,
        })
    }

    fn sample(&mut self, port: &Port) {
        let mode = MODES[usize::from(port.receive_byte() & 3)];
        let (reference_mm, contraction_mm) = (port.receive(), port.receive());
        let inverse = inverse_step(self.tracking.inverse(), &mut self.inverse_state, reference_mm);
        let sized = self.sized.step(reference_mm);
        let command =
            controller_step(&self.tracking, &mut self.state, mode, reference_mm, contraction_mm.into());
        let (law, law_state) = &mut self.sized_law;
        let law_command = law_step(law, law_state, reference_mm, contraction_mm);
        port.send(inverse.unwrap_or(f32::NAN));
        port.send(sized.unwrap_or(f32::NAN));
        port.send(command.map_or(f32::NAN, |command| command.command));
        port.send(law_command.unwrap_or(f32::NAN));
    }
}

/// The controller. Apart, as above.
#[inline(never)]
fn paper_tracking(piecewise: bool) -> Result<BoardTracking, ParameterError> {
    let parameters = if piecewise { piecewise_parameters()? } else { paper_parameters()? };
    BoardTracking::try_new(black_box(&parameters))
}

#[cortex_m_rt::entry]
fn main() -> ! {
    let port = Port::open();
    port.send_byte(0);
    // Where it stands: there is not the stack to move it.
    if let Ok(law) = &mut Law::paper(port.receive_byte() != 0) {
        loop {
            // Whatever it holds is unknown to the compiler.
            black_box(&mut *law).sample(&port);
            #[cfg(feature = "deliberate_panic")]
            black_box([0])[usize::from(port.receive_byte())];
        }
    }
    loop {
        cortex_m::asm::wfi();
    }
}

/// Recognisable in the linked image, under whatever name the compiler gives the handler.
#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    panicked()
}

#[inline(never)]
fn panicked() -> ! {
    loop {
        cortex_m::asm::udf();
    }
}
