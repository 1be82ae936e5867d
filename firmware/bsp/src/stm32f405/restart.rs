//! How an image that drives valves ends: vented, what happened recorded, the processor reset.

use wire::Fault;

use super::{memory, valve};
use crate::safe_end::SafeEnd;

/// Vents, records what happened, and resets the processor.
pub enum Restart {}

impl SafeEnd for Restart {
    fn make_safe() {
        valve::vent();
    }

    fn end(fault: Fault, detail: u32) -> ! {
        memory::seal(fault, detail);
        cortex_m::peripheral::SCB::sys_reset()
    }
}

/// The crystal has stopped: the internal oscillator has taken over, and all that measures time is
/// wrong.
pub fn on_lost_crystal() -> ! {
    cortex_m::interrupt::disable();
    Restart::make_safe();
    Restart::end(Fault::Clock, 0)
}

/// Makes all that ends an image restart it, and the image test the memory before it begins.
#[macro_export]
macro_rules! end_by_restart {
    () => {
        $crate::end_safely!($crate::stm32f405::restart::Restart);
        $crate::test_memory!();

        #[cortex_m_rt::exception]
        unsafe fn NonMaskableInt() -> ! {
            $crate::stm32f405::restart::on_lost_crystal()
        }
    };
}
