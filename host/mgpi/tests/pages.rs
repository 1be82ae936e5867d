//! Reports: what they say, and every one in a real browser, wide and narrow: no error, nothing cut,
//! nothing over another, no letter too small.
//!
//! The browser's part is skipped, in so many words, without Chromium. The page stands in a frame of
//! the wanted width, since a browser's own window has a least one; `pages.js` looks at it, and
//! writes what it finds into the document that the browser prints.

mod common;

use std::process::Command;
use std::sync::LazyLock;

use board_client::pil::lock_step::{Measurement, Run, Sample};
use board_client::pil::results;
use common::{Bench, recording};
use model_core::Surroundings;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use report::tracked::{self, Stroke};

/// The browsers that will do.
const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];
/// A desk and a phone. Unit: pixels.
const WIDTHS: [u32; 2] = [1200, 390];
/// The name of a recording that is longer than a line on a phone.
const LONG: &str = "transport_delay+viscous_lag_of_a_muscle_on_the_bench-35.csv";

#[test]
fn every_report_is_whole_on_a_desk_and_on_a_phone() {
    let Some(browser) =
        BROWSERS.into_iter().find(|name| Command::new(name).arg("--version").output().is_ok())
    else {
        println!("the reports are not looked at in a browser: there is none of {}", BROWSERS.join(", "));
        return;
    };
    let bench = Bench::new();
    recording(&bench, "rec.csv");
    late(&bench, "rec.csv", LONG);
    bench.write("valve.html", &*SLOW_VALVE);
    assert_whole(&bench, browser, "valve.html");
    bench.write("log.csv", results::log(&run()));
    for (report, command) in [
        ("identified.html", "identify rec.csv -o model.toml --starts 2 --report"),
        ("compared.html", "compare rec.csv -o c.csv --models sgpi,mgpi --sizes 3/3 --starts 2 --report"),
        ("adequate.html", "diagnose rec.csv --report"),
        ("diagnosed.html", &format!("diagnose {LONG} --report")),
        ("figures.html", "report --model paper.toml --recording rec.csv --log log.csv -o"),
    ] {
        bench.succeeds(&format!("{command} {report}"));
        assert_whole(&bench, browser, report);
    }
    let (run, stroke) = (run(), Stroke { mm: 120.0, whose: "the model's stroke" });
    let runs = [("tracking", &run), ("feedforward_only", &run), ("feedback_only", &run)];
    bench.write("tracked.html", tracked::to_html(&runs, stroke, "A made-up run"));
    assert_whole(&bench, browser, "tracked.html");
}

/// The diagnosis of a muscle whose valve has a lag of 0.4 s, with command and pressure recorded.
static SLOW_VALVE: LazyLock<String> = LazyLock::new(|| {
    let bench = Bench::new();
    recording(&bench, "rec.csv");
    slow_valve(&bench, "rec.csv", "valve.csv");
    bench.succeeds("diagnose valve.csv --report valve.html");
    bench.read("valve.html")
});

/// What stands between two marks, wherever they are.
fn between<'a>(page: &'a str, from: &str, to: &str) -> Vec<&'a str> {
    page.split(from).skip(1).map(|rest| rest.split(to).next().unwrap_or_default()).collect()
}

/// Text without tags.
fn text(html: &str) -> String {
    html.split('<').map(|part| part.rsplit('>').next().unwrap_or_default()).collect()
}

#[test]
fn a_cause_of_the_valve_is_drawn_with_command_and_pressure() {
    let page = &*SLOW_VALVE;
    for line in ["measured pressure", "command", "simulated from the command"] {
        assert!(page.contains(&format!("data-name=\"{line}\"")), "{line} is not drawn");
    }
    for model in ["operator model alone", "operator model with valve_lag"] {
        assert!(page.contains(&format!("data-name=\"{model}\"")), "{model} is not drawn");
        assert!(page.contains(&format!("<span class=\"name\">{model}</span>")), "{model} has no bar");
    }
}

#[test]
fn what_is_bold_is_named_by_the_verdict() {
    let page = &*SLOW_VALVE;
    assert!(page.contains("is explained by valve_lag."));
    assert_eq!(between(page, "<dt class=\"best\">", "</dt>"), ["valve_lag"]);
    let bold = between(page, "<li class=\"best\"><span class=\"name\">", "<");
    assert_eq!(bold, ["valve as found", "operator model with valve_lag"]);
}

