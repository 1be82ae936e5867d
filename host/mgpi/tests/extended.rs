//! Model files with extensions, and their simulation.

mod common;

use common::{Bench, PAPER};
use recording::model_file::ModelFile;

/// Every extension.
const EXTENSIONS: &str = include_str!("common/every_extension.toml");

/// What acts on the other side of the hysteresis than usual, behind a valve of another form.
const ELSEWHERE: &str = r#"
[extensions.valve_lag]
time_constant_s = 0.05
lead_limit_bar = 1.5
absolute_supply_bar = 8.0
absolute_outside_bar = 1.0

[extensions.load]
acts_on = "contraction"
reference_n = 20.0
knots_mm = [10.0, 60.0, 110.0]
offset_mm_per_n = [0.1, 0.2, 0.4]

[extensions.temperature]
acts_on = "contraction"
reference_c = 25.0
knots_mm = [0.0]
offset_mm_per_k = [-0.1]

[extensions.warm_up]
acts_on = "contraction"
travel_mm = 300.0
knots_mm = [10.0, 110.0]
offset_mm = [3.0, 1.0]

[extensions.viscous_lag]
acts_on = "contraction"
knots_mm = [0.0]
viscosity_s = [0.05]

[extensions.inertia]
acts_on = "contraction"
knots_mm = [60.0]
inertia_s2 = [0.0004]

[extensions.rate_dependent_thresholds]
exponent = 0.6
filter_s = 0.01
knots_mm = [10.0, 60.0, 110.0]
gain = [0.02, 0.03, 0.04]
pressure_gain = 0.3
resolution_bar = 0.004

[extensions.creep]
acts_on = "pressure"
time_constants_s = [0.1, 1.0, 10.0]
fractions = [0.02, 0.03, 0.03]
"#;

fn with_extensions(extensions: &str) -> String {
    format!("{PAPER}\n{extensions}")
}

#[test]
fn every_extension_is_written_as_it_was_read() {
    assert_written_as_read(EXTENSIONS);
}

#[test]
fn an_extension_on_the_other_side_of_the_hysteresis_is_written_as_it_was_read() {
    assert_written_as_read(ELSEWHERE);
}

#[test]
fn a_strength_in_the_unit_of_the_other_side_is_refused() {
    let bench = Bench::new();
    bench.write("bad.toml", with_extensions(&ELSEWHERE.replace("viscosity_s =", "viscosity_bar_s_per_mm =")));
    let error = ModelFile::read(&bench.path("bad.toml")).expect_err("invalid").to_string();
    assert!(error.contains("[extensions.viscous_lag] viscosity_s: missing"), "{error}");
}

fn assert_written_as_read(extensions: &str) {
    let bench = Bench::new();
    bench.write("model.toml", with_extensions(extensions));
    let file = ModelFile::read(&bench.path("model.toml")).expect("valid");
    let written = file.to_toml();
    // Every table with every key, as it stands above.
    let found: Vec<&str> = written.lines().skip_while(|line| !line.starts_with("[extensions.")).collect();
    let given: Vec<&str> = extensions.trim().lines().collect();
    let plain = |line: &&str| line.replace("3e-5", "0.00003");
    assert_eq!(found.iter().map(plain).collect::<Vec<_>>(), given.iter().map(plain).collect::<Vec<_>>());
    let again = ModelFile::read(bench.write("again.toml", &written).path("again.toml").as_path());
    assert_eq!(again.expect("valid").extensions, file.extensions);
}

#[test]
fn a_file_without_extensions_has_none_and_leaves_none() {
    let bench = Bench::new();
    let file = ModelFile::read(&bench.write("paper.toml", PAPER).path("paper.toml")).expect("valid");
    assert_eq!(file.extensions, model_core::ExtensionParameters::default());
    assert!(!file.to_toml().contains("extensions"));
}

