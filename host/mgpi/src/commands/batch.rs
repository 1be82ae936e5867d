//! `mgpi batch`: an archive of recordings diagnosed, a line each.
//!
//! What is done is kept line by line beside the output, in `OUTPUT.part`. A run that was ended goes
//! on from there: a file that is in it with the same SHA-256 is not done again, if its first line
//! names the same program and the same options. The output itself comes into being at the end, in
//! the order of the files' names, whatever order they were done in.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

use clap::Args;
use indicatif::ProgressBar;

use super::search::Columns;
use crate::Error;
use crate::output::{OutputError, Outputs};
use crate::parquet::{self, is_parquet};
use diagnosis::diagnosed::{Diagnosed, Examined};
use diagnosis::{Named, causes::Cause};
use import::Values;
use recording::day::Day;
use recording::table::Table;
use recording::{Choice, TOOL};
use report::archive::{self, Figures, Found};

/// Endings of files that are taken for recordings.
const ENDINGS: [&str; 3] = ["csv", "tsv", "txt"];
/// The columns of the output; figures are in the unit of their line.
const HEADER: [&str; 17] = [
    "file",
    "sha256",
    "error",
    "rows",
    "input",
    "output",
    "unit",
    "stroke",
    "verdict",
    "causes",
    "rivals",
    "plain_rmse",
    "written_rmse",
    "heldout_plain_rmse",
    "heldout_written_rmse",
    "noise_floor",
    "written_form",
];

/// Those of them that are numbers.
const FIGURES: [&str; 7] = [
    "rows",
    "stroke",
    "plain_rmse",
    "written_rmse",
    "heldout_plain_rmse",
    "heldout_written_rmse",
    "noise_floor",
];

/// Diagnoses every recording in a folder, and writes a table of what was found; a run that was
/// ended goes on where it was.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The folder; files of it and of its folders that end in .csv, .tsv or .txt
    folder: PathBuf,
    /// Where the table goes: a line a file; as Parquet if it ends in .parquet
    #[arg(short = 'o', value_name = "RESULTS.csv")]
    results: PathBuf,
    /// Also write a page (one HTML file): each folder of the folder is a muscle, followed from day
    /// to day, by the date in a file's name or that of its last change
    #[arg(long, value_name = "REPORT.html")]
    report: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
    /// Overwrite an existing output, and begin from nothing
    #[arg(long)]
    force: bool,
}

/// A line of the table: as many fields as [`HEADER`].
type Line = Vec<String>;

/// Works through the folder.
///
/// # Errors
/// The folder cannot be read, has no recording, or the output cannot be written. What is wrong with
/// a recording stands in its line.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { folder, results: output, report, columns, force } = arguments;
    let mut outputs = Outputs::claim([output].into_iter().chain(report), &[], *force)?;
    let part = PathBuf::from(format!("{}.part", output.display()));
    let unwritable = |source| OutputError::Unwritable { path: part.clone(), source };
    let mut files = Vec::new();
    find(folder, &mut files)
        .map_err(|error| Error::Usage(format!("{}: cannot be read: {error}", folder.display())))?;
    // Neither what this has written nor what it is writing is a recording.
    files.retain(|file| file != output);
    files.sort();
    if files.is_empty() {
        let endings = ENDINGS.join(", ");
        return Err(Error::Usage(format!("{}: no file in it ends in {endings}", folder.display())));
    }
    let made_by = format!("# {TOOL}, {columns:?}");
    let kept = if *force { BTreeMap::new() } else { lines_of(&part, &made_by) };
    let choice = columns.choice();
    let mut file = File::create(&part).map_err(unwritable)?;
    writeln!(file, "{made_by}").map_err(unwritable)?;
    file.write_all(
        text(std::iter::once(&HEADER.map(str::to_owned).to_vec()).chain(kept.values())).as_bytes(),
    )
    .map_err(unwritable)?;
    drop(file);
    let file = OpenOptions::new().append(true).open(&part).map_err(unwritable)?;
    let (bar, file) = (ProgressBar::new(files.len() as u64), Mutex::new(file));
    let do_next = |path: &Path| {
        let (line, is_kept) = line_of(path, &choice, &kept);
        if !is_kept {
            file.lock().unwrap_or_else(PoisonError::into_inner).write_all(text([&line]).as_bytes())?;
        }
        bar.inc(1);
        Ok((line, is_kept))
    };
    let done: Vec<(Line, bool)> = side_by_side(&files, do_next).map_err(unwritable)?;
    bar.finish_and_clear();
    let lines: Vec<&Line> = done.iter().map(|(line, _)| line).collect();
    stage(&mut outputs, output, &lines)?;
    if let Some(report) = report {
        let found: Vec<Found> = lines.iter().map(|line| found(folder, line)).collect();
        outputs.stage(report, archive::to_html(folder, &found).as_bytes())?;
    }
    outputs.commit()?;
    // Whatever is left of it is in the output.
    let _ = fs::remove_file(&part);
    let count = |is_it: &dyn Fn(&(Line, bool)) -> bool| done.iter().filter(|line| is_it(line)).count();
    let (refused, kept) = (count(&|(line, _)| !line[2].is_empty()), count(&|(_, is_kept)| *is_kept));
    say!(
        "{} recordings in {}: {refused} refused, {kept} kept of an earlier run",
        done.len(),
        output.display()
    );
    for (line, _) in done.iter().filter(|(line, _)| !line[2].is_empty()) {
        say!("refused       {}", line[2]);
    }
    Ok(())
}

