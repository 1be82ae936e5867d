//! `mgpi tune`: the feedback of a model, what it promises, and where there is none.

mod common;

use common::{Bench, PAPER};

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("paper.toml", PAPER);
    bench
}

/// The paper's model with what a recording would show of time: so late, plus and minus so much (s).
fn with_times(late_s: f64, error_s: f64) -> String {
    format!(
        "{PAPER}\n[recorded]\nstep_s = 0.005\nnoise_mm = 0.03\nsteeper = 1.2\nlate_s = {late_s}\nlate_error_s = {error_s}\n\
         valve_late_s = 0.05\nvalve_late_error_s = 0.0002\n"
    )
}

fn number(text: &str, key: &str) -> f64 {
    let line = text.lines().find(|line| line.starts_with(&format!("{key} = "))).expect(key);
    line.split(" = ").nth(1).expect("a value").parse().expect("a number")
}

#[test]
fn a_tuned_model_holds_its_feedback_and_what_that_promises_and_reads_back() {
    let bench = bench();
    let said = bench.succeeds("tune paper.toml -o tuned.toml --report loop.html --json tuning.json");
    for part in ["largest sensitivity", "gain margin", "phase margin", "limited by", "assumed"] {
        assert!(said.contains(part), "{part} is missing: {said}");
    }
    let tuned = bench.read("tuned.toml");
    assert!(number(&tuned, "maximum_sensitivity") <= 2.0 && number(&tuned, "gain_margin") >= 2.0);
    assert!(number(&tuned, "observer_rate_per_s") > 0.1);
    assert!(bench.read("loop.html").contains("Gain of the open loop"));
    assert!(bench.read("tuning.json").contains("\"maximum_sensitivity\""));
    // What is read back is tuned to the same.
    bench.succeeds("tune tuned.toml -o again.toml");
    assert_eq!(bench.read("again.toml"), tuned);
}

#[test]
fn the_better_a_recording_shows_the_time_the_faster_is_the_feedback() {
    let bench = bench();
    let rate = |error_s: f64| {
        bench.write("known.toml", with_times(0.0, error_s));
        bench.succeeds("tune known.toml -o tuned.toml --force");
        number(&bench.read("tuned.toml"), "observer_rate_per_s")
    };
    let (well, badly) = (rate(0.0005), rate(0.01));
    assert!(well > 2.0 * badly, "{well} and {badly} /s");
    assert!((number(&bench.read("tuned.toml"), "lag_s") - 0.05).abs() < 1e-9, "the valve's lag is led");
}

#[test]
fn a_recording_without_movement_and_a_model_that_is_far_off_are_refused_with_the_reason() {
    let bench = bench();
    bench.write("still.toml", with_times(0.0, 1000.0));
    let message = bench.refuses("tune still.toml -o tuned.toml");
    assert!(message.contains("still.toml") && message.contains("mgpi plan"), "{message}");
    bench.write("wrong.toml", with_times(0.0, -1.0));
    let message = bench.refuses("tune wrong.toml -o tuned.toml");
    assert!(message.contains("[recorded] late_error_s: -1 is below 0"), "{message}");
}
