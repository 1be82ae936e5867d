//! A flash that holds anything: reading it changes nothing, saving succeeds, and a save that loses
//! its power leaves the old set or the new.
#![no_main]

use firmware::store::{ParameterStore, Parameters};
use host_tests::flash::{MockFlash, Tear};
use host_tests::store::{numbered, paper_set};
use libfuzzer_sys::fuzz_target;
use wire::State;

/// A sector, of which there are two. Unit: byte.
const SECTOR: usize = 1024;

fuzz_target!(|input: (u16, u8, &[u8])| {
    let (units, tear, contents) = input;
    let flash = MockFlash::<SECTOR>::with(&contents[..contents.len().min(2 * SECTOR)]);
    let mut store = ParameterStore::<_, Parameters>::new(flash.clone());
    let found = store.load();
    assert_eq!(store.load(), found);
    let after = store.into_flash();
    assert_eq!(after.bytes(), flash.bytes());

    let mut store = ParameterStore::new(after);
    let old = numbered(units.into(), paper_set());
    assert_eq!(store.save(State::Ready, &old), Ok(()));
    assert_eq!(store.load(), Ok(old.clone()));

    let mut flash = store.into_flash();
    flash.cut_after(units.into(), Tear::ALL[usize::from(tear) % Tear::ALL.len()], units.into());
    let mut store = ParameterStore::new(flash);
    let new = Parameters { tracking: None, ..old.clone() };
    let saved = store.save(State::Ready, &new);
    let mut flash = store.into_flash();
    flash.power_up();
    let kept = ParameterStore::<_, Parameters>::new(flash).load().expect("the old set was there");
    assert!(kept == new || saved.is_err() && kept == old);
});
