//! `mgpi pil` and `mgpi emulate` with the firmware in the emulator, and with plants of every kind.
//!
//! Skipped, in so many words, where emulator or firmware are missing; `cargo xtask test` provides
//! both.

mod common;

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use board_client::emulator::image;
use common::processes::{assert_none_is_left, emulators, signal};
use common::{Bench, PAPER};
use libtest_mimic::{Arguments, Trial};
use wire::{FRAME_BYTES, Receiver, Request, Response, State};

fn main() {
    let missing = common::processes::missing();
    if let Some(reason) = &missing {
        println!("the tests of the firmware in the loop are skipped: {reason}");
    }
    let tests: [(&str, fn()); 15] = [
        ("three_runs_leave_logs_and_figures", three_runs),
        ("two_runs_are_the_same_byte_for_byte", repeatable),
        ("the_example_in_python_is_a_plant", python_example),
        ("a_plant_that_answers_garbage_is_quoted", garbage),
        ("a_plant_that_never_answers_is_an_error", silent),
        ("a_plant_that_stops_answering_is_an_error_with_its_time", late),
        ("a_plant_that_dies_is_an_error_with_its_last_words", dying),
        ("a_plant_that_answers_twice_is_an_error", twice),
        ("a_plant_beyond_its_sensors_is_an_error", beyond),
        ("what_repeats_is_learnt_stored_and_played_back", learnt),
        ("a_plant_that_dies_while_learning_spoils_nothing", learning_broken),
        ("gains_that_the_board_does_not_take_are_an_error", bad_gain),
        ("ctrl_c_leaves_no_process_and_the_log_so_far", interrupted),
        ("the_emulators_death_is_an_error_with_the_firmwares_log", emulator_killed),
        ("the_emulator_by_hand_answers_at_its_port", by_hand),
    ];
    let trials = tests.into_iter().map(|(name, test)| {
        let run = move || {
            test();
            Ok(())
        };
        Trial::test(name, run).with_ignored_flag(missing.is_some())
    });
    libtest_mimic::run(&Arguments::from_args(), trials.collect()).exit()
}

/// A muscle that takes every pressure at once and never moves.
const STIFF: &str = "while read time command; do echo $command 10; done";
/// Half a second.
const SHORT: &str = "time_s,reference_mm\n0,0\n0.25,50\n0.5,0\n";
/// Longer than any test waits.
const LONG: &str = "time_s,reference_mm\n0,0\n5000,50\n";

/// A bench with the paper's model, a reference, and a firmware file of its own, by which its
/// emulators are known.
fn bench(reference: &str) -> Bench {
    let bench = Bench::new();
    bench.write("model.toml", PAPER).write("ref.csv", reference);
    fs::copy(&*image::find(None).expect("checked"), bench.path("firmware.elf")).expect("copied");
    bench
}

/// `mgpi` in the bench's directory.
fn mgpi(bench: &Bench, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mgpi"));
    command.args(arguments).args(["--firmware", "firmware.elf"]).current_dir(bench.path(""));
    command
}

/// `mgpi pil` with a plant in the language of the shell, which is no muscle that the board's
/// monitors know.
fn pil(bench: &Bench, plant: &str, more: &[&str]) -> Command {
    let basic =
        ["pil", "--model", "model.toml", "--reference", "ref.csv", "--no-monitors", "--plant-command", plant];
    mgpi(bench, &[&basic, more].concat())
}

/// The message of a run that must fail with status 2 and write nothing.
fn refusal(plant: &str, more: &[&str]) -> String {
    let bench = bench(SHORT);
    let outputs = ["-o", "log.csv", "--json", "figures.json"];
    refused(&bench, pil(&bench, plant, &[&outputs, more].concat()).output().expect("mgpi runs"))
}

fn refused(bench: &Bench, output: Output) -> String {
    let message = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(!bench.path("log.csv").exists() && !bench.path("figures.json").exists(), "something was written");
    assert_none_is_left(bench);
    message
}

