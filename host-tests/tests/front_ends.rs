//! The analogue front ends of the reference board (`hardware/board.cir`) in ngspice, at the worst
//! case of their parts; and the list of parts and the drawing against that netlist.
//!
//! Skipped, in so many words, where there is no ngspice; `cargo xtask test` installs it where it
//! can.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Of the output stage: 1 + 20.3 kΩ / 10 kΩ (R5 to R7 in hardware/board.cir). Unit: V per V.
const GAIN: f64 = 3.03;
/// Supply of the converters (docs/board.md). Unit: V.
const SUPPLY_V: f64 = 3.3;
/// A pin's leakage (data sheet DS8626, "I/O static characteristics"), either way. Unit: A.
const LEAKAGES_A: [&str; 2] = ["1u", "-1u"];
/// The amplifier's offset by the list of parts. Unit: V.
const OFFSETS_V: [&str; 2] = ["0.5m", "-0.5m"];
/// Share by which a resistor of the gain is off, by the list of parts.
const RESISTORS: [&str; 2] = ["0.001", "-0.001"];

fn hardware() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../hardware")
}

/// Runs a deck behind the netlist; the figures that it measures, by their names. None where there
/// is no ngspice.
fn measured(deck: &str) -> Option<BTreeMap<String, f64>> {
    let mut file = tempfile::Builder::new().suffix(".cir").tempfile().unwrap();
    let netlist = hardware().join("board.cir");
    writeln!(file, "* deck\n.include {}\n{deck}\n.end", netlist.display()).unwrap();
    let Ok(output) = Command::new("ngspice").arg("-b").arg(file.path()).output() else {
        println!("skipped: no ngspice; `cargo xtask test` installs it, or apt-get install ngspice");
        return None;
    };
    let text = String::from_utf8_lossy(&output.stdout).to_lowercase();
    assert!(!text.contains("failed") && !text.contains("error"), "{text}");
    let figures = text.lines().filter_map(|line| {
        let (name, rest) = line.split_once('=')?;
        let value = rest.split_whitespace().next()?.parse().ok()?;
        Some((name.trim().to_owned(), value))
    });
    Some(figures.collect())
}

/// The supplies of the output stage, and what hangs on it: the input of a regulator.
const SUPPLIES: &str = "Vvdda vdda 0 3.3\nVp vp 0 12\nVn vn 0 -0.23\nRregulator out 0 100k";

#[test]
fn vented_the_pin_is_within_10_mv_of_0_from_every_state_within_a_tenth_of_a_tick() {
    for leak in LEAKAGES_A {
        for off in OFFSETS_V {
            for code_v in [0.0_f64, 0.2, 1.65, 3.3] {
                // Let go of, as in a reset, driven from 1 ms to 3 ms, let go of.
                let Some(found) = measured(&format!(
                    "{SUPPLIES}\nVcode code 0 {code_v}\nVon on 0 pwl(0 0 1m 0 1.001m 3.3 3m 3.3 3.0001m 0)\n\
                     Xc pin code on vdda converter leak={leak}\nXs pin out vp vn output_stage off={off}\n\
                     .tran 0.5u 6m\n\
                     .meas tran reset find v(pin) at=0.9m\n.meas tran driven find v(pin) at=2.9m\n\
                     .meas tran soon find v(pin) at=3.1m\n.meas tran regulator_soon find v(out) at=3.1m\n\
                     .meas tran last find v(pin) at=5.9m\n.meas tran regulator find v(out) at=5.9m"
                )) else {
                    return;
                };
                let at = format!("{code_v} V, leakage {leak} A, offset {off} V: {found:?}");
                assert!((found["driven"] - code_v.clamp(0.2, 3.1)).abs() < 0.001, "{at}");
                for name in ["reset", "soon", "last"] {
                    assert!(found[name].abs() < 0.010, "{name}: {at}");
                }
                // Three times that and the offset: 0.025 bar.
                for name in ["regulator_soon", "regulator"] {
                    assert!(found[name].abs() < 0.025, "{name}: {at}");
                }
            }
        }
    }
}

#[test]
fn while_the_supplies_come_and_go_nothing_is_put_out() {
    // The processor's supply comes before, with, and behind the amplifier's, and goes again.
    for begin_ms in [1, 5, 9] {
        let Some(found) = measured(&format!(
            "Vp vp 0 pwl(0 0 5m 0 7m 12 30m 12 32m 0)\nVn vn 0 pwl(0 0 5m 0 7m -0.23 30m -0.23 32m 0)\n\
             Rregulator out 0 100k\n\
             Xpin pin pin_let_go\nXs pin out vp vn output_stage\nVvdd vdd 0 pwl(0 0 {begin_ms}m 0 12m 3.3)\n\
             .tran 5u 40m\n.meas tran pin_most max v(pin)\n.meas tran most max v(out)\n.meas tran least min v(out)"
        )) else {
            return;
        };
        assert!(found["pin_most"] < 0.010, "{found:?}");
        assert!(found["most"] < 0.035 && found["least"] > -0.035, "{found:?}");
    }
}