#[test]
fn a_lead_limit_that_is_not_given_is_the_usual_one() {
    let bench = Bench::new();
    bench.write("model.toml", with_extensions("[extensions.valve_lag]\ntime_constant_s = 0.1"));
    let file = ModelFile::read(&bench.path("model.toml")).expect("valid");
    assert_eq!(file.extensions.valve_lag.expect("given").lead_limit, 2.0);
}

#[test]
fn extensions_that_cannot_be_are_refused_by_table_and_key() {
    for (good, bad, problem) in [
        ("band_bar = 0.05", "", "[extensions.valve_deadband] band_bar: missing"),
        ("band_bar", "band_mm", "[extensions.valve_deadband] band_bar: missing"),
        (
            "\"backlash\"",
            "\"loose\"",
            "[extensions.valve_deadband] form: \"loose\" is not known, must be \"hold\" or \"backlash\"",
        ),
        (
            "time_constant_s = 0.05",
            "time_constant_s = 0.05\ndamping_ratio = 0.0",
            "no invertible model: valve_lag damping_ratio is 0, must be above 0",
        ),
        (
            "time_constant_s = 0.05",
            "time_constant_s = 0.05\nabsolute_supply_bar = 8.0",
            "[extensions.valve_lag] absolute_outside_bar: missing",
        ),
        (
            "time_constant_s = 0.05",
            "time_constant_s = 0.05\nabsolute_supply_bar = 1.0\nabsolute_outside_bar = 1.0",
            "no invertible model: valve_lag supply is 1 bar, must be above 1 bar",
        ),
        (
            "time_constant_s = 0.05",
            "time_constant_s = 0.05\ndamping_ratio = 1.0\nabsolute_supply_bar = 8.0",
            "[extensions.valve_lag] absolute_supply_bar: unknown key",
        ),
        ("[extensions.load]", "[extensions.weight]", "[extensions] weight: unknown key"),
        ("delay_s = 0.015", "delay_s = 0.015\nlag_s = 1", "[extensions.transport_delay] lag_s: unknown key"),
        ("delay_s = 0.015", "delay_s = nan", "[extensions.transport_delay] delay_s: NaN is not finite"),
        (
            "delay_s = 0.015",
            "delay_s = -0.1",
            "no invertible model: transport_delay delay_s is -0.1 s, must be at least 0 s",
        ),
        ("[0.01, 0.02, 0.04]", "[0.01, 0.02]", "no invertible model: load is 2, must be exactly 3"),
        (
            "knots_mm = [0.0]",
            "knots_mm = [0.0, 1.0, 2.0, 3.0, 4.0]",
            "[extensions.temperature] knots_mm: 5 numbers, must be at most 4",
        ),
        (
            "knots_mm = [10.0, 110.0]",
            "knots_mm = [110.0, 10.0]",
            "no invertible model: knots[1] is 10 mm, must be above 110 mm",
        ),
        (
            "[0.002, 0.003, 0.006]",
            "[0.002, -0.003, 0.006]",
            "no invertible model: viscous_lag[1] is -0.003 bar s/mm, must be at least 0 bar s/mm",
        ),
        (
            "fractions = [0.02, 0.03, 0.03]",
            "fractions = [0.5, 0.3, 0.2]",
            "no invertible model: sum of creep fractions is 1, must be below 1",
        ),
        (
            "gain = [0.02, 0.03, 0.04]",
            "gain = [0.02, 0.03, 0.04]\npressure_gain = 0.3",
            "[extensions.rate_dependent_thresholds] resolution_bar: missing",
        ),
        (
            "gain = [0.02, 0.03, 0.04]",
            "gain = [0.02, 0.03, 0.04]\npressure_gain = 0.3\nresolution_bar = -1",
            "no invertible model: rate_dependent_thresholds resolution is -1 bar, must be at least 0 bar",
        ),
        ("compensated = false", "compensated = 0", "[extensions.drift] compensated: true or false is needed"),
    ] {
        let bench = Bench::new();
        assert!(EXTENSIONS.contains(good), "{good}");
        bench.write("model.toml", with_extensions(&EXTENSIONS.replacen(good, bad, 1)));
        bench.write("rec.csv", "time_s,pressure_bar\n0,1\n");
        let message = bench.refuses("simulate model.toml --input rec.csv -o out.csv");
        assert!(message.contains(&format!("model.toml: {problem}")), "{message}");
    }
}

