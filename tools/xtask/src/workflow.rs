//! The way of a muscle from nothing to tracking, on the emulated board and over its bus: capture,
//! identify, diagnose, deploy, track. It fails unless the identified model tracks better than a
//! poor one before it.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::{host, run};

/// Length of the captured excitation. Unit: s.
const CAPTURE_S: &str = "45";
/// Every Nth tick is recorded: 100 rows a second are plenty for identification.
const EVERY: &str = "10";
/// The poor model: plays and a gain, no more than two of them.
const POOR: [&str; 4] = ["--model", "cpi", "--plays", "2"];
/// Longest time for the board's answer: a machine that does much else keeps its emulator waiting. A
/// question whose answer is lost is asked again twice before the board takes its host for silent,
/// after 0.5 s. Unit: s.
const PATIENCE_S: &str = "0.2";
/// How long the whole should take, on a machine with nothing else to do. Unit: s.
const GOAL_S: f64 = 180.0;

/// Captures, identifies, diagnoses, deploys, tracks, and compares.
///
/// # Errors
/// A command fails, or the error does not fall.
pub fn workflow() -> Result<()> {
    host::build()?;
    let begin = Instant::now();
    let directory = run::target_dir().join("workflow");
    // What an earlier one has left would be in the way.
    let _ = fs::remove_dir_all(&directory);
    fs::create_dir_all(&directory).with_context(|| format!("cannot create {}", directory.display()))?;
    let file = |name: &str| directory.join(name).to_string_lossy().into_owned();
    let (port, recording, reference) = (file("board"), file("recording.csv"), file("reference.csv"));
    let mgpi = |arguments: &[&str]| run::succeed(host::mgpi().args(arguments));
    let bus = ["--port", &*port, "--timeout-s", PATIENCE_S];
    let board = |arguments: &[&str]| mgpi(&[arguments, &bus].concat());
    let _emulated = Emulated::start(port.as_ref())?;

    run::step("capture", || {
        board(&["capture", "--duration-s", CAPTURE_S, "--every", EVERY, "-o", &recording])
    })?;
    let track = |model: &str, name: &str| -> Result<f64> {
        // A model that is as poor as the first one is deployed by force only.
        board(&["deploy", model, "--force"])?;
        let (log, json) = (file(&format!("{name}.csv")), file(&format!("{name}.json")));
        board(&["track", "--reference", &reference, "-o", &log, "--json", &json])?;
        rmse_mm(&json)
    };
    mgpi(&["rig", "reference", "--period-s", "5", "-o", &reference])?;
    let (poor, good, extended) = (file("poor.toml"), file("model.toml"), file("extended.toml"));
    let before_mm = run::step("a poor model", || {
        let identify = ["identify", &recording, "-o", &poor, "--starts", "2"];
        mgpi(&[&identify[..], &POOR].concat())?;
        track(&poor, "poor")
    })?;
    run::step("identify", || {
        mgpi(&["identify", &recording, "-o", &good, "--report", &file("identified.html")])
    })?;
    run::step("diagnose", || {
        let report = file("diagnosed.html");
        mgpi(&["diagnose", &recording, "--model", &good, "-o", &extended, "--report", &report])
    })?;
    let after_mm = run::step("deploy and track", || track(&good, "good"))?;
    run::step("status", || board(&["status"]))?;

    let seconds = begin.elapsed().as_secs_f64();
    println!(
        "\ntracking error: {before_mm:.3} mm with the poor model, {after_mm:.3} mm with the identified one"
    );
    println!("the whole way: {seconds:.0} s (goal: {GOAL_S:.0} s); files in {}", directory.display());
    ensure!(after_mm < before_mm, "the identified model does not track better");
    Ok(())
}

fn rmse_mm(json: &str) -> Result<f64> {
    let text = fs::read_to_string(json).with_context(|| format!("cannot read {json}"))?;
    let figures: Value = serde_json::from_str(&text).with_context(|| format!("{json} is no JSON"))?;
    figures["tracking"]["rmse_mm"].as_f64().with_context(|| format!("{json} lacks tracking.rmse_mm"))
}

/// A board in the emulator with the rig's muscle, its bus a serial port, as long as it is wanted.
struct Emulated {
    port: PathBuf,
}

impl Emulated {
    /// Starts the emulator; its bus is a port of this path, where the board answers when this
    /// returns.
    ///
    /// # Errors
    /// It does not start.
    fn start(port: &Path) -> Result<Self> {
        run::succeed(host::mgpi().args(["emulate", "--background", "--port"]).arg(port))?;
        Ok(Self { port: port.to_owned() })
    }
}

impl Drop for Emulated {
    fn drop(&mut self) {
        // One that has ended by itself has said why.
        let _ = run::succeed(host::mgpi().args(["emulate", "--stop", "--port"]).arg(&self.port));
    }
}
