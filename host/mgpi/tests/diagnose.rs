//! `mgpi diagnose`: what it writes, and what it refuses.

mod common;

use common::{Bench, recording};
use serde_json::Value;

fn bench() -> Bench {
    let bench = Bench::new();
    recording(&bench, "rec.csv");
    bench
}

#[test]
fn the_diagnosis_has_the_agreed_keys() {
    let bench = bench();
    let said = bench.succeeds("diagnose rec.csv --json d.json");
    let json: Value = serde_json::from_str(&bench.read("d.json")).expect("JSON");
    for key in ["verdict", "causes", "alternatives", "baseline", "extended", "heldout", "figures_of_misfit"] {
        assert!(json.get(key).is_some(), "{key}");
    }
    assert!(json.get("suggested_experiment").is_some());
    assert!(json["baseline"]["rmse_mm"].is_number() && json["extended"]["rmse_mm"].is_number());
    for key in ["before_rmse_mm", "after_rmse_mm", "noise_floor_mm"] {
        assert!(json["heldout"][key].is_number(), "{key}");
    }
    let verdict = json["verdict"].as_str().expect("a word");
    assert!(["adequate", "explained", "confounded", "unexplained"].contains(&verdict));
    assert!(said.starts_with(&format!("rec.csv: {verdict}\n")), "{said}");
}

#[test]
fn a_column_that_a_cause_needs_is_said_to_be_missing() {
    let said = bench().succeeds("diagnose rec.csv");
    for cause in ["load", "temperature"] {
        assert!(said.contains(&format!("not examined  {cause}: there is no column")), "{said}");
    }
    assert!(said.contains("not examined  creep: there is no hold"), "{said}");
}

#[test]
fn what_a_recording_begins_within_the_range_with_is_not_scored_and_that_is_said() {
    let bench = bench();
    let until = |file: &str| -> (String, Value) {
        let said = bench.succeeds(&format!("diagnose {file} --json d.json --force"));
        let json: Value = serde_json::from_str(&bench.read("d.json")).expect("JSON");
        (said, json["past_unknown_until_s"].clone())
    };
    let (said, none) = until("rec.csv");
    assert!(none.is_null() && !said.contains("not scored"), "{said}");
    let text = bench.read("rec.csv");
    let rows: Vec<&str> = text.lines().collect();
    bench.write("within.csv", [&rows[..1], &rows[40..]].concat().join("\n"));
    let (said, until_s) = until("within.csv");
    let until_s = until_s.as_f64().expect("a time");
    assert!(said.contains(&format!("not scored    what lies before {until_s:.1} s")), "{said}");
}

#[test]
fn a_recording_that_is_too_short_is_refused() {
    let bench = bench();
    let rows: Vec<String> = bench.read("rec.csv").lines().take(80).map(str::to_owned).collect();
    bench.write("short.csv", rows.join("\n"));
    let message = bench.refuses("diagnose short.csv --json d.json");
    assert!(message.starts_with("error: short.csv: 79 scored rows are too few for a diagnosis"), "{message}");
}

#[test]
fn an_input_that_does_not_move_is_refused() {
    let bench = Bench::new();
    let mut text = "time_s,pressure_bar,contraction_mm\n".to_owned();
    for row in 0..300 {
        text += &format!("{},2,{}\n", f64::from(row) / 20.0, f64::from(row % 7));
    }
    bench.write("still.csv", text);
    let message = bench.refuses("diagnose still.csv");
    assert_eq!(message, "error: still.csv: the input does not move: nothing can be diagnosed\n");
}

#[test]
fn the_page_says_what_the_command_says_and_needs_nothing_from_outside() {
    let bench = bench();
    let said = bench.succeeds("diagnose rec.csv --report d.html");
    let page = bench.read("d.html");
    let sentence = said.lines().nth(1).expect("a sentence");
    assert!(page.contains(&format!("<p class=\"verdict\">{sentence}</p>")), "{sentence}");
    for judged in said.lines().filter_map(|line| line.strip_prefix("not examined  ")) {
        let (cause, why) = judged.split_once(": ").expect("a reason");
        assert!(page.contains(&format!("<dt>{cause}</dt>")) && page.contains(why), "{judged}");
    }
    for foreign in ["<script ", "<link", "<img", "url(", "src="] {
        assert!(!page.contains(foreign), "{foreign}");
    }
}

#[test]
fn an_existing_diagnosis_is_kept_unless_forced() {
    let bench = bench();
    bench.write("d.json", "mine");
    let message = bench.refuses("diagnose rec.csv --json d.json");
    assert_eq!(message, "error: d.json: exists already; --force overwrites it\n");
    assert_eq!(bench.read("d.json"), "mine");
}

#[test]
fn the_extended_model_is_written_and_can_be_simulated() {
    let bench = bench();
    let said = bench.succeeds("diagnose rec.csv -o extended.toml");
    assert!(said.contains("held out      RMSE"), "{said}");
    let simulated = bench.succeeds("simulate extended.toml --input rec.csv -o simulated.csv");
    assert!(simulated.contains("rows simulated"), "{simulated}");
    let message = bench.refuses("diagnose rec.csv -o extended.toml");
    assert_eq!(message, "error: extended.toml: exists already; --force overwrites it\n");
}

