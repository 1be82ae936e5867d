use super::super::Residual;
use super::*;
use crate::causes::cause;
use crate::synthetic::{Noise, held_triangles, times, triangles};

type View = for<'a> fn(&'a Excitation) -> ValveView<'a>;
type Input = fn(f64) -> f64;

/// Judges 120 s of an input with some noise, 100 rows a second, whose output is proportional.
fn judged(valve: View, temperature: Option<fn(f64) -> f64>, input: impl Fn(f64) -> f64) -> Vec<Examinable> {
    let time_s = times(12_000, 0.01);
    let mut noise = Noise::new(1);
    let input: Vec<f64> = time_s.iter().map(|&t| input(t) + noise.white(0.002)).collect();
    let output: Vec<f64> = input.iter().map(|u| 20.0 * u).collect();
    let temperature: Option<Vec<f64>> =
        temperature.map(|of| time_s.iter().map(|&t| of(t) + noise.white(0.01)).collect());
    let residual = Residual {
        time_s: &time_s,
        residual: &output,
        input: &input,
        output: &output,
        load: None,
        temperature: temperature.as_deref(),
    };
    let excitation = Excitation::of(&residual);
    examinable(&excitation, valve(&excitation), "bar")
}

fn of(judged: &[Examinable], cause: Cause) -> &Examinable {
    judged.iter().find(|judged| judged.cause == cause).expect("every cause is judged")
}

/// Triangles of 20 s, each lower than the one before.
fn falling(t: f64) -> f64 {
    (1.0 - (t / 20.0).floor() / 6.0) * triangles(t, 20.0)
}

#[test]
fn slow_triangles_alone_show_neither_delay_nor_lag_inertia_width_or_creep() {
    for input in [falling, |t: f64| triangles(t, 20.0)] {
        let judged = judged(|seen| ValveView::Beside(seen), None, input);
        for cause in [
            cause("transport_delay"),
            cause("viscous_lag"),
            cause("valve_lag"),
            cause("inertia"),
            cause("rate_dependent_width"),
            cause("creep"),
            cause("load"),
            cause("temperature"),
        ] {
            assert!(!of(&judged, cause).examinable, "{:?}", of(&judged, cause));
        }
        assert!(of(&judged, cause("valve_deadband")).examinable);
        assert!(of(&judged, cause("periodic_disturbance")).examinable);
    }
}

#[test]
fn only_alike_swings_show_drift_and_running_in() {
    let at_either_end = |t| if t < 100.0 { falling(t) } else { triangles(t, 20.0) };
    let inputs: [(Input, bool); 3] =
        [(|t| triangles(t, 20.0), true), (at_either_end, true), (falling, false)];
    for (input, shown) in inputs {
        let judged = judged(|_| ValveView::Unseen, None, input);
        for cause in [cause("drift"), cause("warm_up")] {
            assert_eq!(of(&judged, cause).examinable, shown, "{:?}", of(&judged, cause));
        }
    }
}

#[test]
fn triangles_at_two_speeds_show_delay_width_and_inertia_and_still_no_creep() {
    let judged = judged(
        |_| ValveView::Unseen,
        None,
        |t| if t < 60.0 { triangles(t, 20.0) } else { triangles(t, 2.0) },
    );
    for cause in
        [cause("transport_delay"), cause("viscous_lag"), cause("rate_dependent_width"), cause("inertia")]
    {
        assert!(of(&judged, cause).examinable, "{:?}", of(&judged, cause));
    }
    let creep = of(&judged, cause("creep"));
    assert_eq!(creep.why, "there is no hold of 1 s or more; creep needs one of 3 s at least");
}

#[test]
fn holds_show_creep_and_lag() {
    let judged = judged(|_| ValveView::Unseen, None, |t| held_triangles(t, 5.0));
    assert!(
        of(&judged, cause("creep")).why.contains("the longest 5.0 s"),
        "{:?}",
        of(&judged, cause("creep"))
    );
    assert!(of(&judged, cause("creep")).examinable && of(&judged, cause("viscous_lag")).examinable);
    assert!(!of(&judged, cause("rate_dependent_width")).examinable);
}

/// Jumps up and down again within 0.2 s, and moves by `by` in the 1.5 s after each.
fn jumping(t: f64, by: f64) -> f64 {
    match t % 3.4 {
        p if p < 0.2 => 30.0 * p,
        p if p < 1.7 => 6.0 - by * (p - 0.2) / 1.5,
        p if p < 1.9 => (6.0 - by) * (1.9 - p) / 0.2,
        p => by * (p - 1.9) / 1.5,
    }
}