/// A line for the page. A muscle is the folder that its recordings are in.
fn found(folder: &Path, line: &Line) -> Found {
    let field = |name: &str| {
        let place = HEADER.iter().position(|known| *known == name);
        place.map_or("", |place| line[place].as_str())
    };
    let number = |name: &str| field(name).parse().unwrap_or(f64::NAN);
    let file = Path::new(field("file"));
    let inside = file.strip_prefix(folder).unwrap_or(file);
    Found {
        file: inside.display().to_string(),
        muscle: inside.parent().map(|muscle| muscle.display().to_string()).unwrap_or_default(),
        day: Day::of_file(file),
        result: match field("error") {
            "" => Ok(Figures {
                unit: field("unit").to_owned(),
                stroke: number("stroke"),
                verdict: field("verdict").to_owned(),
                causes: field("causes").to_owned(),
                plain_rmse: number("plain_rmse"),
                written_rmse: number("written_rmse"),
            }),
            error => Err(error.to_owned()),
        },
    }
}

/// Stages the table: CSV, or Parquet with figures as numbers.
fn stage(outputs: &mut Outputs, output: &Path, lines: &[&Line]) -> Result<(), Error> {
    if !is_parquet(output) {
        let header = HEADER.map(str::to_owned).to_vec();
        outputs.stage(output, text([&header].into_iter().chain(lines.iter().copied())).as_bytes())?;
        return Ok(());
    }
    let column = |place: usize| lines.iter().map(|line| line[place].clone()).collect();
    let words: Vec<Vec<String>> = (0..HEADER.len()).map(column).collect();
    // What is refused has no figures.
    let number = |word: &String| word.parse().unwrap_or(f64::NAN);
    let numbers: Vec<Vec<f64>> = words.iter().map(|words| words.iter().map(number).collect()).collect();
    let columns: Vec<(&str, Values)> = (0..HEADER.len())
        .map(|place| match FIGURES.contains(&HEADER[place]) {
            true => (HEADER[place], Values::Numbers(&numbers[place])),
            false => (HEADER[place], Values::Words(&words[place])),
        })
        .collect();
    parquet::stage(outputs, output, &columns)
}

/// Does every file, in the order of the files, as many at once as there are cores. By threads of
/// its own: one of the pool that a diagnosis works in would begin the next file while it waits for
/// a part of this one, and so on down its stack.
fn side_by_side<T: Send, E: Send>(
    files: &[PathBuf],
    work: impl Fn(&Path) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let next = AtomicUsize::new(0);
    let results = Mutex::new(Vec::new());
    let worker = || {
        while let Some((place, file)) = {
            let place = next.fetch_add(1, Ordering::Relaxed);
            files.get(place).map(|file| (place, file))
        } {
            let result = work(file);
            results.lock().unwrap_or_else(PoisonError::into_inner).push((place, result));
        }
    };
    let count = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| (0..count.min(files.len())).for_each(|_| drop(scope.spawn(worker))));
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_by_key(|(place, _)| *place);
    results.into_iter().map(|(_, result)| result).collect()
}