/// Starts a run that goes on until it is ended, and waits until all three plants are being asked.
fn endless(bench: &Bench) -> Child {
    let plant =
        "read line; echo 0 0; read line; touch asked.$$; echo 0 0; while read line; do echo 0 0; done";
    let mut command = pil(bench, plant, &["-o", "log.csv", "--json", "figures.json"]);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("mgpi runs");
    while bench.files().iter().filter(|name| name.starts_with("asked.")).count() < 3 {
        assert!(child.try_wait().expect("a child").is_none(), "it ended");
        std::thread::sleep(Duration::from_millis(20));
    }
    child
}

fn three_runs() {
    let bench = bench(SHORT);
    let logs = ["-o", "both.csv", "--feedforward-log", "ff.csv", "--feedback-log", "fb.csv"];
    let output =
        pil(&bench, STIFF, &[&logs[..], &["--json", "figures.json"]].concat()).output().expect("mgpi runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for log in ["both.csv", "ff.csv", "fb.csv"] {
        let log = bench.read(log);
        let mut lines = log.lines();
        assert_eq!(
            lines.next(),
            Some("time_s,reference_mm,contraction_mm,pressure_bar,command_bar,feedforward_bar,feedback_bar")
        );
        assert_eq!(lines.count(), 501);
        // The plant has held the command of the tick before.
        let rows: Vec<Vec<&str>> = log.lines().skip(1).map(|line| line.split(',').collect()).collect();
        assert!(rows.windows(2).all(|pair| pair[0][4] == pair[1][3]));
    }
    let column = |log: &str, index: usize| -> Vec<f64> {
        let text = bench.read(log);
        text.lines()
            .skip(1)
            .map(|line| line.split(',').nth(index).expect("a field").parse().expect("a number"))
            .collect()
    };
    assert!(column("ff.csv", 6).iter().all(|feedback| *feedback == 0.0));
    assert!(column("fb.csv", 5).iter().all(|feedforward| *feedforward == 0.0));
    assert!(column("both.csv", 5).iter().chain(&column("both.csv", 6)).any(|part| *part != 0.0));

    let figures: serde_json::Value = serde_json::from_str(&bench.read("figures.json")).expect("JSON");
    let keys: Vec<&String> = figures.as_object().expect("an object").keys().collect();
    assert_eq!(keys, ["feedback_only", "feedforward_only", "model", "overruns", "ticks", "tracking"]);
    assert_eq!((&figures["ticks"], &figures["overruns"]), (&501.into(), &0.into()));
    // The plant stands at 10 mm, the reference goes from 0 to 50 mm and back.
    for run in ["tracking", "feedforward_only", "feedback_only"] {
        assert_eq!(figures[run]["max_error_mm"], 40.0);
    }
}

fn repeatable() {
    let results = || {
        let bench = bench(SHORT);
        let output =
            pil(&bench, STIFF, &["-o", "log.csv", "--json", "figures.json"]).output().expect("mgpi runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        (bench.read("log.csv"), bench.read("figures.json"))
    };
    assert!(results() == results(), "two runs differ");
}

fn python_example() {
    if Command::new("python3").arg("--version").output().is_err() {
        return println!("skipped: no python3");
    }
    let example = concat!("python3 ", env!("CARGO_MANIFEST_DIR"), "/../../examples/plant.py");
    let bench = bench(SHORT);
    let output = pil(&bench, example, &["--json", "figures.json"]).output().expect("mgpi runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(bench.read("figures.json").contains("\"ticks\": 501"));
}

fn garbage() {
    let message = refusal("while read line; do echo hello there; done", &[]);
    assert!(
        message.contains("at 0 s: the answer `hello there` is not `pressure_bar contraction_mm"),
        "{message}"
    );
}

