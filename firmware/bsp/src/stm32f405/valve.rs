//! The safe value of the valves' outputs, by raw registers.
//!
//! Safe is what a reset makes: the converter has let go of its pins, which resistors pull to 0 V,
//! and no pulse is made. A converter that puts out code 0 would not do: its buffer reaches 0.2 V at
//! worst (data sheet DS8626, "DAC characteristics"), which is 0.6 bar behind the amplifier. Nor
//! would it do for a converter that is stuck.
//!
//! All outputs of the board take it, both channels of the converter and the pulses, whichever are
//! used, since what hangs on them is not known.

use firmware::scaling::VENT;
use stm32f4::stm32f405::{DAC, TIM3};

/// Vents, whoever owns the output. The converter has to be clocked.
pub fn vent() {
    // SAFETY: each store is atomic, and puts out what every owner may put out at any time.
    let (converter, pulses) = unsafe { (&*DAC::ptr(), &*TIM3::ptr()) };
    converter.dhr12r1().write(|w| w.daccdhr().set(VENT.0));
    converter.cr().write(|w| w.en1().disabled().en2().disabled());
    pulses.ccr1().write(|w| w.ccr().set(VENT.0));
}