#[test]
fn the_gain_can_be_counted_on_another_recording() {
    let bench = bench();
    let rows: Vec<String> = bench.read("rec.csv").lines().map(str::to_owned).collect();
    bench.write("half.csv", rows[..rows.len() / 2].join("\n"));
    bench.succeeds("diagnose rec.csv --validate half.csv -o extended.toml --json d.json");
    let json: Value = serde_json::from_str(&bench.read("d.json")).expect("JSON");
    assert!(json["heldout"]["gain_error_mm"].is_number() && json["share_of_gain"].is_number());
    assert!(bench.read("extended.toml").contains("recording = \"half.csv\""));
}

#[test]
fn a_given_model_of_another_muscle_is_said_to_be_that() {
    let bench = bench();
    bench.succeeds("identify rec.csv --envelope pl --starts 4 --no-holdout -o own.toml");
    let said = bench.succeeds("diagnose rec.csv --model own.toml");
    assert!(!said.contains("another muscle"), "{said}");
    // A muscle of twice the stroke.
    let doubled = |(row, line): (usize, &str)| match line.rsplit_once(',') {
        Some((before, last)) if row > 0 => match last.parse::<f64>() {
            Ok(output) => format!("{before},{}", 2.0 * output),
            Err(_) => line.to_owned(),
        },
        _ => line.to_owned(),
    };
    let other: Vec<String> = bench.read("rec.csv").lines().enumerate().map(doubled).collect();
    bench.write("other.csv", other.join("\n"));
    let said = bench.succeeds("diagnose other.csv --model own.toml --json d.json");
    assert!(said.contains("another muscle"), "{said}");
    let json: Value = serde_json::from_str(&bench.read("d.json")).expect("JSON");
    assert_eq!(json["given_model"]["is_of_another_muscle"], true);
}

/// The error that `simulate` says a model has. Unit: mm.
fn simulated_rmse(bench: &Bench, model: &str) -> f64 {
    let said = bench.succeeds(&format!("simulate {model} --input rec.csv -o s.csv --force"));
    let figure = said.split("RMSE ").nth(1).and_then(|rest| rest.split(' ').next());
    figure.expect("an error").parse().expect("a number")
}

/// Diagnoses the recording and writes a model, which is no worse than that of `identify`, and as
/// good as the JSON says; answers what the command has printed.
fn diagnosed_no_worse_than_identified(bench: &Bench) -> String {
    let said = bench.succeeds("diagnose rec.csv -o written.toml --json d.json");
    bench.succeeds("identify rec.csv -o identified.toml --no-holdout");
    let json: Value = serde_json::from_str(&bench.read("d.json")).expect("JSON");
    let [ours, theirs] = ["written.toml", "identified.toml"].map(|model| simulated_rmse(bench, model));
    assert!(ours <= 1.001 * theirs, "{ours} {theirs}");
    let rmse = json["written"]["errors"]["rmse_mm"].as_f64().expect("an error");
    assert!((rmse / ours - 1.0).abs() < 0.01, "{rmse} {ours}");
    said
}

#[test]
fn the_model_that_is_written_is_named_and_no_worse_than_that_of_identify() {
    let bench = bench();
    let said = diagnosed_no_worse_than_identified(&bench);
    assert!(said.contains("written       written.toml: mgpi"), "{said}");
    let without = bench.succeeds("diagnose rec.csv");
    assert_eq!(without.lines().nth(1), said.lines().nth(1));
    assert!(without.contains("best model    mgpi"), "{without}");
}

#[test]
fn beside_a_noisy_pressure_the_written_model_is_judged_on_what_was_measured() {
    let bench = bench();
    let mut noise = common::noise(3);
    let rows = bench.read("rec.csv");
    let mut rows = rows.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let head = rows.next().expect("a header");
    let place = head.iter().position(|name| name == "pressure_bar").expect("a pressure");
    let noisy = rows.map(|mut row| {
        row[place] = (row[place].parse::<f64>().expect("a number") + 0.3 * noise()).to_string();
        row.join(",")
    });
    let text: Vec<String> = [head.join(",")].into_iter().chain(noisy).collect();
    bench.write("rec.csv", text.join("\n"));
    let said = diagnosed_no_worse_than_identified(&bench);
    assert!(said.contains("smoothed"), "{said}");
}

#[test]
fn an_output_that_falls_is_unexplained_with_its_size_and_no_cause_is_named() {
    let bench = bench();
    let negated = |(row, line): (usize, &str)| match line.rsplit_once(',') {
        Some((before, last)) if row > 0 => match last.parse::<f64>() {
            Ok(output) => format!("{before},{}", -output),
            Err(_) => line.to_owned(),
        },
        _ => line.to_owned(),
    };
    let falls: Vec<String> = bench.read("rec.csv").lines().enumerate().map(negated).collect();
    bench.write("falls.csv", falls.join("\n"));
    let said = bench.succeeds("diagnose falls.csv --json d.json");
    let json: Value = serde_json::from_str(&bench.read("d.json")).expect("JSON");
    assert_eq!(json["verdict"], "unexplained", "{said}");
    assert_eq!(json["causes"], serde_json::json!([]));
    assert!(said.contains("% of the stroke") && !said.contains("with the causes"), "{said}");
    assert_eq!(json["unexplained"]["seen"], "poor_model");
    assert!(json["unexplained"]["percent_of_stroke"].as_f64().expect("a share") > 10.0, "{said}");
    assert_eq!(json["unexplained"]["limited_by"], "output_falls");
    assert!(said.contains("give one of the columns the other sign"), "what helps is said: {said}");
}
