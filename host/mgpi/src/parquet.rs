//! Tables that are written as Parquet, where the output's name ends so.

use std::io::Write;
use std::path::Path;

use import::Values;

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
fn write(target: &mut (dyn Write + Send), columns: &[(&str, Values)]) -> std::io::Result<()> {
    import::to_parquet::write(target, columns)
}

#[cfg(not(feature = "parquet"))]
fn write(_: &mut (dyn Write + Send), _: &[(&str, Values)]) -> std::io::Result<()> {
    Err(std::io::Error::other(import::Problem::NotBuilt("Parquet", "parquet")))
}
