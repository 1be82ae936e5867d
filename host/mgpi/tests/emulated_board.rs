//! `mgpi emulate` as a board is used, and as things go wrong: with its muscle torn off, its host or
//! itself killed.
//!
//! Skipped, in so many words, where emulator or firmware are missing; `cargo xtask test` provides
//! both.

mod common;

use std::fs;
use std::io::Read;
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use common::processes::{assert_none_is_left, emulators, signal};
use common::{Bench, PAPER};
use libtest_mimic::{Arguments, Trial};
use serde_json::Value;

fn main() {
    let missing = common::processes::missing();
    if let Some(reason) = &missing {
        println!("the tests of the emulated board are skipped: {reason}");
    }
    let tests: [(&str, fn()); 11] = [
        ("a_muscle_that_is_torn_off_vents_within_200_ticks", torn_off),
        ("without_monitors_a_muscle_that_is_torn_off_is_not_noticed", torn_off_unnoticed),
        ("a_sensor_that_stands_still_ends_pil_with_its_fault_and_keeps_the_logs", frozen),
        ("a_killed_capture_leaves_the_board_vented", killed_capture),
        ("an_interrupted_track_keeps_its_log", interrupted_track),
        ("a_board_that_is_lost_while_learning_spoils_nothing", learning_lost),
        ("a_killed_emulator_leaves_no_program_and_no_way_to_another_board", killed_emulator),
        ("a_port_has_one_emulator", one_a_port),
        ("an_emulator_that_cannot_start_says_why_in_the_background_too", no_start),
        ("readiness_is_told_on_a_descriptor", ready),
        ("a_calibrated_sensor_shows_what_the_gauge_shows_whatever_is_deployed", calibrated),
    ];
    let trials = tests.into_iter().map(|(name, test)| {
        let run = move || {
            test();
            Ok(())
        };
        Trial::test(name, run).with_ignored_flag(missing.is_some())
    });
    // One at a time: the board keeps real time.
    let arguments = Arguments { test_threads: Some(1), ..Arguments::from_args() };
    libtest_mimic::run(&arguments, trials.collect()).exit()
}

/// Up and down, an approach to every height; half a minute.
const REFERENCE: &str = "time_s,reference_mm\n0,10\n4,60\n8,10\n12,60\n16,10\n20,60\n30,10\n";

/// Patience for a machine that does much else; less than the board has with a silent bus.
const BUS: [&str; 4] = ["--port", "board", "--timeout-s", "0.4"];

/// A bench with the paper's model and a reference.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("model.toml", PAPER).write("ref.csv", REFERENCE);
    bench
}

fn mgpi(bench: &Bench, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mgpi"));
    command.args(arguments).current_dir(bench.path(""));
    command
}

fn output(bench: &Bench, arguments: &[&str]) -> Output {
    mgpi(bench, arguments).output().expect("mgpi runs")
}

fn succeeds(bench: &Bench, arguments: &[&str]) -> String {
    let output = output(bench, arguments);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {message}");
    String::from_utf8(output.stdout).expect("UTF-8")
}

fn refused(bench: &Bench, arguments: &[&str]) -> String {
    let output = output(bench, arguments);
    let message = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    message
}

/// The emulated board at the port `board`, until this is dropped.
struct Emulated<'a>(&'a Bench);

impl<'a> Emulated<'a> {
    fn start(bench: &'a Bench, more: &[&str]) -> Self {
        succeeds(bench, &[&["emulate", "--port", "board", "--background"], more].concat());
        assert!(bench.path("board").exists(), "the port is there when the command returns");
        Self(bench)
    }

    fn run(&self, arguments: &[&str]) -> Output {
        output(self.0, &[arguments, &BUS].concat())
    }

    fn spawn(&self, arguments: &[&str]) -> Child {
        mgpi(self.0, &[arguments, &BUS].concat()).stderr(Stdio::piped()).spawn().expect("mgpi runs")
    }

    fn status(&self) -> Value {
        serde_json::from_slice(&self.run(&["status", "--json"]).stdout).expect("JSON")
    }
}

impl Drop for Emulated<'_> {
    fn drop(&mut self) {
        // A test that fails already says more than this.
        let ended = output(self.0, &["emulate", "--port", "board", "--stop"]);
        if !std::thread::panicking() {
            assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
            assert!(!self.0.path("board").is_symlink(), "the port goes with the emulator");
            assert_none_is_left(self.0);
        }
    }
}

