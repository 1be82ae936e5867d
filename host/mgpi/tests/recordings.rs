//! What the command says about recordings, good and bad.

mod common;

use common::{Bench, recording};

const HEADER: &str = "time_s,pressure_bar,contraction_mm\n";

/// Good rows below a header.
fn rows(count: usize) -> String {
    (0..count).map(|i| format!("{},{},{}\n", 0.1 * i as f64, (i % 40) as f64 / 8.0, i % 40)).collect()
}

/// The message about `content` as a recording, without "error: ".
fn refusal(content: impl AsRef<[u8]>, options: &str) -> String {
    let bench = Bench::new();
    bench.write("rec.csv", content);
    let message =
        bench.refuses(&format!("identify rec.csv -o model.toml --report r.html --json r.json {options}"));
    message.trim_end().strip_prefix("error: ").expect(&message).to_owned()
}

#[test]
fn a_missing_column_is_named_beside_those_present() {
    let message = refusal("time_s,pressure_bar\n0,1\n", "");
    assert_eq!(message, "rec.csv: no column contraction_mm; the file has time_s, pressure_bar");
    let message = refusal("time_s,contraction_mm\n0,1\n", "");
    assert_eq!(
        message,
        "rec.csv: no column pressure_bar or command_bar; the file has time_s, contraction_mm"
    );
    let message = refusal(format!("{HEADER}{}", rows(50)), "--output force_n");
    assert!(message.starts_with("rec.csv: no column force_n; the file has time_s"), "{message}");
}

#[test]
fn a_doubled_column_is_refused() {
    let message = refusal("time_s,pressure_bar,pressure_bar,contraction_mm\n0,1,1,2\n", "");
    assert_eq!(message, "rec.csv, line 1, column pressure_bar: the column appears twice");
}

#[test]
fn an_unknown_unit_is_refused_with_the_known_ones() {
    let message = refusal("# x\ntime_s,pressure_x,contraction_mm\n0,1,2\n", "--input pressure_x");
    let start = "rec.csv, line 2, column pressure_x: the name does not end in a known unit; say it by --units pressure_x=UNIT; \
                 known are _s,";
    assert!(message.starts_with(start) && message.contains("_bar"), "{message}");
}

#[test]
fn strictly_a_name_in_upper_case_is_refused() {
    let message = refusal("Time_s,pressure_bar,contraction_mm\n0,1,2\n", "--strict");
    assert_eq!(
        message,
        "rec.csv, line 1, column Time_s: --strict refuses what would have to be mended: \
         Time_s is not a name in small letters with its unit"
    );
}

#[test]
fn commas_that_separate_fields_and_decimals_are_refused() {
    let message = refusal("time_s,pressure_bar,contraction_mm\n0,0,-0,0004,0,0612\n", "");
    assert!(
        message.starts_with(
            "rec.csv, line 2: 6 fields where the header has 3: decimal commas split the numbers; export"
        ),
        "{message}"
    );
}

#[test]
fn a_field_that_is_no_number_is_shown_with_its_line() {
    let message = refusal(format!("{HEADER}0,1,2\n# comment\n\n1,two,3\n"), "");
    assert_eq!(message, "rec.csv, line 5, column pressure_bar: `two` is not a number");
    let message = refusal(format!("{HEADER}0,1,\n"), "");
    assert_eq!(
        message,
        "rec.csv, line 1, column contraction_mm: the column has no value in the rows that are scored"
    );
}

#[test]
fn infinity_is_refused_and_strictly_what_is_missing() {
    let message = refusal(format!("{HEADER}0,1,2\n1,1,NaN\n"), "--strict");
    assert!(
        message.starts_with("rec.csv, line 3, column contraction_mm: no value: the field is empty"),
        "{message}"
    );
    for value in ["inf", "-Infinity", "1e999"] {
        let message = refusal(format!("{HEADER}0,1,2\n1,1,{value}\n"), "");
        assert_eq!(message, format!("rec.csv, line 3, column contraction_mm: `{value}` is not finite"));
    }
}

