//! `mgpi pil --joint`: the firmware of two channels in the emulator, with a joint.
//!
//! Skipped, in so many words, where emulator or firmware are missing; `cargo xtask test` provides
//! both.
#![cfg(unix)]

mod common;

use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;

use board_client::emulator::image::{self, Which};
use common::Bench;
use common::processes::assert_none_is_left;
use libtest_mimic::{Arguments, Trial};

fn main() {
    let no_image = || image::find_which(Which::Joint, None).err().map(|error| error.to_string());
    let missing = common::processes::missing().or_else(no_image);
    if let Some(reason) = &missing {
        println!("the tests of the firmware of a joint are skipped: {reason}");
    }
    let tests: [(&str, fn()); 4] = [
        ("a_joint_is_controlled_by_the_firmware_of_two_channels", controlled),
        ("limits_and_calibration_of_a_file_are_those_of_the_firmware", settings),
        ("a_joint_that_is_not_the_models_is_recognised_before_it_is_controlled", backwards),
        ("a_plant_that_answers_garbage_is_quoted_and_leaves_nothing", garbage),
    ];
    let trials = tests.into_iter().map(|(name, test)| {
        let run = move || {
            test();
            Ok(())
        };
        Trial::test(name, run).with_ignored_flag(missing.is_some())
    });
    libtest_mimic::run(&Arguments::from_args(), trials.collect()).exit()
}

const RUN: &str = "pil --joint --model joint.toml --reference reference.csv";

/// A bench with a model of the rig's joint and a reference of two seconds.
fn with_model() -> Bench {
    let bench = Bench::new();
    bench.succeeds("rig joint record -o joint.csv");
    bench.succeeds("identify --joint joint.csv -o joint.toml");
    bench.write("reference.csv", "time_s,reference_deg,stiffness_nm_per_rad\n0,-12,50\n1,-8,50\n2,-12,55\n");
    bench
}

fn controlled() {
    let bench = with_model();
    let said = bench.succeeds(&format!("{RUN} -o log.csv --json run.json --report run.html"));
    assert!(said.contains("% of range"), "{said}");
    let run: serde_json::Value = serde_json::from_str(&bench.read("run.json")).expect("JSON");
    let share = run["rmse_deg"].as_f64().expect("a number") / run["range_deg"].as_f64().expect("a number");
    assert!(run["ticks"] == 2001 && share < 0.005, "{run}");
    assert_eq!(bench.read("log.csv").lines().count(), 2002);
    assert!(bench.read("run.html").contains("Torque of the feedback"), "a report");
    assert_none_is_left(&bench);
}

fn settings() {
    let bench = with_model();
    bench.write("low.toml", "[limits]\noverpressure_soft_bar = 2\n");
    let refused = bench.refuses(&format!("{RUN} --settings low.toml"));
    assert!(refused.contains("fault 112") || refused.contains("fault 212"), "{refused}");
    let wrong = "[calibration]\npressure_b_zero_code = 410\npressure_b_codes_per_bar = 500\n";
    bench.write("wrong.toml", wrong);
    let refused = bench.refuses(&format!("{RUN} --settings wrong.toml"));
    assert!(refused.contains("pressure b: 1.526251"), "{refused}");
    let off = "[calibration]\npressure_a_zero_code = 430\npressure_a_codes_per_bar = 300\n\
               angle_zero_code = 2200\nangle_codes_per_degree = 21\n";
    bench.write("off.toml", off);
    // Sensors that are off, and a board that knows by how much.
    bench.succeeds(&format!("{RUN} --settings off.toml --json run.json"));
    let run: serde_json::Value = serde_json::from_str(&bench.read("run.json")).expect("JSON");
    let share = run["rmse_deg"].as_f64().expect("a number") / run["range_deg"].as_f64().expect("a number");
    assert!(share < 0.005, "{run}");
    assert_none_is_left(&bench);
}

fn backwards() {
    let bench = with_model();
    let program = env!("CARGO_BIN_EXE_mgpi");
    let turned = "while read a b c; do case $c in -*) echo $a $b ${c#-};; *) echo $a $b -$c;; esac; done";
    let script = format!("#!/bin/sh\n{program} rig joint plant | {turned}\n");
    bench.write("backwards.sh", script);
    std::fs::set_permissions(bench.path("backwards.sh"), Permissions::from_mode(0o755)).expect("executable");
    let refused = bench.refuses(&format!("{RUN} --plant-command ./backwards.sh"));
    assert!(refused.contains("fault 303") && refused.contains("turns the wrong way"), "{refused}");
    assert_none_is_left(&bench);
}

fn garbage() {
    let bench = with_model();
    let before = bench.files();
    let refused = bench.refuses(&format!("{RUN} -o log.csv --plant-command yes"));
    assert!(refused.contains("is not `pressure_a_bar"), "{refused}");
    assert_eq!(bench.files(), before);
    assert_none_is_left(&bench);
}
