//! What the sensors do, and what that may be taken for.

use super::*;

/// A recording whose pressure has so much more noise. Unit: bar.
pub(super) fn noisier(columns: Columns, bar: f64) -> Columns {
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

#[test]
fn what_plays_make_of_a_noisy_pressure_is_no_creep() {
    // Slow triangles of falling height over a curve without memory.
    let time_s: Vec<f64> = (0..6000).map(|row| f64::from(row) * STEP_S).collect();
    let triangle = |&t: &f64| {
        let height = 6.0 - (t / 20.0).floor();
        height * (1.0 - (0.1 * t.rem_euclid(20.0) - 1.0).abs())
    };
    let pressure: Vec<f64> = time_s.iter().map(triangle).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut noise = |y: f64| {
        let value: f64 = StandardNormal.sample(&mut rng);
        y + 0.03 * value
    };
    let output = pressure.iter().map(|p| noise(60.0 * (p / 4.0).tanh())).collect();
    let scored = vec![true; time_s.len()];
    let static_curve = Columns { time_s, input: pressure, output, scored, ..Columns::default() };
    for bar in [0.05, 0.1] {
        let diagnosis = diagnosed(&noisier(static_curve.clone(), bar).with_smooth_input());
        let Smoothing { noise, left } = diagnosis.smoothing.expect("it is noisy");
        assert!((noise / bar - 1.0).abs() < 0.1 && left < 0.3 * bar, "{noise} {left}");
        assert_eq!(names(&diagnosis), [], "{bar} bar");
    }
    assert_eq!(static_curve.with_smooth_input().smoothing, None);
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
fn a_reading_that_sticks_and_jumps_is_unexplained_and_said() {
    let plant = Plant::new();
    let mut held = 0.0_f64;
    let read = |y: &f64| {
        held = if (y - held).abs() >= 2.0 { *y } else { held };
        held
    };
    let output: Vec<f64> = hysteresis(&plant.pressure).iter().map(read).collect();
    let diagnosis = diagnosed(&plant.recorded(&output));
    assert_eq!(diagnosis.verdict, Verdict::Unexplained, "{:?}", names(&diagnosis));
    let Some(Unexplained::Slips(slips)) = diagnosis.unexplained else {
        panic!("{:?}", diagnosis.unexplained)
    };
    assert!((1.4..3.0).contains(&slips.jump), "{slips:?}");
}

#[test]
fn where_nothing_may_be_named_the_model_that_predicts_best_is_written() {
    let plant = Plant::new();
    let samples = 15;
    let late: Vec<f64> = (0..ROWS).map(|row| plant.pressure[row.saturating_sub(samples)]).collect();
    let hanging = read_where(plant.recorded(&hysteresis(&late)), |t| t.rem_euclid(7.3) > 0.6);
    let (diagnosis, extended) = diagnose_and_extend(&hanging, None, &|_, _| ()).expect("a diagnosis");
    assert!(matches!(diagnosis.unexplained, Some(Unexplained::Stuck(_))));
    assert!(diagnosis.causes.is_empty());
    let written = extended.written(&hanging, None).expect("a model");
    assert!(written.model.extensions.transport_delay.is_some(), "{:?}", written.extensions());
    assert!(written.gain.is_sure() && written.rmse < 0.8 * written.plain_rmse, "{}", written.rmse);
}

#[test]
fn the_input_as_measured_comes_back() {
    let plant = Plant::new();
    let noisy = noisier(plant.recorded(&hysteresis(&plant.pressure)), 0.1);
    let smoothed = noisy.clone().with_smooth_input();
    assert!(smoothed.smoothing.is_some() && smoothed.input != noisy.input);
    assert_eq!(smoothed.as_measured().input, noisy.input);
    assert_eq!(noisy.as_measured().input, noisy.input);
}

#[test]
fn what_a_coarse_sensor_reads_does_not_hang() {
    let plant = Plant::new();
    let mut recorded = plant.recorded(&hysteresis(&plant.pressure));
    recorded.output.iter_mut().for_each(|y| *y = (*y / 0.2).round() * 0.2);
    assert_eq!(diagnosed(&recorded).verdict, Verdict::Adequate);
}