fn silent() {
    let message = refusal("cat > /dev/null", &["--plant-timeout-s", "0.2"]);
    assert!(message.contains("the plant `cat > /dev/null`, at 0 s: no answer within 0.2 s"), "{message}");
}

fn late() {
    let message = refusal("read line; echo 0 0; read line; sleep 60", &["--plant-timeout-s", "0.5"]);
    assert!(message.contains("at 0.001 s: no answer within 0.5 s"), "{message}");
}

fn dying() {
    let message = refusal("read line; echo 0 0; read line; echo out of air >&2; exit 3", &[]);
    assert!(message.contains("at 0.001 s: it ended (exit status: 3)\n  out of air"), "{message}");
}

fn twice() {
    let message = refusal("while read line; do printf '1 2\\n3 4\\n'; done", &[]);
    assert!(message.contains("more than one line is answered; the second begins with `3 4`"), "{message}");
}

fn beyond() {
    let message = refusal("while read line; do echo 40 0; done", &[]);
    assert!(message.contains("at 0 s the plant answers the pressure 40 bar, outside"), "{message}");
}

/// A muscle at once and without hysteresis, a fifth shorter than its model: what repeats is a fifth
/// of everything.
const SHORT_OF_IT: &str = r"
import sys
for line in sys.stdin:
    command = float(line.split()[1])
    print(command, 16.0 * command, flush=True)
";

/// Up and down between heights that muscle and model both reach, twice.
const UP_AND_DOWN: &str = "time_s,reference_mm\n0,5\n1,40\n2,5\n3,40\n4,5\n";

fn pass_rmse(said: &str) -> Vec<f64> {
    let lines = said.lines().filter(|line| line.starts_with("pass "));
    lines.map(|line| line.split_whitespace().nth(3).expect("a figure").parse().expect("a number")).collect()
}

/// A bench with a model whose recording has shown that muscle and valve follow at once.
fn prompt(reference: &str) -> Bench {
    let bench = bench(reference);
    let recorded = "[recorded]\nstep_s = 0.005\nnoise_mm = 0.03\nsteeper = 1.2\nlate_s = 0.0\n\
                    late_error_s = 0.001\nvalve_late_s = 0.0\nvalve_late_error_s = 0.001\n";
    bench.write("model.toml", format!("{PAPER}\n{recorded}"));
    bench
}

