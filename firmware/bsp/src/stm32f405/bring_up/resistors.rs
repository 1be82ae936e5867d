//! The resistors of 10 kΩ that keep outputs low while the processor is in a reset: a pull-up
//! inside, of 30 to 50 kΩ (data sheet DS8626, "I/O static characteristics"), makes at most 0.83 V
//! of them, which reads as low, and a high of a pin without one.
//!
//! # Safety
//! The pins stay inputs. What hangs on one without a resistor sees a high for some microseconds:
//! the bus's driver, and a coil's; the dump valve's charge pump needs changes, and stays without.

use stm32f4::stm32f405::{GPIOA, GPIOB};

/// Cycles until a pin has settled: 50 kΩ and 100 pF are 5 µs.
const SETTLING_CYCLES: u32 = 5_000;

/// Outputs that have to be low in a reset, by their pins, and whether each is: PA6, PA8, PB13. To
/// be called before any of them is made an output.
pub fn keep_low() -> [(&'static str, bool); 3] {
    // SAFETY: nobody else has begun to use the ports, and what is changed is put back.
    let (a, b) = unsafe { (&*GPIOA::ptr(), &*GPIOB::ptr()) };
    a.pupdr().modify(|_, w| w.pupdr6().pull_up().pupdr8().pull_up());
    b.pupdr().modify(|_, w| w.pupdr13().pull_up());
    cortex_m::asm::delay(SETTLING_CYCLES);
    let (of_a, of_b) = (a.idr().read(), b.idr().read());
    a.pupdr().modify(|_, w| w.pupdr6().floating().pupdr8().floating());
    b.pupdr().modify(|_, w| w.pupdr13().floating());
    [
        ("pulse_output_resistor", of_a.idr6().bit_is_clear()),
        ("bus_driver_resistor", of_a.idr8().bit_is_clear()),
        ("dump_output_resistor", of_b.idr13().bit_is_clear()),
    ]
}
