//! The functions that `rmodbus` does not know (Modbus application protocol 1.1b3, chapter 6): what
//! each answers.
//!
//! | function | what it does |
//! |---|---|
//! | 8 | diagnostics: 0 sends its data back; 12, 13, 14 tell damaged frames, refused requests, requests for this board |
//! | 17 | the board's number, 0xFF while the valve is driven, name and release |
//! | 22 | mask write: one register of one word becomes `(it AND mask) OR (other AND NOT mask)` |
//! | 23 | writes registers, then reads registers, in one request |
//! | 43/14 | who made it, what it is, its release; by code 3 also which one it is, and its firmware's commit |

use core::fmt::Write as _;

use heapless::{String, Vec};
use wire::registers::{Exception, FRAME_BYTES, MOST_READ, Register};

use super::read::read;
use super::session::Session;
use super::write::{Audience, Words, write};
use crate::identity::{Identity, SOURCE};
use crate::node::Node;
use crate::report::FIRMWARE_VERSION;

/// Function codes.
pub const DIAGNOSTICS: u8 = 8;
pub const REPORT_SERVER_ID: u8 = 17;
pub const MASK_WRITE: u8 = 22;
pub const READ_WRITE: u8 = 23;
pub const ENCAPSULATED: u8 = 43;
/// The one kind of encapsulated request: read device identification.
pub const DEVICE_IDENTIFICATION: u8 = 14;

/// Identification: basic, regular and extended objects, as a whole or one by one.
const CONFORMITY: u8 = 0x83;
/// Objects of this board's own: the processor's number, the board's revision, the processor's line
/// and revision, the commit of the firmware's sources.
const UNIQUE_ID: u8 = 0x80;
const HARDWARE_REVISION: u8 = 0x81;
const PROCESSOR: u8 = 0x82;
const SOURCE_COMMIT: u8 = 0x83;
/// What the board is called.
const NAME: &str = "valve board";

/// Function and data of a response, behind the board's number.
type Pdu = Vec<u8, FRAME_BYTES>;

/// Whether a function is one of these.
pub const fn is_known(function: u8) -> bool {
    matches!(function, DIAGNOSTICS | REPORT_SERVER_ID | MASK_WRITE | READ_WRITE | ENCAPSULATED)
}

/// Carries a request out and puts what it is answered behind the function, which stands in `pdu`
/// already.
///
/// # Errors
/// It is refused; nothing has changed, but see [`write`].
// Not inlined: what these functions need of the stack is not needed by the others.
#[inline(never)]
pub fn carry_out(
    session: &mut Session,
    function: u8,
    data: &[u8],
    audience: Audience,
    node: &mut impl Node,
    pdu: &mut Pdu,
) -> Result<(), Exception> {
    match (function, data) {
        (DIAGNOSTICS, [high, low, of @ ..]) => {
            let count = match u16::from_be_bytes([*high, *low]) {
                0 => return append(pdu, data),
                12 => session.damaged,
                13 => session.refused,
                14 => session.frames,
                _ => return Err(Exception::IllegalFunction),
            };
            if of != [0, 0] {
                return Err(Exception::IllegalValue);
            }
            append(pdu, &[*high, *low])?;
            append(pdu, &(count as u16).to_be_bytes())
        }
        (REPORT_SERVER_ID, []) => {
            let is_driven = node.control(|control| control.state().is_driven());
            let text = named();
            append(pdu, &[2 + text.len() as u8, session.unit(), if is_driven { 0xFF } else { 0 }])?;
            append(pdu, text.as_bytes())
        }
        (MASK_WRITE, &[high, low, and_high, and_low, or_high, or_low]) => {
            let address = u16::from_be_bytes([high, low]);
            let [and, or] = [[and_high, and_low], [or_high, or_low]].map(u16::from_be_bytes);
            let register = Register::at(address).ok_or(Exception::IllegalAddress)?;
            if register.kind.words() != 1 {
                return Err(Exception::IllegalValue);
            }
            let mut word = [0; 2];
            read(session, address, &mut word, node)?;
            let masked = u16::from_be_bytes(word) & and | or & !and;
            write(session, &Words::of_bytes(address, &masked.to_be_bytes())?, audience, node)?;
            append(pdu, data)
        }
        (
            READ_WRITE,
            &[from_high, from_low, read_high, read_low, to_high, to_low, high, low, bytes, ref written @ ..],
        ) => {
            let [from, count, to, written_count] =
                [[from_high, from_low], [read_high, read_low], [to_high, to_low], [high, low]]
                    .map(u16::from_be_bytes);
            let is_whole =
                written.len() == usize::from(bytes) && written.len() == 2 * usize::from(written_count);
            if !is_whole || !(1..=MOST_READ).contains(&count) {
                return Err(Exception::IllegalValue);
            }
            // Before anything is written.
            let exists =
                |offset| from.checked_add(offset).is_some_and(|address| Register::at(address).is_some());
            if !(0..count).all(exists) {
                return Err(Exception::IllegalAddress);
            }
            write(session, &Words::of_bytes(to, written)?, audience, node)?;
            append(pdu, &[2 * count as u8])?;
            let begin = pdu.len();
            pdu.resize(begin + 2 * usize::from(count), 0).map_err(|_| Exception::DeviceFailure)?;
            read(session, from, pdu.get_mut(begin..).unwrap_or_default(), node)
        }
        (ENCAPSULATED, &[DEVICE_IDENTIFICATION, code, object]) => {
            identify(node.identity(), code, object, pdu)
        }
        (ENCAPSULATED, [kind, ..]) if *kind != DEVICE_IDENTIFICATION => Err(Exception::IllegalFunction),
        _ => Err(Exception::IllegalValue),
    }
}

