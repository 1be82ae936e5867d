//! Bring-up of a new board: what each part has to show, and the report of a run as lines of
//! [`wire::bring_up`].
//!
//! # Limits
//! A part is within its limits or not: the limits are those of the parts' data sheets or those that
//! the control itself holds its inputs to, so that a board that passes has no fault in service.
//! Nothing here tells how accurate a sensor is; that is what the calibration is for.

use core::fmt::Write;

use crc::{Crc, Digest};
use heapless::String;
use wire::Scaling;
use wire::bring_up::{CHECKSUM, END, FAULTY, GOOD, LINE_BYTES, NONE};

use crate::DacCode;
use crate::monitors::own::{STRAY_CODES, SUPPLY_SHARE};
use crate::scaling::{CONTRACTION, PRESSURE, REFERENCE_CODE, REFERENCE_SUPPLY_V, SUPPLY};

/// The highest code of a converter.
const FULL_CODE: f32 = 4095.0;
/// One standard deviation of a conversion. Sound boards with this processor are said to differ by
/// three to six codes at most; a deviation as large as the largest of these is a layout's or a
/// supply's. Unit: code.
const NOISE_CODES: [f32; 2] = [0.0, 6.0];
/// What reads back of the output: as in service. Unit: V.
const STRAY_V: f32 = STRAY_CODES as f32 / FULL_CODE * REFERENCE_SUPPLY_V;

/// A part that is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// With the unit at its end.
    pub name: &'static str,
    /// Lowest and highest value of a sound one.
    pub limits: [f32; 2],
    /// Digits behind the point.
    pub digits: usize,
}

impl Part {
    const fn new(name: &'static str, limits: [f32; 2], digits: usize) -> Self {
        Self { name, limits, digits }
    }

    /// Whether a value is within the limits.
    pub fn admits(&self, value: f32) -> bool {
        let [lowest, highest] = self.limits;
        value >= lowest && value <= highest
    }

    const fn input(name: &'static str, scaling: &Scaling) -> Self {
        Self::new(name, [scaling.code_min as f32, scaling.code_max as f32], 1)
    }
}

