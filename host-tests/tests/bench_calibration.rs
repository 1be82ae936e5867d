//! `mgpi calibrate` against the board's own code: what gauge and ruler show becomes what the board
//! shows, and no model takes it away.

use host_tests::desk_commands::DeskBench as Bench;

/// What a gauge shows where the board's standard sensor shows so much, on this desk. Unit: bar.
fn gauge_bar(shown_bar: f64) -> f64 {
    0.1 + 1.05 * shown_bar
}

/// The board's pressure comes to this once the muscle is empty, some tenths of a second behind a
/// stop. Unit: bar.
fn assert_comes_to(bench: &Bench, expected_bar: f64) {
    let shown = || bench.status()["pressure_bar"].as_f64().expect("a pressure");
    let has_come = (0..40).any(|_| (shown() - expected_bar).abs() < 0.03);
    assert!(has_come, "{} bar are shown, not {expected_bar}", shown());
}

#[test]
fn two_points_of_the_pressure_are_what_the_board_shows_from_then_on_whatever_is_deployed() {
    let bench = Bench::new();
    assert_comes_to(&bench, 0.0);
    let readings = format!("--readings {},{}", gauge_bar(0.0), gauge_bar(4.0));
    let said = bench.succeeds(&format!("calibrate pressure --low 0 --high 4 {readings}"));
    assert!(said.contains("written and read back"), "{said}");
    assert_comes_to(&bench, gauge_bar(0.0));
    bench.succeeds("deploy paper.toml");
    assert_comes_to(&bench, gauge_bar(0.0));
    // What is measured is vented, and the valve too.
    assert_eq!(bench.status()["state"], "Ready");
}

#[test]
fn the_regulator_is_brought_to_what_the_sensor_shows() {
    let bench = Bench::new();
    let readings = format!("--readings {},{}", gauge_bar(0.0), gauge_bar(4.0));
    bench.succeeds(&format!("calibrate pressure --low 0 --high 4 {readings}"));
    // By its standard scaling 4 bar are 4.3 by the gauge; the codes that make 1 and 4 bar are less.
    let said = bench.succeeds("calibrate regulator --low 1 --high 4");
    let gain = said.lines().find(|line| line.starts_with("gain")).expect("a gain");
    let after: f64 = gain.split_whitespace().nth(3).and_then(|word| word.parse().ok()).expect("a number");
    assert!((after - 409.5 / 1.05).abs() < 4.0, "{said}");
    // A second time it finds nothing to do.
    let again = bench.succeeds("calibrate regulator --low 1 --high 4 --dry-run");
    let words: Vec<_> =
        again.lines().find(|line| line.starts_with("gain")).expect("a gain").split_whitespace().collect();
    let [before, after] = [1, 3].map(|place| words[place].parse::<f64>().expect("a number"));
    assert!((before - after).abs() < 4.0, "{again}");
}

#[test]
fn a_line_that_no_working_sensor_has_is_refused_and_nothing_changes() {
    let bench = Bench::new();
    let message = bench.refuses("calibrate pressure --low 0 --high 4 --readings 0,8");
    assert!(message.contains("pressure: ") && message.contains("must be 0.8 to 1.25"), "{message}");
    let message = bench.refuses("calibrate contraction --low 0 --high 4 --readings 0,5");
    assert!(message.contains("must be at least 10 mm apart"), "{message}");
    let message = bench.refuses("calibrate pressure --low 0 --high 4 --readings 2,6");
    assert!(message.contains("its zero is off by"), "{message}");
    assert_comes_to(&bench, 0.0);
    assert_eq!(bench.status()["state"], "Off");
}

#[test]
fn a_dry_run_says_the_line_and_writes_nothing() {
    let bench = Bench::new();
    let said = bench.succeeds("calibrate pressure --readings 0.2,4.2 --dry-run");
    assert!(said.contains("nothing has been changed"), "{said}");
    assert_comes_to(&bench, 0.0);
}

#[test]
fn a_reading_is_asked_for_and_a_word_is_no_number() {
    use std::io::Write as _;
    use std::process::Stdio;
    let bench = Bench::new();
    let mut command = bench.command("calibrate pressure --low 0 --high 4");
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("mgpi runs");
    child.stdin.take().expect("piped").write_all(b"four\n0.1\n4.3\n").expect("written");
    let output = child.wait_with_output().expect("it ends");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("\"four\" is no number") && said.contains("written and read back"), "{said}");
}

#[test]
fn a_sensor_of_4_to_20_ma_is_told_shown_backed_up_and_brought_back() {
    let bench = Bench::new();
    let said = bench.succeeds("calibrate pressure --input current --burden-ohm 150 --range 0,10");
    assert!(said.contains("ratiometric -> 4 to 20 mA over 150.0 ohm for 0 to 10 bar"), "{said}");
    let shown = || bench.status()["inputs"]["pressure"].clone();
    assert_eq!(shown(), "4 to 20 mA over 150.0 ohm for 0 to 10 bar");
    bench.succeeds("backup -o current.toml");
    bench.succeeds("calibrate pressure --input ratiometric");
    assert_eq!(shown(), "ratiometric");
    assert_comes_to(&bench, 0.0);
    bench.succeeds("restore current.toml");
    assert_eq!(shown(), "4 to 20 mA over 150.0 ohm for 0 to 10 bar");
}

#[test]
fn an_input_that_cannot_be_is_refused_by_value_and_limits_and_nothing_changes() {
    let bench = Bench::new();
    for (arguments, said) in [
        (
            "--input current --burden-ohm 200 --range 0,10",
            "its pin has 4 V at the end of its range, must be 1 to 3.11",
        ),
        ("--input voltage --divider 0.3 --range 0,6", "its range ends at 6, must be at least 8.5"),
        ("--input current --burden-ohm 150 --range 10,0", "its range is 10 to 0, must rise"),
        ("--input current --range 0,10", "--burden-ohm"),
        ("--input voltage --divider 0.3", "--range"),
        ("--input ratiometric --range 0,10", "no --range"),
    ] {
        let message = bench.refuses(&format!("calibrate pressure {arguments}"));
        assert!(message.contains(said), "{arguments}: {message}");
    }
    let message = bench.refuses("calibrate regulator --input current --burden-ohm 150 --range 0,10");
    assert!(message.contains("the regulator is no input"), "{message}");
    assert_eq!(bench.status()["inputs"]["pressure"], "ratiometric");
}
