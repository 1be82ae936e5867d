//! The demonstration: from a recording of the rig's muscle to the firmware tracking with it, and a
//! report.

use std::fs;

use anyhow::{Context, Result};
use serde_json::Value;

use crate::{host, run};

const RECORDING: &str = "recordings/rig-fig8.csv";
const REFERENCE: &str = "recordings/reference-cosines.csv";

/// The stroke of the paper's muscle, and the figures of its Table 5 (combined controller), in mm.
const PAPER_STROKE_MM: f64 = 123.76;
const PAPER: Run = Run { rmse_mm: 0.8975, mae_mm: 0.7153, max_error_mm: 2.738 };

/// Tracking figures of one run.
struct Run {
    rmse_mm: f64,
    mae_mm: f64,
    max_error_mm: f64,
}

/// Identifies, tracks, reports, and prints the figures beside the paper's.
///
/// # Errors
/// When a command fails or its figures cannot be read.
pub fn demo() -> Result<()> {
    host::build()?;
    let directory = run::target_dir().join("demo");
    fs::create_dir_all(&directory).with_context(|| format!("cannot create {}", directory.display()))?;
    let file = |name: &str| directory.join(name).to_string_lossy().into_owned();
    let mgpi = |arguments: &[&str]| run::succeed(host::mgpi().args(arguments).arg("--force"));
    let (model, log, report) = (file("model.toml"), file("log.csv"), file("report.html"));
    let (identify_json, pil_json) = (file("identify.json"), file("pil.json"));

    run::step("identify", || {
        mgpi(&[
            "identify",
            RECORDING,
            "-o",
            &model,
            "--report",
            &file("identify.html"),
            "--json",
            &identify_json,
        ])
    })?;
    run::step("firmware in the loop", || {
        let plant = ["pil", "--model", &model, "--reference", REFERENCE, "--plant", "rig"];
        mgpi(&[&plant[..], &["-o", &log, "--json", &pil_json]].concat())
    })?;
    run::step("report", || {
        mgpi(&["report", "--model", &model, "--recording", RECORDING, "--log", &log, "-o", &report])
    })?;

    print_figures(&read_json(&identify_json)?, &read_json(&pil_json)?)?;
    println!("\nreport: {report}");
    Ok(())
}

fn read_json(file: &str) -> Result<Value> {
    let text = fs::read_to_string(file).with_context(|| format!("cannot read {file}"))?;
    serde_json::from_str(&text).with_context(|| format!("{file} is no JSON"))
}

fn print_figures(identified: &Value, tracked: &Value) -> Result<()> {
    let stroke_mm = figure(identified, "stroke_mm")?;
    println!("\ntracking error         RMSE mm   MAE mm   max mm   RMSE, % of stroke");
    for (title, key) in
        [("both", "tracking"), ("feed-forward only", "feedforward_only"), ("feedback only", "feedback_only")]
    {
        print_row(title, &Run::of(&tracked[key]).with_context(|| format!("in {key}"))?, stroke_mm);
    }
    print_row("paper, Table 5", &PAPER, PAPER_STROKE_MM);
    Ok(())
}

fn print_row(title: &str, run: &Run, stroke_mm: f64) {
    let percent = 100.0 * run.rmse_mm / stroke_mm;
    println!(
        "{title:<20} {:>9.4} {:>8.4} {:>8.3} {percent:>19.3}",
        run.rmse_mm, run.mae_mm, run.max_error_mm
    );
}

impl Run {
    fn of(json: &Value) -> Result<Self> {
        Ok(Self {
            rmse_mm: figure(json, "rmse_mm")?,
            mae_mm: figure(json, "mae_mm")?,
            max_error_mm: figure(json, "max_error_mm")?,
        })
    }
}

fn figure(json: &Value, key: &str) -> Result<f64> {
    json[key].as_f64().with_context(|| format!("the results lack the number {key}"))
}
