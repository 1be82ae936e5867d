//! Encodings, separators, headers, lines that are no rows, and columns that nobody needs.

use super::bench::*;

fn utf_16(text: &str, bytes: impl Fn(u16) -> [u8; 2]) -> Vec<u8> {
    std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(bytes).collect()
}

#[test]
fn our_own_file_needs_no_note() {
    reads_usual(usual(), &[]);
}

#[test]
fn an_index_of_pandas_is_not_used() {
    let text = file(",time_s,pressure_bar,contraction_mm", |row, [t, p, x]| format!("{row},{t},{p},{x}"));
    reads_usual(text, &["not used, without a unit: (a column without a name)"]);
}

#[test]
fn quoted_row_names_of_r_are_not_used() {
    let text = file("\"\",\"time_s\",\"pressure_bar\",\"contraction_mm\"", |row, [t, p, x]| {
        format!("\"{row}\",{t},{p},{x}")
    });
    reads_usual(text, &["not used"]);
}

#[test]
fn columns_without_a_unit_and_texts_are_not_used() {
    let text = file("time_s,pressure_bar,contraction_mm,cycle,State", |row, [t, p, x]| {
        format!("{t},{p},{x},{},{}", row / 80, if row < 9 { "idle" } else { "run" })
    });
    reads_usual(text, &["not used, without a unit: cycle, State"]);
}

#[test]
fn holes_and_words_in_a_column_that_is_not_used_harm_nobody() {
    for hole in ["", "NaN", "n/a", "broken", "inf"] {
        let text = file("time_s,pressure_bar,temperature_c,contraction_mm", |row, [t, p, x]| {
            format!("{t},{p},{},{x}", if row % 7 == 0 { "21.5" } else { hole })
        });
        reads_usual(text, &[]);
    }
}

#[test]
fn semicolons_and_decimal_commas_are_read() {
    let text = file("time_s;pressure_bar;contraction_mm", |_, row| row.map(comma).join(";"));
    reads_usual(text, &["decimal commas"]);
}

#[test]
fn tabs_are_read_with_points_and_with_commas() {
    let header = "time_s\tpressure_bar\tcontraction_mm";
    reads_usual(file(header, |_, row| row.map(|value| value.to_string()).join("\t")), &[]);
    reads_usual(file(header, |_, row| row.map(comma).join("\t")), &["decimal commas"]);
}

#[test]
fn columns_of_blanks_are_read() {
    let text = file("  time_s   pressure_bar  contraction_mm", |_, [t, p, x]| {
        format!("{t:>8.3} {p:>12.4} {x:>14.4}")
    });
    reads_usual(text, &["separated by blanks"]);
}

#[test]
fn bars_are_read() {
    let text = file("time_s | pressure_bar | contraction_mm", |_, [t, p, x]| format!("{t} | {p} | {x}"));
    reads_usual(text, &[]);
}

#[test]
fn ends_of_lines_of_windows_and_of_old_macs_are_read() {
    reads_usual(usual().replace('\n', "\r\n"), &[]);
    reads_usual(usual().replace('\n', "\r"), &[]);
}

#[test]
fn a_byte_order_mark_is_no_part_of_a_name() {
    reads_usual(format!("\u{feff}{}", usual()), &[]);
}

#[test]
fn utf_16_is_read_in_both_orders() {
    reads_usual(utf_16(&usual(), u16::to_le_bytes), &["UTF-16"]);
    reads_usual(utf_16(&usual(), u16::to_be_bytes), &["UTF-16"]);
}

#[test]
fn windows_1252_is_read() {
    let text =
        file("time_s,pressure_bar,contraction_mm,Temp [°C]", |_, [t, p, x]| format!("{t},{p},{x},21"));
    let bytes: Vec<u8> = text.chars().map(|letter| letter as u8).collect();
    reads_usual(bytes, &["Windows-1252"]);
}

#[test]
fn every_field_may_be_quoted() {
    let text = file("\"time_s\",\"pressure_bar\",\"contraction_mm\"", |_, [t, p, x]| {
        format!("\"{t}\",\"{p}\",\"{x}\"")
    });
    reads_usual(text, &[]);
}

#[test]
fn a_separator_at_the_end_of_rows_is_no_column() {
    reads_usual(file("time_s,pressure_bar,contraction_mm", |_, [t, p, x]| format!("{t},{p},{x},")), &[]);
}