#[test]
fn time_that_goes_back_is_refused() {
    let message = refusal(format!("{HEADER}0,1,2\n0.5,1,2\n0.25,1,2\n"), "");
    assert!(
        message.starts_with("rec.csv, line 4, column time_s: time goes back: 0.25 s follows 0.5 s"),
        "{message}"
    );
}

#[test]
fn a_ragged_row_is_refused() {
    let message = refusal(format!("{HEADER}0,1,2\n0.5,1\n0.75,1,2\n"), "");
    assert_eq!(message, "rec.csv, line 3, column contraction_mm: 2 fields where the header has 3");
}

#[test]
fn fewer_rows_than_parameters_are_refused() {
    let message = refusal(format!("{HEADER}{}", rows(12)), "");
    assert!(message.starts_with("rec.csv, pressure_bar to contraction_mm: 12 rows count"), "{message}");
    assert!(message.contains("parameters"), "{message}");
}

#[test]
fn a_constant_input_is_refused() {
    let constant: String = (0..50).map(|i| format!("{},2.5,{i}\n", 0.1 * f64::from(i))).collect();
    let message = refusal(format!("{HEADER}{constant}"), "");
    assert!(
        message.starts_with("rec.csv, pressure_bar to contraction_mm: the input is constant (2.5)"),
        "{message}"
    );
}

#[test]
fn pressure_outside_the_valves_range_is_refused() {
    let message = refusal(format!("{HEADER}0,1,2\n1,6.5,2\n"), "--input-range 0,6");
    assert_eq!(
        message,
        "rec.csv, line 3, column pressure_bar: 6.5 bar is outside 0 to 6 bar, the range of --input-range"
    );
}

#[test]
fn pressure_that_must_be_in_kilopascal_is_refused() {
    let message = refusal(format!("{HEADER}0,1,2\n1,600,2\n"), "");
    assert_eq!(
        message,
        "rec.csv, line 3, column pressure_bar: 600 bar is outside -1.1 to 100 bar, the pressures of a muscle: \
         is the column in kPa?"
    );
}

#[test]
fn files_without_a_row_are_refused() {
    assert_eq!(refusal("", ""), "rec.csv: the file is empty");
    assert_eq!(refusal("# only a comment\n\n", ""), "rec.csv: the file is empty");
    assert_eq!(refusal(HEADER, ""), "rec.csv: no row of data below the header");
}

#[test]
fn binary_files_are_refused_at_their_first_foreign_byte() {
    assert_eq!(refusal(b"time_s\0", ""), "rec.csv: not a text file: byte 6 is a NUL");
    assert_eq!(refusal(b"\x89PNG\r\n\x1a\n", ""), "rec.csv: not a text file: byte 0 is not UTF-8");
}

#[test]
fn a_missing_file_is_refused() {
    let message = Bench::new().refuses("identify nowhere.csv -o model.toml");
    assert!(message.starts_with("error: nowhere.csv: cannot be read: "), "{message}");
}

#[test]
fn validity_must_be_a_flag_and_once_true() {
    let header = "time_s,pressure_bar,contraction_mm,valid\n";
    let message = refusal(format!("{header}0,1,2,1\n1,1,2,0.5\n"), "");
    assert_eq!(message, "rec.csv, line 3, column valid: 0.5 is neither 0 nor 1");
    let message = refusal(format!("{header}0,1,2,0\n1,1,2,0\n"), "");
    assert_eq!(message, "rec.csv, column valid: no row is valid: the column is 0 everywhere");
}

#[test]
fn a_length_needs_the_length_at_rest() {
    let message = refusal("time_s,pressure_bar,length_mm\n0,1,500\n", "");
    assert_eq!(
        message,
        "rec.csv, column length_mm: is a length; --rest-length MM is needed to turn it into a contraction"
    );
}

