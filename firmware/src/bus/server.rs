//! Frames into answers: `rmodbus` reads and writes them, this says what registers hold and take.

use heapless::Vec;
use rmodbus::consts::ModbusFunction;
use rmodbus::server::{ModbusFrame, Read, Write};
use rmodbus::{ErrorKind, ModbusProto};
use wire::registers::{Exception, FRAME_BYTES};
use wire::slots;

use super::functions;
use super::read::read;
use super::receiver::{BROADCAST, CRC};
use super::session::Session;
use super::slot::{self, Slot};
use super::write::{Audience, Words, write};
use crate::node::Node;

/// Carries out a frame whose CRC fits, and fills in the response; an empty one is not sent. Answers
/// the slot in which it is to be sent, if it is.
pub fn answer(
    session: &mut Session,
    bytes: &[u8],
    node: &mut impl Node,
    response: &mut Vec<u8, FRAME_BYTES>,
) -> Option<Slot> {
    match bytes {
        [_, slots::FUNCTION, ..] => slot::answer(session, bytes, node, response),
        _ => {
            answer_at_once(session, bytes, node, response);
            None
        }
    }
}

fn answer_at_once(
    session: &mut Session,
    bytes: &[u8],
    node: &mut impl Node,
    response: &mut Vec<u8, FRAME_BYTES>,
) {
    let &[unit, function, ref data @ .., _, _] = bytes else { return };
    // From 0x80 on they are those of exceptions, which no request has.
    if function >= 0x80 {
        return;
    }
    let audience = if unit == BROADCAST { Audience::All } else { Audience::This };
    if functions::is_known(function) {
        return answer_ourselves(session, unit, function, data, audience, node, response);
    }
    let mut frame = ModbusFrame::new(session.unit(), bytes, ModbusProto::Rtu, response);
    let is_read = frame.parse().is_ok();
    if !is_read || !frame.processing_required && !frame.response_required {
        return;
    }
    session.frames = session.frames.wrapping_add(1);
    let is_answered = if frame.processing_required {
        let done = process(session, &mut frame, audience, node).map_err(error_kind);
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
    audience: Audience,
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
                write(session, &Words::of_bytes(words.address, words.data)?, audience, node)
            }
            _ => Err(Exception::IllegalValue),
        },
        ModbusFunction::GetHoldings | ModbusFunction::GetInputs => Err(Exception::IllegalValue),
        _ => Err(Exception::IllegalFunction),
    }
}

/// Answers a request of one of our own [`functions`]. To all boards goes a mask write only: the
/// others ask for an answer.
fn answer_ourselves(
    session: &mut Session,
    unit: u8,
    function: u8,
    data: &[u8],
    audience: Audience,
    node: &mut impl Node,
    response: &mut Vec<u8, FRAME_BYTES>,
) {
    let own = session.unit();
    if unit != own && !(audience == Audience::All && function == functions::MASK_WRITE) {
        return;
    }
    session.frames = session.frames.wrapping_add(1);
    // There is room for these and for whatever follows.
    let _ = response.extend_from_slice(&[own, function]);
    if let Err(exception) = functions::carry_out(session, function, data, audience, node, response) {
        session.refused = session.refused.wrapping_add(1);
        response.clear();
        let _ = response.extend_from_slice(&[own, function | 0x80, exception.number() as u8]);
    }
    let crc = CRC.checksum(response).to_le_bytes();
    if audience == Audience::All || response.extend_from_slice(&crc).is_err() {
        response.clear();
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
