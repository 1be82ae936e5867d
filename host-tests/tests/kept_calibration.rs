//! A calibration that was kept is used as it was written, or not at all.

use firmware::scaling::Scalings;
use firmware::store::Sealed;
use firmware::{BlackBox, Capture, Control};
use host_tests::store::calibration as lines;
use wire::{Calibration, Fault, State};

fn control() -> Control {
    Control::simulated(Box::leak(Box::new(BlackBox::new())), Box::leak(Box::new(Capture::new())))
}

/// As it stands in a record.
fn bytes(sealed: &Sealed) -> Vec<u8> {
    postcard::to_slice(sealed, &mut [0; 128]).expect("fits").to_vec()
}

#[test]
fn a_calibration_that_was_kept_is_used() {
    let mut control = control();
    control.recall(&Sealed::new(lines()));
    assert_eq!((control.scalings().calibration(), control.fault()), (lines(), None));
}

#[test]
fn one_with_any_bit_lost_is_a_fault_and_the_standard_scalings_stay() {
    let whole = bytes(&Sealed::new(lines()));
    let mut tried = 0;
    for bit in 0..8 * whole.len() {
        let mut damaged = whole.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        // Whole numbers are of as many bytes as they need: some bits make another length of them.
        let Ok((sealed, [])) = postcard::take_from_bytes::<Sealed>(&damaged) else { continue };
        tried += 1;
        let mut control = control();
        control.recall(&sealed);
        assert_eq!((control.state(), control.fault()), (State::Fault, Some(Fault::CalibrationCorrupt)));
        assert_eq!(control.scalings(), &Scalings::STANDARD, "bit {bit}");
    }
    assert!(tried > 8 * whole.len() * 3 / 4, "{tried} of {} bits", 8 * whole.len());
}

#[test]
fn one_of_no_working_sensor_is_a_fault_though_its_checksum_fits() {
    let mut wrong = lines();
    wrong.pressure.codes_per_unit *= 2.0;
    let mut control = control();
    control.recall(&Sealed::new(wrong));
    assert_eq!(control.fault(), Some(Fault::CalibrationCorrupt));
}

#[test]
fn the_checksum_of_another_calibration_seals_none() {
    let other = Calibration { day: 1, ..lines() };
    assert_eq!(Sealed::under(lines(), other.checksum()), None);
    assert_eq!(Sealed::under(lines(), lines().checksum()), Some(Sealed::new(lines())));
}
