//! Samples that are no measurement, or whose past is unknown, have no part in a model, and that is
//! said.

mod common;

use common::{Bench, recording};
use serde_json::Value;

/// The recording with another contraction in some lines of the file, counted from 1.
fn spoilt(bench: &Bench, lines: std::ops::RangeInclusive<usize>, value: f64) {
    let spoil = |(line, text): (usize, &str)| match text.rsplit_once(',') {
        Some((head, _)) if lines.contains(&line) => format!("{head},{value}\n"),
        _ => format!("{text}\n"),
    };
    let text: String = (1..).zip(bench.read("rec.csv").lines()).map(spoil).collect();
    bench.write("spoilt.csv", text);
}

fn bench() -> Bench {
    let bench = Bench::new();
    recording(&bench, "rec.csv");
    bench
}

/// What a command says is not scored.
fn not_scored(said: &str) -> Vec<String> {
    said.lines().filter(|line| line.starts_with("not scored")).map(str::to_owned).collect()
}

fn identified(bench: &Bench, file: &str) -> (String, Value) {
    let said = bench.succeeds(&format!("identify {file} -o m.toml --json j.json --starts 3 --force"));
    (said, serde_json::from_str(&bench.read("j.json")).expect("JSON"))
}

#[test]
fn a_wild_row_sets_neither_the_stroke_nor_the_error_and_is_listed_with_its_line() {
    let bench = bench();
    let (said, sound) = identified(&bench, "rec.csv");
    assert_eq!(not_scored(&said), [""; 0]);
    spoilt(&bench, 500..=500, 999.0);
    let (said, spoilt) = identified(&bench, "spoilt.csv");
    assert!(said.contains("contraction_mm is 999 mm in line 500 (24.900 s)"), "{said}");
    let number = |json: &Value, at: &str| json.pointer(at).and_then(Value::as_f64).expect("a number");
    assert_eq!(number(&spoilt, "/stroke_mm"), number(&sound, "/stroke_mm"));
    let rmse = [&spoilt, &sound].map(|json| number(json, "/training/rmse_mm"));
    assert!(rmse[0] < rmse[1] + 0.01, "{rmse:?}");
    assert_eq!(spoilt.pointer("/left_out/drop_outs/0/first_line"), Some(&500.into()));
}

#[test]
fn a_run_of_zeros_is_left_out_by_every_command_and_said() {
    let bench = bench();
    spoilt(&bench, 280..=299, 0.0);
    let (identify, _) = identified(&bench, "spoilt.csv");
    let said = not_scored(&identify);
    assert!(said.len() == 1 && said[0].contains("20 samples are no measurement"), "{said:?}");
    assert!(said[0].contains("contraction_mm is 0 mm in lines 280 to 299"), "{said:?}");
    let diagnose = bench.succeeds("diagnose spoilt.csv --report d.html --json d.json");
    assert_eq!(not_scored(&diagnose), said);
    let compare = bench.succeeds("compare spoilt.csv --models sgpi --sizes 3/3 --starts 2");
    assert_eq!(not_scored(&compare), said);
    let simulate = bench.succeeds("simulate m.toml --input spoilt.csv -o out.csv");
    assert_eq!(not_scored(&simulate), said);
    assert!(bench.read("d.html").contains("contraction_mm is 0 mm in lines 280 to 299"));
    // The measured column stays as it was measured.
    assert!(bench.read("out.csv").lines().nth(285).expect("a line").split(',').nth(3) == Some("0"));
}

#[test]
fn a_sensor_that_drops_out_again_and_again_is_unexplained() {
    let bench = bench();
    let drops = |(line, text): (usize, &str)| match text.rsplit_once(',') {
        Some((head, _)) if (100..1150).contains(&line) && line % 150 < 3 => format!("{head},-999\n"),
        _ => format!("{text}\n"),
    };
    let text: String = (1..).zip(bench.read("rec.csv").lines()).map(drops).collect();
    bench.write("spoilt.csv", text);
    let said = bench.succeeds("diagnose spoilt.csv");
    assert!(said.starts_with("spoilt.csv: unexplained"), "{said}");
    assert!(not_scored(&said)[0].contains("contraction_mm is -999 mm"), "{said}");
}

#[test]
fn what_precedes_a_known_past_is_left_out_alike_by_identify_and_diagnose() {
    let bench = bench();
    let text = bench.read("rec.csv");
    let rows: Vec<&str> = text.lines().collect();
    bench.write("within.csv", [&rows[..1], &rows[40..]].concat().join("\n"));
    let (identify, json) = identified(&bench, "within.csv");
    let said = not_scored(&identify);
    assert!(said.len() == 1 && said[0].contains("are history of the input only"), "{said:?}");
    assert_eq!(not_scored(&bench.succeeds("diagnose within.csv")), said);
    assert!(json.pointer("/left_out/history_only_samples").and_then(Value::as_u64) > Some(0));
}

#[test]
fn the_json_of_every_analysis_has_what_was_done_to_the_file_and_what_was_left_out() {
    let bench = bench();
    spoilt(&bench, 280..=299, 0.0);
    let stutter = bench.read("spoilt.csv").replacen("\n5,", "\n5,0,0\n5,", 1);
    bench.write("both.csv", stutter);
    for command in [
        "identify both.csv -o m.toml --starts 2 --no-holdout",
        "diagnose both.csv",
        "compare both.csv --models sgpi --sizes 3/3 --starts 2",
    ] {
        bench.succeeds(&format!("{command} --json j.json --force"));
        let json: Value = serde_json::from_str(&bench.read("j.json")).expect("JSON");
        let note = "1 row with a repeated time was averaged with those of the same time";
        assert_eq!(json["notes"], serde_json::json!([note]), "{command}");
        let samples = json.pointer("/left_out/drop_outs/0/samples").and_then(Value::as_u64);
        assert_eq!(samples, Some(20), "{command}: {}", json["left_out"]);
    }
}
