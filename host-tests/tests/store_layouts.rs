//! Stored sets of this version and of those before, as boards have written them:
//! `golden/store_layout_*.bin`.
//!
//! A failure here says that a stored set would be read otherwise than it was written. Once a layout
//! has been released, the answer is a new one (`firmware::store`); before that, `BLESS=1` rewrites
//! the file of the present layout.

use std::path::{Path, PathBuf};

use firmware::store::{
    JOINT_LAYOUT, JointParameters, LAYOUT, LoadError, ParameterStore, Parameters, Sealed, Set,
};
use host_tests::flash::MockFlash;
use host_tests::store::{calibration, joint_set, paper_set};
use model_core::extension::{DriftParameters, TransportDelayParameters, ValveLagParameters};
use wire::{BusParameters, OnModelFault, Parity, Protection, State};

const SECTOR: usize = 4096;
/// A layout that no firmware has yet.
const LATER: u16 = u16::MAX;

/// A store over the contents of a file; the rest of the flash is blank.
fn store_of<P: Set>(contents: &[u8]) -> ParameterStore<MockFlash<SECTOR>, P> {
    ParameterStore::new(MockFlash::with(contents))
}

/// That of a board with one muscle.
fn store(contents: &[u8]) -> ParameterStore<MockFlash<SECTOR>, Parameters> {
    store_of(contents)
}

fn file(layout: u16) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/golden/store_layout_{layout}.bin"))
}

fn golden(layout: u16) -> Vec<u8> {
    std::fs::read(file(layout)).expect("part of the sources")
}

/// The set in the files.
fn stored() -> Parameters {
    let protection =
        Protection { bus_silent_ticks: 250, on_model_fault: OnModelFault::Vent, ..Protection::STANDARD };
    let bus = BusParameters { unit: 17, baud: 19_200, parity: Parity::Even, turnaround_us: 2_500 };
    Parameters { protection, bus, calibration: Some(Sealed::new(calibration())), ..paper_set() }
}

/// What is written of a flash.
fn written<P: Set>(store: ParameterStore<MockFlash<SECTOR>, P>) -> Vec<u8> {
    let flash = store.into_flash();
    let end = flash.bytes().iter().rposition(|&byte| byte != 0xFF).map_or(0, |last| last + 1);
    flash.bytes()[..end].to_vec()
}

/// A set is written as it stands in the file of its layout, and read from there.
fn assert_as_ever<P: Set>(set: P) {
    let mut writing = store_of(&[]);
    assert_eq!(writing.save(State::Ready, &set), Ok(()));
    let written = written(writing);
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(file(P::LAYOUT), &written).expect("the sources can be written");
    }
    assert!(written == golden(P::LAYOUT), "layout {} has changed", P::LAYOUT);
    assert_eq!(store_of(&golden(P::LAYOUT)).load(), Ok(set));
}

#[test]
fn the_present_layout_is_written_and_read_as_ever() {
    assert_as_ever(stored());
}

#[test]
fn the_present_layout_of_a_joint_is_written_and_read_as_ever() {
    assert_as_ever(joint_set());
}

/// No set of one kind is taken for one of the other, whichever layout it has.
#[test]
fn what_another_kind_of_board_has_stored_is_told_by_its_layout_and_replaced_by_the_next_save() {
    let mut of_muscle = store(&golden(JOINT_LAYOUT));
    assert_eq!(of_muscle.load(), Err(LoadError::Layout(JOINT_LAYOUT)));
    assert_eq!(of_muscle.save(State::Fault, &stored()), Ok(()));
    assert_eq!(of_muscle.load(), Ok(stored()));
    for layout in (2..=LAYOUT).chain([LATER]) {
        let mut of_joint = store_of::<JointParameters>(&golden(layout));
        assert_eq!(of_joint.load(), Err(LoadError::Layout(layout)));
        assert_eq!(of_joint.save(State::Fault, &joint_set()), Ok(()));
        assert_eq!(of_joint.load(), Ok(joint_set()));
    }
}

/// The same set with effects beside hysteresis, and a valve's lag before them.
fn extended() -> Parameters {
    let mut set = stored();
    if let Some(tracking) = &mut set.tracking {
        tracking.extensions.valve_lag =
            Some(ValveLagParameters { lead_limit: 1.5, ..ValveLagParameters::new(0.0625) });
        tracking.extensions.transport_delay = Some(TransportDelayParameters { delay_s: 0.015625 });
        tracking.extensions.drift = Some(DriftParameters { rate_per_s: 0.125, compensated: true });
    }
    set
}

#[test]
fn the_layout_whose_valves_have_one_time_constant_is_read_as_the_same_set() {
    assert_eq!(store(&golden(6)).load(), Ok(stored()));
    assert_eq!(store(include_bytes!("golden/store_layout_6_extended.bin")).load(), Ok(extended()));
}

#[test]
fn the_layout_without_an_observer_is_read_as_the_same_set() {
    assert_eq!(store(&golden(5)).load(), Ok(stored()));
}

#[test]
fn the_layout_of_ratiometric_sensors_is_read_as_the_same_set() {
    assert_eq!(store(&golden(4)).load(), Ok(stored()));
}

#[test]
fn the_layout_whose_calibration_is_not_sealed_is_read_as_the_same_set() {
    assert_eq!(store(&golden(3)).load(), Ok(stored()));
}

#[test]
fn the_layout_without_bus_and_calibration_is_read_and_the_board_reached_as_a_new_one() {
    let expected = Parameters { bus: BusParameters::STANDARD, calibration: None, ..stored() };
    assert_eq!(store(&golden(2)).load(), Ok(expected));
}

#[test]
fn saving_what_was_loaded_brings_an_older_layout_up_to_date() {
    (2..LAYOUT).for_each(assert_is_brought_up_to_date);
}

fn assert_is_brought_up_to_date(layout: u16) {
    let mut migrated = store(&golden(layout));
    let set = migrated.load().expect("readable");
    let before = migrated.into_flash();
    let mut migrated = ParameterStore::new(before.clone());
    assert_eq!(migrated.save(State::Off, &set), Ok(()));
    assert_eq!(migrated.load(), Ok(set.clone()));
    let after = migrated.into_flash();
    assert!(after.work() > 0, "nothing was written");
    // Only once.
    let mut again = ParameterStore::new(after.clone());
    assert_eq!(again.save(State::Off, &set), Ok(()));
    assert_eq!(again.into_flash().work(), after.work());
}

#[test]
fn a_layout_of_a_later_firmware_is_reported_by_its_number_and_not_guessed_at() {
    // The record before it is of layout 2, and not taken in its place.
    assert_eq!(store(&golden(LATER)).load(), Err(LoadError::Layout(LATER)));
}
