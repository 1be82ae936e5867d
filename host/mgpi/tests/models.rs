//! Model files: what is written, what is read, what is refused; and what they compute.

mod common;

use common::{Bench, PAPER, recording};
use identification::HostParameters;
use model_core::paper;
use recording::model_file::ModelFile;

/// The message about the paper's model with a piece replaced, without "error: ".
fn refusal(from: &str, to: &str) -> String {
    assert!(PAPER.contains(from), "nothing to replace");
    refusal_of(&PAPER.replacen(from, to, 1))
}

fn refusal_of(model: &str) -> String {
    let bench = Bench::new();
    bench.write("model.toml", model).write("rec.csv", "time_s,pressure_bar\n0,0\n1,1\n");
    let message = bench.refuses("simulate model.toml --input rec.csv -o out.csv");
    message.trim_end().strip_prefix("error: ").expect(&message).to_owned()
}

#[test]
fn another_format_is_refused() {
    assert_eq!(
        refusal("format = 1", "format = 2"),
        "model.toml: format 2 is of another version; this one reads format 1"
    );
}

#[test]
fn an_unknown_key_is_refused() {
    assert_eq!(refusal("q = 0.2959", "q = 0.2959\nz = 1"), "model.toml: [plays] z: unknown key");
    assert_eq!(refusal("format = 1", "format = 1\nextra = 1"), "model.toml: extra: unknown key");
}

#[test]
fn a_missing_key_is_refused() {
    assert_eq!(refusal("tau = 5.4999\n", ""), "model.toml: [plays] tau: missing");
    assert_eq!(refusal("c1_per_bar", "c1_per_kpa"), "model.toml: [envelope] c1_per_bar: missing");
}

#[test]
fn a_key_of_another_type_is_refused() {
    assert_eq!(
        refusal("c0 = 1.6867", "c0 = \"1.6867\""),
        "model.toml: [envelope] c0: a number is needed, not a value of type string"
    );
    assert_eq!(refusal("count = 10", "count = -1"), "model.toml: [plays] count: -1 is not a count");
    assert_eq!(
        refusal("kind = \"tanh\"", "kind = \"pl\""),
        "model.toml: [envelope] kind: \"pl\" is not known, must be \"tanh\" or \"piecewise_linear\""
    );
}

#[test]
fn a_number_that_is_not_finite_is_refused() {
    assert_eq!(refusal("rho = 0.1827", "rho = nan"), "model.toml: [plays] rho: NaN is not finite");
    assert_eq!(
        refusal("weights_mm = [60.35", "weights_mm = [inf"),
        "model.toml: [dead_zones] weights_mm: inf is not finite"
    );
}

#[test]
fn a_truncated_file_is_refused_at_every_length_with_its_name() {
    let cut = PAPER.rfind("weights_mm").expect("present") + 40;
    let message = refusal_of(&PAPER[..cut]);
    let line = PAPER[..cut].lines().count();
    let start = format!("model.toml, line {line}: not a TOML file, or cut off: ");
    assert!(message.starts_with(&start), "{message}");
    for share in 1..10 {
        let message = refusal_of(&PAPER[..PAPER.len() * share / 10]);
        assert!(message.starts_with("model.toml"), "{message}");
    }
}

#[test]
fn weights_that_cannot_be_inverted_are_refused() {
    let message = refusal("weights_mm = [60.35, 12.3", "weights_mm = [60.35, -70.0");
    assert!(message.starts_with("model.toml: no invertible model: "), "{message}");
    assert!(message.contains("[1] is -9.6") && message.contains("mm, must be above 0 mm"), "{message}");
    let message = refusal("q = 0.2959", "q = -0.2959");
    assert!(message.starts_with("model.toml: no invertible model: q is -0.2959"), "{message}");
}

#[test]
fn a_missing_model_is_refused() {
    let message = Bench::new().refuses("simulate nowhere.toml --input rec.csv -o out.csv");
    assert!(message.starts_with("error: nowhere.toml: cannot be read: "), "{message}");
}

#[test]
fn the_example_is_the_papers_model_bit_for_bit() {
    let bench = Bench::new();
    bench.write("paper.toml", PAPER);
    let file = ModelFile::read(&bench.path("paper.toml")).expect("valid");
    let paper = HostParameters::Cascade(paper::mgpi().and_then(|model| model.convert()).expect("valid"));
    assert_eq!(file.parameters, paper);
}

#[test]
fn an_identified_model_reads_back_as_it_was_written() {
    let bench = Bench::new();
    recording(&bench, "rec.csv");
    bench.succeeds("identify rec.csv -o model.toml --validate rec.csv --starts 2");
    let file = ModelFile::read(&bench.path("model.toml")).expect("valid");
    assert_eq!(file.to_toml(), bench.read("model.toml"));
    assert!(file.identification.is_some_and(|identification| identification.heldout.is_some()));
}

