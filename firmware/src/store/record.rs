//! A record: sequence number, layout, set; in postcard's encoding.
//!
//! # Layouts
//! | layout | set |
//! |---|---|
//! | 2, 3, 4, 5 | [`super::previous`] |
//! | 6 | [`Parameters`] |
//!
//! A change of [`Parameters`], or of anything in it, is a new layout: [`LAYOUT`] is raised, and the
//! struct as it was joins those before it.

use serde::de::DeserializeOwned;

use super::LoadError;
use super::parameters::Parameters;
use super::previous::{self, Ratiometric, Unobserved, Unsealed, WithoutBus};

/// Number of the layout that is written.
pub const LAYOUT: u16 = 6;

/// The longest record: model and gains fit in a frame of the bus, the limits of the plant in 96
/// bytes, the bus's parameters in 12, a calibration with the inputs in 87. Unit: byte, a multiple
/// of the flash's word.
pub const RECORD_BYTES: usize = (wire::FRAME_BYTES + 204).next_multiple_of(32);

/// A record that was read.
pub struct Record {
    /// Counts the saves; the flash does not endure as many as there are numbers.
    pub sequence: u32,
    layout: u16,
    /// The set, or why there is none.
    pub parameters: Result<Parameters, LoadError>,
}

impl Record {
    /// Whether a save of the set would change nothing.
    pub fn holds(&self, parameters: &Parameters) -> bool {
        self.layout == LAYOUT && self.parameters.as_ref() == Ok(parameters)
    }

    /// That of the record after this one.
    pub fn next_sequence(&self) -> u32 {
        self.sequence.saturating_add(1)
    }
}

/// Writes a record into the buffer; `None` if it does not fit.
pub fn encode<'a>(sequence: u32, parameters: &Parameters, buffer: &'a mut [u8]) -> Option<&'a [u8]> {
    postcard::to_slice(&(sequence, LAYOUT, parameters), buffer).ok().map(|bytes| &*bytes)
}

/// The number of a record; `None` if it has no sequence and layout.
pub fn sequence(bytes: &[u8]) -> Option<u32> {
    head(bytes).map(|(sequence, ..)| sequence)
}

/// Reads a record; `None` if it has no sequence and layout.
pub fn decode(bytes: &[u8]) -> Option<Record> {
    let (sequence, layout, set) = head(bytes)?;
    let parameters = match layout {
        LAYOUT => whole(set),
        previous::UNOBSERVED => whole::<Unobserved>(set).map(Parameters::from),
        previous::RATIOMETRIC => whole::<Ratiometric>(set).map(Parameters::from),
        previous::UNSEALED => whole::<Unsealed>(set).map(Parameters::from),
        previous::WITHOUT_BUS => whole::<WithoutBus>(set).map(Parameters::from),
        other => Err(LoadError::Layout(other)),
    };
    Some(Record { sequence, layout, parameters })
}

/// Sequence, layout, and what is behind them.
fn head(bytes: &[u8]) -> Option<(u32, u16, &[u8])> {
    postcard::take_from_bytes(bytes).ok().map(|((sequence, layout), set)| (sequence, layout, set))
}

/// The value that the bytes are, none left over.
fn whole<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, LoadError> {
    match postcard::take_from_bytes(bytes) {
        Ok((value, [])) => Ok(value),
        _ => Err(LoadError::Corrupt),
    }
}