/// The last column of what `simulate` writes.
fn simulated(bench: &Bench, model: &str, recording: &str) -> Vec<f64> {
    bench.succeeds(&format!("simulate {model} --input {recording} -o out.csv --force"));
    let last = |line: &str| line.rsplit_once(',').expect("fields").1.parse().expect("a number");
    bench.read("out.csv").lines().skip(1).map(last).collect()
}

/// A swing of the input, 100 rows a second, with further columns.
fn swing(header: &str, mut rest: impl FnMut(f64) -> String) -> String {
    let row = |k: u32| {
        let time_s = f64::from(k) / 100.0;
        format!("{time_s},{}{}\n", 3.0 - 2.0 * time_s.cos(), rest(time_s))
    };
    format!("time_s,{header}\n") + &(0..1000).map(row).collect::<String>()
}

#[test]
fn a_load_takes_its_pressure_from_the_model_and_needs_its_column() {
    let bench = Bench::new();
    let load = "[extensions.load]\nreference_n = 20.0\nknots_mm = [0.0]\noffset_bar_per_n = [0.05]";
    bench.write("loaded.toml", with_extensions(load)).write("plain.toml", PAPER);
    bench.write("rec.csv", swing("pressure_bar,load_n", |_| ",30".to_owned()));
    let less = |time_s: f64| format!(",{}", 3.0 - 2.0 * time_s.cos() - 0.5);
    bench.write("less.csv", swing("command_bar,pressure_bar", less));
    let (loaded, expected) =
        (simulated(&bench, "loaded.toml", "rec.csv"), simulated(&bench, "plain.toml", "less.csv"));
    assert_eq!(loaded.len(), 1000);
    assert!(loaded.iter().zip(&expected).all(|(loaded, expected)| (loaded - expected).abs() < 1e-6));

    let message = bench.refuses("simulate loaded.toml --input less.csv -o other.csv");
    assert!(message.contains("less.csv: no column load_n; the file has"), "{message}");
}

#[test]
fn a_valve_stands_before_a_model_from_the_command_and_beside_one_from_the_pressure() {
    let bench = Bench::new();
    let from_command = |text: String| text.replace("column = \"pressure_bar\"", "column = \"command_bar\"");
    let lag = "[extensions.valve_lag]\ntime_constant_s = 0.3";
    bench.write("plain.toml", PAPER).write("beside.toml", with_extensions(lag));
    bench.write("before.toml", from_command(with_extensions(lag)));
    // The pressure of a regulator with that lag, from where the command begins.
    let (mut pressure, share) = (1.0, 1.0 - (-0.01_f64 / 0.3).exp());
    let lagging = |time_s: f64| {
        pressure += (3.0 - 2.0 * time_s.cos() - pressure) * share;
        format!(",{pressure}")
    };
    bench.write("rec.csv", swing("command_bar,pressure_bar", lagging));
    let from_pressure = simulated(&bench, "plain.toml", "rec.csv");
    assert_eq!(simulated(&bench, "beside.toml", "rec.csv"), from_pressure);
    let from_command = simulated(&bench, "before.toml", "rec.csv");
    assert!(from_command.iter().zip(&from_pressure).all(|(one, other)| (one - other).abs() < 1e-9));
}

#[test]
fn rows_too_dense_for_a_delay_are_refused_with_their_line() {
    let bench = Bench::new();
    bench.write("model.toml", with_extensions("[extensions.transport_delay]\ndelay_s = 6.0"));
    bench.write("rec.csv", swing("pressure_bar", |_| String::new()));
    let message = bench.refuses("simulate model.toml --input rec.csv -o out.csv");
    assert!(message.contains("rec.csv, line 514, column time_s: there are more samples"), "{message}");
}