/// Flash of the processor. Unit: KB.
pub const FLASH_SIZE: Part = Part::new("flash_size_kb", [1024.0, 1024.0], 0);
/// Level of the brown-out reset in the option bytes: 3 is the one that this board needs.
pub const BROWN_OUT_LEVEL: Part = Part::new("brown_out_level", [3.0, 3.0], 0);
/// Supply of the converters, by the reference voltage.
pub const SUPPLY_V: Part = Part::new(
    "converter_supply_v",
    [REFERENCE_SUPPLY_V * (1.0 - SUPPLY_SHARE), REFERENCE_SUPPLY_V * (1.0 + SUPPLY_SHARE)],
    3,
);
/// The crystal against the internal oscillator of 16 MHz, which is within 4 % from -10 to 85 °C
/// (data sheet DS8626, "HSI oscillator characteristics").
pub const CRYSTAL_HZ: Part = Part::new("crystal_hz", [7_680_000.0, 8_320_000.0], 0);
/// The watchdog's oscillator against the processor's clock (DS8626, "LSI oscillator
/// characteristics").
pub const WATCHDOG_HZ: Part = Part::new("watchdog_oscillator_hz", [17_000.0, 47_000.0], 0);
/// The processor's temperature in a room. Unit: °C.
pub const TEMPERATURE_C: Part = Part::new("processor_temperature_c", [5.0, 60.0], 1);
/// The sensors at rest: plausible codes.
pub const PRESSURE_CODE: Part = Part::input("pressure_code", &PRESSURE);
/// As above.
pub const CONTRACTION_CODE: Part = Part::input("contraction_code", &CONTRACTION);
/// As above.
pub const SUPPLY_CODE: Part = Part::input("supply_pressure_code", &SUPPLY);
/// Noise of a single conversion over a quarter of a second, hum included.
pub const PRESSURE_NOISE: Part = Part::new("pressure_noise_codes", NOISE_CODES, 2);
/// As above.
pub const CONTRACTION_NOISE: Part = Part::new("contraction_noise_codes", NOISE_CODES, 2);
/// As above.
pub const SUPPLY_NOISE: Part = Part::new("supply_pressure_noise_codes", NOISE_CODES, 2);
/// The valve's output, vented.
pub const VENTED_V: Part = Part::new("output_vented_v", [0.0, STRAY_V], 3);
/// The same behind all that was driven.
pub const VENTED_AGAIN_V: Part = Part::new("output_vented_again_v", [0.0, STRAY_V], 3);
/// The output by these codes, and how far it reads from them.
pub const DRIVEN: [(DacCode, Part); 3] = [
    (DacCode(512), Part::new("output_low_error_codes", DRIVEN_CODES, 1)),
    (DacCode(2048), Part::new("output_middle_error_codes", DRIVEN_CODES, 1)),
    (DacCode(3584), Part::new("output_high_error_codes", DRIVEN_CODES, 1)),
];
const DRIVEN_CODES: [f32; 2] = [-(STRAY_CODES as f32), STRAY_CODES as f32];
/// Bytes that the bus has heard of those that it has sent. Unit: byte.
pub const ECHO_BYTES: Part = Part::new("bus_echo_bytes", [16.0, 16.0], 0);
/// What is sent for that.
pub const ECHO_PATTERN: [u8; 16] = *b"\x00\xFF\x55\xAA\x01\x02\x04\x08\x10\x20\x40\x80\x7F\xFE\x0F\xF0";
/// Words of the sector that do not keep what is programmed, or are not blank when erased.
pub const FLASH_WORDS: Part = Part::new("flash_wrong_words", [0.0, 0.0], 0);
/// Time to erase a sector of 16 KB (DS8626, "Flash memory programming"), the longer of two. Unit:
/// ms.
pub const ERASE_MS: Part = Part::new("flash_erase_ms", [1.0, 500.0], 1);
/// Time to program a word, the mean of a sector's (as above). Unit: µs.
pub const PROGRAM_US: Part = Part::new("flash_program_us", [1.0, 100.0], 1);

/// The converters' supply by the reference, as a typical processor reads it. Unit: V.
pub fn supply_v(reference: f32) -> f32 {
    REFERENCE_SUPPLY_V * REFERENCE_CODE / reference
}

/// What a code at the output's pin is. Unit: V.
pub fn volts(code: f32, supply_v: f32) -> f32 {
    code / FULL_CODE * supply_v
}

/// Mean and standard deviation of codes, gathered one by one.
#[derive(Clone, Copy, Debug, Default)]
pub struct Codes {
    count: f32,
    mean: f32,
    squares: f32,
}

impl Codes {
    /// Takes one (Welford's recursion).
    pub fn take(&mut self, code: u16) {
        self.count += 1.0;
        let off = f32::from(code) - self.mean;
        self.mean += off / self.count;
        self.squares += off * (f32::from(code) - self.mean);
    }

    /// Their mean; none of none.
    pub fn mean(&self) -> Option<f32> {
        (self.count > 0.0).then_some(self.mean)
    }

    /// One standard deviation; none of fewer than two.
    pub fn deviation(&self) -> Option<f32> {
        (self.count > 1.0).then(|| libm::sqrtf(self.squares / (self.count - 1.0)))
    }
}

/// The report of a run, a line at a time.
pub struct Report {
    digest: Digest<'static, u32>,
    parts: u32,
    faulty: u32,
}

/// A line of the report, with its end.
pub type ReportLine = String<LINE_BYTES>;

/// Kept, since a digest borrows it.
static CRC: Crc<u32> = CHECKSUM;

impl Default for Report {
    /// Of nothing yet.
    fn default() -> Self {
        Self { digest: CRC.digest(), parts: 0, faulty: 0 }
    }
}

