//! Two muscles at a joint: from a recording to a model and to a run, and what is refused.
#![cfg(unix)]

mod common;

use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;

use common::Bench;

/// A reference of two seconds.
const REFERENCE: &str = "time_s,reference_deg,stiffness_nm_per_rad\n0,-12,50\n1,-8,50\n2,-12,55\n";

fn with_model() -> Bench {
    let bench = Bench::new();
    bench.succeeds("rig joint record -o joint.csv");
    let said = bench.succeeds("identify --joint joint.csv -o joint.toml --json joint.json");
    assert!(said.contains("held out") && said.contains("% of range"), "{said}");
    bench
}

#[test]
fn a_joint_is_recorded_identified_and_controlled() {
    let bench = with_model();
    let figures: serde_json::Value = serde_json::from_str(&bench.read("joint.json")).expect("JSON");
    let share =
        figures["rmse_deg"].as_f64().expect("a number") / figures["range_deg"].as_f64().expect("a number");
    assert!(share < 0.01, "{figures}");
    bench.write("reference.csv", REFERENCE);
    let run = "pil --joint --model joint.toml --reference reference.csv -o log.csv --json run.json";
    let said = bench.succeeds(run);
    assert!(said.contains("% of range"), "{said}");
    let run: serde_json::Value = serde_json::from_str(&bench.read("run.json")).expect("JSON");
    let share = run["rmse_deg"].as_f64().expect("a number") / run["range_deg"].as_f64().expect("a number");
    assert!(run["ticks"] == 2001 && share < 0.005, "{run}");
    assert_eq!(bench.read("log.csv").lines().count(), 2002);
}

#[test]
fn what_does_not_fit_a_joint_is_refused_and_leaves_nothing() {
    let bench = with_model();
    let before = bench.files();
    bench.write("outside.csv", REFERENCE.replace("-8", "80"));
    bench.write("unstiff.csv", "time_s,reference_deg\n0,0\n1,0\n");
    bench.write("reference.csv", REFERENCE);
    for (arguments, message) in [
        ("identify --joint joint.csv joint.csv -o more.toml", "--joint takes one recording"),
        ("identify --joint joint.csv -o more.toml --plays 4", "cannot be used with"),
        ("identify joint.csv -o more.toml --swing-deg 2", "--joint"),
        ("identify --joint joint.csv -o joint.toml", "exists already"),
        ("identify --joint outside.csv -o more.toml", "pressure_a_bar"),
        (
            "pil --joint --model joint.toml --reference outside.csv",
            "80 degrees is outside the angles of joint.toml",
        ),
        ("pil --joint --model joint.toml --reference unstiff.csv", "stiffness_nm_per_rad"),
        ("pil --joint --model joint.csv --reference reference.csv", "not a TOML file"),
        ("pil --joint --model joint.toml --reference reference.csv --kp 3", "cannot be used with"),
        (
            "pil --joint --model joint.toml --reference reference.csv --plant-command yes",
            "is not `pressure_a_bar",
        ),
        ("pil --model joint.toml --reference reference.csv", "kind"),
    ] {
        let refused = bench.refuses(arguments);
        assert!(refused.contains(message), "{arguments}: {refused}");
    }
    let mut expected = before;
    expected.extend(["outside.csv", "reference.csv", "unstiff.csv"].map(str::to_owned));
    expected.sort();
    assert_eq!(bench.files(), expected);
}

#[test]
fn a_joint_that_is_not_the_models_is_recognised_before_it_is_controlled() {
    let bench = with_model();
    bench.write("reference.csv", REFERENCE);
    let run = "pil --joint --model joint.toml --reference reference.csv --plant-command ./backwards.sh";
    let program = env!("CARGO_BIN_EXE_mgpi");
    let turned = "while read a b c; do case $c in -*) echo $a $b ${c#-};; *) echo $a $b -$c;; esac; done";
    let script = format!("#!/bin/sh\n{program} rig joint plant | {turned}\n");
    bench.write("backwards.sh", script);
    std::fs::set_permissions(bench.path("backwards.sh"), Permissions::from_mode(0o755)).expect("executable");
    let refused = bench.refuses(run);
    assert!(refused.contains("turns the wrong way"), "{refused}");
}