#[test]
fn zero_and_span_are_those_of_the_boards_scaling_and_the_buffers_reach() {
    for r in RESISTORS {
        for off in OFFSETS_V {
            for code in [0.0_f64, 224.0, 1024.0, 2048.0, 3868.0, 4095.0] {
                let code_v = code / 4095.0 * SUPPLY_V;
                let Some(found) = measured(&format!(
                    "{SUPPLIES}\nVcode code 0 {code_v}\nVon on 0 3.3\nXc pin code on vdda converter\n\
                     Xs pin out vp vn output_stage off={off} r={r}\n\
                     .tran 1u 3m\n.meas tran regulator find v(out) at=2.9m"
                )) else {
                    return;
                };
                let reached_v = code_v.clamp(0.2, SUPPLY_V - 0.2);
                let error_v = found["regulator"] - reached_v * GAIN;
                // 100 ohm before 100 kilohm take a thousandth, the resistors 0.13 %, the offset 1.5
                // mV.
                assert!(error_v.abs() < 0.002 + 0.003 * reached_v * GAIN, "{code}: {error_v} V");
                let lowest_and_highest =
                    (0.6..0.613).contains(&found["regulator"]) || (9.35..9.43).contains(&found["regulator"]);
                assert!(lowest_and_highest || (224.0..3868.0).contains(&code), "{code}: {found:?}");
            }
        }
    }
}

#[test]
fn the_filters_corner_is_1_6_khz_and_lower_behind_a_source_of_10_kilohm() {
    for (source, corner_hz) in [("1m", 1_592.0), ("10k", 144.7)] {
        let Some(found) = measured(&format!(
            "Vs s 0 dc 1 ac 1\nRs s sensor {source}\nXi sensor pin sensor_input\n\
             .control\nac dec 200 1 100k\nmeas ac corner when vdb(pin)=-3.0103\n.endc"
        )) else {
            return;
        };
        assert!((found["corner"] / corner_hz - 1.0).abs() < 0.002, "{found:?}");
    }
}

#[test]
fn the_dump_valve_is_held_by_changes_only_and_let_go_of_within_10_ms() {
    // A change each millisecond, the last of them down or up; a level that rises once; a reset.
    let changing = |last_ms: i32| {
        let change = |ms: i32| {
            let [before, behind] = if ms % 2 == 0 { [3.3, 0.0] } else { [0.0, 3.3] };
            format!(" {ms}m {before} {ms}.001m {behind}")
        };
        format!("Vpin pin 0 pwl(0 0{})", (1..=last_ms).map(change).collect::<String>())
    };
    for (name, pin, is_held, last_s) in [
        ("low at last", changing(60), true, 60e-3),
        ("high at last", changing(59), true, 59e-3),
        ("high once", "Vpin pin 0 pwl(0 0 50m 0 50.001m 3.3)".to_owned(), false, 50e-3),
        ("reset", "Xpin pin pin_let_go".to_owned(), false, 0.0),
    ] {
        let Some(found) = measured(&format!(
            "{pin}\nXp pin gate charge_pump\n.tran 10u 100m\n\
             .meas tran least min v(gate) from=30m to=58m\n.meas tran before max v(gate) from=30m to=49m\n\
             .meas tran behind max v(gate) from={}m to=99m",
            (last_s + 10e-3) * 1e3
        )) else {
            return;
        };
        // The threshold of Q1 is 0.5 V at least, and it carries the coil's current at 1.7 V.
        assert_eq!(found["least"] > 1.7, is_held, "{name}: {found:?}");
        assert_eq!(found["before"] > 0.5, is_held, "{name}: {found:?}");
        assert!(found["behind"] < 0.5, "{name}: {found:?}");
    }
}

#[test]
fn outputs_that_are_let_go_of_are_low() {
    // The pin's leakage, and 10 uA of what hangs on it: the driver of the bus, of a coil.
    let Some(found) = measured(
        "Xpin pin pin_let_go\nIhangs 0 pin 10u\nXr pin kept_low\n.tran 1u 1m\n.meas tran low find v(pin) at=0.9m",
    ) else {
        return;
    };
    assert!(found["low"] < 0.8, "{found:?}");
}

/// Reference and value of the parts in the netlist.
fn parts() -> BTreeMap<String, String> {
    let netlist = std::fs::read_to_string(hardware().join("board.cir")).unwrap();
    let models = ["pin_let_go", "converter", "amplifier"];
    let mut inside = String::new();
    let mut parts = BTreeMap::new();
    for line in netlist.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match &words[..] {
            [".subckt", name, ..] => inside = (*name).to_owned(),
            [reference, .., value]
                if reference.starts_with(['R', 'C', 'D']) && !models.contains(&&*inside) =>
            {
                parts.insert((*reference).to_owned(), (*value).to_owned());
            }
            _ => {}
        }
    }
    // With its tolerance in the netlist: {10k * (1 - r)}.
    for (reference, value) in [("R5", "10k"), ("R6", "20k"), ("R7", "301")] {
        assert!(netlist.contains(&format!("{{{value} * (1 ")), "{reference}");
        parts.insert(reference.to_owned(), value.to_owned());
    }
    parts
}

#[test]
fn the_list_of_parts_has_every_part_of_the_netlist_by_its_value() {
    let list = std::fs::read_to_string(hardware().join("bom.csv")).unwrap();
    let listed: BTreeMap<_, _> = list
        .lines()
        .skip(1)
        .map(|line| line.split(',').take(2).map(str::to_owned).collect::<Vec<_>>())
        .filter(|columns| columns[1] != "-" && columns[0] != "X1")
        .map(|columns| (columns[0].clone(), columns[1].clone()))
        .collect();
    assert_eq!(listed, parts());
}
