//! A model in C is the model.
//!
//! The sources are compiled by gcc with all warnings as errors, and fed with what the native model
//! is fed with: on this machine, and on a Cortex-M4 in the emulator. Without gcc, its compiler for
//! ARM or the emulator on the machine a test says so and does nothing.

mod common;

use std::fs::File;
use std::process::{Command, Stdio};

use common::{Bench, PAPER};
use model_core::{Hysteresis, InverseHysteresis, Invertible};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use recording::model_file::ModelFile;

/// Answers a line with the model's output, the inverse's input for another muscle.
const PROGRAM: &str = r#"
#include <stdio.h>
#include <math.h>
#include "muscle.h"

int main(void)
{
    muscle_state there, back;
    double input, wanted;
    muscle_rest(&there);
    INVERSE_REST
    (void)back;
    if (!isnan(muscle_step(&there, NAN)) || !isnan(muscle_step(&there, INFINITY))) {
        return 1;
    }
    while (scanf("%lf %lf", &input, &wanted) == 2) {
        printf("%.17g %.17g\n", muscle_step(&there, input), INVERSE);
    }
    return 0;
}
"#;

/// The same on a bare Cortex-M4, which says each answer as 16 digits of its bits.
const BOARD_PROGRAM: &str = r#"
#include <math.h>
#include <stdint.h>
#include <string.h>
#include "muscle.h"
#include "lines.h"

static void ask(int what, const void *argument)
{
    register int number __asm__("r0") = what;
    register const void *about __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(number) : "r"(about) : "memory");
}

static void say(double value, char end)
{
    char text[18];
    uint64_t bits;
    int place;
    memcpy(&bits, &value, sizeof bits);
    for (place = 15; place >= 0; place--) {
        text[place] = "0123456789abcdef"[bits & 15];
        bits >>= 4;
    }
    text[16] = end;
    text[17] = 0;
    ask(4, text);
}

void begin(void)
{
    muscle_state there, back;
    int line;
    muscle_rest(&there);
    INVERSE_REST
    (void)back;
    for (line = 0; line < COUNT; line++) {
        const double input = LINES[line][0], wanted = LINES[line][1];
        say(muscle_step(&there, input), ' ');
        say(INVERSE, '\n');
    }
    ask(24, (const void *)0x20026);
}
"#;

/// Where things are on the emulated STM32F405; the emulator loads variables into RAM itself.
const BOARD_LAYOUT: &str = "
ENTRY(begin)
MEMORY { FLASH : ORIGIN = 0x08000000, LENGTH = 1024K RAM : ORIGIN = 0x20000000, LENGTH = 128K }
SECTIONS {
    .text : { LONG(0x20020000) LONG(begin | 1) KEEP(*(.text*)) *(.rodata*) } > FLASH
    .ARM.exidx : { *(.ARM.exidx*) } > FLASH
    .data : { *(.data*) } > RAM
    .bss : { *(.bss*) *(COMMON) } > RAM
}
";

const STRICT: [&str; 6] = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O2"];

/// Whether there is a program; said if not.
fn has(program: &str) -> bool {
    let found = Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success());
    if !found {
        println!(
            "skipped: there is no {program} on this machine, so that the C sources are not tried with it"
        );
    }
    found
}

/// A program around the exported sources.
fn around(bench: &Bench, program: &str) -> String {
    let has_inverse = bench.read("c/muscle.h").contains("muscle_inverse");
    let (rest, call) = match has_inverse {
        true => ("muscle_rest(&back);", "muscle_inverse(&back, wanted)"),
        false => ("", "wanted"),
    };
    program.replace("INVERSE_REST", rest).replace("INVERSE", call)
}

