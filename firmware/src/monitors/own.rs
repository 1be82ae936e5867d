//! What the board reads back of itself: the voltage at the valve's output, and the processor's
//! reference voltage, which tells the supply of both converters.
//!
//! Both converters have the same supply: a code that was written reads back as the same number,
//! whatever the supply is; a supply that is off shows at the reference only.

use wire::Fault;
use wire::fault::times::STRAY_TICKS;

use super::persistence::InARow;
use crate::board::{AdcCode, DacCode};
use crate::scaling::{REFERENCE_CODE, VENT};

/// How far a sound output may read from its code: offset 12, gain 20 and linearity 4 of the
/// converter that writes, 5 of the one that reads (data sheet DS8626, "DAC" and "ADC
/// characteristics"), rounded up. Unit: code.
pub(crate) const STRAY_CODES: u16 = 48;
/// How near the rails the converter's buffer is guaranteed to get, 0.2 V (the same). Unit: code.
const LOWEST: u16 = 248;
const HIGHEST: u16 = 4095 - LOWEST;
/// How far the supply of the converters may be off: 5 % of its regulator, and 1 % for the reference
/// over temperature. Unit: share.
pub(crate) const SUPPLY_SHARE: f32 = 0.06;
/// What the reference then reads: more where the supply is low.
const REFERENCE: [u16; 2] =
    [(REFERENCE_CODE / (1.0 + SUPPLY_SHARE)) as u16, (REFERENCE_CODE / (1.0 - SUPPLY_SHARE)) as u16];

/// What is remembered of both.
#[derive(Clone, Copy, Debug, Default)]
pub struct Own {
    output: InARow,
    reference: InARow,
}

impl Own {
    /// Takes the samples of a tick, none of what the board does not read. `out`: what was written
    /// before they were taken.
    ///
    /// # Errors
    /// One of the two has been wrong for [`STRAY_TICKS`].
    #[inline(always)]
    pub fn take(
        &mut self,
        output: Option<AdcCode>,
        reference: Option<AdcCode>,
        out: DacCode,
    ) -> Result<(), Fault> {
        let is_stray = output.is_some_and(|read| !is_written(out, read));
        if self.output.holds_for(STRAY_TICKS, is_stray) {
            return Err(Fault::OutputStray);
        }
        let [lowest, highest] = REFERENCE;
        let is_off = reference.is_some_and(|read| read.0 < lowest || read.0 > highest);
        if self.reference.holds_for(STRAY_TICKS, is_off) { Err(Fault::ReferenceVoltage) } else { Ok(()) }
    }
}

/// Whether a reading is that of a code. Between the rails and what the buffer is guaranteed to
/// reach it may be either; vented the pin is let go of, and at 0 V.
fn is_written(out: DacCode, read: AdcCode) -> bool {
    let (lowest, highest) = if out == VENT { (0, 0) } else { (out.0.min(HIGHEST), out.0.max(LOWEST)) };
    read.0 + STRAY_CODES >= lowest && read.0 <= highest + STRAY_CODES
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reading_is_that_of_its_code_within_the_converters_errors_and_the_reach_of_the_buffer() {
        let is_written = |out, read| is_written(DacCode(out), AdcCode(read));
        assert!(is_written(0, 0) && is_written(0, 48) && !is_written(0, 49));
        // A code below the buffer's reach reads as either.
        assert!(is_written(10, 10) && is_written(10, 296) && !is_written(10, 297));
        assert!(is_written(2000, 1952) && is_written(2000, 2048));
        assert!(!is_written(2000, 1951) && !is_written(2000, 2049));
        assert!(is_written(4095, 4095) && is_written(4095, 3799) && !is_written(4095, 3798));
    }

    #[test]
    fn a_supply_that_is_off_by_more_than_six_percent_is_a_fault_after_three_ticks() {
        for (volts, is_good) in [(3.3_f32, true), (3.12, true), (3.48, true), (3.09, false), (3.52, false)] {
            let reference = Some(AdcCode((REFERENCE_CODE * 3.3 / volts + 0.5) as u16));
            let mut own = Own::default();
            let seen = [0; 3].map(|_| own.take(None, reference, VENT));
            let third = if is_good { Ok(()) } else { Err(Fault::ReferenceVoltage) };
            assert_eq!(seen, [Ok(()), Ok(()), third], "{volts} V");
        }
    }
}
