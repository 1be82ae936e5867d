//! `mgpi scan` on a line of boards.

use std::time::Duration;

use board_client::bus::Board;
use board_client::bus::client::Address;
use board_client::bus::port::{Line, Parity};
use host_tests::desk_commands::DeskBench as Bench;
use serde_json::Value;
use wire::State;
use wire::registers::{BAUD, Command};

fn numbers(found: &Value, kind: &str) -> Vec<u64> {
    let of_kind = found.as_array().expect("a list").iter().filter(|found| found["kind"] == kind);
    of_kind.map(|found| found["number"].as_u64().expect("a number")).collect()
}

#[test]
fn every_board_of_a_line_is_listed_by_its_number() {
    let bench = Bench::line(&[3, 17, 18]);
    let said = bench.succeeds("scan --last 20 --timeout-s 0.1 --json");
    let found: Value = serde_json::from_str(&said).expect("JSON");
    assert_eq!(numbers(&found, "board"), [3, 17, 18], "{said}");
    assert_eq!(found[0]["about"]["unique_id"], "003900453134510e32380003", "{said}");
    let said = bench.succeeds("scan --first 17 --last 17 --timeout-s 0.1");
    assert!(said.starts_with("17        115200 bit/s  firmware ") && said.lines().count() == 1, "{said}");
}

#[test]
fn two_boards_of_one_number_are_told_and_the_others_are_listed() {
    let bench = Bench::line(&[2, 5, 5]);
    let output = bench.run("scan --last 6 --timeout-s 0.1 --json");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("number 5: two boards have it"), "{message}");
    let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!((numbers(&found, "board"), numbers(&found, "several")), (vec![2], vec![5]));
}

#[test]
fn one_order_vents_every_board() {
    let bench = Bench::line(&[4, 9]);
    let at = |unit| {
        let line = Line { baud: BAUD, parity: Parity::None };
        Address { port: bench.port().to_owned(), line, unit, limit: Duration::from_millis(500) }
    };
    for unit in [4, 9] {
        let mut board = Board::open(at(unit)).expect("a board");
        board.settled().expect("tested");
        board.drive(Command::Service, State::Service).expect("started");
    }
    let states = |arguments: &str| {
        let said = bench.succeeds(&format!("scan {arguments} --last 9 --timeout-s 0.1 --json"));
        let found: Value = serde_json::from_str(&said).expect("JSON");
        let states = found.as_array().expect("a list").iter().map(|found| found["state"].to_string());
        states.collect::<Vec<_>>()
    };
    assert_eq!(states(""), ["\"Service\""; 2]);
    // Neither has a model.
    assert_eq!(states("--stop"), ["\"Off\""; 2]);
}

#[test]
fn a_line_without_boards_is_said_and_so_are_numbers_that_are_none() {
    let bench = Bench::line(&[40]);
    let message = bench.refuses("scan --last 3 --timeout-s 0.02");
    assert!(message.contains("nobody answers by the numbers 1 to 3"), "{message}");
    assert!(bench.refuses("scan --first 9 --last 3").contains("--first 9 is above --last 3"));
    assert!(bench.refuses("scan --last 248").contains("is not in"));
}
