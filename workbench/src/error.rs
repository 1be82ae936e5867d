//! What makes a command end with exit status 2: the errors of the modules, brought together.

use std::path::PathBuf;

use thiserror::Error;

use crate::identification::IdentificationError;
use crate::model_file::ModelFileError;
use crate::output::OutputError;
use crate::report::DrawingError;
use crate::table::DataError;

/// Why a command did not do its work.
#[derive(Debug, Error)]
pub enum Error {
    /// A recording, reference or log is not what it should be.
    #[error(transparent)]
    Data(#[from] DataError),
    /// A model file is not what it should be.
    #[error(transparent)]
    ModelFile(#[from] ModelFileError),
    /// An output cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A report cannot be drawn.
    #[error(transparent)]
    Drawing(#[from] DrawingError),
    /// No model can be made of a recording.
    #[error("{}, {columns}: {source}", file.display())]
    Identification {
        /// The recording.
        file: PathBuf,
        /// Its input and output columns.
        columns: String,
        /// Why.
        source: Box<IdentificationError>,
    },
}