/// The rig, whose muscle slides off its clamp, 3 mm a tick, 6 s after it was first driven; from
/// when it is all off, the file `torn` has the time.
const TORN_OFF: &str = r#"
import subprocess, sys
rig = subprocess.Popen([sys.argv[1], "rig", "plant"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
begin, slid = None, 0.0
for line in sys.stdin:
    rig.stdin.write(line)
    rig.stdin.flush()
    pressure, contraction = map(float, rig.stdout.readline().split())
    time, command = map(float, line.split())
    begin = time if begin is None and command > 0.5 else begin
    if begin is not None and time > begin + 6.0:
        slid += 3.0
        if contraction - slid <= -7.0 < contraction - slid + 3.0:
            open("torn", "w").write(str(time))
        contraction = max(contraction - slid, -7.0)
    print(pressure, contraction, flush=True)
"#;

/// Tracks with a muscle that is torn off, on a board with these options; none without Python.
fn track_torn_off(bench: &Bench, options: &[&str]) -> Option<(Output, Value)> {
    if Command::new("python3").arg("--version").output().is_err() {
        println!("skipped: no python3");
        return None;
    }
    bench.write("torn.py", TORN_OFF);
    let plant = format!("python3 torn.py {}", env!("CARGO_BIN_EXE_mgpi"));
    let board = Emulated::start(bench, &[&["--plant-command", &plant], options].concat());
    let deployed = board.run(&["deploy", "model.toml"]);
    assert!(deployed.status.success(), "{}", String::from_utf8_lossy(&deployed.stderr));
    let tracked = board.run(&["track", "--reference", "ref.csv", "-o", "log.csv"]);
    Some((tracked, board.status()))
}

fn torn_off() {
    let bench = bench();
    let Some((tracked, status)) = track_torn_off(&bench, &[]) else { return };
    let message = String::from_utf8_lossy(&tracked.stderr);
    assert_eq!(tracked.status.code(), Some(2), "{message}");
    assert!(message.contains("contraction implausible for the pressure (10, Implausible)"), "{message}");
    assert_eq!((&status["state"], &status["fault"]["number"]), (&"Fault".into(), &10.into()));
    assert_eq!(status["command_bar"], 0.0);
    // The plant's time is the number of the tick, from 0 on.
    let torn_s: f64 = bench.read("torn").parse().expect("a time");
    let after = status["record"]["tick"].as_f64().expect("a tick") - 1e3 * torn_s;
    assert!((150.0..=201.0).contains(&after), "vented after {after} ticks");
    assert!(message.contains("what was tracked is kept in log.csv.part"), "{message}");
    assert!(!bench.path("log.csv").exists() && bench.read("log.csv.part").lines().count() > 100);
}

fn torn_off_unnoticed() {
    let bench = bench();
    let Some((tracked, status)) = track_torn_off(&bench, &["--no-monitors"]) else { return };
    assert!(tracked.status.success(), "{}", String::from_utf8_lossy(&tracked.stderr));
    assert_eq!((&status["state"], &status["fault"]), (&"Ready".into(), &Value::Null));
}

fn frozen() {
    let bench = bench();
    // A valve that follows at once, and a length sensor that always reads 10 mm.
    let plant = "while read time command; do echo $command 10; done";
    let pil = ["pil", "--model", "model.toml", "--reference", "ref.csv", "--plant-command", plant];
    let logs = ["-o", "log.csv", "--feedforward-log", "ff.csv", "--feedback-log", "fb.csv"];
    let message = refused(&bench, &[&pil[..], &logs].concat());
    assert!(message.contains("contraction sensor stuck (7, ContractionStuck)"), "{message}");
    assert!(message.contains("cause: ") && message.contains("cure: "), "{message}");
    // The first run with a fault stops the others, wherever they are.
    let runs = [
        ("and feedback", "log.csv.part"),
        ("feed-forward only", "ff.csv.part"),
        ("feedback only", "fb.csv.part"),
    ];
    let (_, kept) = runs.iter().find(|(run, _)| message.contains(run)).expect("a run is named");
    assert!(message.contains(&format!("what was tracked is kept in {kept}")), "{message}");
    assert!(bench.read(kept).lines().count() > 200);
    let whole = bench.files().into_iter().filter(|file| file.ends_with(".csv"));
    assert_eq!(whole.collect::<Vec<_>>(), ["ref.csv"]);
    let again = refused(&bench, &[&pil[..], &logs].concat());
    assert!(again.contains("part: there is a part of an earlier run already; --force"), "{again}");
    succeeds(&bench, &[&pil[..], &logs, &["--force", "--no-monitors"]].concat());
    assert_eq!(bench.files(), ["fb.csv", "ff.csv", "log.csv", "model.toml", "ref.csv"]);
}

/// Waits until a log has so many rows.
fn wait_for_rows(bench: &Bench, file: &str, rows: usize) {
    let deadline = Instant::now() + Duration::from_secs(60);
    while fs::read_to_string(bench.path(file)).unwrap_or_default().lines().count() < rows {
        assert!(Instant::now() < deadline, "{file} does not grow");
        sleep(Duration::from_millis(20));
    }
}

fn killed_capture() {
    let bench = bench();
    let board = Emulated::start(&bench, &[]);
    bench.write("exc.csv", "time_s,command_bar\n0,0\n1,5.5\n60,5.5\n");
    let mut capture = board.spawn(&["capture", "--excitation", "exc.csv", "-o", "rec.csv", "--every", "10"]);
    wait_for_rows(&bench, "rec.csv.part", 200);
    signal("KILL", capture.id());
    capture.wait().expect("a child");
    // Nobody asks the board for longer than it bears; on a busy machine its time passes several
    // times more slowly.
    sleep(Duration::from_secs(10));
    let status = board.status();
    assert_eq!((&status["state"], &status["fault"]["number"]), (&"Fault".into(), &21.into()), "{status}");
    assert_eq!(status["command_bar"], 0.0);
    assert!(status["pressure_bar"].as_f64().expect("a number") < 1.0, "{status}");
    assert!(bench.read("rec.csv.part").lines().count() >= 200, "what was recorded is there");
}

fn interrupted_track() {
    let bench = bench();
    let board = Emulated::start(&bench, &[]);
    assert!(board.run(&["deploy", "model.toml"]).status.success());
    let track = ["track", "--reference", "ref.csv", "-o", "log.csv", "--json", "figures.json"];
    let child = board.spawn(&track);
    wait_for_rows(&bench, "log.csv.part", 100);
    signal("INT", child.id());
    let ended = child.wait_with_output().expect("a child");
    let message = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(130), "{message}");
    assert!(message.contains("what was tracked is kept in log.csv.part"), "{message}");
    assert!(!bench.path("log.csv").exists() && !bench.path("figures.json").exists());
    let kept = bench.read("log.csv.part");
    let head = "time_s,reference_mm,contraction_mm,pressure_bar,command_bar,feedforward_bar,feedback_bar\n";
    assert!(kept.starts_with(head) && kept.lines().count() >= 100, "{kept}");
    let again = board.run(&track);
    let message = String::from_utf8_lossy(&again.stderr);
    assert!(
        message.contains("there is a part of an earlier run already; --force overwrites it"),
        "{message}"
    );
    assert_eq!(board.status()["state"], "Ready", "vented");
}

fn wait_for_port(bench: &Bench) {
    let deadline = Instant::now() + Duration::from_secs(60);
    while !bench.path("board").exists() {
        assert!(Instant::now() < deadline, "no port");
        sleep(Duration::from_millis(20));
    }
}

/// The emulator is killed in the third pass of a learning.
fn learning_lost() {
    let bench = bench();
    bench.write("ref.csv", "time_s,reference_mm\n0,5\n2,50\n4,10\n");
    let recorded = "[recorded]\nstep_s = 0.01\nnoise_mm = 0.03\nsteeper = 1.3\nlate_s = 0.0\n\
                    late_error_s = 0.002\nvalve_late_s = 0.05\nvalve_late_error_s = 0.001\n\
                    valve_second_order_least = 0.0\nvalve_second_order_most = 0.0\n";
    bench.write("model.toml", format!("{PAPER}\n{recorded}"));
    succeeds(&bench, &["tune", "model.toml", "-o", "tuned.toml"]);
    let mut emulator = mgpi(&bench, &["emulate", "--port", "board"]).spawn().expect("mgpi runs");
    wait_for_port(&bench);
    let said = succeeds(&bench, &[&["deploy", "tuned.toml"][..], &BUS].concat());
    assert!(said.contains("tuned, largest sensitivity") && said.contains(": tuned for this model"), "{said}");
    let learn = ["track", "--reference", "ref.csv", "--model", "tuned.toml", "--repeat"];
    let said = succeeds(&bench, &[&learn[..], &["3", "--learn", "learnt.csv"], &BUS].concat());
    let passes = said.lines().filter(|line| line.starts_with("pass ")).count();
    assert!(passes >= 2, "{said}");
    assert!(bench.read("learnt.csv").contains("time_s,reference_mm,correction_mm"), "{said}");
    let on = ["9", "--correction", "learnt.csv", "--learn", "more.csv"];
    let mut child = mgpi(&bench, &[&learn[..], &on, &BUS].concat());
    let mut child = child.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("mgpi runs");
    let mut lines = std::io::BufRead::lines(std::io::BufReader::new(child.stdout.take().expect("a pipe")));
    // Two passes have come to their end.
    let done = lines.by_ref().map_while(Result::ok).filter(|line| line.starts_with("pass ")).take(2);
    assert_eq!(done.count(), 2);
    signal("KILL", emulator.id());
    emulator.wait().expect("a child");
    let output = child.wait_with_output().expect("it ends");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("whole passes is kept in more.csv"), "{message}");
    assert!(bench.read("more.csv").contains("time_s,reference_mm,correction_mm"), "{message}");
}

