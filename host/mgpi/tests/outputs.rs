//! What the commands write, and that they never write over or half of it.

mod common;

use common::{Bench, recording};
use serde_json::Value;

fn bench() -> Bench {
    let bench = Bench::new();
    recording(&bench, "rec.csv");
    bench
}

#[test]
fn an_existing_file_is_kept_unless_forced() {
    let bench = bench();
    bench.write("r.html", "mine");
    let command = "identify rec.csv -o model.toml --report r.html --starts 2";
    let message = bench.refuses(command);
    assert_eq!(message, "error: r.html: exists already; --force overwrites it\n");
    assert_eq!(bench.read("r.html"), "mine");
    bench.succeeds(&format!("{command} --force"));
    assert!(bench.read("r.html").starts_with("<!DOCTYPE html>"));
}

#[test]
fn a_file_for_two_outputs_is_refused() {
    let message = bench().refuses("identify rec.csv -o out --report out");
    assert_eq!(message, "error: out: named for two outputs\n");
}

#[test]
fn a_missing_directory_is_refused_before_the_work() {
    let message = bench().refuses("simulate paper.toml --input rec.csv -o nowhere/out.csv");
    assert_eq!(message, "error: nowhere/out.csv: cannot be written: there is no directory nowhere\n");
}

#[test]
fn the_figures_have_the_agreed_keys() {
    let bench = bench();
    bench.succeeds("identify rec.csv -o model.toml --json r.json --validate rec.csv --starts 2");
    let json: Value = serde_json::from_str(&bench.read("r.json")).expect("JSON");
    let keys = |value: &Value| -> Vec<String> {
        let mut keys: Vec<String> = value.as_object().expect("an object").keys().cloned().collect();
        keys.sort();
        keys
    };
    let all = [
        "collinear",
        "correlation",
        "heldout",
        "heldout_from_s",
        "invertible",
        "left_out",
        "notes",
        "outlier_rows",
        "parameters",
        "preconditioned",
        "recordings",
        "residual_memory_rows",
        "seconds",
        "smallest_slope",
        "starts",
        "stroke_mm",
        "termination",
        "training",
        "validity",
        "worth",
    ];
    assert_eq!(keys(&json), all);
    assert_eq!(keys(&json["training"]), ["mae_mm", "max_error_mm", "rmse_mm"]);
    assert_eq!(json["heldout"], json["training"]);
    assert_eq!(json["invertible"], true);
    let parameter = &json["parameters"][1];
    assert_eq!(keys(parameter), ["identifiable", "interval", "name", "standard_error", "unit", "value"]);
    let number = |value: &Value| value.as_f64().expect("a number");
    let (low, high) = (number(&parameter["interval"][0]), number(&parameter["interval"][1]));
    assert!(low < number(&parameter["value"]) && number(&parameter["value"]) < high);
    assert!((number(&json["correlation"][1][1]) - 1.0).abs() < 1e-9);
    assert_eq!(keys(&json["validity"]), ["input_max_bar", "input_min_bar"]);
    assert_eq!(keys(&json["smallest_slope"]), ["output_mm", "plays"]);
    assert_eq!(json["parameters"][1]["unit"], "1/bar");
}

#[test]
fn without_another_recording_the_later_cycles_are_held_out() {
    let bench = bench();
    bench.succeeds("identify rec.csv -o model.toml --json r.json --starts 2");
    let json: Value = serde_json::from_str(&bench.read("r.json")).expect("JSON");
    // Six triangles of 10 s: three and three.
    assert_eq!(json["heldout_from_s"], 30.0);
    assert!(json["heldout"]["rmse_mm"].is_f64() && json["heldout"] != json["training"]);
    bench.succeeds("identify rec.csv -o model.toml --json r.json --starts 2 --no-holdout --force");
    let json: Value = serde_json::from_str(&bench.read("r.json")).expect("JSON");
    assert!(json["heldout"].is_null() && json["heldout_from_s"].is_null());
}

#[test]
fn other_columns_bring_their_units_into_figures_and_model() {
    let bench = bench();
    let text = bench.read("rec.csv");
    let (_, rows) = text.split_once('\n').expect("a header");
    bench.write("force.csv", format!("time_s,position_mm,force_n\n{rows}"));
    bench.succeeds(
        "identify force.csv -o model.toml --json r.json --input position_mm --output force_n --starts 2",
    );
    let json: Value = serde_json::from_str(&bench.read("r.json")).expect("JSON");
    assert!(json["training"]["rmse_n"].is_f64() && json["stroke_n"].is_f64());
    assert!(json["heldout"]["rmse_n"].is_f64());
    let model = bench.read("model.toml");
    for key in ["c1_per_mm", "weights_n", "input_max_mm", "rmse_n", "stroke_n"] {
        assert!(model.contains(key), "{key} is missing");
    }
}

#[test]
fn simulation_of_a_measured_recording_adds_the_measurement_and_the_error() {
    let bench = bench();
    bench.succeeds("simulate paper.toml --input rec.csv -o out.csv");
    let text = bench.read("out.csv");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("time_s,pressure_bar,contraction_mm,measured_contraction_mm,error_mm"));
    for line in lines {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!((fields[2], fields[4]), (fields[3], "0"));
    }
}

