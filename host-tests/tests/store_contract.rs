//! What the parameter store promises while the power stays.

use embedded_storage::nor_flash::NorFlash;
use firmware::store::{LoadError, ParameterStore, Parameters, SaveError};
use host_tests::flash::MockFlash;
use host_tests::store::{full_set, numbered, paper_set};
use wire::State;

const SECTOR: usize = 4096;

type Store = ParameterStore<MockFlash<SECTOR>, Parameters>;

fn store() -> Store {
    ParameterStore::new(MockFlash::blank())
}

/// The same flash after a restart.
fn restarted(store: Store) -> Store {
    ParameterStore::new(store.into_flash())
}

#[test]
fn a_board_without_a_stored_set_has_the_factorys() {
    assert_eq!(store().load(), Ok(Parameters::FACTORY));
}

#[test]
fn a_set_survives_a_restart_as_the_same_bits() {
    for set in [Parameters::FACTORY, paper_set(), full_set()] {
        let mut store = store();
        assert_eq!(store.save(State::Ready, &set), Ok(()));
        assert_eq!(restarted(store).load(), Ok(set));
    }
}

#[test]
fn a_state_that_drives_the_valve_refuses_a_save_and_the_flash_is_not_touched() {
    for state in State::ALL {
        let mut store = store();
        let saved = store.save(state, &paper_set());
        if state.is_driven() {
            assert_eq!(saved, Err(SaveError::Driven));
            assert_eq!(store.into_flash().work(), 0);
        } else {
            assert_eq!(saved, Ok(()), "{state:?}");
        }
    }
}

#[test]
fn a_set_that_is_not_of_numbers_is_refused_and_the_old_one_kept() {
    let mut store = store();
    assert_eq!(store.save(State::Ready, &paper_set()), Ok(()));
    let mut set = paper_set();
    set.tracking.iter_mut().for_each(|tracking| tracking.period_s = f32::NAN);
    assert_eq!(store.save(State::Ready, &set), Err(SaveError::NotANumber));
    assert_eq!(store.load(), Ok(paper_set()));
}

/// Records that nothing led to come to light when the space before them is filled; found by mutated
/// contents.
#[test]
fn a_record_behind_a_gap_does_not_outlive_a_save() {
    let mut store = store();
    for number in 1..=9 {
        assert_eq!(store.save(State::Ready, &numbered(number, paper_set())), Ok(()));
    }
    let mut bytes = store.into_flash().bytes().to_vec();
    let record = bytes.iter().rposition(|&byte| byte != 0xFF).expect("written") / 9;
    bytes[2 * record..7 * record].fill(0xFF);
    for number in 10..50 {
        let mut store = Store::new(MockFlash::with(&bytes));
        assert_eq!(store.save(State::Ready, &numbered(number, paper_set())), Ok(()));
        assert_eq!(store.load(), Ok(numbered(number, paper_set())));
        bytes = store.into_flash().bytes().to_vec();
    }
}

#[test]
fn a_set_that_is_stored_already_is_not_written_again() {
    let mut store = store();
    assert_eq!(store.save(State::Ready, &paper_set()), Ok(()));
    let flash = store.into_flash();
    let mut store = Store::new(flash.clone());
    assert_eq!(store.save(State::Ready, &paper_set()), Ok(()));
    assert_eq!(store.into_flash().work(), flash.work());
}

#[test]
fn reading_changes_nothing_even_after_an_interrupted_erasure() {
    // The mark at a sector's beginning is erased, that at its end is not.
    let mut flash = MockFlash::<SECTOR>::blank();
    assert_eq!(flash.write(SECTOR as u32 - 4, &[0; 4]), Ok(()));
    let mut store = Store::new(flash.clone());
    assert_eq!(store.load(), Err(LoadError::Corrupt));
    assert_eq!(store.into_flash().bytes(), flash.bytes());
}

#[test]
fn unreadable_contents_are_reported_and_replaced_by_the_next_save() {
    for byte in [0x00, 0x55] {
        let mut store = Store::new(MockFlash::with(&[byte; 2 * SECTOR]));
        assert_eq!(store.load(), Err(LoadError::Corrupt));
        assert_eq!(store.save(State::Fault, &paper_set()), Ok(()));
        assert_eq!(restarted(store).load(), Ok(paper_set()));
    }
}

#[test]
fn every_flipped_bit_of_the_newest_record_leads_back_to_the_set_before() {
    let mut store = store();
    assert_eq!(store.save(State::Ready, &numbered(1, paper_set())), Ok(()));
    let first = store.into_flash();
    let begin = first.bytes().iter().rposition(|&byte| byte != 0xFF).expect("written") / 4 * 4 + 4;
    let mut store = Store::new(first);
    assert_eq!(store.save(State::Ready, &numbered(2, paper_set())), Ok(()));
    let both = store.into_flash().bytes().to_vec();
    // The last word may end in bytes that fill it up, which say nothing.
    let end = both.iter().rposition(|&byte| byte != 0xFF).expect("written") / 4 * 4;
    for bit in begin * 8..end * 8 {
        let mut bytes = both.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(Store::new(MockFlash::with(&bytes)).load(), Ok(numbered(1, paper_set())), "bit {bit}");
    }
}

#[test]
fn a_worn_byte_moves_the_record_to_the_other_sector() {
    let mut flash = MockFlash::blank();
    flash.wear_out(40);
    let mut store = Store::new(flash);
    assert_eq!(store.save(State::Ready, &paper_set()), Ok(()));
    let flash = store.into_flash();
    assert_ne!(flash.bytes()[SECTOR..], [0xFF; SECTOR]);
    assert_eq!(Store::new(flash).load(), Ok(paper_set()));
}

#[test]
fn a_flash_that_is_worn_out_keeps_the_old_set_and_says_so() {
    let mut flash = MockFlash::blank();
    flash.wear_out(SECTOR + 40);
    let mut store = Store::new(flash);
    let kept = (1..=99).find_map(|number| match store.save(State::Ready, &numbered(number, paper_set())) {
        Ok(()) => None,
        Err(error) => Some((error, number - 1)),
    });
    let (refused, kept) = kept.expect("the good sector is full, the other one bad");
    assert!(kept > 1, "the good sector was used");
    assert_eq!(refused, SaveError::NotKept);
    assert_eq!(restarted(store).load(), Ok(numbered(kept, paper_set())));
}

#[test]
fn the_sectors_wear_evenly() {
    let mut store = store();
    let mut erased = 0;
    let mut work = 0;
    for number in 1..200 {
        assert_eq!(store.save(State::Ready, &numbered(number, paper_set())), Ok(()));
        let flash = store.into_flash();
        erased += usize::from(flash.work() - work > SECTOR);
        work = flash.work();
        store = Store::new(flash);
    }
    let records = SECTOR / (work / 200 - SECTOR * erased / 200);
    assert!(
        erased <= 200 / records + 1,
        "{erased} erasures for 199 saves of which {records} fit in a sector"
    );
}