fn succeeds(command: &mut Command) -> String {
    let output = command.output().expect("mgpi runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

fn learnt() {
    let bench = prompt(UP_AND_DOWN);
    bench.write("plant.py", SHORT_OF_IT);
    let plant = "python3 plant.py";
    let said =
        succeeds(&mut pil(&bench, plant, &["--repeat", "4", "--learn", "learnt.csv", "--json", "j.json"]));
    let passes = pass_rmse(&said);
    assert_eq!(passes.len(), 4, "{said}");
    assert!(passes[3] < 0.5 * passes[0], "{passes:?}");
    let json: serde_json::Value = serde_json::from_str(&bench.read("j.json")).expect("JSON");
    assert_eq!(json["passes"].as_array().map(Vec::len), Some(4));
    // What was learnt stands beside its reference, a row a tick, and is played back.
    let learnt = bench.read("learnt.csv");
    assert!(learnt.starts_with("# learnt by mgpi") && learnt.lines().count() == 4003, "{}", learnt.len());
    let said = succeeds(&mut pil(&bench, plant, &["--correction", "learnt.csv", "--repeat", "2"]));
    let again = pass_rmse(&said);
    assert!(
        (again[0] / passes.iter().copied().fold(f64::INFINITY, f64::min) - 1.0).abs() < 0.05,
        "{again:?} {passes:?}"
    );
    assert!(!learnt.is_empty() && bench.read("learnt.csv") == learnt, "played back, not changed");
}

fn learning_broken() {
    let bench = prompt(UP_AND_DOWN);
    // The third run of the plant, the third pass, dies half way.
    let dies = SHORT_OF_IT.replace(
        "import sys\n",
        "import os, sys\nruns = len(open('runs').read()) if os.path.exists('runs') else 0\nopen('runs', 'a').write('x')\n",
    );
    let dies = dies.replace(
        "    print(",
        "    if runs == 2 and float(line.split()[0]) > 2:\n        sys.exit('torn')\n    print(",
    );
    bench.write("plant.py", dies);
    let options = ["--repeat", "4", "--learn", "learnt.csv", "--json", "j.json"];
    let output = pil(&bench, "python3 plant.py", &options).output().expect("mgpi runs");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("what was learnt in 2 whole passes is kept in learnt.csv"), "{message}");
    assert!(message.contains("torn") && !bench.path("j.json").exists(), "{message}");
    let kept = bench.read("learnt.csv");
    assert!(kept.contains("in 2 passes"), "{kept:.200}");
    // In its first pass it spoils nothing that was there.
    let message = String::from_utf8(
        pil(&bench, "python3 -c 1", &["--repeat", "3", "--learn", "learnt.csv", "--force"])
            .output()
            .expect("runs")
            .stderr,
    )
    .expect("UTF-8");
    assert!(!message.contains("is kept"), "{message}");
    assert_eq!(bench.read("learnt.csv"), kept);
}

fn bad_gain() {
    let message = refusal(STIFF, &["--kp=-1"]);
    assert!(message.contains("kp_bar_per_mm is to be -1; the board takes 0 to 10"), "{message}");
}

fn interrupted() {
    let bench = bench(LONG);
    let child = endless(&bench);
    signal("INT", child.id());
    let output = child.wait_with_output().expect("a child");
    assert_eq!(output.status.code(), Some(130));
    assert_none_is_left(&bench);
    assert!(!bench.path("log.csv").exists() && !bench.path("figures.json").exists(), "something was written");
    assert!(bench.read("log.csv.part").lines().count() > 1, "a row at least");
}

fn emulator_killed() {
    let bench = bench(LONG);
    let child = endless(&bench);
    signal("KILL", emulators(&bench)[0]);
    let message = refused(&bench, child.wait_with_output().expect("a child"));
    assert!(message.contains("the emulator has died: it ended (signal: 9"), "{message}");
    assert!(message.contains("INFO state Tracking"), "{message}");
}

fn by_hand() {
    let bench = bench(SHORT);
    let mut child = mgpi(&bench, &["emulate"]).stdout(Stdio::piped()).spawn().expect("mgpi runs");
    let mut lines = BufReader::new(child.stdout.take().expect("a pipe")).lines().map_while(Result::ok);
    let line = lines.find(|line| line.starts_with("serial port ")).expect("a port is announced");
    let port = line.trim_start_matches("serial port ").split(';').next().expect("a path");
    assert_eq!(identify(port), State::Off);
    signal("INT", child.id());
    assert!(child.wait().expect("a child").success());
    assert_none_is_left(&bench);
}

/// The state of the board at a port.
fn identify(path: &str) -> State {
    let mut port = fs::OpenOptions::new().read(true).write(true).open(path).expect("a port");
    // Bytes as they are; the end of the file when none comes within 20 s.
    let raw = ["-F", path, "raw", "-echo", "min", "0", "time", "200"];
    assert!(Command::new("stty").args(raw).status().is_ok_and(|status| status.success()), "a terminal");
    let mut buffer = [0; FRAME_BYTES];
    port.write_all(wire::encode(&Request::Identify, &mut buffer).expect("fits")).expect("sent");
    let mut receiver = Receiver::new();
    BufReader::new(port)
        .bytes()
        .find_map(|byte| match receiver.push(byte.expect("received"))? {
            Ok(Response::Hello(hello)) => Some(hello.state),
            other => panic!("{other:?}"),
        })
        .expect("an answer")
}
