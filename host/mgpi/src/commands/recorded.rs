//! What a recording shows of time and noise, for the model files that are made from it.

use diagnosis::Columns;
use recording::model_file::ModelFile;
use recording::model_file::control::Recorded;
use recording::simulation::Rows;
use tuning::lateness::{self, recorded};

/// Of all columns that a diagnosis looks at. None, with a note, where the model does not run
/// through them.
pub fn of_columns(model: &ModelFile, columns: &Columns) -> Option<Recorded> {
    said(recorded(
        model,
        &lateness::Recording {
            rows: Rows {
                time_s: &columns.time_s,
                input: &columns.input,
                load: columns.load_n.as_deref(),
                temperature: columns.temperature_c.as_deref(),
            },
            scored: &columns.scored,
            output: &columns.output,
            command: columns.command.as_deref(),
        },
    ))
}

fn said(found: Result<Recorded, lateness::NotSimulated>) -> Option<Recorded> {
    found.inspect_err(|why| eprintln!("note: nothing is said of times for the control: {why}")).ok()
}
