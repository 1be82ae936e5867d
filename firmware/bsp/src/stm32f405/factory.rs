//! The processor's temperature and reference voltage by its factory values.
//!
//! The temperature sensor's zero differs by up to 45 K from chip to chip (RM0090, 13.10), the
//! reference by 2.5 %; each chip carries its codes of the sensor at 30 and 110 °C, and of the
//! reference at 30 °C, all measured at 3.3 V (data sheet DS8626, "Temperature sensor calibration
//! values", "Internal reference voltage calibration values"). A code becomes that of a typical
//! chip, whose scalings are [`firmware::scaling::TEMPERATURE`] and
//! [`firmware::scaling::REFERENCE_CODE`].

use core::ops::RangeInclusive;

use firmware::AdcCode;
use firmware::scaling::{REFERENCE_CODE, TEMPERATURE};
use stm32f4::stm32f405::DBGMCU;

use super::memory::DEVICE;

/// Where the codes of the sensor stand. Unit: °C.
const SENSOR: [(*const u16, f32); 2] =
    [(0x1FFF_7A2C as *const u16, 30.0), (0x1FFF_7A2E as *const u16, 110.0)];
/// Where the code of the reference stands.
const REFERENCE: *const u16 = 0x1FFF_7A2A as *const u16;
/// Codes per code of a typical chip that a working one has: of the sensor 2.5 mV/K and some 10 %,
/// of the reference 1.18 to 1.24 V (table 72).
const CREDIBLE_SENSOR: RangeInclusive<f32> = 0.8..=1.25;
const CREDIBLE_REFERENCE: RangeInclusive<f32> = 0.97..=1.03;

/// How codes become those of a typical chip: a straight line.
pub struct Line {
    slope: f32,
    zero: f32,
}

impl Line {
    const SAME: Self = Self { slope: 1.0, zero: 0.0 };

    /// The code of a typical chip.
    pub fn typical(&self, code: AdcCode) -> AdcCode {
        // The conversion saturates, and cuts off towards 0; the sum makes it round.
        AdcCode((self.zero + self.slope * f32::from(code.0) + 0.5) as u16)
    }
}

/// What the maker of the chip has measured; codes as they are where that is not credible.
pub struct Factory {
    /// Of its temperature sensor.
    pub temperature: Line,
    /// Of its reference.
    pub reference: Line,
}

impl Factory {
    /// That of this chip; none in an emulator.
    pub fn of_chip(debug: &DBGMCU) -> Option<Self> {
        if debug.idcode().read().dev_id().bits() != DEVICE {
            return None;
        }
        // SAFETY: the addresses are in the system's memory of every chip of the line, aligned, and
        // never written.
        let code = |place: *const u16| f32::from(unsafe { place.read_volatile() });
        let [(cold, cold_c), (hot, hot_c)] = SENSOR.map(|(place, celsius)| (code(place), celsius));
        let typical = |celsius: f32| TEMPERATURE.zero_code + TEMPERATURE.codes_per_unit * celsius;
        let slope = (typical(hot_c) - typical(cold_c)) / (hot - cold);
        let temperature = if CREDIBLE_SENSOR.contains(&slope) {
            Line { slope, zero: typical(cold_c) - slope * cold }
        } else {
            Line::SAME
        };
        let slope = REFERENCE_CODE / code(REFERENCE);
        let reference =
            if CREDIBLE_REFERENCE.contains(&slope) { Line { slope, zero: 0.0 } } else { Line::SAME };
        Some(Self { temperature, reference })
    }
}
