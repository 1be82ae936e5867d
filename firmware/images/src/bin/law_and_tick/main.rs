//! Control law and tick, and nothing else: no tasks, no logs, no messages. The image is only
//! linked, never run, and shows two things.
//!
//! * **No panic**: whatever model, gains and references the law is given, in whatever state the
//!   control is, and whatever the converter reads, neither can panic when nothing of the panic
//!   machinery is linked. All of that is unknown to the compiler.
//! * **The longest way** through the law of compiled size ([`sized`]).
#![no_std]
#![no_main]

mod sized;

use core::hint::black_box;
use core::panic::PanicInfo;

use firmware::joint::{JointBoard, JointSamples, JointTask};
use firmware::timing::TickEnd;
use firmware::{AcquisitionError, Board, Control, DacCode, Samples};
use model_core::Mode;
// The table of interrupts that the linker asks for.
#[allow(unused_imports, reason = "linked for its statics")]
use stm32f4::stm32f405 as _;
use wire::joint::{BoardJointControl, BoardJointParameters};
use wire::{BoardParameters, BoardTracking};

/// A board of which the compiler knows nothing.
struct Unknown;

impl Board for Unknown {
    fn read(&mut self) -> Result<Samples, AcquisitionError> {
        black_box(Err(AcquisitionError))
    }

    fn drive(&mut self, code: DacCode) {
        black_box(code);
    }
}

impl JointBoard for Unknown {
    fn read(&mut self) -> Result<JointSamples, AcquisitionError> {
        black_box(Err(AcquisitionError))
    }

    fn drive(&mut self, codes: [DacCode; 2]) {
        black_box(codes);
    }
}

/// A value of which the compiler knows nothing.
fn unknown<T>() -> &'static mut T {
    // SAFETY: none, but nobody runs it. An address that the compiler does not know stands for any
    // value.
    unsafe { &mut *(black_box(0x2001_0000_usize) as *mut T) }
}

#[cortex_m_rt::entry]
fn main() -> ! {
    loop {
        tick(unknown());
        validate(unknown());
        tick_of_joint(unknown());
        validate_joint(unknown());
        black_box(sized::tanh_step(unknown(), unknown(), black_box(0.0)).is_ok());
        black_box(sized::piecewise_step(unknown(), unknown(), black_box(0.0)).is_ok());
        black_box(sized::law_step(unknown(), unknown(), black_box(0.0), black_box(0.0)).is_ok());
        #[cfg(feature = "deliberate_panic")]
        black_box([0])[black_box(1_usize)];
    }
}

fn tick(control: &mut Control) {
    control.tick(&mut Unknown);
    control.close_tick(black_box(TickEnd { elapsed_cycles: 0, is_overrun: false }));
}

/// With what a board tells of itself around it.
fn tick_of_joint(task: &mut JointTask) {
    task.hear_stop(black_box(false));
    task.hear_coil(black_box(false));
    task.tick(&mut Unknown);
    task.close_tick(black_box(TickEnd { elapsed_cycles: 0, is_overrun: false }));
}

/// A model before it controls, and its state at rest.
fn validate(parameters: &BoardParameters) {
    if let Ok(tracking) = BoardTracking::try_new(parameters) {
        black_box(black_box(tracking).rest_state(black_box(Mode::Both)));
    }
}

/// The same of a joint.
fn validate_joint(parameters: &BoardJointParameters) {
    if let Ok(control) = BoardJointControl::try_new(parameters) {
        black_box(black_box(control).rest_state(black_box(0.0)));
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
