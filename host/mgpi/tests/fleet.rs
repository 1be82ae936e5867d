//! `mgpi fleet`: many boards without hardware.
#![cfg(unix)]

mod common;

use std::thread::sleep;
use std::time::{Duration, Instant};

use common::Bench;
use common::processes::signal;
use serde_json::Value;

/// Boards of a bench, until the test ends.
struct Fleet<'a>(&'a Bench);

impl<'a> Fleet<'a> {
    fn start(bench: &'a Bench, arguments: &str) -> Self {
        bench.succeeds(&format!("fleet lab --background {arguments}"));
        Self(bench)
    }
}

impl Drop for Fleet<'_> {
    fn drop(&mut self) {
        self.0.mgpi("fleet lab --stop");
    }
}

fn numbers(bench: &Bench, line: u8) -> Vec<u64> {
    let said = bench.succeeds(&format!("scan --port lab/line-{line} --last 8 --timeout-s 0.1 --json"));
    let found: Value = serde_json::from_str(&said).expect("JSON");
    let boards = found.as_array().expect("a list").iter();
    boards.map(|board| board["number"].as_u64().expect("a number")).collect()
}

#[test]
fn every_board_of_a_fleet_answers_by_its_number_on_its_line() {
    let bench = Bench::new();
    let fleet = Fleet::start(&bench, "--boards 7 --lines 3");
    assert_eq!([1, 2, 3].map(|line| numbers(&bench, line)), [vec![1, 2], vec![3, 4], vec![5, 6, 7]]);
    // Its ports are its own, and go with it.
    let said = bench.refuses("fleet lab --boards 7 --lines 3");
    assert!(said.contains("lab/line-1: no serial port can be made there: an emulator has it"), "{said}");
    drop(fleet);
    assert_eq!(bench.files(), ["lab"]);
    assert_eq!(std::fs::read_dir(bench.path("lab")).expect("a directory").count(), 0);
    assert!(bench.refuses("fleet lab --stop").contains("no emulator has this port"));
}

#[test]
fn what_a_killed_fleet_leaves_is_removed_and_the_next_one_starts() {
    let bench = Bench::new();
    let fleet = Fleet::start(&bench, "--boards 2 --lines 2");
    let link = std::fs::read_link(bench.path("lab/line-1")).expect("a link");
    let process = link.iter().nth(2).and_then(|pid| pid.to_str()?.parse().ok()).expect("/proc/NUMBER/fd");
    signal("KILL", process);
    // What is left behind is removed, or replaced.
    bench.succeeds("fleet lab --stop");
    assert_eq!(std::fs::read_dir(bench.path("lab")).expect("a directory").count(), 0);
    drop(fleet);
    let _next = Fleet::start(&bench, "--boards 2 --lines 2");
    assert_eq!([1, 2].map(|line| numbers(&bench, line)), [vec![1], vec![2]]);
}

#[test]
fn numbers_that_no_bus_has_are_refused_before_anything_is_made() {
    let bench = Bench::new();
    let said = bench.refuses("fleet lab --boards 248");
    assert!(said.contains("248 boards are not in 1 to 247"), "{said}");
    let said = bench.refuses("fleet lab --boards 3 --lines 4");
    assert!(said.contains("4 lines are not in 1 to 3"), "{said}");
    assert!(bench.files().is_empty());
}

#[test]
fn a_board_in_the_emulator_is_on_a_line_of_its_own_and_the_gateway_asks_it_in_slots_like_the_others() {
    if board_client::emulator::image::find(None).is_err() {
        println!("skipped: there is no firmware for the emulator");
        return;
    }
    let bench = Bench::new();
    let _fleet = Fleet::start(&bench, "--boards 2 --lines 1 --emulated 1");
    assert_eq!([1, 2].map(|line| numbers(&bench, line)), [vec![1, 2], vec![1]]);
    let file = bench.path("lines.toml");
    let text =
        "[[line]]\nport = \"lab/line-1\"\nboards = [1, 2]\n[[line]]\nport = \"lab/line-2\"\nboards = [1]\n";
    std::fs::write(&file, text).expect("written");
    let gateway = gateway::Gateway::start(gateway::lines::read(&file).expect("two lines"));
    let deadline = Instant::now() + Duration::from_secs(30);
    while gateway.boards().all().iter().any(|board| board.answered < 100) {
        let boards = gateway.boards().all();
        assert!(Instant::now() < deadline, "{boards:#?}");
        assert!(boards.iter().all(|board| board.problem.is_none()), "{boards:#?}");
        sleep(Duration::from_millis(50));
    }
    let boards = gateway.boards().all();
    assert!(boards.iter().all(|board| board.in_slots), "{boards:#?}");
    let states = boards.iter().map(|board| board.telemetry.as_ref().map(|told| told.state));
    assert!(states.into_iter().all(|state| state == Some(wire::State::Off)), "{boards:#?}");
}
