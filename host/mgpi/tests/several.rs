//! Several recordings of one muscle make one model.

mod common;

use common::Bench;
use serde_json::Value;

/// A recording of the simulated muscle, 20 rows a second.
fn record(bench: &Bench, protocol: &str, seed: u64, name: &str) {
    bench.succeeds(&format!("rig record --protocol {protocol} --seed {seed} --rate-hz 20 -o {name}"));
}

/// The error on a recording that took no part. Unit: mm.
fn error_mm(bench: &Bench, recordings: &str) -> f64 {
    bench.succeeds(&format!(
        "identify {recordings} -o m.toml --json r.json --validate third.csv --starts 6 --force"
    ));
    let json: Value = serde_json::from_str(&bench.read("r.json")).expect("JSON");
    json["heldout"]["rmse_mm"].as_f64().expect("a figure")
}

/// Slow triangles and holds show different things of a muscle, and faster triangles something of
/// both. Where one recording is of the third's own kind, it alone may do better: what is left is
/// the error of the model's form, not of too few samples.
#[test]
fn a_model_of_two_different_recordings_predicts_a_third_better_than_one_of_either() {
    for seed in [1, 2, 3] {
        let bench = Bench::new();
        record(&bench, "fig8", 40 + seed, "one.csv");
        record(&bench, "holds", 60 + seed, "other.csv");
        record(&bench, "rates", 50 + seed, "third.csv");
        let [both, one, other] =
            ["one.csv other.csv", "one.csv", "other.csv"].map(|files| error_mm(&bench, files));
        println!("seed {seed}: both {both:.4} mm, one {one:.4} mm, other {other:.4} mm");
        assert!(both < one.min(other), "seed {seed}: {both} mm of both, {one} and {other} mm of one");
    }
}

#[test]
fn the_files_of_a_model_stand_in_it_and_each_is_held_out_once() {
    let bench = Bench::new();
    record(&bench, "fig8", 1, "one.csv");
    record(&bench, "ramps", 2, "other.csv");
    let said =
        bench.succeeds("identify one.csv other.csv -o m.toml --json r.json --report r.html --starts 2");
    assert!(said.contains("(each recording by a model of the others)"), "{said}");
    assert!(said.contains("one.csv: training") && said.contains("other.csv: training"), "{said}");
    let model = bench.read("m.toml");
    assert!(model.contains("[[identification.further]]") && model.contains("by_recording = true"), "{model}");
    let json: Value = serde_json::from_str(&bench.read("r.json")).expect("JSON");
    let files: Vec<&str> = json["recordings"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|one| one["file"].as_str())
        .collect();
    assert_eq!(files, ["one.csv", "other.csv"]);
    // The file is read as it was written.
    bench.succeeds("simulate m.toml --input one.csv -o out.csv");
}

#[test]
fn several_recordings_are_diagnosed_as_one_muscle() {
    for (hidden, verdict, causes) in [("none", "adequate", vec![]), ("load", "explained", vec!["load"])] {
        let bench = Bench::new();
        for (seed, name) in [(1, "one.csv"), (2, "other.csv")] {
            bench.succeeds(&format!(
                "rig record --protocol ramps --seed {seed} --rate-hz 20 --load-n 2 --hide {hidden} -o {name}"
            ));
        }
        let said = bench.succeeds("diagnose one.csv other.csv -o m.toml --json d.json --report r.html");
        assert!(said.starts_with(&format!("one.csv + other.csv: {verdict}")), "{said}");
        let json: Value = serde_json::from_str(&bench.read("d.json")).expect("JSON");
        let found: Vec<&str> = json["causes"]
            .as_array()
            .expect("a list")
            .iter()
            .filter_map(|cause| cause["name"].as_str())
            .collect();
        assert_eq!(found, causes, "{said}");
        let model = bench.read("m.toml");
        assert!(model.contains("[[identification.further]]") && model.contains("other.csv"), "{model}");
        // The file is read as it was written.
        bench.succeeds("simulate m.toml --input one.csv -o out.csv");
    }
}

