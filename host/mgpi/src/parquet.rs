//! Tables that are written as Parquet, where the output's name ends so.

use std::io::{self, Write};
use std::path::Path;

use import::Values;
use recording::table::outline::Sink;

use crate::Error;
use crate::output::Outputs;

/// Whether an output is to be Parquet.
pub fn is_parquet(output: &Path) -> bool {
    output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("parquet"))
}

/// Stages the columns as Parquet.
///
/// # Errors
/// The file cannot be written, or this program was built without the feature.
pub fn stage(outputs: &mut Outputs, output: &Path, columns: &[(&str, Values)]) -> Result<(), Error> {
    outputs.stage_by(output, |target| write(target, columns))?;
    Ok(())
}

#[cfg(feature = "parquet")]
fn write(target: &mut (dyn Write + Send), columns: &[(&str, Values)]) -> io::Result<()> {
    import::to_parquet::write(target, columns)
}

/// Writes columns of numbers with these names, of which `blocks` gives some rows at a time.
///
/// # Errors
/// The file cannot be written, or this program was built without the feature.
#[cfg(feature = "parquet")]
pub fn write_blocks(
    target: &mut (dyn Write + Send),
    names: &[String],
    blocks: impl FnOnce(&mut Sink) -> io::Result<()>,
) -> io::Result<()> {
    let columns: Vec<(&str, Values)> =
        names.iter().map(|name| (name.as_str(), Values::Numbers(&[]))).collect();
    let mut writer = import::to_parquet::Writer::new(target, &columns)?;
    blocks(&mut |columns| {
        let columns: Vec<Values> = columns.iter().map(|numbers| Values::Numbers(numbers)).collect();
        writer.group(&columns)
    })?;
    writer.close()
}

#[cfg(not(feature = "parquet"))]
fn write(_: &mut (dyn Write + Send), _: &[(&str, Values)]) -> io::Result<()> {
    Err(not_built())
}

/// That this program was built without Parquet.
#[cfg(not(feature = "parquet"))]
pub fn write_blocks(
    _: &mut (dyn Write + Send),
    _: &[String],
    _: impl FnOnce(&mut Sink) -> io::Result<()>,
) -> io::Result<()> {
    Err(not_built())
}

#[cfg(not(feature = "parquet"))]
fn not_built() -> io::Error {
    io::Error::other(import::Problem::NotBuilt("Parquet", "parquet"))
}