fn killed_emulator() {
    let bench = bench();
    let mut emulator = mgpi(&bench, &["emulate", "--port", "board"]).spawn().expect("mgpi runs");
    wait_for_port(&bench);
    assert_eq!(emulators(&bench).len(), 1);
    signal("KILL", emulator.id());
    emulator.wait().expect("a child");
    assert_none_is_left(&bench);
    assert!(bench.path("board").is_symlink(), "nobody was there to remove it");
    // Another board, which is given the terminal of the one before.
    succeeds(&bench, &["emulate", "--port", "other", "--background"]);
    let message = refused(&bench, &["status", "--port", "board"]);
    assert!(message.contains("gone"), "{message}");
    let said = succeeds(&bench, &["emulate", "--port", "board", "--background"]);
    assert!(said.contains("board: was left by an emulator that was killed, and is replaced"), "{said}");
    succeeds(&bench, &["status", "--port", "board"]);
    succeeds(&bench, &["emulate", "--port", "board", "--stop"]);
    succeeds(&bench, &["status", "--port", "other"]);
    succeeds(&bench, &["emulate", "--port", "other", "--stop"]);
    assert_none_is_left(&bench);
    let message = refused(&bench, &["emulate", "--port", "other", "--stop"]);
    assert!(message.contains("no emulator has this port"), "{message}");
}

