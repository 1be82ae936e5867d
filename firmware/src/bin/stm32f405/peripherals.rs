//! Sensors and valve of the board: ADC1 and channel 1 of the DAC.
//!
//! # Timing
//! A conversion takes 96 ADC clocks (84 to sample, for a source of up to 10 kΩ behind the input filter, and 12 to
//! convert): 4.6 µs at 21 MHz, 24 µs at the fall-back's 4 MHz. The two channels are converted one after the other, so
//! contraction is sampled that much later than pressure.

use firmware::scaling::VENT;
use firmware::{AcquisitionError, AdcCode, Board, DacCode, Samples};
use stm32f4::stm32f405::{ADC_COMMON, ADC1, DAC, GPIOA};

const PRESSURE_CHANNEL: u8 = 0;
const CONTRACTION_CHANNEL: u8 = 1;

/// Polls before a conversion is given up. It takes at most 768 core cycles, a poll at least 4.
const POLLS_PER_CONVERSION: u32 = 1_000;

/// The board's converters.
pub struct SensorsAndValve {
    adc: ADC1,
    dac: DAC,
}

impl SensorsAndValve {
    /// Vents the valve, then readies the ADC. The peripherals have to be clocked.
    pub fn vented(dac: DAC, adc: ADC1, adc_common: &ADC_COMMON) -> Self {
        let mut board = Self { adc, dac };
        board.drive(VENT);
        board.dac.cr().write(|w| w.en1().enabled());
        adc_common.ccr().write(|w| w.adcpre().div4());
        board.adc.smpr2().write(|w| w.smp0().cycles84().smp1().cycles84());
        board.adc.cr2().write(|w| w.adon().enabled());
        board
    }

    fn convert(&mut self, channel: u8) -> Result<AdcCode, AcquisitionError> {
        // SAFETY: the channels above exist.
        self.adc.sqr3().write(|w| unsafe { w.sq1().bits(channel) });
        self.adc.sr().modify(|_, w| w.eoc().clear_bit());
        self.adc.cr2().modify(|_, w| w.swstart().start());
        (0..POLLS_PER_CONVERSION)
            .any(|_| self.adc.sr().read().eoc().is_complete())
            .then(|| AdcCode(self.adc.dr().read().data().bits()))
            .ok_or(AcquisitionError)
    }
}

impl Board for SensorsAndValve {
    fn read(&mut self) -> Result<Samples, AcquisitionError> {
        Ok(Samples {
            pressure: self.convert(PRESSURE_CHANNEL)?,
            contraction: self.convert(CONTRACTION_CHANNEL)?,
        })
    }

    fn drive(&mut self, code: DacCode) {
        self.dac.dhr12r1().write(|w| w.daccdhr().set(code.0));
    }
}

/// Connects the pins to the peripherals, as the table of the image says.
pub fn route_pins(port: &GPIOA) {
    port.moder().modify(|_, w| {
        w.moder0().analog().moder1().analog().moder2().alternate().moder3().alternate().moder4().analog()
    });
    port.afrl().modify(|_, w| w.afrl2().af7().afrl3().af7());
}
