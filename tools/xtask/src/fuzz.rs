//! Fuzzing: mutated inputs, guided by the code that they reach, for every parser of bytes from
//! outside. The targets are the files of `tools/fuzz/fuzz_targets`.
//!
//! New inputs are gathered in the target directory, and a later run goes on from them; the corpus
//! that is kept with the sources is in `tools/fuzz/corpus`. An input that fails a target is left in
//! `tools/fuzz/artifacts`.

use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::{run, setup};

/// How long a single input may take. Unit: s.
const INPUT_LIMIT_S: u32 = 10;

/// What libFuzzer writes before the number of inputs that it has run.
const EXECUTIONS: &str = "stat::number_of_executed_units:";

/// Runs every target, for an equal share of the time.
///
/// # Errors
/// The fuzzer is missing and cannot be installed; a target does not build, or fails.
pub fn fuzz(seconds: u64) -> Result<()> {
    setup::ensure_fuzzer()?;
    let targets = targets()?;
    run::step("fuzz targets", || run::succeed(&mut cargo_fuzz("build")))?;
    let share_s = (seconds / targets.len() as u64).max(1);
    let mut total = 0;
    println!("{:>12}  target, {share_s} s each", "executions");
    for target in &targets {
        let executions = run_target(target, share_s)?;
        println!("{executions:>12}  {target}");
        total += executions;
    }
    println!("{total:>12}  in all, none failed");
    Ok(())
}

/// Names of the targets, sorted.
fn targets() -> Result<Vec<String>> {
    let directory = run::root().join("tools/fuzz/fuzz_targets");
    let files =
        std::fs::read_dir(&directory).with_context(|| format!("cannot read {}", directory.display()))?;
    let mut names = Vec::new();
    for file in files {
        names.extend(file?.path().file_stem().map(|name| name.to_string_lossy().into_owned()));
    }
    names.sort();
    Ok(names)
}

/// Runs a target; answers how many inputs it was given.
fn run_target(target: &str, seconds: u64) -> Result<u64> {
    let gathered = run::target_dir().join("fuzz-corpus").join(target);
    std::fs::create_dir_all(&gathered).with_context(|| format!("cannot make {}", gathered.display()))?;
    let mut command = cargo_fuzz("run");
    command.arg(target).arg(gathered).arg(Path::new("tools/fuzz/corpus").join(target));
    command.args(["--", "-print_final_stats=1"]);
    command.arg(format!("-max_total_time={seconds}")).arg(format!("-timeout={INPUT_LIMIT_S}"));
    let output = command.stdout(Stdio::null()).output().context("cannot run cargo fuzz")?;
    let messages = String::from_utf8_lossy(&output.stderr);
    let executions = messages.lines().find_map(|line| line.strip_prefix(EXECUTIONS)?.trim().parse().ok());
    match executions {
        Some(executions) if output.status.success() => Ok(executions),
        _ => bail!("{target} failed ({}):\n{messages}", output.status),
    }
}

/// A subcommand of cargo-fuzz. Without a sanitizer: there is no `unsafe` of ours in what is tested,
/// and the installed compiler will do.
fn cargo_fuzz(subcommand: &str) -> Command {
    let mut command =
        run::cargo(&["fuzz", subcommand, "--fuzz-dir", "tools/fuzz", "--sanitizer", "none", "--target-dir"]);
    command.arg(run::target_dir().join("fuzz"));
    command
}