#[test]
fn recordings_that_do_not_go_together_are_refused_by_name() {
    let bench = Bench::new();
    record(&bench, "fig8", 1, "one.csv");
    let text = bench.read("one.csv");
    bench.write("copy.csv", &text);
    bench.write("command.csv", text.replace("pressure_bar", "level_v"));
    for (other, words) in [
        ("copy.csv", "copy.csv: is the same recording as one.csv"),
        ("command.csv", "command.csv: no column pressure_bar"),
        ("nowhere.csv", "nowhere.csv: cannot be read"),
    ] {
        let message = bench.refuses(&format!("identify one.csv {other} -o m.toml --starts 2"));
        assert!(message.contains(words), "{message}");
    }
    let message = bench.refuses("diagnose one.csv copy.csv");
    assert!(message.contains("copy.csv: is the same recording as one.csv"), "{message}");
    let message = bench.refuses("identify one.csv copy.csv -o m.toml --model auto");
    assert!(message.contains("--model auto"), "{message}");
}

#[test]
fn another_unit_is_converted_to_that_of_the_first() {
    let bench = Bench::new();
    record(&bench, "fig8", 1, "one.csv");
    record(&bench, "ramps", 2, "other.csv");
    let text = bench.read("other.csv");
    let header = text.lines().find(|line| line.starts_with("time_s")).expect("a header").to_owned();
    let place = header.split(',').position(|name| name == "contraction_mm").expect("there");
    let in_cm = |line: &str| -> String {
        if line.starts_with('#') || line.is_empty() {
            return line.to_owned();
        }
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        fields[place] = match fields[place].parse::<f64>() {
            Ok(mm) => (mm / 10.0).to_string(),
            Err(_) => "contraction_cm".to_owned(),
        };
        fields.join(",")
    };
    let lines: Vec<String> = text.lines().map(in_cm).collect();
    bench.write("cm.csv", lines.join("\n") + "\n");
    let figure = |files: &str| {
        bench.succeeds(&format!("identify {files} -o m.toml --json r.json --starts 2 --no-holdout --force"));
        let json: Value = serde_json::from_str(&bench.read("r.json")).expect("JSON");
        json["training"]["rmse_mm"].as_f64().expect("a figure")
    };
    let (mm, cm) = (figure("one.csv other.csv"), figure("one.csv cm.csv"));
    assert!((mm - cm).abs() < 1e-6 * mm, "{mm} against {cm}");
}

/// The held-out error of a model is that of `identify`, which makes the same models.
#[test]
fn models_are_compared_on_several_recordings_as_they_are_identified_from_them() {
    let bench = Bench::new();
    record(&bench, "fig8", 1, "one.csv");
    record(&bench, "ramps", 2, "other.csv");
    let said = bench.succeeds(
        "compare one.csv other.csv --models mgpi,sgpi --sizes 5/5 --starts 2 --json c.json --report c.html",
    );
    assert!(said.contains("one.csv + other.csv") && said.contains("a model of the others"), "{said}");
    bench.succeeds("identify one.csv other.csv -o m.toml --plays 5 --dead-zones 5 --starts 2 --json r.json");
    let [table, one] =
        ["c.json", "r.json"].map(|file| serde_json::from_str::<Value>(&bench.read(file)).expect("JSON"));
    let of_mgpi = &table["rows"][0];
    for part in ["training", "heldout"] {
        assert!(one[part]["rmse_mm"].is_number(), "{one}");
        assert_eq!(of_mgpi[part]["rmse_mm"], one[part]["rmse_mm"], "{part}: {of_mgpi}");
    }
    let message = bench.refuses("compare one.csv one.csv --models sgpi");
    assert!(message.contains("the same recording"), "{message}");
}
