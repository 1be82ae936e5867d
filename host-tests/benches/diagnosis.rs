//! How long a diagnosis of 12,000 rows takes, extended model included, where nothing is hidden and
//! where something is: a strong fast effect beside another one takes longest. Run with `cargo bench
//! -p host-tests --bench diagnosis`, on quiet cores.

use diagnosis::{Columns, diagnose_and_extend};
use divan::Bencher;
use host_tests::game::case::Case;
use recording::unit::Unit;
use rig::effect::Effect;
use rig::plant::Kind;

/// What is hidden in turn.
const HIDDEN: [&[Effect]; 8] = [
    &[],
    &[Effect::Creep],
    &[Effect::ViscousLag],
    &[Effect::Inertia],
    &[Effect::TransportDelay, Effect::ViscousLag],
    &[Effect::Inertia, Effect::Creep],
    &[Effect::Inertia, Effect::RateDependentWidth],
    &[Effect::ViscousLag, Effect::RateDependentWidth],
];
/// Diagnoses of each.
const SAMPLES: u32 = 10;

fn main() {
    divan::main();
}

/// What the tool reads out of the game's recording.
fn columns(case: &Case) -> Columns {
    let rows = case.recording();
    let of = |value: fn(&rig::recording::Row) -> f64| -> Vec<f64> { rows.iter().map(value).collect() };
    Columns {
        time_s: of(|row| row.time_s),
        input: of(|row| row.measured.pressure_bar),
        input_unit: Unit::BAR,
        output_unit: Unit::MM,
        input_is_command: false,
        command: Some(of(|row| row.command_bar)),
        output: of(|row| row.measured.contraction_mm),
        scored: vec![true; rows.len()],
        load_n: Some(of(|row| row.measured.load_n)),
        temperature_c: Some(of(|row| row.measured.temperature_c)),
        past_unknown_until_s: None,
        smoothing: None,
        measured_input: None,
        drop_outs: Vec::new(),
    }
}

/// A recording in which so much is hidden, as the game makes it.
fn case(effects: &[Effect]) -> Case {
    Case { kind: Kind::Rig, effects: effects.to_vec(), strength: 1.0, seed: 1 }
}

#[divan::bench(args = HIDDEN.map(|effects| case(effects).hidden()), sample_count = SAMPLES, sample_size = 1)]
fn diagnoses(bencher: Bencher, hidden: &str) {
    let effects = HIDDEN.into_iter().find(|effects| case(effects).hidden() == hidden);
    let columns = columns(&case(effects.expect("one of them")));
    bencher.bench_local(|| diagnose_and_extend(&columns, None, &|_, _| ()).is_ok());
}
