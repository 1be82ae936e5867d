//! What noise of the pressure may be taken for.

use super::*;

/// A recording whose pressure has so much more noise. Unit: bar.
fn noisier(columns: Columns, bar: f64) -> Columns {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let noise = |p: &f64| {
        let value: f64 = StandardNormal.sample(&mut rng);
        p + bar * value
    };
    let input = columns.input.iter().map(noise).collect();
    Columns { input, ..columns }
}

#[test]
fn what_a_noisy_pressure_makes_of_the_contraction_is_not_unexplained() {
    let plant = Plant::new();
    for bar in [0.01, 0.03] {
        let diagnosis = diagnosed(&noisier(plant.recorded(&hysteresis(&plant.pressure)), bar));
        assert_eq!(diagnosis.verdict, Verdict::Adequate, "{bar} bar: {:?}", diagnosis.unexplained);
    }
}
