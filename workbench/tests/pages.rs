//! Every report in a real browser, wide and narrow: no error, nothing cut, nothing over another, no letter too small.
//!
//! Skipped, in so many words, without Chromium. The page stands in a frame of the wanted width, since a browser's own
//! window has a least one; `pages.js` looks at it, and writes what it finds into the document that the browser prints.

mod common;

use std::process::Command;

use common::{Bench, recording};
use model_core::Surroundings;
use workbench::pil::lock_step::{Measurement, Run, Sample};
use workbench::pil::results;
use workbench::report::tracked;

/// The browsers that will do.
const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];
/// A desk and a phone. Unit: pixels.
const WIDTHS: [u32; 2] = [1200, 390];

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
    late(&bench, "rec.csv", "late.csv");
    bench.write("log.csv", results::log(&run()));
    for (report, command) in [
        ("identified.html", "identify rec.csv -o model.toml --starts 2 --report"),
        ("compared.html", "compare rec.csv -o c.csv --models sgpi,mgpi --sizes 3/3 --starts 2 --report"),
        ("adequate.html", "diagnose rec.csv --report"),
        ("diagnosed.html", "diagnose late.csv --report"),
        ("figures.html", "report --model paper.toml --recording rec.csv --log log.csv -o"),
    ] {
        bench.succeeds(&format!("{command} {report}"));
        assert_whole(&bench, browser, report);
    }
    let run = run();
    let runs = [("tracking", &run), ("feedforward_only", &run), ("feedback_only", &run)];
    bench.write("tracked.html", tracked::to_html(&runs, 120.0, "A made-up run"));
    assert_whole(&bench, browser, "tracked.html");
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
