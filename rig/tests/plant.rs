//! What the plant claims: the valve's lag reaches the muscle, the pace is the caller's, the seed
//! decides.

use rig::parameters::{DEAD_LOAD_N, VALVE_TIME_CONSTANT_S};
use rig::plant::Plant;
use rig::sensor::{Measurement, Sensors};

fn after(command_bar: f64, duration_s: f64, steps: u32) -> Measurement {
    let mut plant = Plant::at_rest(DEAD_LOAD_N, Sensors::ideal());
    (0..steps).map(|_| plant.step(command_bar, duration_s / f64::from(steps))).last().unwrap()
}

#[test]
fn pressure_follows_a_step_of_the_command_with_the_valves_lag_and_the_muscle_follows_the_pressure() {
    let early = after(5.0, VALVE_TIME_CONSTANT_S, 50);
    assert!((early.pressure_bar / 5.0 - (1.0 - (-1.0f64).exp())).abs() < 1e-9);
    let late = after(5.0, 20.0 * VALVE_TIME_CONSTANT_S, 50);
    assert!((late.pressure_bar - 5.0).abs() < 1e-6);
    assert!(late.contraction_mm > early.contraction_mm + 10.0);
}

#[test]
fn steps_of_fifty_milliseconds_and_of_one_agree() {
    for command_bar in [0.5, 2.0, 6.0] {
        let (coarse, fine) = (after(command_bar, 0.2, 4), after(command_bar, 0.2, 200));
        let apart_mm = (coarse.contraction_mm - fine.contraction_mm).abs();
        println!("{command_bar} bar: {apart_mm:.1e} mm");
        assert!(apart_mm < 5e-3, "{apart_mm} mm at {command_bar} bar");
    }
}

#[test]
fn no_time_means_no_change() {
    let mut plant = Plant::at_rest(DEAD_LOAD_N, Sensors::ideal());
    let rest = plant.step(6.0, 0.0);
    assert_eq!(rest, plant.step(6.0, 0.0));
    assert_eq!(rest.pressure_bar, 0.0);
}

#[test]
fn same_seed_gives_the_same_run_and_another_seed_another() {
    let run = |seed| {
        let mut plant = Plant::at_rest(DEAD_LOAD_N, Sensors::noisy(seed));
        (0..100).map(|tick| plant.step(f64::from(tick % 7), 0.005)).collect::<Vec<_>>()
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}
