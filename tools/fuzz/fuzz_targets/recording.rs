//! A recording that holds anything: what is accepted has a finite number in every place, and time
//! that increases.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use recording::table::Table;
use recording::table::naming::Naming;
use recording::{Choice, Recording};

fuzz_target!(|bytes: &[u8]| {
    let named = Naming {
        columns: ["time=t:ms", "pressure=p:psi", "contraction=x:nm"]
            .iter()
            .filter_map(|text| text.parse().ok())
            .collect(),
        ..Naming::default()
    };
    let choices = [
        Choice::default(),
        Choice { rest_length_mm: Some(500.0), ..Choice::default() },
        Choice { may_be_sparse: true, ..Choice::default() },
        Choice { naming: named, ..Choice::default() },
    ];
    for choice in &choices {
        let Ok(mut table) = Table::parse(Path::new("recording.csv"), bytes) else { return };
        let Ok(recording) = table.name(&choice.naming).and_then(|()| Recording::of(&table, choice)) else {
            continue;
        };
        let strict = Choice { is_strict: true, ..choice.clone() };
        assert_eq!(
            Recording::of(&table, &strict).is_ok(),
            recording.drive.notes.is_empty() && table.strictly().is_ok()
        );
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