#[test]
fn models_and_envelopes_that_there_are_not_are_refused_plainly() {
    let message = refusal_of_usage("--model preisach");
    assert!(
        message.contains("invalid value 'preisach'")
            && message.contains("possible values: cpi, sgpi, agpi, mpi, egpi, mgpi"),
        "{message}"
    );
    let message = refusal_of_usage("--envelope spline");
    assert!(
        message.contains("invalid value 'spline'") && message.contains("possible values: tanh, pl"),
        "{message}"
    );
}

#[test]
fn an_envelope_for_a_model_that_has_none_to_choose_is_refused() {
    let message = refusal_of_usage("--model agpi --envelope pl");
    assert!(message.contains("--envelope is for the models mgpi and sgpi; agpi has two tanh"), "{message}");
    let message = refusal_of_usage("--model cpi --envelope tanh");
    assert!(message.contains("--envelope is for the models mgpi and sgpi; cpi has none"), "{message}");
}

#[test]
fn a_number_of_knots_outside_its_limits_is_refused() {
    let bench = Bench::new();
    recording(&bench, "rec.csv");
    let message = bench.refuses("identify rec.csv -o model.toml --envelope pl --knots 2");
    assert!(message.contains("number of knots is 2, must be 3 to 32"), "{message}");
}

fn refusal_of_usage(options: &str) -> String {
    Bench::new().refuses(&format!("identify rec.csv -o model.toml {options}"))
}

#[test]
fn byte_order_mark_and_windows_line_ends_change_nothing() {
    let bench = Bench::new();
    recording(&bench, "rec.csv");
    let windows = format!("\u{feff}# from Windows\r\n{}", bench.read("rec.csv").replace('\n', "\r\n"));
    bench.write("windows.csv", windows);
    for name in ["rec", "windows"] {
        bench.succeeds(&format!("identify {name}.csv -o {name}.toml --starts 2"));
    }
    let without_source = |name: &str| -> Vec<String> {
        let text = bench.read(name);
        let differs = |line: &str| line.starts_with("recording =") || line.starts_with("sha256 =");
        text.lines().filter(|line| !differs(line)).map(str::to_owned).collect()
    };
    assert_eq!(without_source("rec.toml"), without_source("windows.toml"));
}

#[test]
fn a_length_is_the_same_recording_as_its_contraction() {
    let bench = Bench::new();
    recording(&bench, "rec.csv");
    let text = bench.read("rec.csv");
    let mut lengths = "time_s,pressure_bar,length_mm\n".to_owned();
    for line in text.lines().skip(1) {
        let (start, contraction) = line.rsplit_once(',').expect("three fields");
        lengths += &format!("{start},{}\n", 500.0 - contraction.parse::<f64>().expect("a number"));
    }
    bench.write("lengths.csv", lengths);
    bench.succeeds("identify rec.csv -o model.toml --starts 2");
    let said = bench.succeeds("simulate model.toml --input lengths.csv -o out.csv --rest-length 500");
    let direct = bench.succeeds("simulate model.toml --input rec.csv -o direct.csv");
    assert_eq!(said, direct);
}

#[test]
fn the_second_recording_needs_the_columns_of_the_first() {
    let bench = Bench::new();
    recording(&bench, "rec.csv");
    bench.write("second.csv", bench.read("rec.csv").replace("pressure_bar", "command_bar"));
    let message = bench.refuses("identify rec.csv -o model.toml --validate second.csv");
    assert_eq!(
        message,
        "error: second.csv: no column pressure_bar; the file has time_s, command_bar, contraction_mm; \
         if command_bar is meant, say --input command_bar\n"
    );
}

#[test]
fn gaps_in_time_are_allowed_and_reported() {
    let bench = Bench::new();
    recording(&bench, "rec.csv");
    let text = bench.read("rec.csv");
    let kept: Vec<&str> = text
        .lines()
        .enumerate()
        .filter(|(line, _)| !(300..320).contains(line))
        .map(|(_, text)| text)
        .collect();
    bench.write("gap.csv", kept.join("\n"));
    let said = bench.succeeds("identify gap.csv -o model.toml --starts 2");
    assert!(said.contains("time steps    0.0500 s, 1 gaps, the largest 1.0500 s at 14.9"), "{said}");
}
