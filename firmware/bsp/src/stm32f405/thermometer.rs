//! The processor's temperature by its factory values.
//!
//! The sensor's zero differs by up to 45 K from chip to chip (RM0090, 13.10); each chip carries its
//! codes at 30 and 110 °C, measured at 3.3 V (data sheet DS8626, "Temperature sensor calibration
//! values"). A code becomes that of a typical sensor, whose scaling is
//! [`firmware::scaling::TEMPERATURE`].

use firmware::AdcCode;
use firmware::scaling::TEMPERATURE;
use stm32f4::stm32f405::DBGMCU;

use super::memory::DEVICE;

/// Where the codes stand. Unit: °C.
const FACTORY: [(*const u16, f32); 2] =
    [(0x1FFF_7A2C as *const u16, 30.0), (0x1FFF_7A2E as *const u16, 110.0)];
/// Codes per code of a typical sensor that a working one has: 2.5 mV/K, and some 10 %.
const CREDIBLE: core::ops::RangeInclusive<f32> = 0.8..=1.25;

/// How codes become those of a typical sensor: a straight line.
pub struct Thermometer {
    slope: f32,
    zero: f32,
}

impl Thermometer {
    const TYPICAL: Self = Self { slope: 1.0, zero: 0.0 };

    /// That of this chip; a typical one, where it carries no credible values.
    pub fn of_chip(debug: &DBGMCU) -> Self {
        if debug.idcode().read().dev_id().bits() != DEVICE {
            return Self::TYPICAL;
        }
        // SAFETY: the addresses are in the system's memory of every chip of the line, aligned, and
        // never written.
        let [(cold, cold_c), (hot, hot_c)] =
            FACTORY.map(|(place, celsius)| (f32::from(unsafe { place.read_volatile() }), celsius));
        let typical = |celsius: f32| TEMPERATURE.zero_code + TEMPERATURE.codes_per_unit * celsius;
        let slope = (typical(hot_c) - typical(cold_c)) / (hot - cold);
        if CREDIBLE.contains(&slope) {
            Self { slope, zero: typical(cold_c) - slope * cold }
        } else {
            Self::TYPICAL
        }
    }

    /// The code of a typical sensor at the same temperature.
    pub fn typical(&self, code: AdcCode) -> AdcCode {
        // The conversion saturates, and cuts off towards 0; the sum makes it round.
        AdcCode((self.zero + self.slope * f32::from(code.0) + 0.5) as u16)
    }
}
