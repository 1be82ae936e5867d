//! `mgpi bus` and what `mgpi status` says of hardware and bus, against the board's own code.

use host_tests::desk_commands::DeskBench as Bench;

#[test]
fn a_board_gets_another_number_and_is_asked_by_it() {
    let bench = Bench::new();
    let said = bench.succeeds("bus");
    assert!(said.contains("number 1, 115200 bit/s, parity none, turn-around 0 us"), "{said}");
    let said = bench.succeeds("bus --set-number 17 --set-turnaround-us 2000 --take");
    assert!(said.contains("-> number 17") && said.contains("listens   by what it keeps"), "{said}");
    let status = bench.succeeds("status --unit 17 --json");
    assert!(status.contains("\"number\": 17"), "{status}");
    bench.refuses("status --timeout-s 0.02");
}

#[test]
fn what_is_not_taken_is_said_to_be_taken_at_the_next_start() {
    let bench = Bench::new();
    let said = bench.succeeds("bus --set-baud 19200 --set-parity even");
    assert!(said.contains("19200 bit/s, parity even"), "{said}");
    assert!(said.contains("by what it kept before; the new at its next start"), "{said}");
}

#[test]
fn a_number_or_a_rate_that_no_board_has_is_refused_before_the_board_is_asked() {
    let bench = Bench::new();
    for wrong in ["--set-number 0", "--set-number 248", "--set-baud 1200", "--set-turnaround-us 60000"] {
        let message = bench.refuses(&format!("bus {wrong}"));
        assert!(message.contains("is not in"), "{message}");
    }
}

#[test]
fn the_status_tells_the_processors_number_and_the_boards_revision() {
    let bench = Bench::new();
    let said = bench.succeeds("status");
    let hardware = "number 003900453134510e32380001, revision 3, processor 0x413 revision 0x1007";
    assert!(said.contains(hardware), "{said}");
    assert_eq!(bench.status()["about"]["unique_id"], "003900453134510e32380001");
}