#[test]
fn no_share_is_above_100_percent() {
    let page = text(&SLOW_VALVE);
    let shares =
        page.match_indices(" %").filter_map(|(at, _)| page[..at].rsplit([' ', '(']).next()?.parse().ok());
    let shares: Vec<f64> = shares.collect();
    assert!(!shares.is_empty() && shares.iter().all(|share| (0.0..=100.0).contains(share)), "{shares:?}");
}

#[test]
fn every_column_of_a_table_has_its_unit() {
    let bench = Bench::new();
    recording(&bench, "rec.csv");
    bench.succeeds("identify rec.csv -o model.toml --starts 2 --report identified.html");
    bench.succeeds("compare rec.csv --models cpi,mgpi --sizes 3/3 --starts 2 --report compared.html");
    for page in [&*SLOW_VALVE, &bench.read("identified.html"), &bench.read("compared.html")] {
        for heading in between(page, "<th>", "</th>") {
            // Names and counts have none; of parameters each row has its own.
            let has_none = ["model", "n", "m", "parameters", "rows"].contains(&heading);
            let is_of_the_row = ["value", "standard error", "95 % interval"].contains(&heading)
                && page.contains("<th>parameter (unit)</th>");
            assert!(has_none || is_of_the_row || heading.contains('('), "{heading}");
        }
    }
}

#[test]
fn a_bar_is_the_error_of_the_curve_that_is_drawn() {
    let page = &*SLOW_VALVE;
    let name = "operator model alone";
    let figure = between(page, "<figcaption>Error: before and after", "</figure>")[0];
    let ends: Vec<f64> =
        between(figure, "data-y=\"", "\"")[0].split(' ').map(|end| end.parse().expect("a number")).collect();
    let height: f64 = between(figure, "class=\"lines\"", ">")[0]
        .split("height=\"")
        .nth(1)
        .and_then(|rest| rest.split('"').next())
        .and_then(|height| height.parse().ok())
        .expect("a height");
    let line = between(figure, &format!("data-name=\"{name}\""), "</g>")[0];
    let places: Vec<(f64, f64)> = between(line, "points=\"", "\"")
        .iter()
        .flat_map(|points| points.split(' '))
        .filter_map(|place| place.split_once(','))
        .map(|(x, y)| (x.parse().expect("a number"), y.parse::<f64>().expect("a number")))
        .map(|(x, y)| (x, ends[1] - y / height * (ends[1] - ends[0])))
        .collect();
    let (mut square, mut width) = (0.0, 0.0);
    for pair in places.windows(2) {
        let [(from, one), (to, other)] = [pair[0], pair[1]];
        square += (to - from) * (one * one + one * other + other * other) / 3.0;
        width += to - from;
    }
    let drawn = (square / width).sqrt();
    let bar: f64 = between(page, &format!("<span class=\"name\">{name}</span>"), "</li>")
        .iter()
        .find_map(|row| between(row, "<span>", "</span>")[0].parse().ok())
        .expect("a bar");
    assert!((drawn / bar - 1.0).abs() < 0.05, "the curve's error is {drawn} mm, the bar says {bar} mm");
}

#[test]
fn the_held_out_rows_are_drawn_and_the_page_says_what_the_model_is_worth() {
    let bench = Bench::new();
    recording(&bench, "rec.csv");
    for option in ["", "--validate rec.csv"] {
        bench.succeeds(&format!("identify rec.csv -o m.toml --starts 2 --report r.html --force {option}"));
        let page = bench.read("r.html");
        for title in ["Held out: loops", "Held out: error over time", "Held out: output over time"] {
            assert!(page.contains(title), "{title} with {option}");
        }
        assert!(page.contains("The model is good"), "{option}");
    }
}

#[test]
fn a_page_of_a_tracking_run_draws_what_drove_the_valve() {
    let run = run();
    let stroke = Stroke { mm: 120.0, whose: "the reference's range" };
    let page = tracked::to_html(&[("tracking", &run)], stroke, "A made-up run");
    let lines = [
        "measured pressure",
        "command",
        "feed-forward",
        "feedback",
        "desired",
        "actual",
        "desired less actual",
    ];
    for line in lines {
        assert!(page.contains(&format!("data-name=\"{line}\"")), "{line}");
    }
    assert_eq!(page.matches("data-clock=\"reference\"").count(), 4, "plots over one time axis");
}

