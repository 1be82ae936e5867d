//! Whatever the units of a recording: what is found is the same, and names and values are in its
//! own units.

mod common;

use std::collections::BTreeMap;

use common::Bench;
use serde_json::Value;

/// Units of input and output, each with what one bar or one mm of the muscle makes there.
struct Units {
    input: (&'static str, f64),
    output: (&'static str, f64),
}

const BOARD: Units = Units { input: ("bar", 1.0), output: ("mm", 1.0) };
const OTHERS: [Units; 3] = [
    Units { input: ("kpa", 100.0), output: ("m", 1e-3) },
    Units { input: ("v", 1.6), output: ("deg", 0.7) },
    Units { input: ("v", 0.5), output: ("n", 2.0) },
];

/// How near a diagnosis comes to a parameter: what docs/game.md counts as found. The search is not
/// independent of the units: the load's offset differs by 9 % between mm and N.
const NEAR: f64 = 0.15;

/// Triangles of three speeds, three times over, of a valve with a dead band and a muscle whose zero
/// drifts and whose curve a load moves. 20 rows a second.
fn record(bench: &Bench, name: &str, units: &Units) {
    let ((input, per_bar), (output, per_mm)) = (units.input, units.output);
    let mut text = format!("time_s,command_{input},pressure_{input},load_n,contraction_{output}\n");
    let (mut pressure, mut plays) = (0.0_f64, [0.0_f64; 3]);
    let mut noise = common::noise(1);
    for row in 0..3600 {
        let time_s = f64::from(row) / 20.0;
        let (period_s, high) = [(20.0, 5.5), (10.0, 5.5), (10.0, 4.0), (20.0, 3.0)][row as usize / 300 % 4];
        let phase = (time_s / period_s).fract();
        let command = high * (1.0 - (2.0 * phase - 1.0).abs());
        pressure = pressure.clamp(command - 0.15, command + 0.15);
        let mut contraction = 0.0;
        for (i, play) in plays.iter_mut().enumerate() {
            let radius = 0.2 * i as f64;
            *play = play.clamp(pressure - radius, pressure + radius);
            contraction += *play * 5.0;
        }
        let load = 20.0 + 15.0 * (time_s / 7.3).sin();
        let contraction = contraction + 0.03 * time_s - 0.1 * load + 0.06 * noise();
        let seen = pressure + 0.004 * noise();
        text += &format!(
            "{time_s},{},{},{load:.3},{}\n",
            command * per_bar,
            seen * per_bar,
            contraction * per_mm
        );
    }
    bench.write(name, text);
}

/// The words of a page or of an answer, without its style, its script and its marks.
fn words(text: &str) -> Vec<String> {
    let mut text = text.to_owned();
    for name in ["style", "script"] {
        while let Some((start, end)) = text.find(&format!("<{name}")).zip(text.find(&format!("</{name}>"))) {
            text.replace_range(start..end + name.len() + 3, " ");
        }
    }
    let mut is_mark = false;
    let shown = |letter: char| {
        is_mark = if is_mark { letter != '>' } else { letter == '<' };
        if is_mark || !letter.is_alphanumeric() { ' ' } else { letter }
    };
    text.chars().map(shown).collect::<String>().split_whitespace().map(str::to_owned).collect()
}

fn has_a_boards_unit(text: &str) -> bool {
    words(text).iter().any(|word| word == "bar" || word == "mm")
}

/// The diagnosis of a recording: what is printed, its JSON, and its page.
fn diagnosed(bench: &Bench, name: &str, units: &Units) -> [String; 3] {
    record(bench, &format!("{name}.csv"), units);
    let said = bench.succeeds(&format!(
        "diagnose {name}.csv --input pressure_{} --output contraction_{} --json {name}.json --report {name}.html",
        units.input.0, units.output.0
    ));
    [said, bench.read(&format!("{name}.json")), bench.read(&format!("{name}.html"))]
}

/// The named causes with their parameters, by name.
fn causes(json: &str) -> BTreeMap<String, Value> {
    let json: Value = serde_json::from_str(json).expect("JSON");
    let causes = json["causes"].as_array().expect("a list").iter();
    causes
        .map(|cause| (cause["name"].as_str().expect("a name").to_owned(), cause["parameters"].clone()))
        .collect()
}

#[test]
fn a_diagnosis_has_the_names_and_units_of_the_recording_and_finds_the_same() {
    let bench = Bench::new();
    let board = diagnosed(&bench, "board", &BOARD);
    let found = causes(&board[1]);
    for wanted in ["valve_deadband", "drift", "load"] {
        assert!(found.contains_key(wanted), "{wanted}: {}", board[0]);
    }
    let evidence = |line: &&str| line.contains("held-out error") || line.contains("differ by");
    let evidence: Vec<&str> = board[0].lines().filter(evidence).collect();
    assert!(!evidence.is_empty() && evidence.iter().all(|line| line.contains(" mm")), "{evidence:?}");
    for (i, units) in OTHERS.iter().enumerate() {
        let texts = diagnosed(&bench, &format!("other-{i}"), units);
        for text in &texts {
            assert!(!has_a_boards_unit(text), "{text}");
        }
        let others = causes(&texts[1]);
        assert!(others.keys().eq(found.keys()), "{}", texts[0]);
        let ((input, per_bar), (output, per_mm)) = (units.input, units.output);
        let value = |all: &BTreeMap<String, Value>, cause: &str, key: &str| {
            let parameters = &all[cause];
            parameters[key].as_f64().unwrap_or_else(|| panic!("{key}: {parameters}"))
        };
        for (cause, key, other, factor) in [
            ("valve_deadband", "band_bar", format!("band_{input}"), per_bar),
            ("drift", "mm_per_s", format!("{output}_per_s"), per_mm),
            ("load", "offset_mm_per_n", format!("offset_{output}_per_n"), per_mm),
        ] {
            let (ours, theirs) = (value(&found, cause, key), value(&others, cause, &other));
            assert!(
                (theirs / (factor * ours) - 1.0).abs() < NEAR,
                "{cause}: {theirs} instead of {ours} {key}"
            );
            assert!(texts[0].contains(&format!("{other} ")), "{}", texts[0]);
        }
    }
}

#[test]
fn models_are_identified_and_compared_in_the_units_of_the_recording() {
    let bench = Bench::new();
    for (i, units) in OTHERS.iter().enumerate() {
        record(&bench, &format!("{i}.csv"), units);
        let columns = format!("--input pressure_{} --output contraction_{}", units.input.0, units.output.0);
        let outputs = format!("--starts 2 --json {i}.json --report {i}.html --force");
        for command in [
            format!("identify {i}.csv -o {i}.toml {outputs} {columns}"),
            format!("compare {i}.csv --models cpi,mgpi --sizes 3/3 -o {i}.table.csv {outputs} {columns}"),
        ] {
            let said = bench.succeeds(&command);
            let files = ["json", "html", "toml"].map(|end| bench.read(&format!("{i}.{end}")));
            for text in [said].iter().chain(&files) {
                assert!(!has_a_boards_unit(text), "{command}: {text}");
            }
        }
        assert!(!has_a_boards_unit(&bench.read(&format!("{i}.table.csv"))));
    }
}
