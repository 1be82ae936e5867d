//! The valve's output as pulses, with the feature `solenoid`: TIM3, 20 kHz at PA6, for the driver
//! of a coil.

use core::convert::Infallible;

use embedded_hal::pwm::{ErrorType, SetDutyCycle};
use firmware::board::pwm_valve::PwmValve;
use stm32f4::stm32f405::{DAC, TIM3};

use super::valve::vent;

/// Unit: Hz.
const PULSES_PER_SECOND: u32 = 20_000;

/// The output.
pub type Output = PwmValve<Pulses>;

/// The timer that makes the pulses.
pub struct Pulses {
    timer: TIM3,
    period: u16,
}

/// Whether the output is read back: the coil hangs on another pin than the converter's.
pub const IS_READ_BACK: bool = false;

/// Without pulses, the voltage output too at its safe value. The timer has to be clocked, by
/// `timer_hz`.
pub fn vented(_: DAC, timer: TIM3, timer_hz: u32) -> Output {
    let period = (timer_hz / PULSES_PER_SECOND) as u16;
    timer.arr().write(|w| w.arr().set(period - 1));
    vent();
    // With a preload: a duty cycle that changes in the middle of a period would else make a second
    // pulse, or none.
    timer.ccmr1_output().write(|w| w.oc1m().pwm_mode1().oc1pe().enabled());
    timer.ccer().write(|w| w.cc1e().set_bit());
    timer.cr1().write(|w| w.cen().enabled());
    PwmValve(Pulses { timer, period })
}

impl ErrorType for Pulses {
    type Error = Infallible;
}

impl SetDutyCycle for Pulses {
    fn max_duty_cycle(&self) -> u16 {
        self.period
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.timer.ccr1().write(|w| w.ccr().set(duty));
        Ok(())
    }
}
