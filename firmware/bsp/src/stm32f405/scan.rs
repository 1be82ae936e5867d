//! The analogue inputs: ADC1's injected group, started by a timer, finished before the tick asks.
//!
//! # Design
//! TIM2 runs at the tick's rate, shifted so that its period ends a scan and a tenth before the tick
//! is due. That starts the four conversions, each of which has a data register of its own; the tick
//! looks whether the last is finished, and never waits. Both clocks come from one oscillator, so
//! that the shift stays.
//!
//! # Timing
//! Temperature first, which needs 480 ADC clocks to settle; then supply, pressure and contraction
//! with 84, for a source of up to 10 kΩ behind the input filter; 12 more each to convert. That is
//! 780 clocks, 37 µs at 21 MHz, 195 µs at the fall-back's 4 MHz. Contraction is sampled 4.6 µs
//! after pressure.

use firmware::{AcquisitionError, AdcCode, Samples};
use model_core::Surroundings;
use stm32f4::stm32f405::{ADC_COMMON, ADC1, TIM2};

use super::clock::Clocks;
use super::thermometer::Thermometer;

/// In the order of conversion: the processor's temperature, then PC0, PA0 and PA1.
const CHANNELS: [u8; 4] = [16, 10, 0, 1];
/// From the start of the first conversion to the end of the last, and a tenth more. Unit: ADC
/// clock.
const SCAN_CLOCKS: u32 = 860;
/// Of the peripheral clock that feeds the converter.
const ADC_DIVIDER: u32 = 4;
/// What stands for samples when there are none: no code of 12 bits.
const NOTHING: u64 = u64::MAX;

/// The running converter.
pub struct Scan {
    adc: ADC1,
    thermometer: Thermometer,
}

impl Scan {
    /// Readies the converter; [`start`](Self::start) lets it run. It has to be clocked.
    pub fn new(adc: ADC1, common: &ADC_COMMON, thermometer: Thermometer) -> Self {
        common.ccr().write(|w| w.adcpre().div4().tsvrefe().enabled());
        adc.cr1().write(|w| w.scan().enabled());
        adc.smpr1().write(|w| w.smp16().cycles480().smp10().cycles84());
        adc.smpr2().write(|w| w.smp0().cycles84().smp1().cycles84());
        let [first, second, third, fourth] = CHANNELS;
        // SAFETY: the channels exist.
        adc.jsqr().write(|w| unsafe {
            w.jl().set(3).jsq1().bits(first).jsq2().bits(second).jsq3().bits(third).jsq4().bits(fourth)
        });
        adc.cr2().write(|w| w.adon().enabled().jextsel().tim2trgo().jexten().rising_edge());
        Self { adc, thermometer }
    }

    /// Starts the timer that starts the conversions; the clock of the tick has to be started right
    /// after.
    pub fn start(timer: &TIM2, clocks: &Clocks, ticks_per_second: u32) {
        let period = clocks.timer_hz / ticks_per_second;
        let lead = SCAN_CLOCKS * ADC_DIVIDER * (clocks.timer_hz / 1000) / (clocks.fast_bus_hz / 1000);
        timer.arr().write(|w| w.arr().set(period - 1));
        timer.cnt().write(|w| w.cnt().set(lead));
        timer.cr2().write(|w| w.mms().update());
        timer.cr1().write(|w| w.cen().enabled());
    }

    /// The samples that were converted for this tick.
    pub fn read(&mut self) -> Result<Samples, AcquisitionError> {
        match adc_scan(&self.adc) {
            NOTHING => Err(AcquisitionError),
            packed => {
                let code = |place: u32| AdcCode((packed >> (16 * place)) as u16);
                Ok(Samples {
                    temperature: self.thermometer.typical(code(0)),
                    supply: code(1),
                    pressure: code(2),
                    contraction: code(3),
                    // This board measures neither.
                    surroundings: Surroundings { load: None, temperature: None },
                })
            }
        }
    }
}

/// The four codes in the order of [`CHANNELS`], 16 bits each, the first lowest; or [`NOTHING`].
///
/// Never inlined, and with a name of its own, so that a debugger can put other values in its place:
/// the emulator has no converter.
// SAFETY: nothing else in the image has this name.
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn adc_scan(adc: &ADC1) -> u64 {
    if adc.sr().read().jeoc().bit_is_clear() {
        return NOTHING;
    }
    // The bits of the register are cleared by zeros and kept by ones.
    adc.sr().modify(|_, w| w.jeoc().clear_bit());
    let code = |register: usize| u64::from(adc.jdr(register).read().jdata().bits());
    code(0) | code(1) << 16 | code(2) << 32 | code(3) << 48
}
