//! Sensors and valves of a board with two channels at a joint: the set points are voltages at PA4
//! and PA5, as that of a board with one channel is at PA4 (`analog.rs`).

use firmware::joint::{JointBoard, JointSamples};
use firmware::scaling::VENT;
use firmware::{AcquisitionError, DacCode};
use stm32f4::stm32f405::DAC;

use super::pins;
use super::scan::joint::JointScan;
use super::valve::vent;

/// Sensors and valves.
pub struct SensorsAndValves {
    scan: JointScan,
    dac: DAC,
}

impl SensorsAndValves {
    /// Both valves vented. The converter has to be clocked.
    pub fn vented(scan: JointScan, dac: DAC) -> Self {
        vent();
        Self { scan, dac }
    }
}

impl JointBoard for SensorsAndValves {
    fn read(&mut self) -> Result<JointSamples, AcquisitionError> {
        self.scan.read()
    }

    fn drive(&mut self, codes: [DacCode; 2]) {
        // No interrupt between the look and the write: one before the look is seen, one behind the
        // write vents by itself. So no write undoes what the detector's interrupt has vented.
        cortex_m::interrupt::free(|_| {
            dac_write_both(&self.dac, if pins::was_supply_low() { [VENT; 2] } else { codes });
        });
    }
}

/// Both codes by one write: no tick drives one channel by its code and the other by that of the
/// tick before.
fn dac_write_both(dac: &DAC, [a, b]: [DacCode; 2]) {
    dac.dhr12rd().write(|w| w.dacc1dhr().set(a.0).dacc2dhr().set(b.0));
    // Each channel takes its pin with the first code that drives, and lets go of it with the vented
    // one.
    dac.cr().write(|w| w.en1().bit(a != VENT).en2().bit(b != VENT));
}
