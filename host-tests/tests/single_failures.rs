//! A part fails while the rig is driven; `cargo run --release -p host-tests --bin single` is the
//! same with 1,000 runs.

use std::collections::BTreeMap;

use host_tests::single::{Failure, run};
use wire::Fault;

#[test]
fn whatever_part_fails_the_muscle_is_empty_in_the_promised_time() {
    let mut faults = BTreeMap::<String, Vec<Option<Fault>>>::new();
    for seed in 1..=80 {
        let end = run(seed);
        assert!(end.is_kept(), "seed {seed}: {end:?}, promised in {} ms", end.failure.within_ticks());
        faults.entry(format!("{:?}", end.failure)).or_default().push(end.fault);
    }
    assert_eq!(faults.len(), Failure::ALL.len(), "a failure is left out: {faults:?}");
    for (failure, fault) in [
        (Failure::ConverterStuck, Fault::OutputStray),
        (Failure::ReferenceHigh, Fault::ReferenceVoltage),
        (Failure::AmplifierHigh, Fault::VentIneffective),
        (Failure::RegulatorOpen, Fault::VentIneffective),
    ] {
        let of = &faults[&format!("{failure:?}")];
        assert!(of.contains(&Some(fault)), "{failure:?} is never seen by {fault:?}: {of:?}");
    }
}