#[test]
fn jumps_after_which_the_input_moves_by_little_show_creep_and_not_apart_from_a_lag() {
    let shown = |by| {
        let input = move |t| jumping(t, by);
        let time_s = times(12_000, 0.01);
        let input: Vec<f64> = time_s.iter().map(|&t| input(t)).collect();
        let residual = Residual {
            time_s: &time_s,
            residual: &input,
            input: &input,
            output: &input,
            load: None,
            temperature: None,
        };
        let excitation = Excitation::of(&residual);
        let judged = examinable(&excitation, ValveView::Unseen, "bar");
        (of(&judged, cause("creep")).clone(), inseparable(&judged, &excitation).causes)
    };
    let (creep, inseparable) = shown(0.2);
    assert_eq!(
        creep.why,
        "there is no hold of 1 s or more; but after 70 jumps the input moves by little, for 1.5 s at most"
    );
    assert!(creep.examinable && inseparable == [cause("viscous_lag"), cause("creep")], "{inseparable:?}");
    let (creep, inseparable) = shown(2.0);
    assert!(!creep.examinable && inseparable.is_empty(), "{creep:?} {inseparable:?}");
}

#[test]
fn without_a_command_beside_the_pressure_nothing_of_the_valve_shows() {
    let cases: [(View, [bool; 3]); 3] = [
        (|_| ValveView::Unseen, [false; 3]),
        (|_| ValveView::InChain, [true, false, true]),
        (|seen| ValveView::Beside(seen), [true; 3]),
    ];
    for (valve, seen) in cases {
        let judged = judged(valve, None, |t| held_triangles(t, 5.0));
        let causes = [cause("valve_lag"), cause("valve_deadband"), cause("supply_saturation")];
        assert_eq!(causes.map(|cause| of(&judged, cause).examinable), seen);
    }
}

#[test]
fn a_column_must_vary_by_more_than_its_noise_and_one_that_only_rises_is_warned_of() {
    let temperature = |of_time: fn(f64) -> f64| {
        let judged = judged(|_| ValveView::Unseen, Some(of_time), falling);
        let Examinable { examinable, why, .. } = of(&judged, cause("temperature")).clone();
        (examinable, why.contains("cannot be told from a drift"))
    };
    assert_eq!(temperature(|_| 21.0), (false, false));
    assert_eq!(temperature(|t| 21.0 + (t / 10.0).sin()), (true, false));
    assert_eq!(temperature(|t| 21.0 + 0.02 * t), (true, true));
}

#[test]
fn a_recording_in_which_nothing_moves_shows_no_loop() {
    let judged = judged(|_| ValveView::Unseen, None, |_| 3.0);
    assert!(
        !of(&judged, cause("hysteresis_shape")).examinable && !of(&judged, cause("viscous_lag")).examinable
    );
}

/// Judges triangles in kPa at these times, beside a load.
fn judged_at(time_s: &[f64], load: impl Fn(f64) -> f64) -> Vec<Examinable> {
    let input: Vec<f64> = time_s.iter().map(|&t| 100.0 * triangles(t, 4.0)).collect();
    let load: Vec<f64> = time_s.iter().map(|&t| load(t)).collect();
    let (output, load) = (input.as_slice(), Some(load.as_slice()));
    let residual = Residual { time_s, residual: output, input: &input, output, load, temperature: None };
    examinable(&Excitation::of(&residual), ValveView::Unseen, "kPa")
}

#[test]
fn three_clean_steps_of_the_load_are_no_noise_and_flicker_is() {
    let time_s = times(3000, 0.01);
    let steps = judged_at(&time_s, |t| 10.0 * (t / 10.0).floor());
    assert_eq!(
        of(&steps, cause("load")).why,
        "the load goes over 20.000 N, but steadily with time: it cannot be told from a drift"
    );
    let there_and_back = judged_at(&time_s, |t| if (10.0..20.0).contains(&t) { 20.0 } else { 0.0 });
    assert!(of(&there_and_back, cause("load")).examinable);
    let flicker = judged_at(&time_s, |t| if (t * 37.0).sin() > 0.0 { 0.1 } else { 0.0 });
    assert!(of(&flicker, cause("load")).why.contains("no more than its noise"), "{flicker:?}");
}

#[test]
fn a_limit_that_is_just_missed_does_not_look_as_if_it_were_met() {
    let slower = judged_at(&times(300, 1.0 / 19.98), |_| 0.0);
    assert!(of(&slower, cause("inertia")).why.starts_with("19.98 rows a second are too few"), "{slower:?}");
    let just = judged_at(&times(300, 0.05), |_| 0.0);
    assert!(!of(&just, cause("inertia")).why.contains("too few"), "{just:?}");
    let shorter = judged_at(&times(999, 0.01), |_| 0.0);
    assert!(
        of(&shorter, cause("periodic_disturbance")).why.starts_with("9.99 s are too short, 10 s"),
        "{shorter:?}"
    );
    let whole = judged_at(&times(1000, 0.01), |_| 0.0);
    assert!(of(&whole, cause("periodic_disturbance")).examinable);
}

#[test]
fn speeds_have_the_unit_of_the_input() {
    let judged = judged_at(&times(3000, 0.01), |_| 0.0);
    let speeds = &of(&judged, cause("rate_dependent_width")).why;
    assert!(speeds.contains(" kPa/s") && !speeds.contains("bar"), "{speeds}");
}
