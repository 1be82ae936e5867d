//! `mgpi tune`: the feedback of a model, what it promises, and where there is none; and what is
//! said of gains that a user gives.

mod common;

use common::{Bench, PAPER};

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("paper.toml", PAPER).write("ref.csv", "time_s,reference_mm\n0,0\n0.01,1\n");
    bench
}

/// What it would show of the valve: how late, and that it is a single lag.
const VALVE: &str = "valve_late_s = 0.05\nvalve_late_error_s = 0.0002\n";
const ONE_LAG: &str = "valve_second_order_least = 0.0\nvalve_second_order_most = 0.0\n";

/// The paper's model with what a recording would show of time: so late, plus and minus so much (s).
fn with_times(late_s: f64, error_s: f64) -> String {
    format!(
        "{PAPER}\n[recorded]\nstep_s = 0.005\nnoise_mm = 0.03\nsteeper = 1.2\nlate_s = {late_s}\n\
         late_error_s = {error_s}\n{VALVE}{ONE_LAG}"
    )
}

fn number(text: &str, key: &str) -> f64 {
    let line = text.lines().find(|line| line.starts_with(&format!("{key} = "))).expect(key);
    line.split(" = ").nth(1).expect("a value").parse().expect("a number")
}

#[test]
fn a_tuned_model_holds_its_gains_and_what_they_promise_and_is_tuned_to_the_same_again() {
    let bench = bench();
    let said = bench.succeeds("tune paper.toml -o tuned.toml --report loop.html --json tuning.json");
    for part in ["largest sensitivity", "gain margin", "phase margin", "limited by", "assumed"] {
        assert!(said.contains(part), "{part} is missing: {said}");
    }
    let tuned = bench.read("tuned.toml");
    assert!(number(&tuned, "maximum_sensitivity") <= 1.6, "{tuned}");
    // Ms of 1.6 bounds both: 1.6/0.6 and 2 asin(1/3.2).
    assert!(number(&tuned, "gain_margin") >= 2.6 && number(&tuned, "phase_margin_deg") >= 36.0, "{tuned}");
    assert!(number(&tuned, "ki_bar_per_mm_s") > 0.0);
    assert!(bench.read("loop.html").contains("Gain of the open loop"));
    let json: serde_json::Value = serde_json::from_str(&bench.read("tuning.json")).expect("JSON");
    assert_eq!(json["kp_bar_per_mm"].as_f64(), Some(number(&tuned, "kp_bar_per_mm")));
    bench.succeeds("tune tuned.toml -o again.toml");
    assert_eq!(bench.read("again.toml"), tuned);
}

#[test]
fn the_better_a_recording_shows_the_time_the_faster_is_the_feedback() {
    let bench = bench();
    let gain = |error_s: f64| {
        bench.write("known.toml", with_times(0.0, error_s));
        bench.succeeds("tune known.toml -o tuned.toml --force");
        number(&bench.read("tuned.toml"), "ki_bar_per_mm_s")
    };
    let (well, badly) = (gain(0.0005), gain(0.01));
    assert!(well > 2.0 * badly, "{well} and {badly} bar/(mm s)");
    let tuned = bench.read("tuned.toml");
    assert!((number(&tuned, "lag_s") - 0.05).abs() < 1e-9, "the valve's lag is led: {tuned}");
    assert_eq!(number(&tuned, "slew_bar_per_s"), 120.0, "the whole range in the valve's lag");
}

#[test]
fn a_valve_that_may_be_of_second_order_makes_the_feedback_slower_and_that_is_said() {
    let bench = bench();
    bench.write("known.toml", with_times(0.0, 0.0005));
    bench.write("open.toml", with_times(0.0, 0.0005).replace(ONE_LAG, ""));
    let known = bench.succeeds("tune known.toml -o tuned.toml");
    let open = bench.succeeds("tune open.toml -o slower.toml");
    assert!(!known.contains("second order") && open.contains("of second order"), "{open}");
    let [fast, slow] = ["tuned.toml", "slower.toml"].map(|file| number(&bench.read(file), "ki_bar_per_mm_s"));
    assert!(slow < 0.5 * fast, "{slow} of {fast} bar/(mm s)");
}

