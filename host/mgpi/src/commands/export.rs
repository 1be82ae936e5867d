//! `mgpi export`: a model for other people's programs.

use std::fs;
use std::path::PathBuf;

use clap::Args;

use crate::Error;
use crate::output::{OutputError, Outputs};
use export::c::sources;
use recording::model_file::ModelFile;

/// Writes a model as source code for other people's programs.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The model, from `mgpi identify`
    model: PathBuf,
    /// A folder for a header and a source of plain C99: no allocation, no library but libm
    #[arg(long, value_name = "DIR")]
    c: PathBuf,
    /// What the files, the functions and the state are called
    #[arg(long, default_value = "muscle")]
    name: String,
    /// Leave out what extends the hysteresis, which C sources do not have
    #[arg(long)]
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
    let Arguments { model: file, c: folder, name, operator_only, force } = arguments;
    let model = ModelFile::read(file)?;
    let sources = sources(&model, name, *operator_only)?;
    fs::create_dir_all(folder).map_err(|source| OutputError::Unwritable { path: folder.clone(), source })?;
    let [header, source] = ["h", "c"].map(|ending| folder.join(name).with_extension(ending));
    let mut outputs = Outputs::claim([&header, &source], &[file], *force)?;
    outputs.stage(&header, sources.header.as_bytes())?;
    outputs.stage(&source, sources.source.as_bytes())?;
    outputs.commit()?;
    say!("{} and {}: {}", header.display(), source.display(), sources.in_words());
    Ok(())
}
