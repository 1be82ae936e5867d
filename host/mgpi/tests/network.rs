//! `mgpi gateway` on the network, seen by programs that others have written: Zenoh's own Python,
//! rosbags and mcap (`host-tests/network/client.py`).
//!
//! Skipped, in so many words, where that Python is missing; `cargo xtask test` provides it.
#![cfg(unix)]

mod common;

use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use common::Bench;
use libtest_mimic::{Arguments, Trial};
use serde_json::Value;

/// The environment variable that names the Python which has the clients.
const VARIABLE: &str = "MGPI_NETWORK_PYTHON";
/// What they do.
const CLIENT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../host-tests/network/client.py");
/// Four boards on two lines.
const LINES: &str = "[[line]]\nport = \"boards/line-1\"\nboards = [1, 2]\n\
    [[line]]\nname = \"arm\"\nport = \"boards/line-2\"\nboards = [{number = 3, name = \"biceps\"}, 4]\n\
    [[group]]\nname = \"left\"\nboards = [\"line-1/1\", \"line-1/2\", \"biceps\"]\n";
/// How long a board of a fleet bears its host to be silent: `bus_silent_ticks` of 1 ms. Unit: s.
const SILENT_S: f64 = 0.5;
/// What may come on top: a round of a line, and a machine that does much else. Unit: s.
const LATE_S: f64 = 0.5;

fn main() {
    let is_missing = std::env::var_os(VARIABLE).is_none();
    if is_missing {
        println!(
            "the tests of the network are skipped: {VARIABLE} names no Python; `cargo xtask test` makes one"
        );
    }
    let tests: [(&str, fn()); 11] = [
        ("no_message_is_lost_on_its_way_to_another_program", nothing_lost),
        ("set_points_drive_the_boards_and_silence_vents_them", driven),
        ("a_killed_gateway_leaves_every_board_vented_within_its_patience", killed),
        ("a_trajectory_begins_on_all_boards_within_a_tick_or_on_none_and_ends_with_its_client", played),
        ("a_group_is_started_driven_and_stopped_as_one", grouped),
        ("sixteen_boards_of_a_slow_line_all_track_behind_one_order", many_started),
        ("boards_that_stay_are_not_disturbed_by_another_file_of_lines", reloaded),
        ("by_certificates_of_ones_own_some_see_some_drive_and_the_rest_are_kept_out", secured),
        ("by_a_password_some_are_let_in_and_the_rest_kept_out", with_password),
        ("ros_2_sees_topics_services_types_and_hashes_as_its_own", ros),
        ("a_recording_is_read_by_others_and_by_import", recorded),
    ];
    let trials = tests.into_iter().map(|(name, test)| {
        let run = move || {
            test();
            Ok(())
        };
        Trial::test(name, run).with_ignored_flag(is_missing)
    });
    // One at a time: the boards keep real time.
    let arguments = Arguments { test_threads: Some(1), ..Arguments::from_args() };
    libtest_mimic::run(&arguments, trials.collect()).exit()
}

/// A fleet whose boards have a model.
struct Lab(Bench);

impl Lab {
    fn new() -> Self {
        Self::of(LINES, &[(1, 1), (1, 2), (2, 3), (2, 4)])
    }

    /// Boards by line and number.
    fn of(lines: &str, boards: &[(usize, usize)]) -> Self {
        let bench = Bench::new();
        bench.write("lines.toml", lines).write("model.toml", common::PAPER);
        let count = boards.iter().map(|(line, _)| *line).max().unwrap_or(1);
        bench.succeeds(&format!("fleet boards --boards {} --lines {count} --background", boards.len()));
        for (line, unit) in boards {
            bench.succeeds(&format!("deploy model.toml --port boards/line-{line} --unit {unit} --force"));
        }
        Self(bench)
    }

    /// Runs a gateway on a port that is free.
    fn gateway(&self, options: &str) -> Gateway {
        let end_point = format!("tcp/127.0.0.1:{}", free_port());
        self.gateway_at(end_point.clone(), &format!("--zenoh {end_point} {options}"))
    }

    fn gateway_at(&self, end_point: String, options: &str) -> Gateway {
        let mut program = Command::new(env!("CARGO_BIN_EXE_mgpi"))
            .args(["gateway", "lines.toml", "--http", "127.0.0.1:0"])
            .args(options.split_whitespace())
            .current_dir(self.0.path(""))
            .stdout(Stdio::piped())
            .spawn()
            .expect("mgpi runs");
        let output = BufReader::new(program.stdout.take().expect("a pipe"));
        let said =
            output.lines().map_while(Result::ok).any(|line| line.starts_with("on Zenoh under mgpi/1/lab"));
        assert!(said, "it says that it is on the network");
        Gateway { program, end_point }
    }
}

