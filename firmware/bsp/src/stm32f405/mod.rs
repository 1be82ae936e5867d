//! The drivers of the STM32F405, by its registers. No wait in them is unbounded; the tick's do not
//! wait at all.
//!
//! | file | what it drives |
//! |---|---|
//! | [`clock`] | crystal, multiplier, buses |
//! | [`start`], [`restart`] | what an image that drives valves begins with, and how it ends |
//! | [`scan`] | the analogue inputs; `scan/joint.rs` those of two channels |
//! | [`output`] | the valve: `analog.rs` by a voltage, or `pulses.rs` with the feature `solenoid` |
//! | [`joint`] | sensors and valves of two channels |
//! | [`valve`] | the safe value of all by raw registers |
//! | [`factory`] | the processor's temperature and reference by its factory values |
//! | [`image`] | the head of the firmware, and its checksum |
//! | [`memory_test`] | the test of the RAM |
//! | [`tick`] | the clock of the control, and moments in microseconds |
//! | [`watchdog`] | the hardware watchdog |
//! | [`memory`] | the black box, and why the processor has started |
//! | [`flash`] | erasing and programming; `parameter_flash.rs` and [`image_flash`] make use of it |
//! | [`stored`] | what a board keeps in its flash, and has at hand |
//! | [`image_flash`] | the places of the images |
//! | [`pins`] | routing, status light, voltage detector |
//! | [`bring_up`] | what the bring-up image needs beyond these |

pub mod bring_up;
pub mod clock;
pub mod factory;
pub mod flash;
pub mod image;
pub mod image_flash;
pub mod joint;
pub mod memory;
pub mod memory_test;
#[cfg_attr(not(feature = "solenoid"), path = "analog.rs")]
#[cfg_attr(feature = "solenoid", path = "pulses.rs")]
pub mod output;
mod parameter_flash;
pub mod pins;
pub mod restart;
pub mod scan;
pub mod start;
pub mod stored;
pub mod tick;
pub mod valve;
pub mod watchdog;

use firmware::board::Valve;
use firmware::scaling::VENT;
use firmware::{AcquisitionError, Board, DacCode, Samples};

use output::Output;
use scan::Scan;

/// Sensors and valve.
pub struct SensorsAndValve {
    scan: Scan,
    valve: Output,
    /// Whether the output has not taken the last code.
    has_failed: bool,
}

impl SensorsAndValve {
    /// Both together.
    pub fn new(scan: Scan, valve: Output) -> Self {
        Self { scan, valve, has_failed: false }
    }
}

impl Board for SensorsAndValve {
    fn read(&mut self) -> Result<Samples, AcquisitionError> {
        let samples = self.scan.read();
        // Converters that fail are of one kind: after some ticks in a row the valve is vented.
        if self.has_failed { Err(AcquisitionError) } else { samples }
    }

    fn drive(&mut self, code: DacCode) {
        // No interrupt between the look and the write: one before the look is seen, one behind the
        // write vents by itself. So no write undoes what the detector's interrupt has vented.
        let done =
            cortex_m::interrupt::free(|_| self.valve.set(if pins::was_supply_low() { VENT } else { code }));
        self.has_failed = done.is_err();
    }
}
