//! `mgpi diagnose`: what a simulation gets wrong about a recording, and why.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use super::diagnosed_json;
use super::search::Columns as Chosen;
use crate::Error;
use crate::diagnosis::reject::Unexplained;
use crate::diagnosis::{Columns, Diagnosis, Verdict, diagnose};
use crate::output::Outputs;
use crate::recording::{Drive, output};
use crate::table::Table;
use crate::unit::Unit;

/// Shows what a simulation gets wrong about a recording, and names the cause.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The recording; load_n, temperature_c and, beside pressure_bar, command_bar are used where they are there
    #[arg(value_name = "REC.csv")]
    recording: PathBuf,
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
    let mut outputs = Outputs::claim(&arguments.json, &[file], arguments.force)?;
    let (columns, unit) = read(file, &arguments.columns)?;
    let begin = Instant::now();
    let diagnosis = with_bar(|progress| diagnose(&columns, progress))
        .map_err(|source| Error::Diagnosis { file: file.clone(), source })?;
    let seconds = begin.elapsed().as_secs_f64();
    if let Some(json) = &arguments.json {
        let text = format!("{:#}\n", diagnosed_json::to_json(&diagnosis, unit, seconds));
        outputs.stage(json, text.as_bytes())?;
    }
    outputs.commit()?;
    print_summary(file, &diagnosis, unit, seconds);
    Ok(())
}

/// The columns of a recording that a diagnosis looks at, and the output's unit.
///
/// # Errors
/// The recording is not what it should be.
pub fn read(file: &Path, chosen: &Chosen) -> Result<(Columns, Unit), Error> {
    let table = Table::read(file)?;
    let choice = chosen.choice();
    let drive = Drive::of(&table, &choice)?;
    let output = output(&table, &choice)?;
    let column = |name: &str| table.column(name).map(<[f64]>::to_vec);
    let input_is_command = drive.input.channel.name == "command_bar";
    let columns = Columns {
        command: if input_is_command { None } else { column("command_bar") },
        load_n: column("load_n"),
        temperature_c: column("temperature_c"),
        time_s: drive.time_s,
        input: drive.input.values,
        input_is_command,
        output: output.values,
        scored: drive.scored,
    };
    Ok((columns, output.channel.unit))
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
    for judged in diagnosis.examinable.iter().filter(|judged| !judged.examinable) {
        say!("not examined  {}: {}", judged.cause, judged.why);
    }
    say!("{seconds:.1} s");
}

/// The verdict in a sentence.
pub fn in_a_sentence(diagnosis: &Diagnosis, unit: Unit) -> String {
    let names: Vec<&str> = diagnosis.causes.iter().map(|named| named.cause.name()).collect();
    match diagnosis.verdict {
        Verdict::Adequate => "The operator model describes the recording; no cause is named.".to_owned(),
        Verdict::Explained => {
            format!("What the operator model gets wrong is explained by {}.", names.join(" and "))
        }
        Verdict::Confounded => format!(
            "{} would explain it, and so would other causes; this recording does not tell them apart.",
            names.join(" and ")
        ),
        Verdict::Unexplained => match &diagnosis.unexplained {
            Some(Unexplained::ZeroStep { time_s, height }) => {
                format!("None of the causes: the zero jumps by {height:.2} {unit} at {time_s:.0} s.")
            }
            Some(Unexplained::Outliers { rows, largest }) => format!(
                "None of the causes: {rows} single rows are off their neighbours, by up to {largest:.2} {unit}."
            ),
            Some(Unexplained::NotRepeatable { pure_error, tones_hz }) => {
                let tones: Vec<String> = tones_hz.iter().map(|hz| format!("{hz:.3} Hz")).collect();
                let tones = if tones.is_empty() {
                    "without a tone".to_owned()
                } else {
                    format!("with peaks at {}", tones.join(", "))
                };
                format!(
                    "None of the causes: visits to the same state differ by {pure_error:.2} {unit}, {tones}; \
                     something acts that no column shows."
                )
            }
            None => "None of the causes explains it.".to_owned(),
        },
    }
}
