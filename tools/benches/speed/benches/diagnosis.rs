//! How long a diagnosis of 12,000 rows takes, extended model included, where nothing is hidden and
//! where something is: a strong fast effect beside another one takes longest. Run with `cargo bench
//! --manifest-path tools/benches/speed/Cargo.toml --bench diagnosis`, on quiet cores.

use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use diagnosis::{Columns, diagnose_and_extend};
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
/// Diagnoses of each, and the time that is expected to be enough for them.
const SAMPLES: usize = 10;
const ENOUGH: Duration = Duration::from_secs(60);

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

fn diagnoses(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("diagnosis");
    group.sample_size(SAMPLES).measurement_time(ENOUGH);
    for effects in HIDDEN {
        let case = Case { kind: Kind::Rig, effects: effects.to_vec(), strength: 1.0, seed: 1 };
        let columns = columns(&case);
        group.bench_function(case.hidden(), |bencher| {
            bencher.iter(|| diagnose_and_extend(&columns, None, &|_, _| ()).is_ok());
        });
    }
    group.finish();
}

criterion_group!(benches, diagnoses);
criterion_main!(benches);