#[test]
fn every_model_of_the_family_is_identified_written_read_and_simulated() {
    let bench = Bench::new();
    recording(&bench, "rec.csv");
    let models = ["cpi", "sgpi", "agpi", "mpi", "egpi", "mgpi", "mgpi --envelope pl", "sgpi --envelope pl"];
    for model in models {
        bench.succeeds(&format!("identify rec.csv -o model.toml --model {model} --starts 4 --force"));
        let file = ModelFile::read(&bench.path("model.toml")).expect(model);
        assert_eq!(file.to_toml(), bench.read("model.toml"), "{model}");
        let (name, _) = model.split_once(' ').unwrap_or((model, ""));
        assert_eq!(file.parameters.kind().name(), name);
        // What simulate prints are the figures that identify has written.
        let summary = bench.succeeds("simulate model.toml --input rec.csv -o out.csv --force");
        let training = file.identification.expect("identified").training;
        assert!(summary.contains(&format!("RMSE {:.4} mm", training.rmse)), "{model}: {summary}");
    }
}

#[test]
fn a_model_can_be_chosen_out_of_the_family() {
    let bench = Bench::new();
    recording(&bench, "rec.csv");
    let summary =
        bench.succeeds("identify rec.csv -o model.toml --model auto --starts 2 --plays 4 --dead-zones 4");
    for model in ["cpi", "sgpi", "agpi", "mpi", "egpi", "mgpi", "mgpi-pl-free"] {
        assert!(summary.lines().any(|line| line.starts_with(&format!("{model} "))), "{model}: {summary}");
    }
    let chosen = summary.lines().find_map(|line| line.strip_prefix("chosen        ")).expect("a choice");
    let file = ModelFile::read(&bench.path("model.toml")).expect("valid");
    assert!(chosen.starts_with(file.parameters.kind().name()), "{chosen}");
    // Held out of the choice, too.
    assert!(file.identification.is_some_and(|identification| identification.heldout.is_some()));
}

#[test]
fn free_weights_are_written_and_read_again() {
    let bench = Bench::new();
    recording(&bench, "rec.csv");
    bench.succeeds("identify rec.csv -o model.toml --weights free --starts 2 --no-holdout");
    let text = bench.read("model.toml");
    assert!(text.contains("density = \"free\""), "{text}");
    assert_eq!(ModelFile::read(&bench.path("model.toml")).expect("valid").to_toml(), text);
}

#[test]
fn outliers_are_listed() {
    let bench = Bench::new();
    recording(&bench, "clean.csv");
    let spoil = |(row, line): (usize, &str)| {
        let (front, contraction) = line.rsplit_once(',').expect("fields");
        match contraction.parse::<f64>() {
            Ok(mm) if row == 400 => format!("{front},{}\n", mm + 30.0),
            _ => format!("{line}\n"),
        }
    };
    bench.write("rec.csv", bench.read("clean.csv").lines().enumerate().map(spoil).collect::<String>());
    let summary =
        bench.succeeds("identify rec.csv -o model.toml --json r.json --loss huber --starts 4 --no-holdout");
    assert!(summary.contains("the first at"), "{summary}");
    // Row 400 of the file, its header being row 0.
    assert!(bench.read("r.json").contains("399"));
}

#[test]
fn a_model_of_another_kind_is_refused() {
    assert_eq!(
        refusal("kind = \"mgpi\"", "kind = \"preisach\""),
        "model.toml: kind: \"preisach\" is not known; known are cpi, sgpi, agpi, mpi, egpi, mgpi"
    );
    assert_eq!(refusal("kind = \"mgpi\"", "kind = \"sgpi\""), "model.toml: line: missing");
}

#[test]
fn simulation_reproduces_the_papers_loop() {
    let bench = Bench::new();
    let path: Vec<f64> = (0..=6).chain((1..6).rev()).map(f64::from).collect();
    let rows: String =
        path.iter().enumerate().map(|(i, bar)| format!("{},{bar}\n", 0.5 * i as f64)).collect();
    bench.write("loop.csv", format!("time_s,pressure_bar\n{rows}")).write("paper.toml", PAPER);
    bench.succeeds("simulate paper.toml --input loop.csv -o out.csv");
    let text = bench.read("out.csv");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("time_s,pressure_bar,contraction_mm"));
    let contraction_mm: Vec<f64> =
        lines.map(|line| line.rsplit_once(',').expect("three fields").1.parse().expect("a number")).collect();
    // Computed independently, by the sums of equations (6) and (14).
    let expected = [
        -1.128, 16.726, 56.943, 89.044, 105.888, 117.078, 123.763, 120.585, 113.651, 100.631, 74.463, 30.985,
    ];
    assert_eq!(contraction_mm.len(), expected.len());
    for ((bar, got), expected) in path.iter().zip(&contraction_mm).zip(expected) {
        assert!((got - expected).abs() < 0.001, "{got} mm at {bar} bar, not {expected} mm");
    }
}
