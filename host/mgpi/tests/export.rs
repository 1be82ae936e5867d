//! A model in C is the model.
//!
//! The sources are compiled by gcc with all warnings as errors, and fed with what the native model
//! is fed with. Without gcc on the machine the test says so and does nothing.

mod common;

use std::io::Write;
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

/// Whether there is a compiler; said if not.
fn has_gcc() -> bool {
    let found = Command::new("gcc").arg("--version").output().is_ok_and(|output| output.status.success());
    if !found {
        println!("skipped: there is no gcc on this machine, so that the C sources are not compiled");
    }
    found
}

/// Compiles the exported sources with a program around them.
fn compile(bench: &Bench) {
    let has_inverse = bench.read("c/muscle.h").contains("muscle_inverse");
    let (rest, call) = match has_inverse {
        true => ("muscle_rest(&back);", "muscle_inverse(&back, wanted)"),
        false => ("", "wanted"),
    };
    bench.write("c/main.c", PROGRAM.replace("INVERSE_REST", rest).replace("INVERSE", call));
    let output = Command::new("gcc")
        .args(["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O2", "-ffp-contract=off"])
        .args(["-o", "muscle", "c/main.c", "c/muscle.c", "-lm"])
        .current_dir(bench.path("."))
        .output()
        .expect("gcc runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// The largest differences of model and inverse to the native ones, as shares of their ranges.
fn differences(bench: &Bench) -> [f64; 2] {
    let file = ModelFile::read(&bench.path("m.toml")).expect("a model");
    let ((low, high), (least, most)) = (file.parameters.input(), file.model.output_range());
    let mut random = ChaCha8Rng::seed_from_u64(5);
    // Also beyond the ends.
    let mut draw = |low: f64, high: f64| low + (high - low) * random.random_range(-0.1..1.1);
    let lines: Vec<[f64; 2]> = (0..5000).map(|_| [draw(low, high), draw(least, most)]).collect();
    let mut child = Command::new(bench.path("muscle"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("it was compiled");
    let text: String = lines.iter().map(|[input, wanted]| format!("{input:?} {wanted:?}\n")).collect();
    let mut stdin = child.stdin.take().expect("a pipe");
    let writer = std::thread::spawn(move || stdin.write_all(text.as_bytes()));
    let output = child.wait_with_output().expect("it ends");
    writer.join().expect("no panic").expect("it reads");
    assert!(output.status.success(), "{:?}", output.status);
    let inverse = file.model.inverse().expect("invertible");
    let (mut there, mut back) = (file.model.rest_state(), inverse.rest_state());
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    let mut worst = [0.0_f64; 2];
    for (line, [input, wanted]) in text.lines().zip(&lines) {
        let ours: Vec<f64> = line.split(' ').map(|field| field.parse().expect("a number")).collect();
        let step = file.model.step(&mut there, *input).expect("finite");
        worst[0] = worst[0].max((ours[0] - step).abs() / (most - least));
        if bench.read("c/muscle.h").contains("muscle_inverse") {
            let answer = inverse.step(&mut back, *wanted).expect("finite");
            worst[1] = worst[1].max((ours[1] - answer).abs() / (high - low));
        }
    }
    assert_eq!(text.lines().count(), lines.len());
    worst
}

#[test]
fn models_of_every_kind_compile_without_a_warning_and_answer_as_the_native_ones() {
    if !has_gcc() {
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
        bench.succeeds("export m.toml --c c --force");
        compile(&bench);
        let [forward, inverse] = differences(&bench);
        println!("{options}: model {forward:.1e}, inverse {inverse:.1e} of the range");
        assert!(forward < 1e-12 && inverse < 1e-12, "{options}: {forward:e}, {inverse:e}");
    }
    bench.write("m.toml", PAPER);
    bench.succeeds("export m.toml --c c --force");
    compile(&bench);
    let [forward, inverse] = differences(&bench);
    assert!(forward < 1e-12 && inverse < 1e-12, "the paper's: {forward:e}, {inverse:e}");
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
