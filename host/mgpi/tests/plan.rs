//! What `mgpi plan` claims: a command within its limits that says what each part is for, and
//! nothing half done.

mod common;

use common::Bench;

/// Times and commands of a plan.
fn rows(csv: &str) -> Vec<(f64, f64)> {
    let data = csv.lines().skip_while(|line| line.starts_with('#'));
    data.skip(1)
        .map(|line| {
            let (time_s, command_bar) = line.split_once(',').expect("two fields");
            (time_s.parse().expect("a number"), command_bar.parse().expect("a number"))
        })
        .collect()
}

#[test]
fn a_plan_says_what_its_parts_are_for_and_where_rivals_part() {
    let bench = Bench::new();
    let printed = bench.succeeds("plan --causes transport_delay,valve_lag -o plan.csv --max-bar 4");
    let csv = bench.read("plan.csv");
    for words in [
        "excitation for transport_delay, valve_lag",
        "jumps with short holds",
        "transport_delay or valve_lag: after a jump a delay leaves all still",
        "record the measured pressure as pressure_bar",
    ] {
        assert!(csv.contains(words) && printed.contains(words), "{words} is missing: {printed}");
    }
    assert!(!csv.contains("long holds"), "creep is not asked for: {csv}");
    let rows = rows(&csv);
    assert!(rows.windows(2).all(|pair| pair[0].0 < pair[1].0));
    let highest = rows.iter().map(|row| row.1).fold(0.0, f64::max);
    assert_eq!(highest, 4.0);
}

#[test]
fn the_same_wishes_give_the_same_file() {
    let bench = Bench::new();
    let command = "plan --max-bar 5 --min-bar 0.5 --slew-bar-per-s 10 --rate-hz 50 --duration-s 400 -o";
    bench.succeeds(&format!("{command} one.csv"));
    bench.succeeds(&format!("{command} other.csv"));
    let csv = bench.read("one.csv");
    assert_eq!(csv, bench.read("other.csv"));
    let rows = rows(&csv);
    assert!(rows.windows(2).all(|pair| (pair[1].1 - pair[0].1).abs() <= 0.2 + 1e-4));
    assert!((rows[rows.len() - 1].0 - 400.0).abs() <= 0.021);
}

#[test]
fn unusable_wishes_are_refused() {
    let bench = Bench::new();
    for (arguments, message) in [
        ("--causes friction", "known are valve_lag, valve_deadband"),
        ("--max-bar 0", "0 to 0 bar; the lower must come first"),
        ("--max-bar 600", "600 bar is outside -1 to 100 bar"),
        ("--max-bar nan", "the lower must come first"),
        ("--slew-bar-per-s 0", "a number above 0"),
        ("--duration-s 5", "5 s is too short"),
        ("--rate-hz 1e6", "a lower rate has fewer"),
    ] {
        let refusal = bench.refuses(&format!("plan -o plan.csv {arguments}"));
        assert!(refusal.contains(message), "{arguments}: {refusal}");
    }
}

#[test]
fn an_existing_plan_is_kept_unless_forced() {
    let bench = Bench::new();
    bench.write("plan.csv", "mine");
    let refusal = bench.refuses("plan -o plan.csv");
    assert_eq!(refusal, "error: plan.csv: exists already; --force overwrites it\n");
    assert_eq!(bench.read("plan.csv"), "mine");
    bench.succeeds("plan -o plan.csv --force");
}