/// Looks at a report at every width.
fn assert_whole(bench: &Bench, browser: &str, report: &str) {
    for width in WIDTHS {
        let faults = faults(bench, browser, report, width);
        assert!(faults.is_empty(), "{report} at {width} pixels: {faults}");
    }
}

/// A run of a muscle that stays half a millimetre behind.
fn run() -> Run {
    let sample = |tick: u32| {
        let time_s = f64::from(tick) / 1000.0;
        let reference_mm = 60.0 * (1.0 - (6.3 * time_s).cos());
        let measured = Measurement {
            pressure_bar: reference_mm / 40.0,
            contraction_mm: reference_mm - 0.5,
            surroundings: Surroundings::default(),
        };
        Sample { time_s, reference_mm, measured, command_bar: 2.0, feedforward_bar: 2.0, feedback_bar: 0.0 }
    };
    Run { samples: (0..1000).map(sample).collect(), overruns: 0 }
}

/// The recording, of a muscle that is late by 0.3 s.
fn late(bench: &Bench, from: &str, to: &str) {
    let text = bench.read(from);
    let rows: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let mut late = "time_s,pressure_bar,contraction_mm\n".to_owned();
    for (row, fields) in rows.iter().enumerate() {
        late += &format!("{},{},{}\n", fields[0], fields[1], rows[row.saturating_sub(6)][2]);
    }
    bench.write(to, late);
}

/// The recording, of a muscle whose valve follows its command with a lag of 0.4 s; sensors have
/// noise of up to 0.003 bar and 0.05 mm.
fn slow_valve(bench: &Bench, from: &str, to: &str) {
    let drive = bench.read(from);
    let rows: Vec<(f64, f64)> = drive
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|field| field.parse().expect("a number")).collect::<Vec<f64>>())
        .map(|fields| (fields[0], fields[1]))
        .collect();
    let (mut pressure, mut pressures) = (0.0, "time_s,pressure_bar\n".to_owned());
    for (time_s, command) in &rows {
        pressure += (command - pressure) * (1.0 - (-0.05_f64 / 0.4).exp());
        pressures += &format!("{time_s},{pressure}\n");
    }
    bench.write("drive.csv", pressures);
    bench.succeeds("simulate paper.toml --input drive.csv -o simulated.csv");
    let simulated = bench.read("simulated.csv");
    let mut noise = ChaCha8Rng::seed_from_u64(1);
    let mut both = "command_bar,time_s,pressure_bar,contraction_mm\n".to_owned();
    for ((_, command), row) in rows.iter().zip(simulated.lines().skip(1)) {
        let fields: Vec<f64> = row.split(',').map(|field| field.parse().expect("a number")).collect();
        let pressure = fields[1] + noise.random_range(-0.003..0.003);
        let contraction = fields[2] + noise.random_range(-0.05..0.05);
        both += &format!("{command},{},{pressure},{contraction}\n", fields[0]);
    }
    bench.write(to, both);
}

/// What is wrong with a page at a width; empty if nothing is.
fn faults(bench: &Bench, browser: &str, report: &str, width: u32) -> String {
    let page = bench.read(report);
    // What goes wrong is noted from the first line on.
    let noting = "<head><script>failures = []; onerror = failure => { failures.push(String(failure)) }; \
                  console.error = (...all) => { failures.push(all.join(\" \")) }</script>";
    let page = page.replacen("<head>", noting, 1);
    let quoted = page.replace('&', "&amp;").replace('"', "&quot;");
    let look = include_str!("common/pages.js");
    bench.write(
        "frame.html",
        format!(
            "<!DOCTYPE html><meta charset=\"utf-8\"><pre id=\"faults\">not looked at</pre>\
             <iframe width=\"{width}\" height=\"900\" style=\"border:0\" srcdoc=\"{quoted}\"></iframe>\
             <script>{look}</script>"
        ),
    );
    let profile = bench.path(&format!("profile-{width}"));
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--window-size=1400,1000"])
        .arg(format!("--user-data-dir={}", profile.display()))
        .args(["--virtual-time-budget=5000", "--dump-dom"])
        .arg(format!("file://{}", bench.path("frame.html").display()))
        .output()
        .expect("the browser runs");
    let document = String::from_utf8_lossy(&output.stdout);
    let (_, rest) = document.split_once("<pre id=\"faults\">").expect("the document");
    rest.split_once("</pre>").expect("its end").0.to_owned()
}
