//! The command as its users meet it: files, dialogue, messages and exit status.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

fn rig(folder: &Path, arguments: &str) -> Output {
    command(folder, arguments).output().unwrap()
}

fn command(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rig"));
    command.current_dir(folder).args(arguments.split_whitespace());
    command
}

/// Feeds `input` to `rig plant` and waits for its end.
fn dialogue(arguments: &str, input: &[u8]) -> Output {
    let mut plant = command(Path::new("."), &format!("plant {arguments}"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    plant.stdin.take().unwrap().write_all(input).unwrap();
    plant.wait_with_output().unwrap()
}

fn assert_refused(output: &Output, message: &str) {
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(stderr.contains(message), "{message:?} is not in {stderr:?}");
}

fn names(folder: &Path) -> Vec<String> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn every_protocol_is_recorded_with_its_origin_header_and_rising_times() {
    let folder = TempDir::new().unwrap();
    for protocol in ["fig8", "rates", "holds", "ramps"] {
        let output =
            rig(folder.path(), &format!("record --protocol {protocol} --rate-hz 30 -o {protocol}.csv"));
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let csv = fs::read_to_string(folder.path().join(format!("{protocol}.csv"))).unwrap();
        let mut lines = csv.lines().skip_while(|line| line.starts_with("# "));
        assert!(csv.starts_with(&format!("# protocol {protocol}, seed 1, rig ")));
        assert_eq!(lines.next(), Some("time_s,command_bar,pressure_bar,contraction_mm"));
        let rows: Vec<Vec<f64>> =
            lines.map(|line| line.split(',').map(|field| field.parse().unwrap()).collect()).collect();
        assert!(rows.len() > 1000 && rows.iter().all(|row| row.len() == 4));
        assert!(rows.windows(2).all(|pair| pair[0][0] < pair[1][0]));
    }
}

#[test]
fn recording_depends_on_nothing_but_its_arguments() {
    let folder = TempDir::new().unwrap();
    let record = |name: &str, arguments: &str| {
        rig(folder.path(), &format!("record --protocol ramps --rate-hz 20 -o {name} {arguments}"));
        fs::read(folder.path().join(name)).unwrap()
    };
    let first = record("first.csv", "--seed 7");
    assert_eq!(first, record("second.csv", "--seed 7"));
    for other in ["--seed 8", "--seed 7 --no-noise", "--seed 7 --load-n 40"] {
        assert_ne!(first, record("other.csv", &format!("--force {other}")));
    }
}

#[test]
fn hidden_effects_are_repeated_by_seed_and_add_the_columns_of_load_and_temperature() {
    let folder = TempDir::new().unwrap();
    let record = |name: &str, arguments: &str| {
        let output = rig(folder.path(), &format!("record --rate-hz 30 -o {name} {arguments}"));
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        fs::read_to_string(folder.path().join(name)).unwrap()
    };
    for plant in ["rig", "mgpi"] {
        let hidden = format!("--protocol rich --plant {plant} --hide creep+load --strength 0.33 --seed 9");
        let first = record("first.csv", &format!("{hidden} --force"));
        assert_eq!(first, record("second.csv", &format!("{hidden} --force")));
        assert!(first.contains("\ntime_s,command_bar,pressure_bar,contraction_mm,load_n,temperature_c\n"));
    }
    let rows =
        |csv: &str| csv.lines().filter(|line| !line.starts_with('#')).map(str::to_owned).collect::<Vec<_>>();
    let none = record("none.csv", "--protocol fig8 --hide none");
    assert_eq!(rows(&none), rows(&record("zero.csv", "--protocol fig8 --hide inertia --strength 0")));
}

#[test]
fn what_is_drawn_at_random_stands_in_the_truth_file_only() {
    let folder = TempDir::new().unwrap();
    for (hide, count) in [("random", 0..=1), ("random-pair", 2..=2)] {
        for seed in 1..6 {
            let arguments =
                format!("record --protocol rich --hide {hide} --seed {seed} --rate-hz 20 --force");
            let output = rig(folder.path(), &format!("{arguments} -o r.csv --truth truth.json"));
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let csv = fs::read_to_string(folder.path().join("r.csv")).unwrap();
            let truth = fs::read_to_string(folder.path().join("truth.json")).unwrap();
            let truth: serde_json::Value = serde_json::from_str(&truth).unwrap();
            let causes: Vec<&String> = truth["causes"].as_object().unwrap().keys().collect();
            assert!(count.contains(&causes.len()), "{causes:?}");
            let comments: String = csv.lines().filter(|line| line.starts_with('#')).collect();
            assert!(causes.iter().all(|cause| !comments.contains(*cause)), "{comments} tells {causes:?}");
            assert!(String::from_utf8_lossy(&output.stdout).is_empty());
        }
    }
}

#[test]
fn existing_file_is_kept_unless_forced() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("kept.csv");
    fs::write(&file, "mine").unwrap();
    for command in ["record --protocol fig8 -o kept.csv", "reference -o kept.csv"] {
        assert_refused(&rig(folder.path(), command), "kept.csv: exists already; --force overwrites it");
        assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
    }
    assert!(rig(folder.path(), "reference -o kept.csv --force").status.success());
    assert!(fs::read_to_string(&file).unwrap().contains("time_s,reference_mm\n0,0\n"));
    assert_eq!(names(folder.path()), ["kept.csv"]);
}

#[test]
fn bad_arguments_are_named_with_their_limits_and_write_nothing() {
    let folder = TempDir::new().unwrap();
    for (arguments, message) in [
        ("record --protocol fig9 -o r.csv", "fig9"),
        ("record --protocol fig8", "--output"),
        ("record --protocol fig8 --rate-hz 0 -o r.csv", "must be from 1 to 10000 Hz"),
        ("record --protocol fig8 --rate-hz NaN -o r.csv", "must be from 1 to 10000 Hz"),
        ("record --protocol fig8 --load-n 500 -o r.csv", "must be from 0 to 80 N"),
        ("record --protocol fig8 --seed x -o r.csv", "--seed"),
        ("record --protocol rich --hide lag -o r.csv", "no effect \"lag\"; there are none, random"),
        ("record --protocol rich --hide creep+creep -o r.csv", "creep is named twice"),
        ("record --protocol rich --hide creep --strength 9 -o r.csv", "must be from 0 to 3 times"),
        ("record --protocol fig8 -o missing/r.csv", "cannot write in missing"),
        ("record --protocol fig8 --force -o .", ".: not a file"),
        ("reference --amplitudes-mm 110,x -o r.csv", "invalid value 'x'"),
        ("reference --amplitudes-mm 1e9 -o r.csv", "must be from 0 to 500 mm"),
        ("reference --period-s 0 -o r.csv", "must be from 0.1 to 3600 s"),
    ] {
        assert_refused(&rig(folder.path(), arguments), message);
        assert_eq!(names(folder.path()), [""; 0], "after {arguments}");
    }
}

#[test]
fn plant_answers_each_line_before_it_gets_the_next_and_ends_with_its_input() {
    let mut plant = command(Path::new("."), "plant --no-noise")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = plant.stdin.take().unwrap();
    let mut answers = BufReader::new(plant.stdout.take().unwrap()).lines();
    let mut last_mm = -10.0;
    for tick in 0..100 {
        writeln!(input, "{} 5", f64::from(tick) * 0.005).unwrap();
        let answer = answers.next().unwrap().unwrap();
        let (pressure, contraction) = answer.split_once(' ').unwrap();
        let pressure_bar: f64 = pressure.parse().unwrap();
        let contraction_mm: f64 = contraction.parse().unwrap();
        assert!((pressure_bar - 5.0 * (1.0 - (-f64::from(tick) * 0.1).exp())).abs() < 1e-9);
        assert!(contraction_mm >= last_mm);
        last_mm = contraction_mm;
    }
    drop(input);
    assert!(plant.wait().unwrap().success());
}

#[test]
fn plant_takes_its_steps_from_the_times() {
    let last = |input: &[u8]| {
        let output = dialogue("--no-noise", input);
        assert!(output.status.success());
        let stdout = String::from_utf8(output.stdout).unwrap();
        stdout.lines().last().unwrap().split_once(' ').unwrap().0.parse::<f64>().unwrap()
    };
    let at_once = last(b"7 3\r\n7.04 3\r\n");
    assert!((at_once - 3.0 * (1.0 - (-0.8f64).exp())).abs() < 1e-9);
    assert!((at_once - last(b"0 3\n0.01 3\n0.015 3\n0.04 3")).abs() < 1e-9);
}

#[test]
fn plant_repeats_itself_by_seed() {
    let input = b"0 1\n0.1 2\n0.2 3\n";
    let run = |arguments| dialogue(arguments, input).stdout;
    assert_eq!(run("--seed 4"), run("--seed 4"));
    assert_ne!(run("--seed 4"), run("--seed 5"));
}

#[test]
fn plant_with_something_hidden_answers_load_and_temperature_too() {
    let answer = |arguments| String::from_utf8(dialogue(arguments, b"0 1\n0.1 2\n").stdout).unwrap();
    for (arguments, fields) in [("", 2), ("--hide creep", 4), ("--hide none --plant mgpi", 4)] {
        assert!(answer(arguments).lines().all(|line| line.split(' ').count() == fields), "{arguments}");
    }
}

#[test]
fn plant_names_the_line_and_the_field_it_cannot_take() {
    for (input, message) in [
        (&b"0 1\n0.1 abc\n"[..], "line 2: command_bar is \"abc\", not a finite number"),
        (b"x 1\n", "line 1: time_s is \"x\", not a finite number"),
        (b"0 inf\n", "line 1: command_bar is \"inf\", not a finite number"),
        (b"0 1\n\n", "line 2: 2 numbers expected, `time_s command_bar`, found \"\""),
        (b"0 1 2\n", "line 1: 2 numbers expected"),
        (b"0 1\n1 1\n1 1\n", "line 3: time_s is 1 s, not after the previous line's 1 s"),
        (b"\xff\xfe 1\n", "line 1: not text"),
        (&[b'1'; 300], "line 1: longer than 256 bytes"),
    ] {
        assert_refused(&dialogue("", input), message);
    }
}

#[test]
fn kept_recordings_are_what_their_comment_lines_make() {
    let folder = TempDir::new().unwrap();
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings");
    for name in ["rig-fig8.csv", "rig-ramps.csv", "reference-cosines.csv"] {
        let csv = fs::read_to_string(kept.join(name)).unwrap();
        let arguments = csv.lines().find_map(|line| line.strip_prefix("# rig ")).unwrap();
        let output = rig(folder.path(), &format!("{arguments} -o {name}"));
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(
            fs::read_to_string(folder.path().join(name)).unwrap() == csv,
            "{name} differs: write it anew"
        );
    }
}
