//! Adaptation on the board: what it learns, keeps and does not learn, on the bench.

use firmware::adaptation::Told;
use firmware::scaling::CONTRACTION;
use host_tests::bench::Bench;
use host_tests::configuration;
use model_core::adaptation::Change;
use model_core::{Mode, ModelParameters, paper};
use wire::registers::Learning;
use wire::{Configuration, Fault, Protection, Request, State};

/// Of the reference. Unit: tick.
const CYCLE: u32 = 10_000;

fn paper_configuration() -> Configuration {
    configuration(&ModelParameters::Cascade(paper::mgpi().expect("valid")))
}

/// A board that tracks by the inverse alone, and whose valve gives 6 % too little.
fn board(learning: Learning) -> Bench {
    let mut bench = Bench::new(3);
    bench.wrong.leak = -0.06;
    bench.start(Protection::STANDARD, &paper_configuration(), Mode::FeedforwardOnly);
    bench.control().adaptation().switch(learning);
    bench
}

/// Follows a raised cosine for so many cycles; answers the root mean square error of the last
/// one. Unit: mm.
fn follow(bench: &mut Bench, cycles: u32) -> f64 {
    let mut squares = 0.0;
    for tick in 0..cycles * CYCLE {
        let turns = f64::from(tick) / f64::from(CYCLE);
        let wanted_mm = 15.0 + 40.0 * (1.0 - (std::f64::consts::TAU * turns).cos());
        bench.reference_mm = wanted_mm;
        bench.tick();
        if tick >= (cycles - 1) * CYCLE {
            squares += (f64::from(CONTRACTION.value(bench.samples().contraction.0)) - wanted_mm).powi(2);
        }
    }
    (squares / f64::from(CYCLE)).sqrt()
}

fn change(bench: &mut Bench) -> Change<f32> {
    bench.control().learnt().change
}

#[test]
fn a_board_that_learns_follows_a_valve_that_gives_too_little_and_keeps_what_it_has_learnt() {
    let plain_mm = follow(&mut board(Learning::Off), 3);
    let mut bench = board(Learning::On);
    let learnt_mm = follow(&mut bench, 6);
    assert!(learnt_mm < 0.4 * plain_mm, "{plain_mm} mm, {learnt_mm} mm, {:?}", change(&mut bench));
    // A stop, a start and the same model with other gains leave it.
    let learnt = change(&mut bench);
    bench.demand(&Request::Stop);
    let mut other = paper_configuration();
    other.tracking.pid.kp *= 0.5;
    bench.start(Protection::STANDARD, &other, Mode::FeedforwardOnly);
    bench.control().adaptation().switch(Learning::Kept);
    assert_eq!(change(&mut bench), learnt);
    let kept_mm = follow(&mut bench, 2);
    assert!(kept_mm < 0.5 * plain_mm, "{kept_mm} mm");
    assert_eq!(change(&mut bench), learnt);
}

#[test]
fn another_model_and_the_switch_forget_what_was_learnt() {
    let mut bench = board(Learning::On);
    follow(&mut bench, 2);
    let none = Told { learning: Learning::Off, change: Change::default(), steps: 0 };
    bench.demand(&Request::Stop);
    let mut smaller = paper::mgpi().expect("valid");
    smaller.input_max = 5.0;
    bench.demand(&Request::Configure(configuration(&ModelParameters::Cascade(smaller))));
    assert_eq!(bench.control().learnt(), none);
    let mut bench = board(Learning::On);
    follow(&mut bench, 2);
    bench.control().adaptation().switch(Learning::Off);
    assert_eq!(bench.control().learnt(), none);
}

#[test]
fn a_sensor_that_is_unplugged_trips_and_spoils_nothing() {
    let mut bench = board(Learning::On);
    follow(&mut bench, 3);
    let learnt = change(&mut bench);
    bench.wrong.contraction_code = Some(4095);
    for _ in 0..100 {
        bench.tick();
    }
    assert_eq!((bench.state(), bench.control().fault()), (State::Fault, Some(Fault::ContractionSensor)));
    assert_eq!(change(&mut bench), learnt);
}

#[test]
fn a_supply_that_cannot_give_what_is_asked_for_teaches_nothing() {
    // Two thirds of the pressure: further from the command than what follows.
    let mut bench = board(Learning::On);
    follow(&mut bench, 3);
    let learnt = change(&mut bench);
    bench.wrong.leak = -0.5;
    for _ in 0..200 {
        bench.reference_mm = 90.0;
        bench.tick();
    }
    assert_eq!(change(&mut bench), learnt);
}
