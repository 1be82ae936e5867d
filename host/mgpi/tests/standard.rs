//! `-` is standard input where a file is read, and standard output where one is written.

mod common;

use common::{Bench, recording};

fn bench() -> Bench {
    let bench = Bench::new();
    recording(&bench, "rec.csv");
    bench
}

#[test]
fn a_recording_and_a_model_come_from_standard_input() {
    let bench = bench();
    bench.succeeds("simulate paper.toml --input rec.csv -o file.csv");
    let (recording, model) = (bench.read("rec.csv"), bench.read("paper.toml"));
    for (arguments, content) in [
        ("simulate paper.toml --input - -o rec-out.csv", recording.as_bytes()),
        ("simulate - --input rec.csv -o model-out.csv", model.as_bytes()),
    ] {
        let output = bench.fed(arguments, content);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    assert_eq!(bench.read("rec-out.csv"), bench.read("file.csv"));
    assert_eq!(bench.read("model-out.csv"), bench.read("file.csv"));
}

#[test]
fn a_file_on_standard_output_is_clean() {
    let bench = bench();
    bench.succeeds("simulate paper.toml --input rec.csv -o file.csv");
    let output = bench.mgpi("simulate paper.toml --input rec.csv -o -");
    assert_eq!(String::from_utf8_lossy(&output.stdout), bench.read("file.csv"));
    assert!(String::from_utf8_lossy(&output.stderr).contains("rows simulated"));
    let text = bench.succeeds("identify rec.csv -o model.toml --json - --starts 2 --no-holdout");
    let figures: serde_json::Value = serde_json::from_str(&text).expect("JSON alone");
    assert_eq!(figures["notes"], serde_json::json!([]));
    assert!(bench.succeeds("plan --causes creep -o -").contains("\ntime_s,command_bar\n"));
}

#[test]
fn standard_input_is_read_once_and_named_in_messages() {
    let bench = bench();
    let message = bench.refuses("identify - -o model.toml --validate -");
    assert_eq!(message, "error: standard input (-): named for two inputs, and can be read once only\n");
    let output = bench.fed("identify - -o model.toml", b"time_s,pressure_bar\n0,1\n");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.starts_with("error: standard input: no column contraction_mm"), "{message}");
    assert_eq!(output.status.code(), Some(2));
    let message = bench.refuses("identify rec.csv -o - --json -");
    assert_eq!(message, "error: -: named for two outputs\n");
}

#[test]
fn what_was_done_to_read_a_file_is_said_and_kept() {
    let bench = bench();
    let text = bench.read("rec.csv").replacen("\n5,", "\n5,0,0\n5,", 1);
    bench.write("stutter.csv", &text);
    let output = bench.mgpi("identify stutter.csv -o model.toml --json r.json --starts 2 --no-holdout");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let note = "1 row with a repeated time was averaged with those of the same time";
    assert!(said.contains(&format!("note: stutter.csv: {note}\n")), "{said}");
    let figures: serde_json::Value = serde_json::from_str(&bench.read("r.json")).expect("JSON");
    assert_eq!(figures["notes"][0], note);
    let message = bench.refuses("identify stutter.csv -o strict.toml --strict");
    assert_eq!(
        message,
        format!("error: stutter.csv: --strict refuses what would have to be mended: {note}\n")
    );
}

#[test]
fn a_model_is_simulated_on_a_recording_in_another_unit() {
    let bench = bench();
    let said = bench.succeeds("simulate paper.toml --input rec.csv -o bar.csv");
    let rows: String = bench
        .read("rec.csv")
        .lines()
        .skip(1)
        .map(|line| {
            let fields: Vec<f64> = line.split(',').map(|field| field.parse().expect("a number")).collect();
            format!("{},{},{}\n", 1e3 * fields[0], 100.0 * fields[1], 0.1 * fields[2])
        })
        .collect();
    bench.write("other.csv", format!("t,Pressure [kPa],x\n{rows}"));
    let options = "--columns time=t:ms,contraction=x:cm";
    let other = bench.succeeds(&format!("simulate paper.toml --input other.csv -o kpa.csv {options}"));
    let figures = |said: &str| said.lines().last().expect("figures").to_owned();
    assert_eq!(figures(&other), figures(&said));
}
