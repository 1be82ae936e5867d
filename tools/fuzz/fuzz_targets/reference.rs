//! A reference that holds anything: what is accepted has ticks within bounds, whose time does not
//! fall.
#![no_main]

use std::path::Path;

use board_client::pil::reference::{MOST_TICKS, Reference};
use libfuzzer_sys::fuzz_target;
use recording::Choice;
use recording::table::Table;

/// How many ticks are looked at.
const TICKS: usize = 1000;
/// How far ahead the reference is asked for too.
const AHEAD_S: f64 = 0.1;

fuzz_target!(|bytes: &[u8]| {
    let Ok(table) = Table::parse(Path::new("reference.csv"), bytes) else { return };
    let Ok(reference) = Reference::of(&table, "reference_mm", Choice::default(), 1000.0) else { return };
    assert!((1..=MOST_TICKS).contains(&reference.ticks()));
    let times: Vec<f64> = reference.samples(AHEAD_S).take(TICKS).map(|wanted| wanted.time_s).collect();
    assert_eq!(times.len(), reference.ticks().min(TICKS));
    assert!(times.is_sorted());
});
