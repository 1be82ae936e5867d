//! What the muscle claims about its hysteresis, on the public interface.

use rig::muscle::Muscle;
use rig::parameters::{DEAD_LOAD_N, VALVE_RANGE_BAR};

/// Contraction at the end of each straight leg between `turns_bar`, taken in steps of at most
/// `step_bar`, mm.
fn at_turns_mm(turns_bar: &[f64], step_bar: f64) -> Vec<f64> {
    let mut muscle = Muscle::at_rest(DEAD_LOAD_N);
    let legs = turns_bar.windows(2);
    legs.map(|leg| {
        let steps = ((leg[1] - leg[0]).abs() / step_bar).ceil().max(1.0);
        for step in 1..=steps as u32 {
            muscle.step(leg[0] + (leg[1] - leg[0]) * f64::from(step) / steps, DEAD_LOAD_N);
        }
        muscle.contraction_mm()
    })
    .collect()
}

/// Contraction at 1 to 5 bar on the way up from rest, and on the way back from 6 bar; and the
/// stroke, mm.
fn major_loop_mm() -> (Vec<f64>, Vec<f64>, f64) {
    let up = at_turns_mm(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0], 0.001);
    let down = up[6..].iter().rev().copied().collect();
    (up[..5].to_vec(), down, up[5])
}

#[test]
fn stroke_and_loop_are_near_the_published_muscle() {
    let (rising_mm, falling_mm, stroke_mm) = major_loop_mm();
    println!("rising {rising_mm:.1?}, falling {falling_mm:.1?}, stroke {stroke_mm:.1} mm");
    assert!((stroke_mm - 123.8).abs() < 1.0, "stroke {stroke_mm} mm");
    for (ours, published) in
        [(&rising_mm, [16.8, 56.9, 89.0, 105.9, 117.1]), (&falling_mm, [31.1, 74.4, 100.6, 113.7, 120.6])]
    {
        for (ours_mm, published_mm) in ours.iter().zip(published) {
            assert!((ours_mm - published_mm).abs() < 4.0, "{ours_mm} mm against {published_mm} mm");
        }
    }
}

#[test]
fn falling_branch_lies_above_the_rising_one_and_is_widest_below_mid_range() {
    let (rising_mm, falling_mm, _) = major_loop_mm();
    let width_mm: Vec<_> = falling_mm.iter().zip(&rising_mm).map(|(down, up)| down - up).collect();
    assert!(width_mm.iter().all(|&width_mm| width_mm > 2.0), "{width_mm:?}");
    assert!(width_mm[0].min(width_mm[1]) > 3.0 * width_mm[4], "not lopsided: {width_mm:?}");
}

#[test]
fn contraction_depends_on_the_pressures_and_not_on_how_finely_they_are_passed() {
    let turns_bar = [0.0, 4.5, 1.2, 6.0, 0.0, 3.0, 2.0, 2.8, 0.4];
    let fine_mm = at_turns_mm(&turns_bar, 0.0005);
    let worst_mm = |step_bar: f64| {
        let coarse_mm = at_turns_mm(&turns_bar, step_bar);
        fine_mm.iter().zip(coarse_mm).map(|(fine, coarse)| (fine - coarse).abs()).fold(0.0, f64::max)
    };
    println!("steps of 0.01 and 0.1 bar: {:.1e} and {:.1e} mm", worst_mm(0.01), worst_mm(0.1));
    assert!(worst_mm(0.01) < 1e-3);
    assert!(worst_mm(0.1) < 5e-3);
}

#[test]
fn inner_loops_return_to_where_they_left_within_a_quarter_of_a_millimetre_but_not_exactly() {
    let mut worst_mm: f64 = 0.0;
    for high_bar in [2.0, 3.0, 4.0, 5.0, 6.0] {
        for low_bar in [0.2, 0.5, 1.0, 1.6] {
            for middle_bar in [0.3, 0.5, 0.8].map(|share| low_bar + share * (high_bar - low_bar)) {
                let nested = at_turns_mm(&[0.0, high_bar, low_bar, middle_bar, low_bar, high_bar], 0.01);
                worst_mm = worst_mm.max((nested[1] - nested[3]).abs()).max((nested[0] - nested[4]).abs());
            }
        }
    }
    println!("worst {worst_mm:.4} mm");
    assert!((0.01..0.25).contains(&worst_mm), "{worst_mm} mm");
}

#[test]
fn wider_loop_wipes_out_what_was_inside_it() {
    let plain = at_turns_mm(&[0.0, 6.0, 0.0, 6.0, 0.0, 3.0], 0.01);
    let detour = at_turns_mm(&[0.0, 2.0, 1.0, 4.0, 3.0, 6.0, 0.0, 6.0, 0.0, 3.0], 0.01);
    let left_mm = (plain[4] - detour[8]).abs();
    assert!(left_mm < 1e-3, "{left_mm} mm left of the detour");
}

#[test]
fn loops_between_the_same_pressures_are_not_congruent() {
    // The same two pressures on the way up and, after the full range, on the way down.
    let turns =
        |low: f64, high: f64| at_turns_mm(&[0.0, high, low, high, VALVE_RANGE_BAR, low, high, low], 0.01);
    let mut worst = 0.0f64;
    for (low_bar, high_bar) in [(2.0, 4.0), (2.0, 3.0), (1.0, 2.0), (0.8, 1.6)] {
        let at = turns(low_bar, high_bar);
        let (first_mm, second_mm) = (at[2] - at[1], at[5] - at[4]);
        println!("{low_bar} to {high_bar} bar: heights {first_mm:.2} and {second_mm:.2} mm");
        worst = worst.max((second_mm / first_mm - 1.0).abs());
    }
    // Generalized Prandtl-Ishlinskii models, with one envelope or two, have equal heights to
    // rounding.
    assert!(worst > 0.02, "heights agree within {worst}");
}

#[test]
fn load_extends_the_muscle_and_costs_stroke() {
    let at_six_bar_mm = |load_n: f64| {
        let mut muscle = Muscle::at_rest(load_n);
        let rest_mm = muscle.contraction_mm();
        muscle.step(VALVE_RANGE_BAR, load_n);
        (rest_mm, muscle.contraction_mm())
    };
    let ((light_rest_mm, light_mm), (heavy_rest_mm, heavy_mm)) = (at_six_bar_mm(0.0), at_six_bar_mm(60.0));
    assert!(light_rest_mm == 0.0 && heavy_rest_mm < -10.0);
    assert!((2.0..20.0).contains(&(light_mm - heavy_mm)), "{light_mm} and {heavy_mm} mm");
}
