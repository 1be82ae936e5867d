//! What backups of both kinds of boards have in common: how one is kept, and what is said before
//! one is restored.

use std::path::Path;

use crate::Error;
use crate::output::Outputs;

/// Writes the text of a backup, unless it does not read back as what the board has.
///
/// # Errors
/// It does not, or cannot be written.
pub fn keep((output, text): (&Path, &str), reads_back: bool, mut outputs: Outputs) -> Result<(), Error> {
    if !reads_back {
        return Err(Error::Usage(format!(
            "{}: the board has a configuration that no file of this version can hold",
            output.display()
        )));
    }
    outputs.stage(output, text.as_bytes())?;
    Ok(outputs.commit()?)
}

/// Says what differs of a file; whether it is to be restored.
pub fn is_to_be_done(file: &Path, differences: &[String], dry_run: bool) -> bool {
    if differences.is_empty() {
        say!("the board has all of {} already", file.display());
        return false;
    }
    say!("of {} differs (board -> file)", file.display());
    differences.iter().for_each(|difference| say!("  {difference}"));
    if dry_run {
        say!("nothing has been changed (--dry-run)");
    }
    !dry_run
}
