//! Names, units and holes of input and output.

use super::bench::*;

/// A file with these names, whose values are so many times bar and mm.
fn named(header: &str, input: f64, output: f64) -> String {
    file(header, |_, [t, p, x]| format!("{t},{},{}", p * input, x * output))
}

#[test]
fn units_in_brackets_are_read() {
    reads_usual(named("Time [s],Pressure [bar],Contraction [mm]", 1.0, 1.0), &[]);
    reads_usual(named("time / s,pressure / bar,contraction / mm", 1.0, 1.0), &[]);
    reads_usual(named("Time(s),Pressure(bar(g)),Contraction(mm)", 1.0, 1.0), &[]);
    reads_usual(named("TIME_S,PRESSURE_BAR,CONTRACTION_MM", 1.0, 1.0), &[]);
}

#[test]
fn a_row_of_units_is_read() {
    for units in ["s,bar,mm", "[s],[bar],[mm]", "(s),(bar),(mm)"] {
        reads_usual(named(&format!("Time,Pressure,Contraction\n{units}"), 1.0, 1.0), &["read as units"]);
    }
    let text = named("time_s,pressure_bar,contraction_mm\ns,kPa,mm", 100.0, 1.0);
    let kpa = [("pressure_kpa", 100.0), ("contraction_mm", 1.0)];
    refuses(text, "--units pressure_bar=bar or --units pressure_bar=kPa", "--units pressure_bar=kPa", kpa);
}

#[test]
fn the_model_takes_over_the_unit_of_its_column() {
    for (unit, a_bar) in [
        ("kpa", 100.0),
        ("mpa", 0.1),
        ("mbar", 1000.0),
        ("hpa", 1000.0),
        ("pa", 1e5),
        ("psi", 1e5 / 6_894.757_293_168_361),
    ] {
        let name = format!("pressure_{unit}");
        let text = named(&format!("time_s,{name},contraction_mm"), a_bar, 1.0);
        reads(text, "", [(&name, a_bar), ("contraction_mm", 1.0)], &[]);
    }
    for (unit, a_mm) in [("cm", 0.1), ("um", 1000.0), ("m", 0.001)] {
        let name = format!("contraction_{unit}");
        reads(
            named(&format!("time_s,pressure_bar,{name}"), 1.0, a_mm),
            "",
            [("pressure_bar", 1.0), (&name, a_mm)],
            &[],
        );
    }
    let inches = [("pressure_bar", 1.0), ("contraction_in", 1.0 / 25.4)];
    reads(named("time_s,pressure_bar,Contraction [in]", 1.0, 1.0 / 25.4), "", inches, &[]);
}

#[test]
fn a_column_that_is_asked_for_in_a_unit_is_converted() {
    let text = named("time_s,pressure_kpa,contraction_cm", 100.0, 0.1);
    let notes = ["pressure_kpa was converted to bar", "contraction_cm was converted to mm"];
    reads(text, "--input pressure_bar --output contraction_mm", USUAL, &notes);
}

/// A file with a pressure that follows a command; the array says how many of each column's unit are
/// one bar.
fn commanded(pressure: &str, [input, command]: [f64; 2], follow: impl Fn(f64) -> f64) -> String {
    let header = format!("time_s,{pressure},command_bar,contraction_mm");
    file(&header, |_, [t, p, x]| format!("{t},{},{},{x}", follow(p) * input, p * command))
}

#[test]
fn a_pressure_in_the_commands_unit_under_another_name_is_asked_about() {
    let follows = |p: f64| 0.02 + 0.97 * p;
    for (column, a_bar, right) in
        [("pressure_psig", 1.0, "bar"), ("pressure_bar", 0.1, "mpa"), ("pressure_kpa", 14.504, "psi")]
    {
        let text = commanded(column, [a_bar, 1.0], follows);
        let refused = read(text.as_bytes(), "").expect_err("it is refused");
        let cure = format!("--units pressure={right}");
        assert!(refused.contains(&format!("is it in {right}? {cure} if so")), "{refused}");
        let recording = read(text.as_bytes(), &cure).expect("the cure helps");
        let [_, p, _] = row(40);
        assert!((recording.drive.input.values[40] - a_bar * follows(p)).abs() < 1e-9);
        let (_, confirmed) = refused.rsplit_once(", ").expect("two options");
        let confirmed = confirmed.trim_end_matches(" if the name is right");
        read(text.as_bytes(), confirmed).expect("the name is right");
    }
    let text = commanded("pressure_bar", [1.0, 1000.0], follows);
    let refused = read(text.as_bytes(), "").expect_err("it is refused");
    assert!(refused.contains("column command_bar"), "{refused}");
    read(text.as_bytes(), "--units command=mbar").expect("the cure helps");
}

#[test]
fn a_pressure_that_hardly_follows_its_command_is_read() {
    // A tenth of the swing about the same mean: a lag, and no other unit.
    let lags = commanded("pressure_bar", [1.0, 1.0], |p| 3.0 + 0.1 * (p - 3.0));
    read(lags.as_bytes(), "").expect("it is read");
    let saturates = commanded("pressure_bar", [1.0, 1.0], |p| p.min(0.9));
    read(saturates.as_bytes(), "").expect("it is read");
}

#[test]
fn nanometres_and_newton_metres_are_asked_about() {
    let text = named("time_s,pressure_bar,contraction_nm", 1.0, 1e6);
    let words = "--units contraction=nm or --units contraction=newton_metre";
    refuses(&text, words, "--units contraction=nm", [("pressure_bar", 1.0), ("contraction_nm", 1e6)]);
    let recording = read(text.as_bytes(), "--units contraction=newton_metre --output contraction");
    assert_eq!(recording.expect("it is said").output.channel.name, "contraction_newton_metre");
    let text = named("time_s,pressure_bar,contraction_in", 1.0, 1.0 / 25.4);
    let inches = [("pressure_bar", 1.0), ("contraction_in", 1.0 / 25.4)];
    refuses(text, "--units contraction=inch", "--units contraction=inch", inches);
}

