//! Every fault of the table, injected: a row each, then all of them at random moments.
//!
//! `cargo test -p host-tests --test faults -- --nocapture` prints the figures.

mod inject;

use std::thread;

use firmware::scaling::VENT;
use host_tests::bench::Bench;
use inject::{Injection, configuration_for, mode_for};
use model_core::Mode;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use wire::fault::table::{Latch, Reaction, Row, TABLE};
use wire::{Fault, Protection, Refusal, Request, Response, State};

/// Longest time that a run waits for what is detected to begin. Unit: tick.
const PATIENCE: u32 = 12_000;

/// How a run has ended.
#[derive(Debug)]
struct End {
    /// The fault that is latched.
    latched: Option<Fault>,
    /// Ticks from the begin of what is detected.
    after: u32,
}

/// The reference at a tick: swings between 15 and 105 mm, one in 4 s. Unit: mm.
fn reference_mm(tick: u32, phase: u32) -> f64 {
    let turns = f64::from(tick + phase) / 4000.0;
    15.0 + 45.0 * (1.0 - (std::f64::consts::TAU * turns).cos())
}

/// Tracks for `before` ticks, injects the fault, and goes on until the board reacts.
fn run(row: &Row, protection: Protection, bench: &mut Bench, before: u32, phase: u32) -> End {
    bench.start(protection, &configuration_for(row.fault), mode_for(row.fault));
    for tick in 0..before {
        bench.reference_mm = reference_mm(tick, phase);
        bench.tick();
        assert_eq!(bench.state(), State::Tracking, "{:?} before {:?}", bench.control().fault(), row.fault);
    }
    let mut injection = Injection::of(row.fault);
    let mut after = 0;
    for tick in before..before + PATIENCE {
        bench.reference_mm = reference_mm(tick, phase);
        let is_there = injection.apply(bench);
        bench.tick();
        after = if is_there { after + 1 } else { 0 };
        let is_over = row.reaction == Reaction::Count && tick == before + 100;
        if bench.state() == State::Fault || is_over {
            break;
        }
    }
    End { latched: bench.control().fault(), after }
}

/// What has to hold once a fault has vented, whatever the host does.
fn assert_stays_vented(bench: &mut Bench, fault: Fault) {
    for request in [Request::Start(Mode::Both), Request::SetMode(Mode::Both), Request::Service(1000)] {
        let response = bench.request(&request);
        assert_eq!(response, Response::Refused(Refusal::WrongState(State::Fault)), "{fault:?}, {request:?}");
    }
    for _ in 0..200 {
        bench.tick();
        assert_eq!((bench.state(), bench.output()), (State::Fault, VENT), "{fault:?}");
    }
}

/// The time that the table allows: the reaction to what is seen between ticks comes with the next
/// one.
fn allowed(row: &Row) -> u32 {
    row.within_ticks.max(1)
}

#[test]
fn every_row_of_the_table_ends_as_it_says_by_its_own_fault() {
    for row in &TABLE {
        // Each fault by itself: a slipped sensor is also implausible, a pressure that a stuck valve
        // holds looks stuck.
        let on = Protection::STANDARD;
        let protection = match row.fault {
            Fault::Authority | Fault::PressureStuck => {
                Protection { following_limit_bar_s: f32::INFINITY, ..on }
            }
            Fault::ValveStuck | Fault::VentIneffective => {
                Protection { stuck_command_bar: f32::INFINITY, ..on }
            }
            Fault::Adaptation => Protection { implausible_share: f32::INFINITY, ..on },
            Fault::ContractionStuck => {
                Protection { implausible_share: f32::INFINITY, authority_bar: f32::INFINITY, ..on }
            }
            _ => on,
        };
        let mut bench = Bench::new(1);
        let end = run(row, protection, &mut bench, 1500, 0);
        println!("{:?}: {} ticks, at most {}", row.fault, end.after, row.within_ticks);
        if row.reaction == Reaction::Count {
            assert_eq!(bench.state(), State::Tracking, "{:?}", row.fault);
            assert_eq!(end.latched, None);
        } else {
            assert_eq!((bench.state(), end.latched), (State::Fault, Some(row.fault)), "{end:?}");
            assert!(end.after <= allowed(row), "{:?}: {} ticks", row.fault, end.after);
            // What is seen at the end of a tick vents in the next, anything else in its own.
            if !matches!(row.fault, Fault::TaskSilent | Fault::Deadline) {
                assert_eq!(bench.output(), VENT, "{:?}", row.fault);
            }
            assert_stays_vented(&mut bench, row.fault);
        }
        assert_counted(&mut bench, row.fault);
        assert_latched_as_the_table_says(&mut bench, row);
    }
}

fn assert_counted(bench: &mut Bench, fault: Fault) {
    let Response::Telemetry(telemetry) = bench.request(&Request::Telemetry) else { panic!("telemetry") };
    assert!(telemetry.faults[usize::from(fault.code()) - 1] > 0, "{fault:?} is not counted");
}

fn assert_latched_as_the_table_says(bench: &mut Bench, row: &Row) {
    bench.wrong = Default::default();
    let answer = bench.request(&Request::Acknowledge);
    match row.latch {
        Latch::Acknowledged => assert_eq!(answer, Response::Accepted, "{:?}", row.fault),
        Latch::PowerOn => assert_eq!(answer, Response::Refused(Refusal::WrongState(State::Fault))),
        Latch::Never => assert_eq!(bench.state(), State::Tracking),
    }
}

#[test]
fn in_a_thousand_runs_with_a_fault_at_a_random_moment_none_ends_with_the_valve_open() {
    const RUNS: u64 = 1000;
    const THREADS: u64 = 4;
    let counts = thread::scope(|scope| {
        let threads: Vec<_> = (0..THREADS)
            .map(|thread| {
                scope.spawn(move || (thread..RUNS).step_by(THREADS as usize).map(random_run).collect())
            })
            .collect();
        threads
            .into_iter()
            .flat_map(|thread| -> Vec<bool> { thread.join().expect("no run fails") })
            .collect::<Vec<_>>()
    });
    let own = counts.iter().filter(|is_own| **is_own).count();
    println!(
        "{} runs: all end vented in the state and the time of the table; {own} by their own fault",
        counts.len()
    );
    assert_eq!(counts.len(), RUNS as usize);
}

/// A run whose fault, moment and course depend on the seed; whether it has ended by its own fault,
/// and not by another one that the same damage shows.
fn random_run(seed: u64) -> bool {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let row = &TABLE[random.next_u32() as usize % TABLE.len()];
    let (before, phase) = (random.next_u32() % 3000, random.next_u32() % 4000);
    let mut bench = Bench::new(seed);
    let End { latched, after } = run(row, Protection::STANDARD, &mut bench, before, phase);
    if row.reaction == Reaction::Count {
        assert_eq!(bench.state(), State::Tracking, "seed {seed}, {:?}", row.fault);
        bench.demand(&Request::Stop);
        bench.tick();
        assert_eq!((bench.state(), bench.output()), (State::Ready, VENT), "seed {seed}, {:?}", row.fault);
        return true;
    }
    assert_eq!(bench.state(), State::Fault, "seed {seed}, {:?} at tick {before}", row.fault);
    assert!(after <= allowed(row), "seed {seed}, {:?} at tick {before}: {after} ticks", row.fault);
    assert_stays_vented(&mut bench, row.fault);
    latched == Some(row.fault)
}