fn succeeds(command: &mut Command) -> String {
    let output = command.output().expect("it runs");
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// Inputs, and wanted outputs, also beyond the ends.
fn lines(file: &ModelFile) -> Vec<[f64; 2]> {
    let ((low, high), (least, most)) = (file.parameters.input(), file.model.output_range());
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut draw = |low: f64, high: f64| low + (high - low) * random.random_range(-0.1..1.1);
    (0..5000).map(|_| [draw(low, high), draw(least, most)]).collect()
}

/// What the sources answer on this machine.
fn on_host(bench: &Bench, lines: &[[f64; 2]]) -> Vec<[f64; 2]> {
    bench.write("c/main.c", around(bench, PROGRAM));
    let mut gcc = Command::new("gcc");
    gcc.args(STRICT).args(["-ffp-contract=off", "-o", "muscle", "c/main.c", "c/muscle.c", "-lm"]);
    succeeds(gcc.current_dir(bench.path(".")));
    let text: String = lines.iter().map(|[input, wanted]| format!("{input:?} {wanted:?}\n")).collect();
    bench.write("lines.txt", text);
    let stdin = File::open(bench.path("lines.txt")).expect("it was written");
    let text = succeeds(Command::new(bench.path("muscle")).stdin(stdin));
    let number = |field: &str| field.parse().expect("a number");
    text.lines().map(|line| line.split_once(' ').map(|(a, b)| [number(a), number(b)]).expect("two")).collect()
}

/// What they answer on the board.
fn on_board(bench: &Bench, lines: &[[f64; 2]]) -> Vec<[f64; 2]> {
    bench.write("c/board.c", around(bench, BOARD_PROGRAM)).write("board.ld", BOARD_LAYOUT);
    let rows: String =
        lines.iter().map(|[input, wanted]| format!("    {{{input:?}, {wanted:?}}},\n")).collect();
    let count = lines.len();
    bench.write(
        "c/lines.h",
        format!("#define COUNT {count}\nstatic const double LINES[COUNT][2] = {{\n{rows}}};\n"),
    );
    let mut gcc = Command::new("arm-none-eabi-gcc");
    gcc.args(STRICT).args(["-mcpu=cortex-m4", "-mthumb", "-nostartfiles", "-T", "board.ld"]);
    succeeds(gcc.args(["-o", "board.elf", "c/board.c", "c/muscle.c", "-lm"]).current_dir(bench.path(".")));
    let mut qemu = Command::new("qemu-system-arm");
    qemu.args(["-M", "netduinoplus2", "-display", "none", "-monitor", "none", "-serial", "none"]);
    qemu.args(["-chardev", "stdio,id=said", "-semihosting-config", "enable=on,target=native,chardev=said"]);
    let text = succeeds(qemu.arg("-kernel").arg(bench.path("board.elf")).stdin(Stdio::null()));
    let number = |field: &str| f64::from_bits(u64::from_str_radix(field, 16).expect("16 digits"));
    text.lines().map(|line| line.split_once(' ').map(|(a, b)| [number(a), number(b)]).expect("two")).collect()
}

/// The largest differences of model and inverse to the native ones, as shares of their ranges.
fn differences(bench: &Bench, on: impl Fn(&Bench, &[[f64; 2]]) -> Vec<[f64; 2]>) -> [f64; 2] {
    let file = ModelFile::read(&bench.path("m.toml")).expect("a model");
    let ((low, high), (least, most)) = (file.parameters.input(), file.model.output_range());
    let lines = lines(&file);
    let answers = on(bench, &lines);
    assert_eq!(answers.len(), lines.len());
    let inverse = file.model.inverse().expect("invertible");
    let (mut there, mut back) = (file.model.rest_state(), inverse.rest_state());
    let has_inverse = bench.read("c/muscle.h").contains("muscle_inverse");
    let mut worst = [0.0_f64; 2];
    for (answer, [input, wanted]) in answers.iter().zip(&lines) {
        let step = file.model.step(&mut there, *input).expect("finite");
        worst[0] = worst[0].max((answer[0] - step).abs() / (most - least));
        if has_inverse {
            let step = inverse.step(&mut back, *wanted).expect("finite");
            worst[1] = worst[1].max((answer[1] - step).abs() / (high - low));
        }
    }
    worst
}

/// Holds the model of `m.toml` against its sources.
fn assert_same(bench: &Bench, model: &str, on: impl Fn(&Bench, &[[f64; 2]]) -> Vec<[f64; 2]>) {
    bench.succeeds("export m.toml --c c --force");
    let [forward, inverse] = differences(bench, on);
    println!("{model}: model {forward:.1e}, inverse {inverse:.1e} of the range");
    assert!(forward < 1e-12 && inverse < 1e-12, "{model}: {forward:e}, {inverse:e}");
}

#[test]
fn models_of_every_kind_compile_without_a_warning_and_answer_as_the_native_ones() {
    if !has("gcc") {
        return;
    }
    let bench = Bench::new();
    bench.succeeds("rig record --protocol fig8 --seed 1 --rate-hz 20 -o rec.csv");
    for options in [
        "--model mgpi",
        "--model mgpi --envelope pl --plays 3",
        "--model mgpi --plays 40 --dead-zones 1",
        "--model sgpi",
        "--model sgpi --weights free --plays 6",
        "--model mpi",
        "--model cpi",
        "--model agpi --plays 5",
        "--model egpi --plays 5",
    ] {
        bench.succeeds(&format!("identify rec.csv -o m.toml --starts 2 --no-holdout --force {options}"));
        assert_same(&bench, options, on_host);
    }
    bench.write("m.toml", PAPER);
    assert_same(&bench, "the paper's", on_host);
}

#[test]
fn on_a_cortex_m4_the_sources_answer_as_the_native_model() {
    if !has("arm-none-eabi-gcc") || !has("qemu-system-arm") {
        return;
    }
    let bench = Bench::new();
    bench.write("m.toml", PAPER);
    assert_same(&bench, "the paper's", on_board);
    bench.succeeds("rig record --protocol fig8 --seed 1 --rate-hz 20 -o rec.csv");
    for options in ["--model mgpi --envelope pl --plays 3", "--model cpi", "--model egpi --plays 5"] {
        bench.succeeds(&format!("identify rec.csv -o m.toml --starts 2 --no-holdout --force {options}"));
        assert_same(&bench, options, on_board);
    }
}

#[test]
fn a_unit_of_fmi_has_the_model_and_the_library() {
    let bench = Bench::new();
    bench.write("m.toml", PAPER).write("library", "code");
    bench.succeeds("export m.toml --fmu u.fmu --name biceps --library library");
    let unit = std::fs::read(bench.path("u.fmu")).expect("it was written");
    let text = String::from_utf8_lossy(&unit);
    for file in ["modelDescription.xml", "/biceps", "resources/model.toml", "resources/unit.toml"] {
        assert!(text.contains(file), "{file}");
    }
    for (options, words) in [
        ("--fmu u.fmu --library library", "exists already"),
        ("--fmu v.fmu --library library --name a-b", "a name of C"),
        ("--fmu v.fmu --library nothing", "nothing: the unit's library cannot be read"),
        ("--fmu v.fmu --library library --inverse", "--period-s"),
        ("--fmu v.fmu --library library --inverse --period-s 0", "a time above 0 s is needed"),
        ("--fmu v.fmu --library library --inverse --period-s nan", "a time above 0 s is needed"),
        ("--fmu v.fmu --c c", "cannot be used with"),
        ("--name biceps", "--c <DIR>"),
    ] {
        let message = bench.refuses(&format!("export m.toml {options}"));
        assert!(message.contains(words), "{options}: {message}");
    }
    bench.write("m.toml", PAPER.replace("[plays]", "[plays]\nq = nan"));
    bench.refuses("export m.toml --fmu v.fmu --library library");
}

#[test]
fn what_c_cannot_say_is_refused_and_nothing_is_written() {
    let bench = Bench::new();
    bench.write("m.toml", PAPER);
    for name in ["2fast", "a-b", "while", "\u{b5}"] {
        assert!(
            bench.refuses(&format!("export m.toml --c c --name {name}")).contains("a name of C"),
            "{name}"
        );
    }
    bench.write("late.toml", format!("{PAPER}\n[extensions.transport_delay]\ndelay_s = 0.02\n"));
    let message = bench.refuses("export late.toml --c c");
    assert!(
        message.contains("extended by transport_delay") && message.contains("--operator-only"),
        "{message}"
    );
    bench.succeeds("export late.toml --c c --operator-only");
    let message = bench.refuses("export m.toml --c c");
    assert!(message.contains("exists already"), "{message}");
}
