//! What a recording shows of time and noise, for the model files that are made from it.

use diagnosis::Columns;
use recording::model_file::ModelFile;
use recording::model_file::control::Recorded;

/// Of all columns that a diagnosis looks at. None, with a note, where the model does not run
/// through them.
pub fn of_columns(model: &ModelFile, columns: &Columns) -> Option<Recorded> {
    let say = |why: &_| eprintln!("note: nothing is said of times for the control: {why}");
    columns.recorded(model).inspect_err(say).ok()
}
