//! What an image that drives valves begins with, before it has a task: watchdog, supply, clocks,
//! and whether program and memory are sound.

use firmware::faults::black_box::Reset;
use stm32f4::stm32f405::{DBGMCU, EXTI, FLASH, IWDG, PWR, RCC};
use wire::Fault;

use super::clock::{self, Clocks, Source};
use super::flash::Flash;
use super::image::{self, Image};
use super::pins::VoltageDetector;
use super::watchdog::HardwareWatchdog;
use super::{memory, memory_test};

/// What has begun, and what was found.
pub struct Started {
    /// Waits as for a vented valve.
    pub hardware_watchdog: HardwareWatchdog,
    /// Its interrupt may come.
    pub voltage: VoltageDetector,
    /// The frequencies.
    pub clocks: Clocks,
    /// Locked.
    pub flash: Flash,
    /// Why the processor has started.
    pub reset: Reset,
    is_supplied: bool,
    image: Image,
    has_memory: bool,
    lacks_brown_out_reset: bool,
}

/// Begins. The outputs of a board whose program or memory is damaged are held in reset for good.
pub fn begin(rcc: &RCC, watchdog: IWDG, power: PWR, flash: FLASH, lines: &EXTI, debug: &DBGMCU) -> Started {
    clock::feed_peripherals(rcc);
    let hardware_watchdog = HardwareWatchdog::start(watchdog, debug);
    let reset = memory::reset_cause(rcc);
    let voltage = VoltageDetector::start(power, lines);
    let is_supplied = voltage.wait();
    let clocks = clock::start(rcc, &flash, debug, is_supplied);
    let lacks_brown_out_reset = memory::lacks_brown_out_reset(&flash);
    if lacks_brown_out_reset {
        defmt::warn!("the brown-out reset is off: set it by the option bytes");
    }
    let flash = Flash::new(flash);
    let (image, has_memory) = (image::check(&flash), memory_test::has_passed());
    let started = Started {
        hardware_watchdog,
        voltage,
        clocks,
        flash,
        reset,
        is_supplied,
        image,
        has_memory,
        lacks_brown_out_reset,
    };
    if !started.is_sound() {
        clock::hold_outputs(rcc);
    }
    started
}

impl Started {
    /// Whether program and memory are sound. Else nothing may be driven.
    pub fn is_sound(&self) -> bool {
        self.image != Image::Damaged && self.has_memory
    }

    /// What was found. The first faults vent, the others are only to be known of.
    pub fn faults(&self) -> [[Option<Fault>; 3]; 2] {
        let has_fallen_back = self.is_supplied && self.clocks.source == Source::Internal;
        let of = |is_so: bool, fault| is_so.then_some(fault);
        [
            [
                of(!self.is_supplied, Fault::BrownOut),
                of(self.image == Image::Damaged, Fault::ImageDamaged),
                of(!self.has_memory, Fault::MemoryDamaged),
            ],
            [
                of(has_fallen_back, Fault::Clock),
                of(self.image == Image::Unchecked, Fault::ImageDamaged),
                of(self.lacks_brown_out_reset, Fault::BrownOut),
            ],
        ]
    }
}
