//! Frames into answers: `rmodbus` reads and writes them, this says what registers hold and take.

use heapless::Vec;
use rmodbus::consts::ModbusFunction;
use rmodbus::server::{ModbusFrame, Read, Write};
use rmodbus::{ErrorKind, ModbusProto};
use wire::registers::{Exception, FRAME_BYTES, UNIT};

use super::read::read;
use super::session::Session;
use super::write::{Words, write};
use crate::node::Node;

/// Carries out a frame whose CRC fits, and fills in the response; an empty one is not sent.
pub fn answer(
    session: &mut Session,
    bytes: &[u8],
    node: &mut impl Node,
    response: &mut Vec<u8, FRAME_BYTES>,
) {
    // These are the functions of exceptions, which no request has.
    if bytes.get(1).is_some_and(|function| *function >= 0x80) {
        return;
    }
    let mut frame = ModbusFrame::new(UNIT, bytes, ModbusProto::Rtu, response);
    let is_read = frame.parse().is_ok();
    if !is_read || !frame.processing_required && !frame.response_required {
        return;
    }
    session.frames = session.frames.wrapping_add(1);
    node.control(|control| control.hear());
    let is_answered = if frame.processing_required {
        let done = process(session, &mut frame, node).map_err(error_kind);
        if frame.readonly { frame.process_external_read(done) } else { frame.process_external_write(done) }
    } else {
        Ok(())
    };
    session.refused = session.refused.wrapping_add(u32::from(frame.error.is_some()));
    let (is_wanted, is_answered) = (frame.response_required, is_answered.is_ok());
    if !is_wanted || !is_answered || frame.finalize_response().is_err() {
        response.clear();
    }
}

fn process(
    session: &mut Session,
    frame: &mut ModbusFrame<'_, Vec<u8, FRAME_BYTES>>,
    node: &mut impl Node,
) -> Result<(), Exception> {
    match frame.func {
        ModbusFunction::GetHoldings | ModbusFunction::GetInputs if frame.count > 0 => {
            match frame.get_external_read() {
                Ok(Read::Words(words)) => read(session, words.address, words.buf, node),
                _ => Err(Exception::DeviceFailure),
            }
        }
        ModbusFunction::SetHolding | ModbusFunction::SetHoldingsBulk => match frame.get_external_write() {
            Ok(Write::Words(words)) if words.data.len() == 2 * usize::from(words.count) => {
                write(session, &Words::of_bytes(words.address, words.data)?, node)
            }
            _ => Err(Exception::IllegalValue),
        },
        ModbusFunction::GetHoldings | ModbusFunction::GetInputs => Err(Exception::IllegalValue),
        _ => Err(Exception::IllegalFunction),
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
