//! What the production image makes of its parameter store. The emulated flash is read-only: what
//! stands in it was written by the same store on the host, with the board's sectors.

use firmware::store::{ParameterStore, Parameters};
use host_tests::flash::MockFlash;
use host_tests::store::{numbered, paper_set};
use libtest_mimic::Failed;
use wire::fault::times::ALLOWANCE_TICKS;
use wire::{Configuration, Fault, Request, State, Telemetry, VERSION};

use super::bench::Bench;
use super::faults::track;

/// Unit: byte.
const SECTOR: usize = 16 * 1024;

/// The contents of a flash in which these sets were saved one after the other.
fn stored(sets: impl IntoIterator<Item = Parameters>) -> Result<Vec<u8>, Failed> {
    let mut store = ParameterStore::new(MockFlash::<SECTOR>::blank());
    for set in sets {
        store.save(State::Ready, &set).map_err(|error| format!("{error:?}"))?;
    }
    Ok(store.into_flash().bytes().to_vec())
}

pub fn starts_with_what_is_stored() -> Result<(), Failed> {
    // Enough to have filled a sector, and begun the other. Only the last set lets the host be
    // silent while it looks on.
    let sets = (1..60).map(|number| numbered(number, paper_set())).chain([numbered(1000, paper_set())]);
    let mut bench = Bench::with_store(5, &stored(sets)?)?;
    bench.make_ready(None)?;
    track(&mut bench)
}

pub fn faults() -> Result<(), Failed> {
    let golden = |name: &str| std::fs::read(format!("{}/tests/golden/{name}", env!("CARGO_MANIFEST_DIR")));
    let stores = [
        (vec![0; 2 * SECTOR], Fault::ConfigurationCorrupt),
        (golden("store_layout_65535.bin")?, Fault::ConfigurationVersion),
    ];
    for (store, fault) in stores {
        let mut bench = Bench::with_store(5, &store)?;
        bench.tick(Some)?;
        bench.assert_vented_by(fault)?;
        bench.demand(&Request::Acknowledge)?;
        let state = bench.telemetry()?.state;
        if state != State::Off {
            return Err(format!("{fault:?}: {state:?} after the acknowledgement").into());
        }
    }
    Ok(())
}

pub fn saves_in_time() -> Result<(), Failed> {
    // Both sectors with as many records as there is room for, so that all there is to be read is
    // read.
    let full = (1..90).map(|number| numbered(number, paper_set())).chain([numbered(1000, paper_set())]);
    let mut bench = Bench::with_store(5, &stored(full)?)?;
    bench.make_ready(None)?;
    let before = bench.telemetry()?.ticks;
    bench.demand_unstored(&Request::Protect(numbered(1001, paper_set()).protection))?;
    let Telemetry { state, fault, ticks, .. } = bench.telemetry()?;
    println!("saving: at most {} ticks, of {ALLOWANCE_TICKS} that a task may be silent", ticks - before);
    if (state, fault) != (State::Ready, None) {
        return Err(format!("{state:?}, {fault:?} after {} ticks", ticks - before).into());
    }
    Ok(())
}

pub fn of_a_flash_that_does_not_keep() -> Result<(), Failed> {
    let mut bench = Bench::new(5)?;
    let tracking = paper_set().tracking.ok_or("no model")?;
    bench.make_ready(Some(&Configuration { version: VERSION, tracking }))?;
    track(&mut bench)
}
