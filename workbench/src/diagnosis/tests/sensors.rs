//! What the sensors do, and what that may be taken for.

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

/// A recording whose contraction is read anew only where that is asked for.
fn read_where(columns: Columns, is_read: impl Fn(f64) -> bool) -> Columns {
    let mut last = 0.0;
    let reading = |(&y, &t): (&f64, &f64)| {
        last = if is_read(t) { y } else { last };
        last
    };
    let output = columns.output.iter().zip(&columns.time_s).map(reading).collect();
    Columns { output, ..columns }
}

#[test]
fn a_reading_that_hangs_now_and_then_is_unexplained_and_said() {
    let plant = Plant::new();
    let recorded = plant.recorded(&hysteresis(&plant.pressure));
    let diagnosis = diagnosed(&read_where(recorded, |t| t.rem_euclid(7.3) > 0.6));
    assert_eq!(diagnosis.verdict, Verdict::Unexplained, "{:?}", names(&diagnosis));
    assert!(matches!(diagnosis.unexplained, Some(Unexplained::Stuck(stuck)) if stuck.longest_s > 0.5));
}

#[test]
fn what_a_coarse_sensor_reads_does_not_hang() {
    let plant = Plant::new();
    let mut recorded = plant.recorded(&hysteresis(&plant.pressure));
    recorded.output.iter_mut().for_each(|y| *y = (*y / 0.2).round() * 0.2);
    assert_eq!(diagnosed(&recorded).verdict, Verdict::Adequate);
}
