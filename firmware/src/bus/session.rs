//! What the bus remembers from request to request, beside the control.

use heapless::String;
use model_core::Mode;
use wire::registers::{Command, Exception, UploadResult};
use wire::{Refusal, text};

use super::listening::Listening;
use super::upload::Upload;
use crate::update::Update;

/// What earlier requests have left.
#[derive(Debug)]
pub struct Session {
    /// The last command that was taken.
    pub command: Command,
    /// That of the next start.
    pub mode: Mode,
    pub capture_from: u32,
    /// By which parameters the board listens.
    pub listening: Listening,
    /// Whether those that are kept are to be taken, behind the answer.
    pub takes_line: bool,
    pub upload: Upload,
    pub result: UploadResult,
    pub update: Update,
    /// Why a request was refused, where there is more to say than by the exception.
    pub message: String<100>,
    pub frames: u32,
    pub refused: u32,
    /// As the receiver has counted.
    pub damaged: u32,
}

impl Session {
    /// The board's number.
    pub const fn unit(&self) -> u8 {
        self.listening.in_use().unit
    }

    /// One that has heard nothing.
    pub const fn new() -> Self {
        Self {
            command: Command::None,
            mode: Mode::Both,
            capture_from: 0,
            listening: Listening::new(),
            takes_line: false,
            upload: Upload::new(),
            result: UploadResult::None,
            update: Update::new(),
            message: String::new(),
            frames: 0,
            refused: 0,
            damaged: 0,
        }
    }

    /// The exception for a refusal; keeps its words.
    pub fn refuse(&mut self, refusal: Refusal) -> Exception {
        self.message.clear();
        match refusal {
            Refusal::WrongState(_) => Exception::DeviceBusy,
            Refusal::Parameter(message) => {
                self.message = message;
                Exception::IllegalValue
            }
            Refusal::Version(_) => Exception::IllegalValue,
            Refusal::NotStored => {
                self.message = text(format_args!("in use until power-off: the flash has not kept it"));
                Exception::DeviceFailure
            }
            Refusal::NotArmed => {
                self.message =
                    text(format_args!("a valve is opened in two steps: command 6 first, then this"));
                Exception::DeviceBusy
            }
            Refusal::Unreadable | Refusal::NotHere => Exception::DeviceFailure,
        }
    }
}

impl Default for Session {
    fn default() -> Self {
        Self::new()
    }
}