#[test]
fn the_report_is_one_file_that_needs_nothing_from_outside() {
    let bench = bench();
    bench.succeeds("identify rec.csv -o model.toml --report r.html --starts 2");
    let page = bench.read("r.html");
    assert_self_contained(&page, 11);
    for text in [
        "Loops: contraction over pressure",
        "Error over time",
        "Error over the input",
        "Envelope of the plays",
        "Weights of the plays",
        "Dead-zone map",
        "standard error",
        "c0",
    ] {
        assert!(page.contains(text), "{text} is missing");
    }
}

#[test]
fn the_report_shows_the_parts_that_a_model_has() {
    let bench = bench();
    let drawings = |options: &str| {
        bench.succeeds(&format!(
            "identify rec.csv -o m.toml --report r.html --starts 2 --force --no-holdout {options}"
        ));
        let page = bench.read("r.html");
        ["Envelope of", "Envelopes of", "Weights of", "Dead-zone map", "Added function"]
            .map(|part| page.contains(&format!("<title>{part}")))
    };
    assert_eq!(drawings("--model cpi"), [false, false, true, false, false]);
    assert_eq!(drawings("--model mpi"), [false, false, true, true, false]);
    assert_eq!(drawings("--model sgpi --envelope pl"), [true, false, true, false, false]);
    assert_eq!(drawings("--model agpi"), [false, true, true, false, false]);
    assert_eq!(drawings("--model egpi"), [false, true, true, false, true]);
}

#[test]
fn the_papers_figures_are_drawn_from_a_log() {
    let bench = bench();
    let mut log =
        "time_s,reference_mm,contraction_mm,pressure_bar,command_bar,feedforward_bar,feedback_bar\n"
            .to_owned();
    for tick in 0..1000 {
        let time_s = f64::from(tick) / 1000.0;
        let reference_mm = 60.0 * (1.0 - (6.3 * time_s).cos());
        log += &format!("{time_s},{reference_mm},{},2,2,2,0\n", reference_mm - 0.5);
    }
    bench.write("log.csv", log);
    let report = "report --model paper.toml --recording rec.csv --log log.csv -o r.html";
    bench.succeeds(report);
    let page = bench.read("r.html");
    assert_self_contained(&page, 12);
    for text in ["Fig. 8", "Fig. 11", "Fig. 12", "Fig. 13", "largest error 0.5000 mm"] {
        assert!(page.contains(text), "{text} is missing");
    }
    bench.write("log.csv", "time_s,reference_mm\n0,1\n");
    let message = bench.refuses(&format!("{report} --force"));
    assert_eq!(message, "error: log.csv: no column contraction_mm; the file has time_s, reference_mm\n");
}

/// Named drawings, and no script, link or image from outside.
fn assert_self_contained(page: &str, drawings: usize) {
    assert_eq!(page.matches("role=\"img\"").count(), drawings);
    assert_eq!(page.matches("<title>").count(), drawings + 1);
    for foreign in ["<script ", "<link", "<img", "url(", "src=", "import", "fetch("] {
        assert!(!page.contains(foreign), "{foreign}");
    }
}

#[test]
fn an_input_is_never_overwritten_not_even_by_force() {
    let bench = bench();
    let before = bench.read("rec.csv");
    let message = bench.refuses("simulate paper.toml --input rec.csv -o ./rec.csv --force");
    assert_eq!(message, "error: ./rec.csv: is an input of this command; not even --force overwrites it\n");
    assert_eq!(bench.read("rec.csv"), before);
}

#[test]
fn a_model_that_does_not_describe_the_recording_is_called_that() {
    let bench = bench();
    let falling: String = bench
        .read("rec.csv")
        .lines()
        .map(|line| match line.rsplit_once(',').map(|(head, last)| (head, last.parse::<f64>())) {
            Some((head, Ok(contraction))) => format!("{head},{}\n", -contraction),
            _ => format!("{line}\n"),
        })
        .collect();
    bench.write("falling.csv", falling);
    let output = bench.mgpi("identify falling.csv -o model.toml --report report.html --starts 2");
    let message = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(
        message.contains("warning: falling.csv: this model does not describe the recording"),
        "{message}"
    );
    assert!(message.contains("the output falls as the input rises"), "{message}");
    let page = bench.read("report.html");
    assert!(
        page.contains("This model does not describe the recording: poor"),
        "the page carries the warning"
    );
    assert!(!page.contains("strictly increasing"), "the page does not praise it");
    // A later command says so too: the reason goes with the model.
    assert!(bench.read("model.toml").contains("limited_by = \"output_falls\""));
    assert!(bench.succeeds("simulate model.toml --input rec.csv -o out.csv").contains("rows simulated"));
}

/// Not about outputs, but about all of these tests: the bench is theirs.
#[test]
fn a_test_that_fails_leaves_no_program_at_work() {
    let bench = Bench::new();
    let mut sleeping = std::process::Command::new("sleep");
    let mut sleeping = sleeping.arg("600").current_dir(bench.path("")).spawn().expect("it starts");
    let failed = std::panic::catch_unwind(move || {
        let _bench = bench;
        panic!("a test that fails on purpose");
    });
    assert!(failed.is_err());
    assert!(!sleeping.wait().expect("a child").success(), "it was not left to end by itself");
}
