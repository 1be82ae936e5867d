//! What `mgpi compare` claims: a row a model and size, the same figures as `mgpi identify`, nothing
//! half done.

mod common;

use common::{Bench, recording};
use serde_json::Value;

fn bench() -> Bench {
    let bench = Bench::new();
    recording(&bench, "rec.csv");
    bench
}

fn json(bench: &Bench, name: &str) -> Value {
    serde_json::from_str(&bench.read(name)).expect("JSON")
}

#[test]
fn every_model_has_a_row_in_every_size_and_none_twice() {
    let bench = bench();
    let printed = bench
        .succeeds("compare rec.csv -o t.csv --models cpi,sgpi-free,mgpi-pl --sizes 3/3,4/3,3/4 --starts 2");
    let csv = bench.read("t.csv");
    let names: Vec<String> =
        csv.lines().skip(1).map(|line| line.split(',').take(3).collect::<Vec<_>>().join(" ")).collect();
    let expected =
        ["cpi 3 ", "cpi 4 ", "sgpi-free 3 ", "sgpi-free 4 ", "mgpi-pl 3 3", "mgpi-pl 4 3", "mgpi-pl 3 4"];
    assert_eq!(names, expected);
    assert_eq!(printed.lines().filter(|line| line.starts_with("mgpi-pl ")).count(), 3, "{printed}");
}

#[test]
fn the_figures_are_those_that_identify_finds() {
    let bench = bench();
    for options in ["", "--validate rec.csv"] {
        bench.succeeds(&format!(
            "compare rec.csv --json c.json --models sgpi --sizes 4/4 --starts 2 --force {options}"
        ));
        bench.succeeds(&format!(
            "identify rec.csv -o m.toml --json i.json --model sgpi --plays 4 --starts 2 --force {options}"
        ));
        let (compared, identified) = (json(&bench, "c.json"), json(&bench, "i.json"));
        for key in ["training", "heldout", "starts", "termination"] {
            assert!(!identified[key].is_null(), "{key}");
            assert_eq!(compared["rows"][0][key], identified[key], "{key}");
        }
        assert_eq!(compared["stroke_mm"], identified["stroke_mm"]);
    }
}

#[test]
fn a_model_of_the_recordings_class_comes_out_best() {
    let bench = bench();
    bench.succeeds(
        "compare rec.csv --json c.json --report r.html --models cpi,sgpi,mgpi --sizes 10/10 --starts 8",
    );
    let json = json(&bench, "c.json");
    let rmse = |row: usize| json["rows"][row]["training"]["rmse_mm"].as_f64().expect("a figure");
    assert!(rmse(2) < 0.5 * rmse(1) && rmse(1) < rmse(0), "{} {} {}", rmse(0), rmse(1), rmse(2));
    let page = bench.read("r.html");
    for text in ["Loops of mgpi 10/10", "Loops of sgpi 10", "Root mean square error (mm)", "held out"] {
        assert!(page.contains(text), "{text} is missing");
    }
    assert_eq!(page.matches("role=\"img\"").count(), 4);
}

#[test]
fn without_held_out_rows_the_table_has_no_such_columns() {
    let bench = bench();
    let printed = bench.succeeds("compare rec.csv -o t.csv --models cpi --sizes 3/3 --starts 2 --no-holdout");
    assert!(printed.contains("Nothing was held out") && !printed.contains("held out  "), "{printed}");
    let csv = bench.read("t.csv");
    let (header, row) = csv.trim_end().split_once('\n').expect("a row");
    let place = header.split(',').position(|name| name == "heldout_rmse_mm").expect("a column");
    assert_eq!(row.split(',').nth(place), Some(""));
}

#[test]
fn unusable_arguments_are_refused() {
    let bench = bench();
    for (arguments, message) in [
        (
            "--models agpi-pl",
            "known are cpi, sgpi, agpi, mpi, egpi, mgpi, sgpi-pl, mgpi-pl, and each with -free",
        ),
        ("--models pid", "known are cpi"),
        ("--sizes 10", "two numbers N/M are needed: 1 to 128 plays, 1 to 128 dead zones"),
        ("--sizes 0/10", "two numbers N/M are needed"),
        ("--validate nowhere.csv", "nowhere.csv"),
        ("--starts 0", "number of starts is 0"),
        ("-o t --report t", "named for two outputs"),
    ] {
        let refusal = bench.refuses(&format!("compare rec.csv {arguments}"));
        assert!(refusal.contains(message), "{arguments}: {refusal}");
    }
}

#[test]
fn an_existing_table_is_kept_unless_forced() {
    let bench = bench();
    bench.write("t.csv", "mine");
    let command = "compare rec.csv -o t.csv --models cpi --sizes 3/3 --starts 2";
    assert_eq!(bench.refuses(command), "error: t.csv: exists already; --force overwrites it\n");
    assert_eq!(bench.read("t.csv"), "mine");
    bench.succeeds(&format!("{command} --force"));
    assert!(bench.read("t.csv").starts_with("model,plays,"));
}

#[test]
fn a_recording_that_no_model_can_be_made_of_is_refused() {
    let bench = bench();
    bench.write(
        "still.csv",
        "time_s,pressure_bar,contraction_mm\n0,1,2\n.1,1,2\n.2,1,2\n.3,1,2\n.4,1,2\n.5,1,2\n",
    );
    let refusal = bench.refuses("compare still.csv -o t.csv --models cpi --sizes 1/1");
    assert!(refusal.contains("the input is constant (1)"), "{refusal}");
}
