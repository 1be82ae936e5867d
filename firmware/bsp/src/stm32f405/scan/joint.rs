//! The inputs of a board with two channels at a joint: both pressures and the angle five times in
//! turn and the second output once by the regular group, what is left by the injected one. They
//! take as long as those of a board with one channel.

use firmware::joint::JointSamples;
use firmware::{AcquisitionError, AdcCode};
use stm32f4::stm32f405::{ADC_COMMON, ADC1, DBGMCU, DMA2};

use super::{CONTRACTION, CONVERSIONS, ONCE, PRESSURE, RING, Scan, Sequence, is_complete};

/// Pressure b at PC1; the angle is where a board with one channel has the contraction, PA1.
const PRESSURE_B: u8 = 11;
/// The second output, PA5.
const OUTPUT_B: u8 = 5;
/// Conversions of each input that a tick is given the mean of.
const IN_TURN: usize = 5;
const INPUTS: [u8; 3] = [PRESSURE, CONTRACTION, PRESSURE_B];
/// The place of the second output in the regular group, behind all others.
const LAST: usize = IN_TURN * INPUTS.len();

const SEQUENCE: Sequence = {
    let mut regular = [OUTPUT_B; 2 * CONVERSIONS];
    let mut place = 0;
    while place < LAST {
        regular[place] = INPUTS[place % INPUTS.len()];
        place += 1;
    }
    Sequence { regular, once: ONCE }
};

/// The running converter.
pub struct JointScan(Scan);

impl JointScan {
    /// As [`Scan::new`].
    pub fn new(adc: ADC1, common: &ADC_COMMON, dma: DMA2, debug: &DBGMCU) -> Self {
        Self(Scan::ready(adc, common, dma, debug, &SEQUENCE))
    }

    /// The samples that were converted for this tick.
    ///
    /// # Errors
    /// There are none that are newer than those of the tick before.
    pub fn read(&mut self) -> Result<JointSamples, AcquisitionError> {
        let Scan { adc, dma, factory } = &self.0;
        if !is_complete(adc, dma) {
            return Err(AcquisitionError);
        }
        let mut sums = [0; INPUTS.len()];
        for turn in 0..IN_TURN {
            for (input, sum) in sums.iter_mut().enumerate() {
                *sum += half(turn * INPUTS.len() + input);
            }
        }
        let [a, angle, b] = sums.map(|sum| AdcCode(((sum + IN_TURN as u32 / 2) / IN_TURN as u32) as u16));
        let own = |register: usize| AdcCode(adc.jdr(register).read().jdata().bits());
        let factory = factory.as_ref();
        Ok(JointSamples {
            pressures: [a, b],
            angle,
            supply: own(2),
            temperature: factory.map_or(own(0), |factory| factory.temperature.typical(own(0))),
            outputs: factory.map(|_| [own(3), AdcCode(half(LAST) as u16)]),
            reference: factory.map(|factory| factory.reference.typical(own(1))),
        })
    }
}

/// What the DMA has written at a place of the regular group.
fn half(place: usize) -> u32 {
    RING.word(place / 2) >> (16 * (place % 2)) & 0xFFFF
}