/// Read device identification: from an object on, by code 1 of the basic ones, 2 of the regular
/// ones too, 3 of all; by code 4 one of them.
fn identify(identity: &Identity, code: u8, object: u8, pdu: &mut Pdu) -> Result<(), Exception> {
    let release = release();
    let [unique_id, revision, processor] = [
        in_digits(&identity.unique_id),
        in_digits(&[identity.hardware_revision]),
        in_digits(&[(identity.processor >> 16) as u16, identity.processor as u16]),
    ];
    let mut commit = in_digits(&SOURCE.commit);
    if SOURCE.is_modified {
        // There is room.
        let _ = commit.push('+');
    }
    let objects = [
        (0, "mgpi"),
        (1, "mgpi-valve-board"),
        (2, &*release),
        (4, NAME),
        (5, "STM32F405"),
        (UNIQUE_ID, &*unique_id),
        (HARDWARE_REVISION, &*revision),
        (PROCESSOR, &*processor),
        (SOURCE_COMMIT, &*commit),
    ];
    let is_known = objects.iter().any(|(id, _)| *id == object);
    let from = if is_known { object } else { 0 };
    let range = match code {
        1 => from..=2,
        2 => from..=0x7F,
        3 => from..=0xFF,
        4 if is_known => object..=object,
        4 => return Err(Exception::IllegalAddress),
        _ => return Err(Exception::IllegalValue),
    };
    let chosen = objects.iter().filter(|(id, _)| range.contains(id));
    // All fit into one frame: nothing follows.
    append(pdu, &[DEVICE_IDENTIFICATION, code, CONFORMITY, 0, 0, chosen.clone().count() as u8])?;
    for (id, text) in chosen {
        append(pdu, &[*id, text.len() as u8])?;
        append(pdu, text.as_bytes())?;
    }
    Ok(())
}

/// Words by their hexadecimal digits.
fn in_digits(words: &[u16]) -> String<41> {
    let mut text = String::new();
    for word in words {
        // Ten words, the most there are, fit.
        let _ = write!(text, "{word:04x}");
    }
    text
}

/// The release, as `0.1.0`.
fn release() -> String<20> {
    let [major, minor, patch] = FIRMWARE_VERSION;
    let mut text = String::new();
    // Three numbers of at most five digits fit.
    let _ = write!(text, "{major}.{minor}.{patch}");
    text
}

/// Name and release.
fn named() -> String<40> {
    let mut text = String::new();
    // Both fit.
    let _ = write!(text, "{NAME} {}", release());
    text
}

fn append(pdu: &mut Pdu, bytes: &[u8]) -> Result<(), Exception> {
    pdu.extend_from_slice(bytes).map_err(|_| Exception::DeviceFailure)
}
