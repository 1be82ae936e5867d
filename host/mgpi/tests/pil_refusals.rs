//! What `mgpi pil` refuses before it starts the firmware.

mod common;

use common::{Bench, PAPER};

/// A bench with the paper's model and a short reference.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("model.toml", PAPER).write("ref.csv", "time_s,reference_mm\n0,0\n0.01,1\n");
    bench
}

const PIL: &str =
    "pil --model model.toml --reference ref.csv -o log.csv --json figures.json --plant-command cat";

#[test]
fn a_model_from_another_quantity_than_the_boards_is_refused() {
    let bench = bench();
    bench.write("model.toml", PAPER.replace("_bar", "_v"));
    let message = bench.refuses(PIL);
    assert!(
        message.contains("model.toml: its input is in V; the valve board needs bar or another pressure"),
        "{message}"
    );
}

#[test]
fn a_model_with_more_plays_than_the_board_takes_is_refused() {
    let bench = bench();
    bench.write("model.toml", PAPER.replacen("count = 10", "count = 33", 1));
    let message = bench.refuses(PIL);
    assert!(message.contains("model.toml: no model for the board: plays"), "{message}");
    assert!(message.contains("33") && message.contains("32"), "{message}");
}

#[test]
fn a_reference_without_its_column_is_refused() {
    let bench = bench();
    bench.write("ref.csv", "time_s,contraction_mm\n0,0\n");
    let message = bench.refuses(PIL);
    assert!(message.contains("ref.csv: no column reference_mm"), "{message}");
    // There is no option --input, as identify has it.
    assert!(
        message.contains("if contraction_mm is meant, say --columns reference=contraction_mm"),
        "{message}"
    );
}

#[test]
fn a_reference_whose_time_stands_still_is_refused() {
    let bench = bench();
    bench.write("ref.csv", "time_s,reference_mm\n0,0\n1,5\n1,6\n");
    let message = bench.refuses(PIL);
    assert!(message.contains("ref.csv, line 4, column time_s: time does not increase"), "{message}");
}

#[test]
fn a_reference_longer_than_memory_is_refused() {
    let bench = bench();
    bench.write("ref.csv", "time_s,reference_mm\n0,0\n1e9,5\n");
    let message = bench.refuses(PIL);
    assert!(message.contains("ref.csv: 1000000000001 ticks; a run takes at most 10000000"), "{message}");
}

#[test]
fn a_firmware_that_is_not_there_is_named_with_how_to_build_it() {
    let message = bench().refuses(&format!("{PIL} --firmware none.elf"));
    assert!(message.contains("none.elf: no such file; `cargo xtask firmware` builds"), "{message}");
}

#[test]
fn a_file_that_is_no_firmware_is_refused() {
    let message = bench().refuses(&format!("{PIL} --firmware model.toml"));
    assert!(message.contains("model.toml: not the firmware"), "{message}");
}

#[test]
fn an_existing_log_is_not_overwritten() {
    let bench = bench();
    bench.write("log.csv", "precious");
    let message = bench.refuses(PIL);
    assert!(message.contains("log.csv: exists already; --force overwrites it"), "{message}");
    assert_eq!(bench.read("log.csv"), "precious");
}

#[test]
fn a_plant_other_than_the_rig_is_refused() {
    let message = bench().refuses("pil --model model.toml --reference ref.csv --plant robot");
    assert!(message.contains("rig:EFFECT"), "{message}");
}

#[test]
fn a_rate_of_zero_is_refused() {
    let message = bench().refuses(&format!("{PIL} --rate-hz 0"));
    assert!(message.contains("--rate-hz") && message.contains("above 0"), "{message}");
}