#[test]
fn names_that_are_not_ours_are_named_by_options() {
    let text = named("t,p,x", 1.0, 1.0);
    let cure = "--columns time=t:s,pressure=p:bar,contraction=x:mm";
    let message = read(text.as_bytes(), "--columns time=t:s").expect_err("the others have no unit");
    assert!(message.contains("--columns pressure=p:bar"), "{message}");
    refuses(&text, "no column time_s; the file has t, p, x", cure, USUAL);
    reads(
        &text,
        "--time t --input p --output x --units t=s,p=bar,x=mm",
        [("p_bar", 1.0), ("x_mm", 1.0)],
        &[],
    );
    let message = read(text.as_bytes(), "--columns time=t:s,pressure=q:bar").expect_err("no such column");
    assert!(message.contains("no column q; the file has t, p, x"), "{message}");
}

#[test]
fn a_column_that_is_named_counts_before_one_that_has_the_name() {
    let text = file("time_s,pressure_bar,p,contraction_mm", |_, [t, p, x]| format!("{t},9,{p},{x}"));
    reads(text, "--columns pressure=p:bar", USUAL, &[]);
    let text =
        file("time_s,command_bar,pressure_bar,contraction_mm", |_, [t, p, x]| format!("{t},{p},9,{x}"));
    reads(&text, "--columns pressure=command_bar,command=pressure_bar", USUAL, &[]);
    reads(&text, "--columns pressure=command_bar", USUAL, &[]);
    let text = named("t,p,contraction_mm", 1.0, 1.0);
    reads(text, "--columns time=t,pressure=p --units t=s,pressure=bar", USUAL, &[]);
}

#[test]
fn another_pair_is_offered_where_the_usual_one_is_missing() {
    let text = named("time_s,command_v,displacement_um", 1.0, 1.0);
    let pair = [("command_v", 1.0), ("displacement_um", 1.0)];
    refuses(&text, "--input command_v", "--input command_v --output displacement_um", pair);
    let message = read(text.as_bytes(), "--input command_v").expect_err("no output");
    assert!(message.contains("--output displacement_um"), "{message}");
}

#[test]
fn a_pressure_without_a_unit_is_asked_about() {
    refuses(
        named("time_s,pressure,contraction_mm", 1.0, 1.0),
        "column pressure: the name does not end in a known unit; say it by --units pressure=UNIT",
        "--units pressure=bar",
        USUAL,
    );
}

#[test]
fn a_length_becomes_a_contraction_in_any_unit() {
    let text =
        file("time_s,pressure_bar,length_cm", |_, [t, p, x]| format!("{t},{p},{}", (500.0 - x) / 10.0));
    reads(text, "--rest-length 500", USUAL, &["length_cm was converted to mm"]);
}

#[test]
fn rows_without_an_input_are_left_out() {
    let text = file("time_s,pressure_bar,contraction_mm", |row, [t, p, x]| match row {
        100..105 | 200 => format!("{t},NaN,{x}"),
        _ => format!("{t},{p},{x}"),
    });
    let recording = read(text.as_bytes(), "").expect("it is read");
    let source = |place| (0..ROWS).filter(|row| !(100..105).contains(row) && *row != 200).nth(place);
    compare(&recording, USUAL, |place| source(place).expect("a row"));
    said(
        &recording,
        &[
            "6 rows without a value of pressure_bar were left out, the longest stretch 5 rows from line 102 on",
        ],
    );
    assert_eq!(recording.drive.timing.gaps, 2);
}

#[test]
fn rows_without_an_output_are_history_of_the_input() {
    let text = file("time_s,pressure_bar,contraction_mm", |row, [t, p, x]| match row {
        100..110 => format!("{t},{p},"),
        _ => format!("{t},{p},{x}"),
    });
    let recording = read(text.as_bytes(), "").expect("it is read");
    compare(&recording, USUAL, |place| place);
    assert_eq!(recording.drive.scored.iter().filter(|scored| !**scored).count(), 10);
    said(&recording, &["10 rows without a value of contraction_mm are history of the input only"]);
}

#[test]
fn flags_may_be_words() {
    let text = file("time_s,pressure_bar,contraction_mm,valid", |row, [t, p, x]| {
        format!("{t},{p},{x},{}", if row < 20 { "False" } else { "True" })
    });
    let recording = read(text.as_bytes(), "").expect("it is read");
    assert_eq!(recording.drive.scored.iter().filter(|scored| !**scored).count(), 20);
}

#[test]
fn commas_that_may_mean_two_things_are_refused() {
    let text =
        file("time_s;pressure_bar;contraction_mm", |row, [t, _, _]| format!("{t};{},500;2", row % 5 + 1));
    refuses(text.replace('.', ""), "may have a decimal comma or a comma between thousands", "", USUAL);
    let text = file("time_s;pressure_bar;contraction_mm", |_, [t, p, x]| format!("{t};{};{x}", comma(p)));
    refuses(text, "has a comma, other numbers have points", "", USUAL);
    // A version among them is not measured.
    let text = file("time_s;pressure_bar;contraction_mm;version", |_, row| {
        format!("{};1.2", row.map(comma).join(";"))
    });
    reads(text, "", USUAL, &["decimal commas", "not used"]);
}