impl Report {
    /// A part that was measured; none where it could not be, which is a fault.
    pub fn number(&mut self, part: &Part, value: Option<f32>) -> ReportLine {
        let Part { name, limits: [lowest, highest], digits } = *part;
        let is_good = value.is_some_and(|value| part.admits(value));
        let mut line = ReportLine::new();
        // None of the lines is longer than its room.
        let _ = match value {
            Some(value) => write!(line, "{name} {value:.digits$} {lowest:.digits$} {highest:.digits$}"),
            None => write!(line, "{name} {NONE} {lowest:.digits$} {highest:.digits$}"),
        };
        self.end_of(line, is_good)
    }

    /// A part that is told by a word.
    pub fn word(&mut self, name: &str, word: &str, is_good: bool) -> ReportLine {
        let mut line = ReportLine::new();
        let _ = write!(line, "{name} {word} {NONE} {NONE}");
        self.end_of(line, is_good)
    }

    fn end_of(&mut self, mut line: ReportLine, is_good: bool) -> ReportLine {
        let _ = writeln!(line, " {}", if is_good { GOOD } else { FAULTY });
        self.parts += 1;
        self.faulty += u32::from(!is_good);
        self.digest.update(line.as_bytes());
        line
    }

    /// The last line.
    pub fn end(self) -> ReportLine {
        let mut line = ReportLine::new();
        let checksum = self.digest.finalize();
        let _ = writeln!(line, "{END} {} {} {checksum:08x}", self.parts, self.faulty);
        line
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::string::String;

    use super::*;

    #[test]
    fn a_value_at_its_limit_is_good_and_one_beyond_or_missing_is_a_fault() {
        let mut report = Report::default();
        let mut text = String::new();
        text += &report.number(&WATCHDOG_HZ, Some(17_000.0));
        text += &report.number(&WATCHDOG_HZ, Some(47_001.0));
        text += &report.number(&CRYSTAL_HZ, None);
        text += &report.number(&SUPPLY_V, Some(f32::NAN));
        text += &report.word("reset_cause", "power_on", true);
        let checksum = CHECKSUM.checksum(text.as_bytes());
        text += &report.end();
        let lines = [
            "watchdog_oscillator_hz 17000 17000 47000 ok",
            "watchdog_oscillator_hz 47001 17000 47000 FAULT",
            "crystal_hz - 7680000 8320000 FAULT",
            "converter_supply_v NaN 3.102 3.498 FAULT",
            "reset_cause power_on - - ok",
            &std::format!("end 5 3 {checksum:08x}"),
        ];
        assert!(text.lines().eq(lines), "{text}");
    }

    #[test]
    fn mean_and_deviation_are_those_of_the_codes() {
        let mut codes = Codes::default();
        assert_eq!((codes.mean(), codes.deviation()), (None, None));
        [2, 4, 4, 4, 5, 5, 7, 9].iter().for_each(|&code| codes.take(code));
        assert_eq!(codes.mean(), Some(5.0));
        let expected = (32.0_f32 / 7.0).sqrt();
        assert!(codes.deviation().is_some_and(|deviation| (deviation - expected).abs() < 1e-6));
    }

    #[test]
    fn the_supply_is_that_by_which_the_reference_reads_so() {
        assert!((supply_v(REFERENCE_CODE) - 3.3).abs() < 1e-6);
        assert!((supply_v(REFERENCE_CODE * 3.3 / 3.0) - 3.0).abs() < 1e-5);
    }

    #[test]
    fn every_line_has_room() {
        let parts = [
            FLASH_SIZE,
            BROWN_OUT_LEVEL,
            SUPPLY_V,
            CRYSTAL_HZ,
            WATCHDOG_HZ,
            TEMPERATURE_C,
            PRESSURE_CODE,
            CONTRACTION_CODE,
            SUPPLY_CODE,
            PRESSURE_NOISE,
            CONTRACTION_NOISE,
            SUPPLY_NOISE,
            VENTED_V,
            VENTED_AGAIN_V,
            ECHO_BYTES,
            FLASH_WORDS,
            ERASE_MS,
            PROGRAM_US,
        ];
        for part in parts.iter().chain(DRIVEN.iter().map(|(_, part)| part)) {
            assert!(Report::default().number(part, Some(-4.2e9)).ends_with('\n'), "{part:?}");
        }
    }
}
