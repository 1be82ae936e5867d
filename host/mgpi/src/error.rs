//! What makes a command end with exit status 2: the errors of the modules, brought together.

use std::path::PathBuf;

use model_core::ParameterError;
use thiserror::Error;

use crate::live::LiveError;
use crate::output::OutputError;
use board_client::backup::BackupFileError;
use board_client::bring_up::BringUpError;
use board_client::bus::BoardError;
#[cfg(unix)]
use board_client::emulator::{EmulatorError, image::ImageError};
use board_client::joint::error::JointBoardError;
use board_client::joint::settings::SettingsFileError;
use board_client::part::PartError;
use board_client::pil::PilError;
use board_client::update::{PackageError, UpdateError};
use diagnosis::DiagnosisError;
use diagnosis::plan::PlanError;
use export::c::NotExported;
use export::fmu::NoUnit;
#[cfg(unix)]
use fleet::FleetError;
use gateway::lines::LinesError;
use gateway::record::RecordError;
use identification::IdentificationError;
use identification::joint::JointError;
use import::ImportError;
use network::NetworkError;
use recording::joint::file::JointFileError;
use recording::model_file::ModelFileError;
use recording::simulation::SimulationError;
use recording::table::DataError;

/// Why a command did not do its work.
#[derive(Debug, Error)]
pub enum Error {
    /// A recording, reference or log is not what it should be.
    #[error(transparent)]
    Data(#[from] DataError),
    /// A file of another program is not what it should be.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// A model file is not what it should be.
    #[error(transparent)]
    ModelFile(#[from] ModelFileError),
    /// The model file of a joint is not what it should be.
    #[error(transparent)]
    JointFile(#[from] JointFileError),
    /// No joint can be made of a recording.
    #[error("{}: {source}", file.display())]
    Joint {
        /// The recording.
        file: PathBuf,
        /// Why.
        source: JointError,
    },
    /// A model does not answer a recording.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// Parameters that no model can be made of.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// An output cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A model cannot be written in another language.
    #[error(transparent)]
    NotExported(#[from] NotExported),
    /// A model cannot be written as a unit for co-simulation.
    #[error(transparent)]
    NoUnit(#[from] NoUnit),
    /// A log does not grow.
    #[error(transparent)]
    Part(#[from] PartError),
    /// The simulated muscle does not do its work.
    #[error("{0}")]
    Rig(String),
    /// There is no firmware.
    #[cfg(unix)]
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The emulator does not do its work.
    #[cfg(unix)]
    #[error(transparent)]
    Emulator(#[from] EmulatorError),
    /// There is no fleet.
    #[cfg(unix)]
    #[error(transparent)]
    Fleet(#[from] FleetError),
    /// A run of the firmware does not come to its end.
    #[error(transparent)]
    Pil(#[from] PilError),
    /// A board of a joint does not do what it is asked for.
    #[error(transparent)]
    JointBoard(#[from] JointBoardError),
    #[error(transparent)]
    JointSettings(#[from] SettingsFileError),
    /// The file of a backup is not what it should be.
    #[error(transparent)]
    BackupFile(#[from] BackupFileError),
    /// A board on the bus does not do what it is asked for.
    #[error(transparent)]
    Board(#[from] BoardError),
    /// The file of an update is not what it should be.
    #[error(transparent)]
    Package(#[from] PackageError),
    /// A board does not take a new image.
    #[error(transparent)]
    Update(#[from] UpdateError),
    /// A new board is not tested, or has not passed.
    #[error(transparent)]
    BringUp(#[from] BringUpError),
    /// A file of lines is of no use.
    #[error(transparent)]
    Lines(#[from] LinesError),
    /// A gateway cannot be on the network.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// A gateway cannot record.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The live page cannot be served.
    #[error(transparent)]
    Live(#[from] LiveError),
    /// An excitation cannot be planned.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Options that do not go together.
    #[error("{0}")]
    Usage(String),
    /// Nothing can be said of a recording.
    #[error("{}: {source}", file.display())]
    Diagnosis {
        /// The recording.
        file: PathBuf,
        /// Why.
        source: DiagnosisError,
    },
    /// No feedback is safe for a model.
    #[error("{}: {source}", file.display())]
    Tuning {
        /// The model.
        file: PathBuf,
        /// Why.
        source: tuning::Refusal,
    },
    /// No model of a recording runs through another one.
    #[error("{}: the model does not run through the recording", .0.display())]
    NotSimulated(PathBuf),
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

impl Error {
    /// The exit status that tells a caller: 130 when the user has interrupted (128 and the signal's
    /// number), else 2.
    pub fn exit_status(&self) -> u8 {
        let is_stopped = matches!(
            self,
            Self::Pil(PilError::Stopped)
                | Self::Board(BoardError::Stopped)
                | Self::JointBoard(JointBoardError::Stopped)
                | Self::Update(UpdateError::Stopped)
                | Self::BringUp(BringUpError::Stopped)
        );
        if is_stopped { 130 } else { 2 }
    }
}