/// The recordings of a folder and of those in it.
fn find(folder: &Path, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let (path, kind) = (entry.path(), entry.file_type()?);
        if kind.is_dir() {
            find(&path, files)?;
        } else if path
            .extension()
            .is_some_and(|ending| ENDINGS.iter().any(|known| ending.eq_ignore_ascii_case(known)))
        {
            files.push(path);
        }
    }
    Ok(())
}

/// The whole lines that an earlier run has left, by file and SHA-256; none where that was made by
/// another program or with other options.
fn lines_of(part: &Path, made_by: &str) -> BTreeMap<(String, String), Line> {
    let content = fs::read_to_string(part).unwrap_or_default();
    // What stands behind the last end of a line was being written.
    let whole = content.rsplit_once('\n').map_or("", |(whole, _)| whole);
    let Some(whole) = whole.strip_prefix(made_by).and_then(|rest| rest.strip_prefix('\n')) else {
        return BTreeMap::new();
    };
    let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(whole.as_bytes());
    if reader.headers().map_or(true, |found| found.iter().ne(HEADER)) {
        return BTreeMap::new();
    }
    let lines = reader.records().filter_map(Result::ok).filter(|line| line.len() == HEADER.len());
    let lines = lines.map(|line| line.iter().map(str::to_owned).collect::<Line>());
    lines.map(|line| ((line[0].clone(), line[1].clone()), line)).collect()
}

/// The line of a file, and whether an earlier run has made it.
fn line_of(path: &Path, choice: &Choice, kept: &BTreeMap<(String, String), Line>) -> (Line, bool) {
    let name = path.display().to_string();
    let table = choice.table(path);
    let sha256 = table.as_ref().map_or_else(|_| String::new(), |table| table.sha256().to_owned());
    if let Some(line) = kept.get(&(name.clone(), sha256.clone())).filter(|_| !sha256.is_empty()) {
        return (line.clone(), true);
    }
    let found = table.map_err(Error::from).and_then(|table| {
        // A defect of ours in one file is no reason to lose the others.
        let work = AssertUnwindSafe(|| diagnosed(path, &table, choice));
        catch_unwind(work).unwrap_or_else(|_| {
            Err(Error::Usage(format!("{name}: the diagnosis broke off; please report it")))
        })
    });
    let mut line = vec![name, sha256];
    match found {
        Ok(found) => line.extend(fields(&found)),
        Err(error) => line.push(error.to_string()),
    }
    line.resize(HEADER.len(), String::new());
    (line, false)
}

fn diagnosed(path: &Path, table: &Table, choice: &Choice) -> Result<Diagnosed, Error> {
    let examined = Examined::of(table, choice)?;
    examined
        .diagnosed(None, None, &|_, _| ())
        .map_err(|error| Error::Usage(format!("{}: {error}", path.display())))
}

/// The fields behind file and SHA-256.
fn fields(found: &Diagnosed) -> impl Iterator<Item = String> {
    let Diagnosed { diagnosis, gain, written, examined, .. } = found;
    let recording = &examined.recording;
    let names = |causes: &mut dyn Iterator<Item = Cause>| {
        causes.map(|cause| cause.name()).collect::<Vec<_>>().join(" + ")
    };
    let rivals: Vec<String> =
        diagnosis.alternatives.iter().map(|set| names(&mut set.iter().copied())).collect();
    [
        String::new(),
        recording.drive.time_s.len().to_string(),
        recording.drive.input.channel.name.clone(),
        recording.output.channel.name.clone(),
        recording.output.channel.unit.to_string(),
        recording.stroke().to_string(),
        diagnosis.verdict.name().to_owned(),
        names(&mut diagnosis.causes.iter().map(|Named { cause, .. }| *cause)),
        rivals.join(" | "),
        written.plain_rmse.to_string(),
        written.rmse.to_string(),
        written.gain.before.rmse.to_string(),
        written.gain.after.rmse.to_string(),
        gain.noise_floor.to_string(),
        written.model.form(),
    ]
    .into_iter()
}

/// Lines as text.
fn text<'a>(lines: impl IntoIterator<Item = &'a Line>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for line in lines {
        // Nothing that is in memory refuses a line.
        let _ = writer.write_record(line);
    }
    String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
}
