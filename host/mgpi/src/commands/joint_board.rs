//! What the commands for a joint's board have in common.

use std::path::{Path, PathBuf};

use board_client::joint::error::JointBoardError;
use board_client::joint::link::{Address, JointLink};
use board_client::joint::settings;
use clap::Args;
use wire::joint::JointSettings;

use crate::Error;

/// What the board of a joint is found and given with.
#[derive(Args, Debug)]
#[group(skip)]
#[command(next_help_heading = "Joint")]
pub struct BoardArguments {
    #[command(flatten)]
    fault: FaultArguments,
    /// Limits and calibration that the board of a joint is given
    #[arg(long, value_name = "SETTINGS.toml", requires = "joint")]
    settings: Option<PathBuf>,
}

/// What is done about a fault that the board of a joint is found at.
#[derive(Args, Debug)]
#[group(skip)]
#[command(next_help_heading = "Joint")]
pub struct FaultArguments {
    /// Take a fault of the board of a joint for seen to
    #[arg(long, requires = "joint")]
    acknowledge: bool,
}

impl BoardArguments {
    /// The file of the settings.
    pub fn file(&self) -> Option<&Path> {
        self.settings.as_deref()
    }

    /// Reads the settings, if there are any.
    ///
    /// # Errors
    /// The file is not what it should be.
    pub fn settings(&self) -> Result<Option<JointSettings>, Error> {
        Ok(self.file().map(settings::read).transpose()?)
    }

    /// Opens the link of a board that rests, and is at no fault.
    ///
    /// # Errors
    /// As for [`JointLink::open`].
    pub fn open(&self, address: &Address) -> Result<JointLink, JointBoardError> {
        self.fault.open(address)
    }
}

impl FaultArguments {
    /// Opens the link of a board that rests, and is at no fault.
    ///
    /// # Errors
    /// As for [`JointLink::open`].
    pub fn open(&self, address: &Address) -> Result<JointLink, JointBoardError> {
        JointLink::open(address.clone(), self.acknowledge)
    }
}

/// Says that a board has not kept what it was given, where that ends nothing.
pub fn note_unkept(link: &JointLink) {
    if !link.has_kept() {
        eprintln!("note: {}", JointBoardError::NotStored);
    }
}
