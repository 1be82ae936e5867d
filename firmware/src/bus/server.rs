//! Frames into answers: `rmodbus` reads and writes them, this says what registers hold and take.

use heapless::{String, Vec};
use model_core::Mode;
use rmodbus::consts::ModbusFunction;
use rmodbus::server::{ModbusFrame, Read, Write};
use rmodbus::{ErrorKind, ModbusProto};
use wire::Refusal;
use wire::registers::{Command, Exception, FRAME_BYTES, UNIT, UploadResult};

use super::read::read;
use super::upload::Upload;
use super::write::{Words, write};
use crate::node::Node;
use crate::order::text;

/// What the bus knows beside the control.
#[derive(Debug)]
pub struct Server {
    /// The last command that was taken.
    pub(super) command: Command,
    /// That of the next start.
    pub(super) mode: Mode,
    pub(super) capture_from: u32,
    pub(super) upload: Upload,
    pub(super) result: UploadResult,
    /// Why a request was refused, where there is more to say than by the exception.
    pub(super) message: String<100>,
    pub(super) frames: u32,
    pub(super) refused: u32,
    /// As the receiver has counted.
    pub(super) damaged: u32,
}

impl Server {
    /// One that has heard nothing.
    pub const fn new() -> Self {
        Self {
            command: Command::None,
            mode: Mode::Both,
            capture_from: 0,
            upload: Upload::new(),
            result: UploadResult::None,
            message: String::new(),
            frames: 0,
            refused: 0,
            damaged: 0,
        }
    }

    /// Carries out a frame whose CRC fits, and fills in the response; an empty one is not sent.
    pub fn answer(&mut self, bytes: &[u8], node: &mut impl Node, response: &mut Vec<u8, FRAME_BYTES>) {
        // These are the functions of exceptions, which no request has.
        if bytes.get(1).is_some_and(|function| *function >= 0x80) {
            return;
        }
        let mut frame = ModbusFrame::new(UNIT, bytes, ModbusProto::Rtu, response);
        let is_read = frame.parse().is_ok();
        if !is_read || !frame.processing_required && !frame.response_required {
            return;
        }
        self.frames = self.frames.wrapping_add(1);
        node.control(|control| control.hear());
        let is_answered = if frame.processing_required {
            let done = self.process(&mut frame, node).map_err(error_kind);
            if frame.readonly {
                frame.process_external_read(done)
            } else {
                frame.process_external_write(done)
            }
        } else {
            Ok(())
        };
        self.refused = self.refused.wrapping_add(u32::from(frame.error.is_some()));
        let (is_wanted, is_answered) = (frame.response_required, is_answered.is_ok());
        if !is_wanted || !is_answered || frame.finalize_response().is_err() {
            response.clear();
        }
    }

    fn process(
        &mut self,
        frame: &mut ModbusFrame<'_, Vec<u8, FRAME_BYTES>>,
        node: &mut impl Node,
    ) -> Result<(), Exception> {
        match frame.func {
            ModbusFunction::GetHoldings | ModbusFunction::GetInputs if frame.count > 0 => {
                match frame.get_external_read() {
                    Ok(Read::Words(words)) => read(self, words.address, words.buf, node),
                    _ => Err(Exception::DeviceFailure),
                }
            }
            ModbusFunction::SetHolding | ModbusFunction::SetHoldingsBulk => {
                match frame.get_external_write() {
                    Ok(Write::Words(words)) if words.data.len() == 2 * usize::from(words.count) => {
                        write(self, &Words::of_bytes(words.address, words.data)?, node)
                    }
                    _ => Err(Exception::IllegalValue),
                }
            }
            ModbusFunction::GetHoldings | ModbusFunction::GetInputs => Err(Exception::IllegalValue),
            _ => Err(Exception::IllegalFunction),
        }
    }

    /// The exception for a refusal; keeps its words.
    pub(super) fn refuse(&mut self, refusal: Refusal) -> Exception {
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
            Refusal::Unreadable | Refusal::NotHere => Exception::DeviceFailure,
        }
    }
}

impl Default for Server {
    fn default() -> Self {
        Self::new()
    }
}

/// What `rmodbus` calls an exception.
fn error_kind(exception: Exception) -> ErrorKind {
    match exception {
        Exception::IllegalFunction => ErrorKind::IllegalFunction,
        Exception::IllegalAddress => ErrorKind::IllegalDataAddress,
        Exception::IllegalValue => ErrorKind::IllegalDataValue,
        Exception::DeviceFailure => ErrorKind::SlaveDeviceFailure,
        Exception::DeviceBusy => ErrorKind::SlaveDeviceBusy,
    }
}