#[test]
fn lines_above_the_header_are_skipped() {
    let above = "Logger;LX-200\nSerial;00123\nStarted;2024-05-01 12:00:00\n\n";
    let text = file("time_s;pressure_bar;contraction_mm", |_, [t, p, x]| format!("{t};{p};{x}"));
    reads_usual(format!("{above}{text}"), &["3 lines above the header"]);
    reads_usual(format!("sep=;\n{text}"), &["1 lines above the header"]);
}

#[test]
fn a_labview_file_is_read_once_its_channels_are_named() {
    let head = "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\nMulti_Headings\tYes\n\
                X_Columns\tOne\nTime_Pref\tRelative\nDate\t2024/05/01\nTime\t12:00:00.1\n***End_of_Header***\t\n\t\n\
                Channels\t2\t\t\nSamples\t300\t300\t\nDate\t2024/05/01\t2024/05/01\t\nX_Dimension\tTime\tTime\t\n\
                X0\t0.0\t0.0\t\nDelta_X\t0.05\t0.05\t\n***End_of_Header***\t\t\t\n";
    let rows = file("X_Value\tUntitled\tUntitled 1\tComment", |_, [t, p, x]| format!("{t}\t{p}\t{x}"));
    let text = format!("{head}{rows}");
    let message = read(text.as_bytes(), "").expect_err("the channels have no names");
    assert!(message.contains("--columns pressure=Untitled:bar"), "{message}");
    let recording = read(text.as_bytes(), "--columns pressure=Untitled:bar,contraction=untitled_1:mm");
    let recording = recording.expect("it is read");
    compare(&recording, USUAL, |place| place);
    said(
        &recording,
        &["LabVIEW header", "X_Value was read as a time in s", "not used, without a unit: Comment"],
    );
}

#[test]
fn comments_of_matlab_and_in_rows_are_no_data() {
    let text = format!("% made by MATLAB\n{}", usual());
    reads_usual(text, &[]);
    let text = file("time_s,pressure_bar,contraction_mm", |row, [t, p, x]| {
        format!("{t},{p},{x}{}", if row == 17 { " # touched" } else { "" })
    });
    reads_usual(text, &[]);
}

#[test]
fn a_header_in_a_comment_as_of_numpy_is_read() {
    let text =
        file("# time_s pressure_bar contraction_mm", |_, [t, p, x]| format!("{t:.18e} {p:.18e} {x:.18e}"));
    reads_usual(text, &["comment above the first row"]);
}

#[test]
fn a_header_that_comes_again_is_skipped() {
    let text = usual();
    let lines: Vec<&str> = text.lines().collect();
    let text = lines.iter().enumerate().map(|(at, line)| match at {
        100 | 200 => format!("{}\n{line}\n", lines[0]),
        _ => format!("{line}\n"),
    });
    reads_usual(text.collect::<String>(), &["the header came again 2 times"]);
}

#[test]
fn what_is_cut_off_or_said_at_the_end_is_left_out() {
    reads_usual(usual() + "15.0,2.2", &["1 incomplete lines at the end, from line 302 on"]);
    reads_usual(usual() + "end of file\n300 samples\n", &["2 incomplete lines at the end"]);
}

#[test]
fn a_row_that_is_cut_off_in_the_middle_is_refused() {
    let text = usual().replacen("\n0.5,", "\n0.5\n0.5,", 1);
    refuses(text, "fields where the header has 3", "", USUAL);
}

#[test]
fn a_file_without_a_header_says_so() {
    let text = usual();
    let (_, rows) = text.split_once('\n').expect("lines");
    refuses(rows, "line 1: the file has no header: its first line is `0,0,-1.25`", "", USUAL);
}

#[test]
fn commas_between_fields_and_in_numbers_are_refused() {
    let text =
        file("time_s,pressure_bar,contraction_mm", |_, row| row.map(|value| comma(value + 0.001)).join(","));
    refuses(text, "decimal commas split the numbers; export", "", USUAL);
}

#[test]
fn what_is_no_table_is_refused() {
    let text = file("{\"logger\": 1}", |_, [t, p, _]| format!("{{\"t\": {t}, \"p\": {p}}}"));
    let message = read(text.as_bytes(), "").expect_err("it is JSON");
    assert!(message.contains("no column time_s"), "{message}");
}
