//! A record: sequence number, layout, set; in postcard's encoding.

use super::LoadError;
use super::set::Set;

/// The longest record: model and gains, of a muscle or a joint, fit in a frame, the limits of the
/// plant in 96 bytes, the bus's parameters in 12, a calibration with the inputs in 87. Unit: byte,
/// a multiple of the flash's word.
pub const RECORD_BYTES: usize = (wire::FRAME_BYTES + 204).next_multiple_of(32);

/// A record that was read.
pub struct Record<P> {
    /// Counts the saves; the flash does not endure as many as there are numbers.
    pub sequence: u32,
    layout: u16,
    /// The set, or why there is none.
    pub parameters: Result<P, LoadError>,
}

impl<P: Set> Record<P> {
    /// Whether a save of the set would change nothing.
    pub fn holds(&self, parameters: &P) -> bool {
        self.layout == P::LAYOUT && self.parameters.as_ref() == Ok(parameters)
    }

    /// That of the record after this one.
    pub fn next_sequence(&self) -> u32 {
        self.sequence.saturating_add(1)
    }
}

/// Writes a record into the buffer; `None` if it does not fit.
pub fn encode<'a, P: Set>(sequence: u32, parameters: &P, buffer: &'a mut [u8]) -> Option<&'a [u8]> {
    postcard::to_slice(&(sequence, P::LAYOUT, parameters), buffer).ok().map(|bytes| &*bytes)
}

/// The number of a record; `None` if it has no sequence and layout.
pub fn sequence(bytes: &[u8]) -> Option<u32> {
    head(bytes).map(|(sequence, ..)| sequence)
}

/// Reads a record; `None` if it has no sequence and layout.
pub fn decode<P: Set>(bytes: &[u8]) -> Option<Record<P>> {
    let (sequence, layout, set) = head(bytes)?;
    Some(Record { sequence, layout, parameters: P::of_layout(layout, set) })
}

/// Sequence, layout, and what is behind them.
fn head(bytes: &[u8]) -> Option<(u32, u16, &[u8])> {
    postcard::take_from_bytes(bytes).ok().map(|((sequence, layout), set)| (sequence, layout, set))
}