fn one_a_port() {
    let bench = bench();
    let board = Emulated::start(&bench, &[]);
    let message = refused(&bench, &["emulate", "--port", "board"]);
    assert!(message.contains("an emulator has it, process "), "{message}");
    assert_eq!(board.status()["state"], "Off", "the first is undisturbed");
}

fn no_start() {
    let bench = bench();
    for more in [&["--background"][..], &[]] {
        let message =
            refused(&bench, &[&["emulate", "--port", "board", "--firmware", "none.elf"], more].concat());
        assert!(message.starts_with("error: none.elf: no such file"), "{message}");
    }
    assert_none_is_left(&bench);
}

fn ready() {
    let bench = bench();
    let mut emulator = mgpi(&bench, &["emulate", "--port", "board", "--ready-fd", "2"])
        .stderr(Stdio::piped())
        .spawn()
        .expect("mgpi runs");
    let mut line = [0; 6];
    emulator.stderr.take().expect("a pipe").read_exact(&mut line).expect("a line");
    assert_eq!(&line, b"ready\n");
    succeeds(&bench, &["status", "--port", "board"]);
    signal("TERM", emulator.id());
    assert!(emulator.wait().expect("a child").success());
    assert_none_is_left(&bench);
}

/// A gauge that shows 0.1 bar more than the sensor, and a twentieth: the board shows the same
/// behind the calibration, and behind a model that is deployed.
fn calibrated() {
    let bench = bench();
    let board = Emulated::start(&bench, &[]);
    let said = board.run(&["calibrate", "pressure", "--low", "0", "--high", "4", "--readings", "0.1,4.3"]);
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    // The muscle has to empty first.
    let is_near = |status: &Value| (status["pressure_bar"].as_f64().expect("a pressure") - 0.1).abs() < 0.05;
    let comes = || (0..40).any(|_| is_near(&board.status()));
    assert!(comes(), "{}", board.status());
    let deployed = board.run(&["deploy", "model.toml"]);
    assert!(deployed.status.success(), "{}", String::from_utf8_lossy(&deployed.stderr));
    assert!(comes(), "{}", board.status());
}
