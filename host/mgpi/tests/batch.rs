//! An archive of recordings: one bad file hurts nobody, and a run that was ended goes on.

mod common;

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::Bench;

/// A folder of three recordings, one of them in a folder of its own, and a file that is none.
fn archive() -> Bench {
    let bench = Bench::new();
    std::fs::create_dir_all(bench.path("archive/march")).expect("writable");
    for (name, seed) in [("archive/one.csv", 1), ("archive/two.csv", 2), ("archive/march/three.csv", 3)] {
        bench.succeeds(&format!("rig record --protocol ramps --seed {seed} --rate-hz 10 -o {name}"));
        // Half a minute of it is diagnosed in no time.
        let text = bench.read(name);
        let lines: Vec<&str> = text.lines().take(400).collect();
        bench.write(name, lines.join("\n") + "\n");
    }
    bench.write("archive/broken.csv", "time_s,pressure_bar,contraction_mm\n0,0,0\n0.1,touched,1\n");
    bench.write("archive/notes.md", "no recording\n");
    bench
}

fn lines(text: &str) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    reader.records().map(|line| line.expect("a line").iter().map(str::to_owned).collect()).collect()
}

#[test]
fn every_recording_has_a_line_and_what_is_wrong_with_one_stands_in_its_own() {
    let bench = archive();
    let said = bench.succeeds("batch archive -o results.csv");
    assert!(said.contains("4 recordings in results.csv: 1 refused, 0 kept"), "{said}");
    let lines = lines(&bench.read("results.csv"));
    let files: Vec<&str> = lines.iter().map(|line| line[0].as_str()).collect();
    assert_eq!(
        files,
        ["archive/broken.csv", "archive/march/three.csv", "archive/one.csv", "archive/two.csv"]
    );
    assert!(lines[0][2].contains("line 3, column pressure_bar"), "{:?}", lines[0]);
    assert!(lines[1..].iter().all(|line| line[2].is_empty() && !line[8].is_empty()), "{lines:?}");
    assert_eq!(bench.files(), ["archive", "results.csv"]);
    assert!(bench.refuses("batch archive -o results.csv").contains("exists already"));
    std::fs::create_dir(bench.path("empty")).expect("writable");
    assert!(bench.refuses("batch empty -o other.csv").contains("no file in it ends in csv, tsv, txt"));
}

#[test]
fn the_page_follows_every_muscle_from_day_to_day() {
    let bench = archive();
    for (name, to) in [("one", "2026-01-10"), ("two", "2026-05-20")] {
        std::fs::rename(
            bench.path(&format!("archive/{name}.csv")),
            bench.path(&format!("archive/march/m_{to}.csv")),
        )
        .expect("renamed");
    }
    bench.succeeds("batch archive -o results.csv --report page.html");
    let page = bench.read("page.html");
    for wanted in [
        "4 recordings of 2 muscles, 1 of them refused",
        "<h2>march</h2>",
        "Stroke of march",
        "march/m_2026-05-20.csv",
        "line 3, column pressure_bar",
    ] {
        assert!(page.contains(wanted), "{wanted}");
    }
    assert!(!page.contains("http-equiv") && !page.contains("src=\"http"), "it needs nothing from outside");
    assert!(bench.refuses("batch archive -o other.csv --report page.html").contains("exists already"));
}

#[test]
fn a_run_that_was_killed_goes_on_and_comes_to_the_same() {
    let bench = archive();
    bench.succeeds("batch archive -o whole.csv");
    let mut child = Command::new(env!("CARGO_BIN_EXE_mgpi"))
        .args(["batch", "archive", "-o", "results.csv"])
        .current_dir(bench.path("."))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("mgpi runs");
    let begin = Instant::now();
    let count =
        || std::fs::read_to_string(bench.path("results.csv.part")).unwrap_or_default().lines().count();
    // What made it, the header and the refused file come at once, a first diagnosis later.
    while count() < 4 && begin.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().expect("it runs");
    child.wait().expect("it ends");
    assert!(!bench.path("results.csv").exists(), "it had ended before it was killed");
    // As it would be cut in the middle of a line; and something that shows whether a line is kept.
    let kept = bench.read("results.csv.part").replace("pressure_bar", "kept_bar") + "archive/two.csv,abc";
    bench.write("results.csv.part", &kept);
    bench.write("other.csv.part", &kept);
    let said = bench.succeeds("batch archive -o results.csv");
    assert!(said.contains("1 kept") || said.contains("2 kept"), "{said}");
    let results = bench.read("results.csv");
    assert!(results.contains("kept_bar"), "a file was done again: {results}");
    assert_eq!(results.replace("kept_bar", "pressure_bar"), bench.read("whole.csv"));
    assert!(!bench.path("results.csv.part").exists());
    // With other options a file may have another answer.
    let said = bench.succeeds("batch archive --input pressure_bar -o other.csv");
    assert!(said.contains("0 kept"), "{said}");
}