#[test]
fn where_the_valve_was_not_recorded_a_user_may_say_what_it_is_and_else_is_told() {
    let bench = bench();
    let known = with_times(0.0, 0.001);
    let (unseen, _) = known.split_once("valve_late_s").expect("there");
    bench.write("unseen.toml", unseen);
    let said = bench.succeeds("tune unseen.toml -o assumed.toml");
    assert!(said.contains("the valve is not known, and a lag of up to 0.07 s"), "{said}");
    let said = bench.succeeds("tune unseen.toml --valve-lag-s 0.02 -o told.toml");
    assert!(!said.contains("the valve is not known"), "{said}");
    assert_eq!(number(&bench.read("told.toml"), "lag_s"), 0.02);
    assert!(
        number(&bench.read("told.toml"), "ki_bar_per_mm_s")
            > number(&bench.read("assumed.toml"), "ki_bar_per_mm_s")
    );
    assert!(bench.refuses("tune unseen.toml --valve-lag-s 0").contains("a number above 0"), "zero");
}

#[test]
fn where_no_gain_is_safe_there_is_none_and_the_reason_is_told() {
    let bench = bench();
    bench.write("still.toml", with_times(0.0, 1000.0));
    let message = bench.refuses("tune still.toml -o tuned.toml");
    assert!(message.contains("still.toml") && message.contains("too little movement"), "{message}");
    bench.write("wrong.toml", with_times(0.0, -1.0));
    let message = bench.refuses("tune wrong.toml -o tuned.toml");
    assert!(message.contains("[recorded] late_error_s: -1 is below 0"), "{message}");
    bench.write("late.toml", format!("{PAPER}\n[extensions.transport_delay]\ndelay_s = 8.0\n"));
    let message = bench.refuses("tune late.toml -o tuned.toml");
    assert!(message.contains("keeps a largest sensitivity of 1.6"), "{message}");
    bench.write(
        "band.toml",
        format!("{PAPER}\n[extensions.valve_deadband]\nform = \"hold\"\nband_bar = 0.2\n"),
    );
    let message = bench.refuses("tune band.toml -o tuned.toml");
    assert!(message.contains("below 0.2 bar") && message.contains("hunts"), "{message}");
}

/// What pil says of gains before it misses its firmware.
fn said_of(bench: &Bench, model: &str, gains: &str) -> String {
    bench.refuses(&format!(
        "pil --model {model} --reference ref.csv --plant-command cat --firmware none.elf {gains} -o log.csv"
    ))
}

#[test]
fn gains_that_a_user_gives_are_held_against_the_margins() {
    let bench = bench();
    bench.write("known.toml", with_times(0.0, 0.002));
    let said = said_of(&bench, "known.toml", "--kp 0.5 --ki 5");
    assert!(said.contains("is not stable everywhere") && said.contains("times what it may be"), "{said}");
    let said = said_of(&bench, "known.toml", "--kp 0.25 --ki 1");
    assert!(said.contains("near the edge: largest sensitivity") && said.contains("gain margin"), "{said}");
    for gains in ["--kp 0.01 --ki 0.05", "--max-bar 5", ""] {
        let said = said_of(&bench, "known.toml", gains);
        assert!(!said.contains("warning"), "{gains}: {said}");
    }
}

#[test]
fn a_tuning_for_another_tick_is_not_used_and_that_is_said() {
    let bench = bench();
    bench.write("known.toml", with_times(0.0, 0.002));
    bench.succeeds("tune known.toml -o tuned.toml");
    let said = said_of(&bench, "tuned.toml", "--rate-hz 200");
    assert!(said.contains("tuned for a tick of 0.001 s") && said.contains("--rate-hz 200"), "{said}");
    assert!(!said_of(&bench, "tuned.toml", "").contains("tuned for a tick"));
}

#[test]
fn learning_needs_passes_and_a_model_whose_errors_can_shrink() {
    let bench = bench();
    bench.write("known.toml", with_times(0.0, 0.002));
    assert!(said_of(&bench, "known.toml", "--learn learnt.csv").contains("--learn needs --repeat N"));
    let said = said_of(&bench, "known.toml", "--learn learnt.csv --correction other.csv --repeat 2");
    assert!(said.contains("other.csv"), "{said}");
    bench.write("other.csv", "time_s,reference_mm,correction_mm\n0,0,0\n0.01,2,0\n");
    let said = said_of(&bench, "known.toml", "--correction other.csv");
    assert!(said.contains("learnt for another reference: at 0.001 s"), "{said}");
}
