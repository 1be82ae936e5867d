//! A recording that holds anything: what is accepted has a finite number in every place, and time that increases.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use workbench::recording::{Choice, Recording};
use workbench::table::Table;

fuzz_target!(|bytes: &[u8]| {
    let Ok(table) = Table::parse(Path::new("recording.csv"), bytes) else { return };
    let choices = [Choice::default(), Choice { rest_length_mm: Some(500.0), ..Choice::default() }];
    for recording in choices.iter().filter_map(|choice| Recording::of(&table, choice).ok()) {
        let time_s = &recording.drive.time_s;
        assert!(time_s.windows(2).all(|pair| pair[0] < pair[1]));
        for values in [time_s, &recording.drive.input.values, &recording.output.values] {
            assert!(
                values.len() == recording.drive.scored.len() && values.iter().all(|value| value.is_finite())
            );
        }
        assert!(recording.drive.scored.contains(&true));
    }
});
