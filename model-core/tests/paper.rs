//! Tables 1 and 2 of the paper: the loop that they describe, and its round trip.

use model_core::{Hysteresis, InverseHysteresis, Invertible, Mgpi, MgpiParameters, Real, paper};

type Model<T> = Mgpi<T, { paper::SIZE }, { paper::SIZE }>;

fn parameters() -> MgpiParameters<f64, { paper::SIZE }, { paper::SIZE }> {
    paper::mgpi().expect("the tabled parameters are valid")
}

fn model<T: Real>() -> Model<T> {
    Mgpi::try_new(&parameters().convert().expect("same capacity")).expect("the tabled model is invertible")
}

/// Triangles of falling amplitude as in Fig. 8, sampled at 1 kHz with a period of 20 s, from 0.
/// Unit: bar.
fn triangles() -> impl Iterator<Item = f64> {
    [6.0, 5.0, 4.0, 3.0, 2.0, 1.0].into_iter().flat_map(|amplitude| {
        (0..20_000).map(move |k| amplitude * (1.0 - (f64::from(k) / 10_000.0 - 1.0).abs()))
    })
}

#[test]
fn the_tabled_model_reaches_123_76_mm_at_6_bar() {
    let (rest, full) = model::<f64>().output_range();
    assert!((full - 123.76).abs() < 0.005, "{full} mm");
    assert!((rest - -1.13).abs() < 0.005, "{rest} mm");
}

#[test]
fn the_first_loading_and_unloading_of_the_tabled_model_have_the_checked_values() {
    let model = model::<f64>();
    let mut state = model.rest_state();
    let mut at = |x| model.step(&mut state, x).expect("finite");
    let rising: Vec<f64> = [1.0, 2.0, 3.0, 4.0, 5.0].map(&mut at).to_vec();
    at(6.0);
    let mut falling: Vec<f64> = [5.0, 4.0, 3.0, 2.0, 1.0].map(&mut at).to_vec();
    falling.reverse();
    println!("rising {rising:.2?} mm, falling {falling:.2?} mm");
    // Computed independently, by the sums of equations (6) and (14), at exactly these pressures.
    let checked = [[16.726, 56.943, 89.044, 105.888, 117.078], [30.985, 74.463, 100.631, 113.651, 120.585]];
    for (branch, checked) in [rising, falling].iter().zip(checked) {
        for (got, checked) in branch.iter().zip(checked) {
            assert!((got - checked).abs() <= 0.001, "{got} mm, checked {checked} mm");
        }
    }
}

/// The published check values were read at the nearest of 1,000 samples a stroke: at 1.002 bar for
/// 1 bar, at 1.998 bar for 2 bar. At exactly 1 bar the falling branch is 0.1 mm lower, see the test
/// above.
#[test]
fn the_loop_sampled_every_6_mbar_has_the_check_values_within_0_05_mm() {
    let model = model::<f64>();
    let mut state = model.rest_state();
    let mut branch = |bars: &mut dyn Iterator<Item = u32>| -> Vec<(f64, f64)> {
        bars.map(|k| f64::from(k) * 0.006).map(|x| (x, model.step(&mut state, x).expect("finite"))).collect()
    };
    let rising = branch(&mut (0..=1000));
    let falling = branch(&mut (0..1000).rev());
    let nearest = |branch: &[(f64, f64)], bar: f64| {
        let distance = |sample: &&(f64, f64)| (sample.0 - bar).abs();
        branch.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("samples").1
    };
    let checked =
        [(1.0, 16.8, 31.1), (2.0, 56.9, 74.4), (3.0, 89.0, 100.6), (4.0, 105.9, 113.7), (5.0, 117.1, 120.6)];
    for (bar, up, down) in checked {
        let (got_up, got_down) = (nearest(&rising, bar), nearest(&falling, bar));
        assert!((got_up - up).abs() <= 0.05, "rising at {bar} bar: {got_up} mm, checked {up} mm");
        assert!((got_down - down).abs() <= 0.05, "falling at {bar} bar: {got_down} mm, checked {down} mm");
    }
}

#[test]
fn the_partial_sums_of_table_2_are_positive_and_the_smallest_is_the_first() {
    let smallest = model::<f64>().dead_zones().smallest_slope();
    assert!((smallest / paper::MUSCLE_LENGTH_MM - 0.1207).abs() < 1e-12, "{smallest}");
}

/// The largest pressure difference after forward and inverse over the triangles. Unit: bar.
fn round_trip_error<T: Real>() -> f64 {
    let model = model::<T>();
    let inverse = model.inverse().expect("invertible");
    let (mut state, mut inverse_state) = (model.rest_state(), inverse.rest_state());
    let error = |x: f64| {
        let x = T::from_f64(x);
        let y = model.step(&mut state, x).expect("finite");
        (inverse.step(&mut inverse_state, y).expect("finite") - x).abs().to_f64()
    };
    triangles().map(error).fold(0.0, f64::max)
}

#[test]
fn the_round_trip_over_1_khz_triangles_is_exact_to_1e_12_bar_in_double_precision() {
    let error = round_trip_error::<f64>();
    println!("round trip in f64: {error:.1e} bar");
    assert!(error < 1e-12, "{error} bar");
}

#[test]
fn the_round_trip_over_1_khz_triangles_is_exact_to_5e_5_bar_in_single_precision() {
    let error = round_trip_error::<f32>();
    println!("round trip in f32: {error:.1e} bar");
    assert!(error < 5e-5, "{error} bar");
    assert!(error > 1e-7, "{error} bar is better than single precision can be: is it single precision?");
}
