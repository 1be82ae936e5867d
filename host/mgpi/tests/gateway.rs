//! `mgpi gateway` over a fleet of boards without hardware.
#![cfg(unix)]

mod common;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use common::Bench;
use serde_json::Value;

/// How long anything may take to be seen, on a machine with much else to do.
const PATIENCE: Duration = Duration::from_secs(30);

/// Three boards on two lines, and a fourth that is not there.
const LINES: &str = "[[line]]\nport = \"lab/line-1\"\nboards = [1]\n\
    [[line]]\nname = \"arm\"\nport = \"lab/line-2\"\nboards = [{number = 2, name = \"biceps\"}, 3, 9]\n";

/// A gateway, until the test ends.
struct Gateway {
    program: Child,
    address: String,
}

impl Gateway {
    fn start(bench: &Bench) -> Self {
        let mut program = Command::new(env!("CARGO_BIN_EXE_mgpi"))
            .args(["gateway", "lines.toml", "--http", "127.0.0.1:0"])
            .current_dir(bench.path(""))
            .stdout(Stdio::piped())
            .spawn()
            .expect("mgpi runs");
        let mut said = String::new();
        let output = program.stdout.take().expect("a pipe");
        BufReader::new(output).read_line(&mut said).expect("it says where");
        let address =
            said.strip_prefix("http://").and_then(|said| said.split_once('/')).expect("an address").0;
        Self { address: address.to_owned(), program }
    }

    /// What is answered, head and content.
    fn ask(&self, request: &str, header: &str) -> String {
        let mut stream = TcpStream::connect(&self.address).expect("connected");
        write!(stream, "{request} HTTP/1.1\r\nHost: {}\r\n{header}\r\n", self.address).expect("written");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("answered");
        answer
    }

    fn boards(&self) -> Vec<Value> {
        let answer = self.ask("GET /fleet.json", "");
        let (_, content) = answer.split_once("\r\n\r\n").expect("a content");
        let told: Value = serde_json::from_str(content).expect("JSON");
        told["boards"].as_array().expect("a list").clone()
    }

    /// The boards as soon as they are so.
    fn wait(&self, what: &str, is_so: impl Fn(&[Value]) -> bool) -> Vec<Value> {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let boards = self.boards();
            if is_so(&boards) {
                return boards;
            }
            assert!(Instant::now() < deadline, "{what}: {boards:#?}");
            sleep(Duration::from_millis(50));
        }
    }
}

