//! Two muscles at a joint: from a recording to a model, and what is refused. Runs of the firmware:
//! `joint_emulated`.
#![cfg(unix)]

mod common;

use common::Bench;

/// A reference of two seconds.
const REFERENCE: &str = "time_s,reference_deg,stiffness_nm_per_rad\n0,-12,50\n1,-8,50\n2,-12,55\n";

fn with_model() -> Bench {
    let bench = Bench::new();
    bench.succeeds("rig joint record -o joint.csv");
    let said =
        bench.succeeds("identify --joint joint.csv -o joint.toml --json joint.json --report joint.html");
    assert!(said.contains("held out") && said.contains("% of range"), "{said}");
    bench
}

#[test]
fn a_joint_is_recorded_and_identified() {
    let bench = with_model();
    let figures: serde_json::Value = serde_json::from_str(&bench.read("joint.json")).expect("JSON");
    let share =
        figures["rmse_deg"].as_f64().expect("a number") / figures["range_deg"].as_f64().expect("a number");
    assert!(share < 0.01, "{figures}");
    for end in ["softest", "stiffest"] {
        let (value, error) =
            (&figures[format!("{end}_nm_per_rad")], &figures[format!("{end}_standard_error")]);
        let share = error.as_f64().expect("an error") / value.as_f64().expect("a stiffness");
        assert!((0.001..0.05).contains(&share), "{end}: {figures}");
    }
    let page = bench.read("joint.html");
    assert!(page.contains("Stiffness that may be asked for") && !page.contains("NaN"), "a report");
    assert!(!page.to_lowercase().contains("left out"), "nothing was slack");
}

/// The same recording twice is what it is once, but that it is filled twice.
#[test]
fn several_recordings_of_a_joint_make_one_model() {
    let bench = with_model();
    let said = bench.succeeds("identify --joint joint.csv joint.csv -o both.toml --json both.json");
    assert!(said.contains("from joint.csv, joint.csv"), "{said}");
    let figures = |file: &str| serde_json::from_str::<serde_json::Value>(&bench.read(file)).expect("JSON");
    let number = |file: &str, name: &str| figures(file)[name].as_f64().expect("a number");
    let (once, twice) = (number("joint.json", "rmse_deg"), number("both.json", "rmse_deg"));
    assert!((twice / once - 1.0).abs() < 0.1, "{once} and {twice} degrees");
    let rows = |file: &str| number(file, "scored_rows");
    assert!(rows("both.json") == 2.0 * rows("joint.json"));
    assert!(bench.read("both.toml").contains("recording = \"joint.csv, joint.csv\""));
}

#[test]
fn what_does_not_fit_a_joint_is_refused_and_leaves_nothing() {
    let bench = with_model();
    let before = bench.files();
    bench.write("outside.csv", REFERENCE.replace("-8", "80"));
    bench.write("unstiff.csv", "time_s,reference_deg\n0,0\n1,0\n");
    bench.write("reference.csv", REFERENCE);
    for (arguments, message) in [
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
        ("pil --model joint.toml --reference reference.csv", "kind"),
        ("pil --model joint.toml --reference reference.csv --settings board.toml", "--joint"),
        ("pil --joint --model joint.toml --reference reference.csv --settings board.toml", "board.toml"),
    ] {
        let refused = bench.refuses(arguments);
        assert!(refused.contains(message), "{arguments}: {refused}");
    }
    let mut expected = before;
    expected.extend(["outside.csv", "reference.csv", "unstiff.csv"].map(str::to_owned));
    expected.sort();
    assert_eq!(bench.files(), expected);
}