/// Nobody takes it in the moment between.
fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").expect("a port").local_addr().expect("bound").port()
}

impl Drop for Lab {
    fn drop(&mut self) {
        self.0.mgpi("fleet boards --stop");
    }
}

/// A gateway, until the test ends.
struct Gateway {
    program: Child,
    end_point: String,
}

impl Gateway {
    fn client(&self, command: &[&str]) -> Child {
        client(&self.end_point, command)
    }

    /// What the client tells.
    fn told(&self, command: &[&str]) -> Value {
        told(self.client(command))
    }
}

fn client(end_point: &str, command: &[&str]) -> Child {
    let python = std::env::var_os(VARIABLE).expect("looked for before");
    Command::new(python)
        .args([CLIENT, "--end-point", end_point, "--domain", "7"])
        .args(command)
        .stdout(Stdio::piped())
        .spawn()
        .expect("Python runs")
}

fn told(client: Child) -> Value {
    let output = client.wait_with_output().expect("it ends");
    assert!(output.status.success(), "the client says what is wrong above");
    serde_json::from_slice(&output.stdout).expect("a line of JSON")
}

impl Drop for Gateway {
    fn drop(&mut self) {
        // It has ended by itself if this fails.
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

fn nothing_lost() {
    let lab = Lab::new();
    let told = lab.gateway("").told(&["watch", "--seconds", "5"]);
    assert_eq!(
        (&told["boards"], &told["lost"], &told["missed"]),
        (&4.into(), &0.into(), &0.into()),
        "{told}"
    );
    assert!(told["messages"].as_u64().is_some_and(|messages| messages > 200), "{told}");
}

fn driven() {
    let lab = Lab::new();
    let told = lab.gateway("").told(&["drive", "--seconds", "6"]);
    for (what, wanted) in [("started", 4), ("tracking", 4), ("vented", 4)] {
        assert_eq!(told[what], wanted, "{told}");
    }
    // The host is silent; and what is sent to a vented board is refused.
    assert_eq!(told["faults"], serde_json::json!([21]), "{told}");
    assert_eq!(told["refused_set_points"], serde_json::json!(["the board is not driven"]), "{told}");
    let vented_s = told["latest_vent_s"].as_f64().expect("a time");
    assert!(vented_s < SILENT_S + LATE_S, "{told}");
    assert!(told["worst_error_mm"].as_f64().is_some_and(|error_mm| error_mm < 5.0), "{told}");
}

fn played() {
    let lab = Lab::new();
    let told = lab.gateway("").told(&["play"]);
    let refused: Vec<&str> =
        told["refused"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    for (refused, said) in refused.iter().zip([
        "the start was 1.0",
        "the start is in 0.",
        "60 s are allowed: compare the clocks",
        "point 1 of the trajectory: 900 mm is not in -20 to 200 mm",
        "point 2 of the trajectory: 0.5 s is no time behind 1 s",
        "nobody: there is no board or group of this name",
        "the grant 1 is not that for which the board is driven",
        "the board is there twice",
        "no trajectory: unknown field `begin_s`",
        "this gateway speaks mgpi/1, not mgpi/0",
    ]) {
        assert!(refused.contains(said), "{refused}, not {said}");
    }
    assert_eq!((refused.len(), &told["undisturbed"]), (10, &true.into()), "{told}");
    assert!(
        told["twice"].as_str().is_some_and(|said| said.contains("a trajectory waits or plays")),
        "{told}"
    );
    assert_eq!(told["played"], 4, "{told}");
    let number = |what: &str| told[what].as_f64().expect("a number");
    // The boards of a line hear one frame: they begin in the same tick, or the next.
    assert!(number("skew_ticks") <= 1.0, "{told}");
    // Over all lines, as far as their clocks are known.
    assert!(number("start_off_s") <= number("start_bound_s") + 3e-3, "{told}");
    // A corner lies between two points of the board's stream, 10 ms apart, at up to 20 mm/s.
    assert!(number("worst_reference_error_mm") < 0.3 && number("compared") > 100.0, "{told}");
    assert!(number("latest_vent_s") < SILENT_S + LATE_S, "{told}");
    assert_eq!(told["faults"], serde_json::json!([21]), "{told}");
    assert_eq!(told["ended"], serde_json::json!(["the board is driven no longer"]), "{told}");
}

fn grouped() {
    let lab = Lab::new();
    let told = lab.gateway("").told(&["group", "--members", "line-1/1,line-1/2,biceps"]);
    assert_eq!(told["unknown"], serde_json::json!([{}, {}]), "{told}");
    assert_eq!(told["refused_start"], serde_json::json!({}), "{told}");
    assert!(
        told["twice"][0].as_str().is_some_and(|said| said.contains("driven for another client")),
        "{told}"
    );
    assert_eq!(told["driven"], serde_json::json!(["biceps", "line-1/1", "line-1/2"]), "{told}");
    let contractions = told["contractions_mm"].as_array().expect("a list");
    assert!(contractions.iter().all(|mm| mm.as_f64().is_some_and(|mm| (mm - 25.0).abs() < 2.0)), "{told}");
    assert_eq!(told["stopped"], serde_json::json!([{"done": true}]), "{told}");
    assert_eq!(told["refused"], serde_json::json!(["the board is not driven"]), "{told}");
}

fn many_started() {
    let boards: Vec<(usize, usize)> = (1..=16).map(|unit| (1, unit)).collect();
    let numbers: Vec<usize> = boards.iter().map(|(_, unit)| *unit).collect();
    let lab = Lab::of(&format!("[[line]]\nport = \"boards/line-1\"\nboards = {numbers:?}\n"), &boards);
    // Each for itself, by one query: they answer when all have been tried, and all have waited.
    let told = lab.gateway("").told(&["drive", "--seconds", "4"]);
    for what in ["started", "tracking", "vented"] {
        assert_eq!(told[what], 16, "{told}");
    }
    assert_eq!(told["faults"], serde_json::json!([21]), "{told}");
}

fn reloaded() {
    let lab = Lab::new();
    // One line loses a board and gains one that is not there; the other stays; a third is new.
    let new = LINES.replace("boards = [1, 2]", "boards = [1, 9]").replace("\"line-1/2\", ", "")
        + "[[line]]\nname = \"new\"\nport = \"other/line-1\"\nboards = [1]\n";
    lab.0.write("new.toml", &new);
    lab.0.succeeds("fleet other --boards 1 --lines 1 --background");
    let path = |file: &str| lab.0.path(file).display().to_string();
    let gateway = lab.gateway("");
    let told = gateway.told(&["reload", "--lines", &path("lines.toml"), "--new", &path("new.toml")]);
    lab.0.mgpi("fleet other --stop");
    let keys = |boards: &[&str]| boards.iter().map(|board| format!("mgpi/1/lab/{board}")).collect::<Vec<_>>();
    let before = keys(&["arm/3", "arm/4", "line-1/1", "line-1/2"]);
    assert_eq!((&told["before"], &told["after_bad"]), (&before.clone().into(), &before.into()), "{told}");
    let refused = told["refused"].as_str().expect("words");
    assert!(refused.ends_with("lines.toml: line line-1: board 0: numbers are 1 to 247"), "{told}");
    assert_eq!(told["done"], serde_json::json!({"done": true}), "{told}");
    assert_eq!(told["after"], serde_json::json!(keys(&["arm/3", "arm/4", "line-1/1", "new/1"])), "{told}");
    let alive = keys(&["arm/3/alive", "arm/4/alive", "line-1/1/alive", "new/1/alive"]);
    assert_eq!(told["alive"], serde_json::json!(alive), "{told}");
    assert_eq!(told["lost"], 0, "{told}");
    // A round of the line with the board that is not there: 60 ms, and this machine's other work.
    assert!(told["longest_gap_s"].as_f64().is_some_and(|gap_s| gap_s < SILENT_S), "{told}");
    assert_eq!(told["driven"], serde_json::json!(keys(&["arm/3", "arm/4", "line-1/1"])), "{told}");
    // What was driven on the board that went has been stopped.
    drop(gateway);
    let removed = lab.0.succeeds("status --port boards/line-1 --unit 2 --json");
    let removed: Value = serde_json::from_str(&removed).expect("JSON");
    assert_eq!((&removed["state"], &removed["fault"]), (&"Ready".into(), &Value::Null), "{removed:#}");
}

fn secured() {
    for link in ["tls", "quic"] {
        let lab = Lab::new();
        let end_point = format!("{link}/localhost:{}", free_port());
        let folder = lab.0.path("keys").display().to_string();
        let made = client(&end_point, &["certificates", &folder]).wait().expect("it ends");
        assert!(made.success(), "the client says what is wrong above");
        let gateway = lab.gateway_at(end_point, &format!("--zenoh-config {folder}/gateway.json5"));
        let told = gateway.told(&["secure", &folder]);
        assert_eq!(told["None"], serde_json::json!({"kept_out": true}), "{link}: {told}");
        assert_eq!(
            told["viewer"],
            serde_json::json!({"seen": 4, "started": 0, "refused": 0}),
            "{link}: {told}"
        );
        assert_eq!(
            told["driver"],
            serde_json::json!({"seen": 4, "started": 4, "refused": 0}),
            "{link}: {told}"
        );
    }
}

fn with_password() {
    let lab = Lab::new();
    let end_point = format!("tcp/127.0.0.1:{}", free_port());
    let folder = lab.0.path("passwords").display().to_string();
    let made = client(&end_point, &["passwords", &folder]).wait().expect("it ends");
    assert!(made.success(), "the client says what is wrong above");
    let gateway = lab.gateway_at(end_point, &format!("--zenoh-config {folder}/gateway.json5"));
    let told = gateway.told(&["login"]);
    assert_eq!(told, serde_json::json!({"nobody": "kept out", "wrong": "kept out", "driver": 4}));
}

fn killed() {
    let lab = Lab::new();
    let mut gateway = lab.gateway("");
    let mut client = gateway.client(&["drive", "--seconds", "60"]);
    sleep(Duration::from_secs(4));
    gateway.program.kill().expect("it is at work");
    gateway.program.wait().expect("it ends");
    sleep(Duration::from_secs_f64(SILENT_S + LATE_S));
    client.kill().expect("it is at work");
    client.wait().expect("it ends");
    for (line, unit) in [(1, 1), (1, 2), (2, 3), (2, 4)] {
        let status = lab.0.succeeds(&format!("status --port boards/line-{line} --unit {unit} --json"));
        let status: Value = serde_json::from_str(&status).expect("JSON");
        assert_eq!(status["state"], "Fault", "{status:#}");
        assert!(status["command_bar"].as_f64().is_some_and(|command| command.abs() < 1e-3), "{status:#}");
    }
}

fn ros() {
    let lab = Lab::new();
    let told = lab.gateway("--ros-domain 7").told(&["ros"]);
    let endpoints = [
        "MP /diagnostics",
        "MP /lab/joint_states",
        "MS /lab/joint_commands",
        "MS /lab/joint_trajectory",
        "SS /lab/start",
        "SS /lab/stop",
    ];
    assert_eq!(told["endpoints"], serde_json::json!(endpoints), "{told}");
    assert_eq!(told["joints"], serde_json::json!(["line-1/1", "line-1/2", "biceps", "arm/4"]), "{told}");
    assert_eq!((&told["start"][0], &told["stop"][0]), (&true.into(), &true.into()), "{told}");
    let moved = told["moved_to_m"].as_array().expect("a list");
    assert!(moved.iter().all(|m| m.as_f64().is_some_and(|m| (m - 0.03).abs() < 2e-3)), "{told}");
    let played = told["played_to_m"].as_array().expect("a list");
    assert!(played.iter().all(|m| m.as_f64().is_some_and(|m| (m - 0.025).abs() < 2e-3)), "{told}");
}

fn recorded() {
    let lab = Lab::new();
    let mut gateway = lab.gateway("--record lab.mcap");
    gateway.told(&["drive", "--seconds", "4"]);
    assert!(lab.0.files().contains(&"lab.mcap.part".to_owned()));
    common::processes::signal("INT", gateway.program.id());
    assert!(gateway.program.wait().expect("it ends").success());
    let told = gateway.told(&["bag", &lab.0.path("lab.mcap").display().to_string()]);
    let count = |what: &str| told["counts"][format!("/biceps/{what}")].as_u64().unwrap_or_default();
    assert!(count("joint_state") > 100 && count("joint_state") == count("pressure"), "{told}");
    assert!(count("joint_reference") > 50 && count("joint_reference") < count("joint_state"), "{told}");
    assert_eq!(told["joints"], serde_json::json!(["arm/4", "biceps", "line-1/1", "line-1/2"]), "{told}");
    assert!(told["highest_pressure_pa"].as_f64().is_some_and(|pressure| pressure > 1e4), "{told}");
    assert!(lab.0.refuses("gateway lines.toml --record lab.mcap").contains("lab.mcap: there is such a file"));
    // A muscle of it as a recording.
    let map = "pressure=/biceps/pressure.fluid_pressure:Pa,contraction=/biceps/joint_state.position_1:m";
    lab.0.succeeds(&format!("import lab.mcap --map {map} -o biceps.csv"));
    let rows = lab.0.read("biceps.csv");
    assert!(rows.starts_with("time_s,"), "{}", &rows[..80]);
    assert_eq!(rows.lines().count() as u64, count("joint_state") + 1);
}
