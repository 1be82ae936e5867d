//! `cargo xtask arrows`: which crate may build on which, and no circle among the files of one.
//! Dependencies point one way; what would turn one round is refused.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::{circles, run};

/// A crate of ours, and those of ours that it may build on, besides all that these may build on.
/// What a test of it needs besides does not count.
const ALLOWED: [(&str, &[&str]); 27] = [
    ("model-core", &[]),
    ("wire", &["model-core"]),
    ("firmware", &["wire"]),
    ("bsp", &["firmware"]),
    ("images", &["bsp"]),
    ("board-models", &["wire"]),
    ("rig", &["model-core"]),
    ("recording", &["model-core"]),
    ("identification", &["recording"]),
    ("diagnosis", &["identification"]),
    ("tuning", &["recording"]),
    ("board-client", &["wire", "recording"]),
    ("report", &["diagnosis", "tuning", "board-client"]),
    ("export", &["recording"]),
    ("fmu", &["export"]),
    ("import", &["recording"]),
    ("fleet", &["firmware", "rig", "board-client"]),
    ("ros", &[]),
    ("gateway", &["board-client", "ros"]),
    ("network", &["gateway"]),
    ("mgpi", &["fleet", "network", "report", "export", "import"]),
    ("mgpi-python", &["report"]),
    ("host-tests", &["board-models", "fleet", "diagnosis", "tuning"]),
    ("probe", &["firmware"]),
    ("instruction-counter", &[]),
    ("packing", &["board-client"]),
    ("xtask", &["board-models", "probe", "packing"]),
];

/// Holds the crates' manifests against the table, and their files against each other.
///
/// # Errors
/// A crate builds on one that it may not build on, or is not in the table; files form a circle.
pub fn check() -> Result<()> {
    let output = run::cargo(&["metadata", "--format-version", "1", "--no-deps"]).output()?;
    ensure!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata = serde_json::from_slice(&output.stdout)?;
    let wrong = wrong(&metadata)?;
    ensure!(wrong.is_empty(), "arrows that must not be:\n  {}", wrong.join("\n  "));
    let circles = circles(&metadata)?;
    ensure!(circles.is_empty(), "circles of files:\n  {}", circles.join("\n  "));
    println!("{} crates, no arrow that must not be, no circle of files", ALLOWED.len());
    Ok(())
}

/// The circles among the files of every crate, a line each.
fn circles(metadata: &Value) -> Result<Vec<String>> {
    let mut all = Vec::new();
    for package in metadata["packages"].as_array().context("no packages")? {
        let name = package["name"].as_str().context("a package without a name")?;
        let manifest = Path::new(package["manifest_path"].as_str().context("no manifest_path")?);
        let circles = circles::of_crate(&manifest.with_file_name("src"))?;
        all.extend(circles.into_iter().map(|files| format!("{name}: {files}")));
    }
    Ok(all)
}

/// The arrows that must not be, a line each.
fn wrong(metadata: &Value) -> Result<Vec<String>> {
    let packages = metadata["packages"].as_array().context("no packages")?;
    let ours: BTreeSet<&str> = packages.iter().filter_map(|package| package["name"].as_str()).collect();
    let mut wrong = Vec::new();
    for package in packages {
        let name = package["name"].as_str().context("a package without a name")?;
        let Some(allowed) = below(name) else {
            wrong.push(format!("{name} is not in the table"));
            continue;
        };
        let dependencies = package["dependencies"].as_array().context("no dependencies")?;
        let normal = dependencies.iter().filter(|dependency| dependency["kind"].is_null());
        for to in normal.filter_map(|dependency| dependency["name"].as_str()) {
            if ours.contains(to) && !allowed.contains(to) {
                wrong.push(format!("{name} -> {to}"));
            }
        }
    }
    Ok(wrong)
}

/// All crates that a crate may build on; none if it is not in the table.
fn below(name: &str) -> Option<BTreeSet<&'static str>> {
    let (_, direct) = ALLOWED.iter().find(|(known, _)| *known == name)?;
    let mut all = BTreeSet::from_iter(direct.iter().copied());
    for lower in direct.iter().filter_map(|lower| below(lower)) {
        all.extend(lower);
    }
    Some(all)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn package(name: &str, dependencies: &[(&str, Option<&str>)]) -> Value {
        let dependencies: Vec<Value> =
            dependencies.iter().map(|(name, kind)| json!({ "name": name, "kind": kind })).collect();
        json!({ "name": name, "dependencies": dependencies })
    }

    #[test]
    fn an_arrow_up_and_a_crate_that_nobody_knows_are_found() -> Result<()> {
        let metadata = json!({ "packages": [
            package("model-core", &[("libm", None), ("recording", None)]),
            package("recording", &[("model-core", None), ("identification", Some("dev"))]),
            package("identification", &[("recording", None)]),
            package("attic", &[]),
        ]});
        assert_eq!(wrong(&metadata)?, ["model-core -> recording", "attic is not in the table"]);
        Ok(())
    }

    #[test]
    fn no_library_of_the_host_builds_on_the_firmware_or_on_what_it_has_to_find_out() {
        for library in ["recording", "identification", "diagnosis", "board-client", "report"] {
            let allowed = below(library).expect("in the table");
            assert!(!allowed.contains("firmware") && !allowed.contains("rig"), "{library} -> {allowed:?}");
        }
    }

    #[test]
    fn a_crate_builds_on_those_above_it_in_the_table_alone() {
        for (k, (name, allowed)) in ALLOWED.iter().enumerate() {
            for to in *allowed {
                let place = ALLOWED.iter().position(|(known, _)| known == to);
                assert!(place.is_some_and(|place| place < k), "{name} -> {to}");
            }
        }
    }
}
