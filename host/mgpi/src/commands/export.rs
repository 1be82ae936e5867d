//! `mgpi export`: a model for other people's programs.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::Error;
use crate::output::{OutputError, Outputs};
use export::c::sources;
use export::fmu::{Direction, Unit};
use recording::model_file::ModelFile;

/// Writes a model for other people's programs: C sources, or a unit for simulators that read FMI.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The model, from `mgpi identify`
    model: PathBuf,
    /// A folder for a header and a source of plain C99: no allocation, no library but libm
    #[arg(long, value_name = "DIR", required_unless_present = "fmu", conflicts_with = "fmu")]
    c: Option<PathBuf>,
    /// A unit of FMI 3.0 for co-simulation: the native model with all extensions, for this platform
    #[arg(long, value_name = "UNIT.fmu")]
    fmu: Option<PathBuf>,
    /// The unit answers the input that brings about a wanted output, at a period of --period-s
    #[arg(long, requires = "fmu", requires = "period_s")]
    inverse: bool,
    /// Time between samples of the inverse, s
    #[arg(long, value_name = "SECONDS", requires = "inverse")]
    period_s: Option<f64>,
    /// The library of the unit [default: the one that is built beside mgpi]
    #[arg(long, value_name = "FILE", requires = "fmu")]
    library: Option<PathBuf>,
    /// What the files, the functions and the state are called; of a unit its library
    #[arg(long, default_value = "muscle")]
    name: String,
    /// Leave out what extends the hysteresis, which C sources do not have
    #[arg(long, requires = "c")]
    operator_only: bool,
    /// Overwrite existing outputs
    #[arg(long)]
    force: bool,
}

/// Exports.
///
/// # Errors
/// The model is not what it should be, or has no such form; a file cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    match (&arguments.c, &arguments.fmu) {
        (Some(folder), _) => c(arguments, folder),
        (None, Some(unit)) => fmu(arguments, unit),
        (None, None) => Err(Error::Usage("--c or --fmu says what is written".to_owned())),
    }
}

fn c(arguments: &Arguments, folder: &Path) -> Result<(), Error> {
    let Arguments { model: file, name, operator_only, force, .. } = arguments;
    let model = ModelFile::read(file)?;
    let sources = sources(&model, name, *operator_only)?;
    let unwritable = |source| OutputError::Unwritable { path: folder.to_owned(), source };
    fs::create_dir_all(folder).map_err(unwritable)?;
    let [header, source] = ["h", "c"].map(|ending| folder.join(name).with_extension(ending));
    let mut outputs = Outputs::claim([&header, &source], &[file], *force)?;
    outputs.stage(&header, sources.header.as_bytes())?;
    outputs.stage(&source, sources.source.as_bytes())?;
    outputs.commit()?;
    say!("{} and {}: {}", header.display(), source.display(), sources.in_words());
    Ok(())
}

fn fmu(arguments: &Arguments, unit: &PathBuf) -> Result<(), Error> {
    let Arguments { model: file, inverse, period_s, library, name, force, .. } = arguments;
    let mut outputs = Outputs::claim([unit], &[file], *force)?;
    let direction = match (inverse, period_s) {
        (true, Some(period_s)) => Direction::Inverse { period_s: *period_s },
        _ => Direction::Forward,
    };
    let made = Unit::new(ModelFile::read(file)?, direction)?;
    let library = library.clone().map_or_else(beside, Ok)?;
    let code = fs::read(&library).map_err(|error| {
        Error::Usage(format!(
            "{}: the unit's library cannot be read: {error}; `cargo build --release -p fmu` builds it, --library names it",
            library.display()
        ))
    })?;
    outputs.stage(unit, &made.archive(name, &code)?)?;
    outputs.commit()?;
    let names: Vec<String> = made.variables().into_iter().map(|variable| variable.name).collect();
    say!("{}: variables {}", unit.display(), names.join(", "));
    Ok(())
}

/// The library that is built beside this program.
fn beside() -> Result<PathBuf, Error> {
    let program = std::env::current_exe().map_err(|error| {
        Error::Usage(format!("where mgpi is cannot be found: {error}; --library names the library"))
    })?;
    let name = format!("{}mgpi_fmu{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    Ok(program.with_file_name(name))
}
