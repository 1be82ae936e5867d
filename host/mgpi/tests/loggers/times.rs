//! Clocks: units, dates, coarse and repeated stamps, clocks that go back.

use super::bench::*;

/// A file whose times are written so.
fn timed(name: &str, time: impl Fn(f64) -> String) -> String {
    file(&format!("{name},pressure_bar,contraction_mm"), |_, [t, p, x]| format!("{},{p},{x}", time(t)))
}

/// A time of day, from noon on.
fn of_day(t: f64) -> String {
    format!("12:{:02}:{:06.3}", (t / 60.0) as usize, t % 60.0)
}

#[test]
fn iso_times_are_read() {
    for name in ["time", "timestamp", "Date_Time"] {
        reads_usual(timed(name, |t| format!("2024-05-01T{}", of_day(t))), &["times of a clock"]);
    }
    reads_usual(timed("time", |t| format!("2024-05-01T{}Z", of_day(t))), &["times of a clock"]);
    reads_usual(timed("time", |t| format!("2024-05-01 {}+02:00", of_day(t))), &["times of a clock"]);
}

#[test]
fn dates_of_other_kinds_are_read() {
    reads_usual(timed("Time", of_day), &["times of a clock"]);
    reads_usual(timed("Time", |t| format!("05/01/2024 {}", of_day(t))), &["times of a clock"]);
    let text = file("Timestamp;pressure_bar;contraction_mm", |_, [t, p, x]| {
        format!("01.05.2024 {};{};{}", of_day(t).replace('.', ","), comma(p), comma(x))
    });
    reads_usual(text, &["decimal commas", "times of a clock"]);
}

#[test]
fn a_number_among_times_of_a_clock_is_refused() {
    let text = timed("Time", |t| if t == 5.0 { "5".to_owned() } else { of_day(t) });
    refuses(text, "line 102, column Time: `5` is not a number", "", USUAL);
}

#[test]
fn a_date_that_is_not_known_is_refused_with_one_that_is() {
    let text = timed("time", |t| format!("5/1/2024 {} PM", of_day(t)));
    refuses(text, "is not a known time; write 2024-05-01T13:02:03.25", "", USUAL);
}

#[test]
fn milliseconds_and_microseconds_are_read() {
    reads_usual(timed("time_ms", |t| format!("{}", (1e3 * t).round())), &["time in ms"]);
    reads_usual(timed("time_us", |t| format!("{}", (1e6 * t).round())), &["time in µs"]);
    reads_usual(timed("Time [ms]", |t| format!("{}", (1e3 * t).round())), &["time in ms"]);
    reads_usual(timed("t_ms", |t| format!("{}", (1e3 * t).round())), &["time in ms"]);
}

#[test]
fn times_since_1970_are_read() {
    reads_usual(timed("time_s", |t| format!("{:.3}", 1_714_550_400.0 + t)), &["since 1970"]);
    reads_usual(timed("timestamp", |t| format!("{:.3}", 1_714_550_400.0 + t)), &["s since 1970"]);
    reads_usual(
        timed("time", |t| format!("{}", 1_714_550_400_000.0 + (1e3 * t).round())),
        &["ms since 1970"],
    );
    let text =
        timed("timestamp", |t| format!("{}", 1_714_550_400_000_000_000_i64 + (1e9 * t).round() as i64));
    reads_usual(text, &["ns since 1970"]);
}

#[test]
fn milliseconds_under_the_name_of_seconds_are_asked_about() {
    let text = timed("time_s", |t| format!("{}", (1e3 * t).round()));
    refuses(&text, "--units time=ms if so, --units time=s if they are right", "--units time=ms", USUAL);
    let confirmed = read(text.as_bytes(), "--units time=s").expect("it is confirmed");
    assert_eq!(confirmed.drive.timing.median_step_s, 50.0);
}

#[test]
fn a_time_without_a_unit_is_asked_about() {
    refuses(timed("time", |t| t.to_string()), "--units time=s or --units time=ms", "--units time=s", USUAL);
    refuses(timed("tick_ms", |t| (1e3 * t).to_string()), "--time tick_ms", "--time tick_ms", USUAL);
    refuses(timed("when", |t| t.to_string()), "no column time_s", "--columns time=when:s", USUAL);
}

#[test]
fn coarse_stamps_at_a_steady_rate_give_the_right_times() {
    let text = timed("time_s", |t| format!("{}", (10.0 * t + 1e-9).floor() / 10.0));
    reads_usual(text, &["300 rows share 150 time stamps at a steady rate"]);
    let text = timed("time_s", |t| format!("{}", (2.0 * t + 1e-9).floor() / 2.0));
    reads_usual(text, &["300 rows share 30 time stamps at a steady rate"]);
}

#[test]
fn rows_of_a_logger_that_stutters_are_averaged() {
    let text = file("time_s,pressure_bar,contraction_mm", |row, [t, p, x]| match row {
        50 | 51 | 90 => format!("{t},{},{x}\n{t},{},{x}", p - 0.5, p + 0.5),
        _ => format!("{t},{p},{x}"),
    });
    reads_usual(text, &["3 rows with a repeated time were averaged"]);
}

#[test]
fn a_clock_that_goes_back_is_refused() {
    let text = timed("time_s", |t| format!("{}", if t < 10.0 { t } else { t - 10.0 }));
    refuses(text, "line 202, column time_s: time goes back: 0 s follows 9.95 s", "", USUAL);
}

#[test]
fn rows_without_a_time_are_left_out() {
    let recording =
        read(timed("time_s", |t| if t == 5.0 { "NaN".to_owned() } else { t.to_string() }).as_bytes(), "");
    let recording = recording.expect("it is read");
    compare(&recording, USUAL, |place| if place < 100 { place } else { place + 1 });
    said(&recording, &["1 rows without a value of time_s were left out"]);
}