impl Drop for Gateway {
    fn drop(&mut self) {
        // It has ended by itself if this fails.
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

fn is_seen(board: &Value) -> bool {
    board["problem"].is_null() && !board["telemetry"].is_null()
}

#[test]
fn every_board_of_every_line_is_seen_and_what_is_not_there_is_said() {
    let bench = Bench::new();
    bench.write("lines.toml", LINES);
    bench.succeeds("fleet lab --boards 3 --lines 2 --background");
    let gateway = Gateway::start(&bench);
    let is_whole = |boards: &[Value]| boards.iter().filter(|board| is_seen(board)).count() == 3;
    let boards = gateway.wait("three boards", |boards| is_whole(boards) && !boards[3]["problem"].is_null());
    let names: Vec<&Value> = boards.iter().map(|board| &board["name"]).collect();
    assert_eq!(names, ["line-1/1", "biceps", "arm/3", "arm/9"]);
    assert!(boards[3]["problem"].as_str().is_some_and(|words| words.contains("no answer from unit 9")));
    let told = &boards[1]["telemetry"];
    assert_eq!(told["state"], "Off");
    // An exchange takes some milliseconds, and its half is the bound.
    let bound_s = told["time_bound_s"].as_f64().expect("a bound");
    assert!(bound_s > 0.5e-3 && bound_s < 50e-3, "{bound_s} s");
    let metrics = gateway.ask("GET /metrics", "");
    assert!(metrics.contains("mgpi_seen{board=\"biceps\",line=\"arm\",number=\"2\"} 1\n"), "{metrics}");
    assert!(metrics.contains("mgpi_seen{board=\"arm/9\",line=\"arm\",number=\"9\"} 0\n"), "{metrics}");
    // It has all ports; the boards are another program's as soon as it ends.
    assert!(bench.refuses("status --port lab/line-1").contains("busy"));
    drop(gateway);
    bench.succeeds("status --port lab/line-1");
    bench.succeeds("fleet lab --stop");
}

#[test]
fn an_order_comes_from_the_page_alone_and_vents_every_board() {
    let bench = Bench::new();
    bench.write("lines.toml", LINES).write("model.toml", common::PAPER);
    bench.succeeds("fleet lab --boards 3 --lines 2 --background --no-monitors");
    bench.succeeds("deploy model.toml --port lab/line-2 --unit 3 --force");
    bench.write("reference.csv", "time_s,reference_mm\n0,0\n1,40\n600,40\n");
    // Killed, it leaves the board driven: without monitors nothing else vents it.
    let mut track = Command::new(env!("CARGO_BIN_EXE_mgpi"))
        .args([
            "track",
            "--reference",
            "reference.csv",
            "--port",
            "lab/line-2",
            "--unit",
            "3",
            "-o",
            "log.csv",
        ])
        .current_dir(bench.path(""))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("mgpi runs");
    sleep(Duration::from_secs(5));
    track.kill().expect("it is at work");
    track.wait().expect("it ends");
    let gateway = Gateway::start(&bench);
    let is = |state: &'static str| move |boards: &[Value]| boards[2]["telemetry"]["state"] == state;
    gateway
        .wait("the board is driven", |boards| ["Tracking", "Holding"].iter().any(|state| is(state)(boards)));
    let foreign = gateway.ask("POST /stop", "");
    assert!(foreign.starts_with("HTTP/1.1 403"), "{foreign}");
    assert!(!gateway.ask("POST /start", "X-Mgpi-Order: 1\r\n").starts_with("HTTP/1.1 202"));
    gateway.wait("nothing has stopped it", |boards| {
        ["Tracking", "Holding"].iter().any(|state| is(state)(boards))
    });
    assert!(gateway.ask("POST /stop", "X-Mgpi-Order: 1\r\n").starts_with("HTTP/1.1 202"));
    gateway.wait("the board is vented", is("Ready"));
    drop(gateway);
    bench.succeeds("fleet lab --stop");
}

#[test]
fn a_line_that_goes_and_comes_again_needs_no_new_gateway() {
    let bench = Bench::new();
    bench.write("lines.toml", LINES);
    let gateway = Gateway::start(&bench);
    gateway.wait("no port so far", |boards| boards.iter().all(|board| !board["problem"].is_null()));
    for _ in 0..2 {
        bench.succeeds("fleet lab --boards 3 --lines 2 --background");
        gateway.wait("three boards", |boards| boards[..3].iter().all(is_seen));
        bench.succeeds("fleet lab --stop");
        gateway.wait("no port", |boards| boards.iter().all(|board| !is_seen(board)));
    }
}

#[test]
fn a_file_of_no_use_is_refused_by_name_and_place() {
    let bench = Bench::new();
    for (text, message) in [
        ("", "missing field `line`"),
        ("[[line]]\nport = \"p\"\nboards = [1, 1]\n", "lines.toml: line line-1: board 1 is there twice"),
        ("[[line]]\nport = 3\nboards = [1]\n", "line 2, column 8"),
    ] {
        bench.write("lines.toml", text);
        let said = bench.refuses("gateway lines.toml --http 127.0.0.1:0");
        assert!(said.contains(message), "{said}");
    }
    assert!(bench.refuses("gateway none.toml").contains("none.toml"));
}

#[test]
fn a_network_that_cannot_be_is_refused_and_nothing_is_recorded() {
    let bench = Bench::new();
    bench.write("lines.toml", LINES);
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let taken = format!("--zenoh tcp/{}", taken.local_addr().expect("bound"));
    for (options, message) in [
        ("--ros-domain 0", "--ros-domain needs --zenoh"),
        ("--zenoh tcp/127.0.0.1:0 --name a/b", "the name \"a/b\": this name cannot be part of a key"),
        ("--zenoh 127.0.0.1", "Zenoh: "),
        (&*taken, "Zenoh: "),
        ("--zenoh-config none.json5", "none.json5"),
        ("--zenoh-config lines.toml", "lines.toml"),
    ] {
        let said =
            bench.refuses(&format!("gateway lines.toml --http 127.0.0.1:0 --record lab.mcap {options}"));
        assert!(said.contains(message), "{options}: {said}");
    }
    assert_eq!(bench.files(), ["lines.toml"]);
}
