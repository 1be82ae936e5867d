//! Who is examined: whatever makes a verdict of a recording.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};
use serde::Deserialize;
use serde_json::{Map, Value};

/// True of both plants under any finite operator model, so it does not count.
const SHAPE: &str = "hysteresis_shape";

/// A diagnosis of a recording. It sees the file and nothing else.
pub trait Finder: Sync {
    /// Its verdict.
    ///
    /// # Errors
    /// There is none; that counts as wrong.
    fn find(&self, csv: &[u8]) -> Result<Found>;
}

/// What a diagnosis says.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// `adequate`, `explained`, `confounded` or `unexplained`.
    pub verdict: String,
    /// The causes it names with their parameters, `hysteresis_shape` aside.
    pub causes: BTreeMap<String, Map<String, Value>>,
    /// Other sets of causes that it does not tell apart from these.
    pub alternatives: Vec<BTreeSet<String>>,
}

impl Found {
    /// Out of the JSON of `mgpi diagnose`.
    ///
    /// # Errors
    /// It is of another form.
    pub fn of_json(json: &[u8]) -> Result<Self> {
        let json: Diagnosis = serde_json::from_slice(json).context("no diagnosis")?;
        let causes = json.causes.into_iter().filter(|cause| cause.name != SHAPE);
        let is_counted = |name: &String| name != SHAPE;
        let sets = json.alternatives.into_iter();
        Ok(Self {
            verdict: json.verdict,
            alternatives: sets.map(|set| set.into_iter().filter(is_counted).collect()).collect(),
            causes: causes.map(|cause| (cause.name, cause.parameters)).collect(),
        })
    }

    /// Whether it names these causes and no others, and says that they explain the recording.
    pub fn names<'a>(&self, causes: impl Iterator<Item = &'a str>) -> bool {
        let (named, asked): (BTreeSet<_>, BTreeSet<_>) =
            (self.causes.keys().map(String::as_str).collect(), causes.collect());
        // A shape that is too poor, and no other cause, is either verdict.
        let verdict = if asked.is_empty() { &["adequate", "explained"][..] } else { &["explained"] };
        named == asked && verdict.contains(&self.verdict.as_str())
    }
}

impl fmt::Display for Found {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<_> = self.causes.keys().map(String::as_str).collect();
        match (self.verdict.as_str(), names.is_empty()) {
            ("explained", false) => f.write_str(&names.join("+")),
            ("explained" | "adequate", true) => f.write_str("none"),
            (verdict, true) => f.write_str(verdict),
            (verdict, false) => write!(f, "{verdict} ({})", names.join("+")),
        }
    }
}

/// The part of the JSON that is looked at.
#[derive(Deserialize)]
struct Diagnosis {
    verdict: String,
    causes: Vec<Named>,
    #[serde(default)]
    alternatives: Vec<BTreeSet<String>>,
}

#[derive(Deserialize)]
struct Named {
    name: String,
    parameters: Map<String, Value>,
}

/// The command `mgpi diagnose`, which gets the recording as a file.
#[derive(Debug, Clone)]
pub struct DiagnoseCommand {
    /// The program `mgpi`.
    pub program: PathBuf,
}

impl Finder for DiagnoseCommand {
    fn find(&self, csv: &[u8]) -> Result<Found> {
        let folder = tempfile::tempdir().context("no place for a recording")?;
        let (recording, json) = (folder.path().join("recording.csv"), folder.path().join("diagnosis.json"));
        std::fs::write(&recording, csv)?;
        let mut command = Command::new(&self.program);
        // Games run side by side, so that each has one thread.
        command
            .env("RAYON_NUM_THREADS", "1")
            .arg("diagnose")
            .arg(&recording)
            .arg("--json")
            .arg(&json)
            .stdout(Stdio::null());
        let output = command.output().with_context(|| format!("cannot run {}", self.program.display()))?;
        ensure!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr).trim());
        Found::of_json(&std::fs::read(&json)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shape_does_not_count_and_other_causes_do() {
        let json = br#"{"verdict": "explained", "baseline": {}, "causes": [
            {"name": "hysteresis_shape", "parameters": {}, "share_of_residual": 0.5},
            {"name": "creep", "parameters": {"fraction_per_decade": 0.03}}]}"#;
        let found = Found::of_json(json).expect("a diagnosis");
        assert!(found.names(["creep"].into_iter()) && !found.names(["drift"].into_iter()));
        assert_eq!(found.causes["creep"]["fraction_per_decade"], 0.03);
        assert_eq!(found.to_string(), "creep");
        assert!(Found::of_json(b"{}").is_err());
    }
}
