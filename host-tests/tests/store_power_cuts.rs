//! The parameter store loses power at every byte of a save, in every way that a word or a sector
//! can be left.

use firmware::store::{JointParameters, ParameterStore, Parameters, RECORD_BYTES, Set};
use host_tests::flash::{MockFlash, Tear};
use host_tests::store::{Limited, full_set, joint_set, numbered, paper_set};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wire::State;

/// A small sector, so that a few saves fill it. Unit: byte.
const SMALL: usize = 4096;
/// That of the board. Unit: byte.
const REAL: usize = 16 * 1024;

/// Sets of a kind of board that a row is made of, again and again.
trait Row: Limited {
    const OF_ROW: [fn() -> Self; 4];

    /// The `number`th of a row of sets, each unlike the others.
    fn at(number: usize) -> Self {
        numbered(number as u32, Self::OF_ROW[number % 4]())
    }
}

impl Row for Parameters {
    const OF_ROW: [fn() -> Self; 4] = [full_set, || Self::FACTORY, paper_set, paper_set];
}

impl Row for JointParameters {
    const OF_ROW: [fn() -> Self; 4] = [joint_set, || Self::NEW, joint_set, uncalibrated];
}

fn uncalibrated() -> JointParameters {
    JointParameters { calibration: None, ..joint_set() }
}

/// A flash in which the sets from 0 on were saved, one after the other.
fn history<P: Row, const SECTOR: usize>(saves: usize) -> MockFlash<SECTOR> {
    let mut store = ParameterStore::new(MockFlash::blank());
    (0..saves).for_each(|number| assert_eq!(store.save(State::Ready, &P::at(number)), Ok(())));
    store.into_flash()
}

/// What a board that starts finds; after a first save that was broken off that is a new board's
/// set.
fn found<P: Set, const SECTOR: usize>(store: &mut ParameterStore<MockFlash<SECTOR>, P>) -> P {
    store.load().unwrap_or(P::NEW)
}

/// Cuts the save of `new` after `units` of work, starts again, and saves once more.
fn cut<P: Row, const SECTOR: usize>(
    flash: &MockFlash<SECTOR>,
    old: &P,
    new: &P,
    (units, tear): (usize, Tear),
) {
    let at = || format!("{tear:?} cut after {units} bytes");
    let mut flash = flash.clone();
    flash.cut_after(units, tear, units as u64);
    let mut store = ParameterStore::new(flash);
    assert!(store.save(State::Ready, new).is_err(), "{}", at());

    let mut flash = store.into_flash();
    flash.power_up();
    let mut store = ParameterStore::new(flash);
    let kept = found(&mut store);
    assert!(kept == *old || kept == *new, "{}: neither set but {kept:?}", at());

    let further = P::at(9999);
    assert_eq!(store.save(State::Ready, &further), Ok(()), "{}", at());
    assert_eq!(store.load(), Ok(further), "{}", at());
}

/// Cuts save number `number` at every byte of its work, or every some bytes, in every way; the
/// number of cuts.
fn cut_everywhere<P: Row, const SECTOR: usize>(number: usize, every: usize) -> usize {
    let flash = history::<P, SECTOR>(number);
    let old = number.checked_sub(1).map_or(P::NEW, P::at);
    let new = P::at(number);
    let mut whole = ParameterStore::new(flash.clone());
    assert_eq!(whole.save(State::Ready, &new), Ok(()));
    let work = whole.into_flash().work() - flash.work();
    let cuts = (0..work).step_by(every).flat_map(|units| Tear::ALL.map(|tear| (units, tear)));
    cuts.map(|at| cut(&flash, &old, &new, at)).count()
}

/// From the blank flash until both sectors have been erased for a second time.
fn cut_every_save<P: Row>() {
    let cuts: usize = (0..16).map(|number| cut_everywhere::<P, SMALL>(number, 1)).sum();
    println!("{cuts} cuts, none lost");
    assert!(cuts >= 10_000);
}

#[test]
fn every_cut_of_a_save_leaves_the_old_set_or_the_new_and_a_further_save_succeeds() {
    cut_every_save::<Parameters>();
}

#[test]
fn every_cut_of_a_save_of_a_joint_leaves_the_old_set_or_the_new_and_a_further_save_succeeds() {
    cut_every_save::<JointParameters>();
}

#[test]
fn cuts_of_an_erasure_of_the_boards_sectors_leave_the_old_set_or_the_new() {
    let mut store = ParameterStore::new(MockFlash::<REAL>::blank());
    let mut erases = |number: &usize| {
        let before = store.flash().work();
        assert_eq!(store.save(State::Ready, &Parameters::at(*number)), Ok(()));
        store.flash().work() - before > REAL
    };
    // The first save erases too: nobody knows what a new flash holds. Then each sector once.
    let erasing: Vec<usize> = (0..).filter(|number| erases(number)).skip(1).take(2).collect();
    let cuts: usize = erasing.iter().map(|&number| cut_everywhere::<Parameters, REAL>(number, 13)).sum();
    println!("{cuts} cuts, none lost");
}

#[test]
fn power_that_is_lost_again_and_again_loses_no_set() {
    let mut cuts = 0;
    for seed in 0..400 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut flash = MockFlash::<SMALL>::blank();
        let mut old = Parameters::FACTORY;
        for number in 0..40 {
            let new = Parameters::at(random.random_range(1..1000));
            let is_cut = random.random_bool(0.7);
            if is_cut {
                let units = random.random_range(0..SMALL + RECORD_BYTES);
                let tear = Tear::ALL[random.random_range(0..Tear::ALL.len())];
                flash.cut_after(units, tear, seed);
            }
            let mut store = ParameterStore::new(flash);
            let saved = store.save(State::Ready, &new);
            flash = store.into_flash();
            flash.power_up();
            let mut store = ParameterStore::new(flash);
            let kept = found(&mut store);
            flash = store.into_flash();
            let at = format!("seed {seed}, save {number}: {saved:?}");
            assert!(kept == new || saved.is_err() && kept == old, "{at}");
            cuts += usize::from(saved.is_err());
            old = kept;
        }
    }
    println!("{cuts} cuts, none lost");
}
