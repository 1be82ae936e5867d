//! `mgpi diagnose`: what a simulation gets wrong about a recording, and why.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use super::diagnosed_json;
use super::search::Columns as Chosen;
use crate::Error;
use crate::diagnosis::words::{experiment, in_a_sentence};
use crate::diagnosis::{Columns, Diagnosis, diagnose};
use crate::output::Outputs;
use crate::recording::Recording;
use crate::report::diagnosed;
use crate::table::Table;
use crate::unit::Unit;

/// Shows what a simulation gets wrong about a recording, and names the cause.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The recording; load_n, temperature_c and, beside pressure_bar, command_bar are used where they are there
    #[arg(value_name = "REC.csv")]
    recording: PathBuf,
    /// Also write a page that shows it: one HTML file
    #[arg(long, value_name = "REPORT.html")]
    report: Option<PathBuf>,
    /// Also write the diagnosis as JSON
    #[arg(long, value_name = "DIAGNOSIS.json")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Chosen,
    /// Overwrite existing outputs
    #[arg(long)]
    force: bool,
}

/// Diagnoses.
///
/// # Errors
/// The recording is not what it should be or too short, or an output cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let file = &arguments.recording;
    let mut outputs =
        Outputs::claim(arguments.report.iter().chain(&arguments.json), &[file], arguments.force)?;
    let (columns, recording) = read(file, &arguments.columns)?;
    let unit = recording.output.channel.unit;
    let begin = Instant::now();
    let diagnosis = with_bar(|progress| diagnose(&columns, progress))
        .map_err(|source| Error::Diagnosis { file: file.clone(), source })?;
    let seconds = begin.elapsed().as_secs_f64();
    if let Some(report) = &arguments.report {
        outputs.stage(report, diagnosed::to_html(&diagnosis, &recording).as_bytes())?;
    }
    if let Some(json) = &arguments.json {
        let text = format!("{:#}\n", diagnosed_json::to_json(&diagnosis, unit, seconds));
        outputs.stage(json, text.as_bytes())?;
    }
    outputs.commit()?;
    print_summary(file, &diagnosis, unit, seconds);
    Ok(())
}

/// The columns of a recording that a diagnosis looks at, and the recording that they are from.
///
/// # Errors
/// The recording is not what it should be.
pub fn read(file: &Path, chosen: &Chosen) -> Result<(Columns, Recording), Error> {
    let table = Table::read(file)?;
    let recording = Recording::of(&table, &chosen.choice())?;
    let Recording { drive, output } = &recording;
    let column = |name: &str| table.column(name).map(<[f64]>::to_vec);
    let input_is_command = drive.input.channel.name == "command_bar";
    let columns = Columns {
        command: if input_is_command { None } else { column("command_bar") },
        load_n: column("load_n"),
        temperature_c: column("temperature_c"),
        time_s: drive.time_s.clone(),
        input: drive.input.values.clone(),
        input_is_command,
        output: output.values.clone(),
        scored: drive.scored.clone(),
    };
    Ok((columns, recording))
}

/// Works with a bar that shows how far it is, and with what.
fn with_bar<T>(work: impl FnOnce(&(dyn Fn(f64, &str) + Sync)) -> T) -> T {
    const PARTS: f64 = 1000.0;
    let style = ProgressStyle::with_template("diagnosing {wide_bar} {percent} % {msg}");
    let bar =
        ProgressBar::new(PARTS as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let result = work(&|share, what| {
        bar.set_position((PARTS * share) as u64);
        bar.set_message(what.to_owned());
    });
    bar.finish_and_clear();
    result
}

fn print_summary(file: &Path, diagnosis: &Diagnosis, unit: Unit, seconds: f64) {
    say!("{}: {}", file.display(), diagnosis.verdict.name());
    say!("{}", in_a_sentence(diagnosis, unit));
    let (before, after) = diagnosis.heldout;
    say!(
        "held out      {before:.3} {unit} before, {after:.3} {unit} with the causes; noise {:.3} {unit}",
        diagnosis.anatomy.noise.deviation
    );
    for named in &diagnosis.causes {
        let parameters: Vec<String> =
            named.parameters.iter().map(|(name, value)| format!("{name} {value:.4}")).collect();
        say!("{:<22}{}", named.cause.name(), parameters.join(", "));
        for words in &named.evidence {
            say!("{:<22}{words}", "");
        }
    }
    for set in &diagnosis.alternatives {
        let names: Vec<&str> = set.iter().map(|cause| cause.name()).collect();
        say!("as well       {}", names.join(" and "));
    }
    if let Some(command) = experiment(diagnosis) {
        say!("to separate   {command}");
    }
    for judged in diagnosis.examinable.iter().filter(|judged| !judged.examinable) {
        say!("not examined  {}: {}", judged.cause, judged.why);
    }
    say!("{seconds:.1} s");
}
