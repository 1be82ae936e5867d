//! The exchange in slots: one frame tells all members of a line what each is asked for, and each
//! answers behind it in its own slot.
//!
//! # Frames
//! Modbus RTU's: a number, a function ([`FUNCTION`], of those that are free for users), the CRC.
//! Numbers are big-endian.
//!
//! | request, to all (number 0) | bytes |
//! |---|---|
//! | 0, function | 2 |
//! | members, 1 to [`MOST_MEMBERS`] | 1 |
//! | sequence: of all that is said in the frame | 2 |
//! | gap: before each slot (µs) | 2 |
//! | each member in the order of the slots: number, what is said ([`Said`]), the last tick of its own at which that counts, set point (mm) | 10 |
//!
//! | answer | bytes |
//! |---|---|
//! | the member's number, function | 2 |
//! | sequence of the request | 2 |
//! | what has become of what was said ([`Outcome`]), state, fault | 3 |
//! | tick | 4 |
//! | pressure (bar), contraction (mm), reference (mm), command (bar) | 16 |
//! | supply (0.001 bar), temperature (0.01 °C) | 4 |
//! | worst tick (core clock cycles) | 4 |
//!
//! # Timing contract
//! Slots begin as [`Slots::begin_us`] says, whoever is silent. All answers tell of the moment at
//! which the request ended.
//!
//! # Limits
//! Values of supply and temperature beyond ±32 bar and ±327 °C are told as these.

use heapless::Vec;

use crate::registers::{FRAME_BYTES, state, state_number};
use crate::{BusParameters, State};

/// The function's code.
pub const FUNCTION: u8 = 65;
/// Of a request without its members, CRC included. Unit: byte.
const EMPTY_BYTES: usize = 9;
/// Of a member in a request. Unit: byte.
const MEMBER_BYTES: usize = 10;
/// The most members of a request.
pub const MOST_MEMBERS: usize = (FRAME_BYTES - EMPTY_BYTES) / MEMBER_BYTES;
/// Of an answer, CRC included. Unit: byte.
pub const ANSWER_BYTES: usize = 37;
/// The shortest gap, half a tick: a tick that has to end by then delays an answer by no more. Unit:
/// µs.
pub const LEAST_GAP_US: u16 = 500;
/// How far ahead the last tick may lie at which something counts: who says more has another clock,
/// or the board has restarted since. Unit: tick.
pub const MOST_AHEAD_TICKS: u32 = 1_000;

const CRC: crc::Crc<u16> = crc::Crc::<u16>::new(&crc::CRC_16_MODBUS);

/// What a member is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Said {
    /// Nothing: it is only asked.
    Nothing,
    /// The host lives.
    Lives,
    /// The host lives, and this is the set point. Unit: mm.
    SetPoint(f32),
}

/// What has become of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Outcome {
    /// Nothing was said.
    Asked,
    /// It was taken.
    Taken,
    /// Its last tick is over.
    Late,
    /// Its last tick is too far ahead.
    Ahead,
    /// Its sequence is not newer than the last heartbeat.
    Repeated,
    /// The set point is out of limits, or the state does not take it.
    Refused,
}

impl Outcome {
    /// By their numbers.
    const ALL: [Self; 6] = [Self::Asked, Self::Taken, Self::Late, Self::Ahead, Self::Repeated, Self::Refused];

    /// Of something that counts until a tick, by its sequence; `None` if nothing speaks against it.
    pub fn against(until: u32, now: u32, sequence: u16, last: Option<u16>) -> Option<Self> {
        let left = until.wrapping_sub(now);
        let is_newer = last.is_none_or(|last| sequence.wrapping_sub(last).cast_signed() > 0);
        if left.cast_signed() < 0 {
            Some(Self::Late)
        } else if left > MOST_AHEAD_TICKS {
            Some(Self::Ahead)
        } else if !is_newer {
            Some(Self::Repeated)
        } else {
            None
        }
    }
}

/// A member in a request.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Member {
    /// Its number on the bus.
    pub unit: u8,
    /// What it is told.
    pub said: Said,
    /// The last of its own ticks at which that counts.
    pub until: u32,
}

/// A member's answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// Its number on the bus.
    pub unit: u8,
    /// That of the request: what comes late is not taken for the answer to another one.
    pub sequence: u16,
    /// What has become of what it was told.
    pub outcome: Outcome,
    /// Its state.
    pub state: State,
    /// The number of its latched fault, 0 for none.
    pub fault: u8,
    /// Ticks since its start; wraps.
    pub ticks: u32,
    /// Unit: bar.
    pub pressure_bar: f32,
    /// Unit: mm.
    pub contraction_mm: f32,
    /// Unit: mm.
    pub reference_mm: f32,
    /// Unit: bar.
    pub command_bar: f32,
    /// Unit: bar.
    pub supply_bar: f32,
    /// Unit: °C.
    pub temperature_c: f32,
    /// Unit: core clock cycle.
    pub worst_tick_cycles: u32,
}

/// When the slots behind a request begin.
#[derive(Clone, Copy, Debug)]
pub struct Slots {
    byte_bits: u32,
    baud: u32,
    gap_us: u32,
}

impl Slots {
    /// Those of a line, with this gap.
    pub const fn new(bus: &BusParameters, gap_us: u16) -> Self {
        Self {
            byte_bits: bus.byte_bits(),
            baud: if bus.baud == 0 { 1 } else { bus.baud },
            gap_us: gap_us as u32,
        }
    }

    /// How long so many bytes take. Unit: µs.
    pub const fn bytes_us(&self, bytes: usize) -> u32 {
        let bits = bytes as u64 * self.byte_bits as u64;
        (bits * 1_000_000).div_ceil(self.baud as u64) as u32
    }

    /// From the end of the request to the begin of the slot of this place, counted from 0. Unit:
    /// µs.
    pub const fn begin_us(&self, place: usize) -> u32 {
        self.gap_us + place as u32 * (self.bytes_us(ANSWER_BYTES) + self.gap_us)
    }
}

/// How long a request is by its first bytes, CRC included, once they tell it. Unit: byte.
pub fn request_bytes(bytes: &[u8]) -> Option<usize> {
    Some(EMPTY_BYTES + MEMBER_BYTES * usize::from(*bytes.get(2)?))
}

/// A request to these members; `None` where there are none, or more than fit.
pub fn request(sequence: u16, gap_us: u16, members: &[Member]) -> Option<Vec<u8, FRAME_BYTES>> {
    if !(1..=MOST_MEMBERS).contains(&members.len()) {
        return None;
    }
    let mut frame = Vec::new();
    frame.extend_from_slice(&[0, FUNCTION, members.len() as u8]).ok()?;
    frame.extend_from_slice(&sequence.to_be_bytes()).ok()?;
    frame.extend_from_slice(&gap_us.to_be_bytes()).ok()?;
    for &Member { unit, said, until } in members {
        let (kind, mm) = match said {
            Said::Nothing => (0, 0.0),
            Said::Lives => (1, 0.0),
            Said::SetPoint(mm) => (2, mm),
        };
        frame.extend_from_slice(&[unit, kind]).ok()?;
        frame.extend_from_slice(&until.to_be_bytes()).ok()?;
        frame.extend_from_slice(&mm.to_be_bytes()).ok()?;
    }
    closed(frame)
}

/// A request of somebody else, as it came.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// Of all that is said in it.
    pub sequence: u16,
    /// Before each slot. Unit: µs.
    pub gap_us: u16,
    members: &'a [[u8; MEMBER_BYTES]],
}

impl<'a> Request<'a> {
    /// The request in a frame whose CRC fits; `None` if the frame is no request.
    pub fn of_frame(frame: &'a [u8]) -> Option<Self> {
        let &[0, FUNCTION, count, high, low, gap_high, gap_low, ref members @ .., _, _] = frame else {
            return None;
        };
        let (members, rest) = members.as_chunks();
        (members.len() == usize::from(count) && rest.is_empty()).then_some(Self {
            sequence: u16::from_be_bytes([high, low]),
            gap_us: u16::from_be_bytes([gap_high, gap_low]),
            members,
        })
    }

    /// The place of a board and what it is told; what is said in a way that is not known is
    /// nothing. `None` for a board that is no member.
    pub fn of_unit(&self, unit: u8) -> Option<(usize, Member)> {
        let place = self.members.iter().position(|member| member.first() == Some(&unit))?;
        let &[unit, kind, a, b, c, d, e, f, g, h] = self.members.get(place)?;
        let said = match kind {
            1 => Said::Lives,
            2 => Said::SetPoint(f32::from_be_bytes([e, f, g, h])),
            _ => Said::Nothing,
        };
        Some((place, Member { unit, said, until: u32::from_be_bytes([a, b, c, d]) }))
    }
}

impl Answer {
    /// Its frame.
    pub fn frame(&self) -> Option<Vec<u8, FRAME_BYTES>> {
        let mut frame = Vec::new();
        let state = state_number(self.state) as u8;
        frame.extend_from_slice(&[self.unit, FUNCTION]).ok()?;
        frame.extend_from_slice(&self.sequence.to_be_bytes()).ok()?;
        frame.extend_from_slice(&[self.outcome as u8, state, self.fault]).ok()?;
        frame.extend_from_slice(&self.ticks.to_be_bytes()).ok()?;
        for value in [self.pressure_bar, self.contraction_mm, self.reference_mm, self.command_bar] {
            frame.extend_from_slice(&value.to_be_bytes()).ok()?;
        }
        for value in [1e3 * self.supply_bar, 1e2 * self.temperature_c] {
            // Rounded; a conversion ends at the limits.
            let rounded = (value + if value < 0.0 { -0.5 } else { 0.5 }) as i16;
            frame.extend_from_slice(&rounded.to_be_bytes()).ok()?;
        }
        frame.extend_from_slice(&self.worst_tick_cycles.to_be_bytes()).ok()?;
        closed(frame)
    }

    /// That of a frame; `None` if it is none, or damaged.
    pub fn of_frame(frame: &[u8]) -> Option<Self> {
        let (content, crc) = frame.split_last_chunk()?;
        if frame.len() != ANSWER_BYTES || CRC.checksum(content) != u16::from_le_bytes(*crc) {
            return None;
        }
        let &[unit, FUNCTION, high, low, outcome, state_number, fault, ref numbers @ ..] = content else {
            return None;
        };
        let (words, rest) = numbers.as_chunks::<4>();
        let &[ticks, pressure, contraction, reference, command, [a, b, c, d], worst] = words else {
            return None;
        };
        (unit != 0 && rest.is_empty()).then_some(Self {
            unit,
            sequence: u16::from_be_bytes([high, low]),
            outcome: *Outcome::ALL.get(usize::from(outcome))?,
            state: state(state_number.into())?,
            fault,
            ticks: u32::from_be_bytes(ticks),
            pressure_bar: f32::from_be_bytes(pressure),
            contraction_mm: f32::from_be_bytes(contraction),
            reference_mm: f32::from_be_bytes(reference),
            command_bar: f32::from_be_bytes(command),
            supply_bar: 1e-3 * f32::from(i16::from_be_bytes([a, b])),
            temperature_c: 1e-2 * f32::from(i16::from_be_bytes([c, d])),
            worst_tick_cycles: u32::from_be_bytes(worst),
        })
    }
}

/// A frame with its CRC.
fn closed(mut frame: Vec<u8, FRAME_BYTES>) -> Option<Vec<u8, FRAME_BYTES>> {
    let crc = CRC.checksum(&frame);
    frame.extend_from_slice(&crc.to_le_bytes()).ok()?;
    Some(frame)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn member(unit: u8, said: Said) -> Member {
        Member { unit, said, until: 0x0102_0304 }
    }

    #[test]
    fn a_request_is_read_as_it_was_written_and_no_board_but_its_members_is_in_it() {
        let members = [member(7, Said::SetPoint(12.5)), member(9, Said::Lives), member(8, Said::Nothing)];
        let frame = request(0xFFFE, 600, &members).expect("fits");
        assert_eq!(request_bytes(&frame), Some(frame.len()));
        let read = Request::of_frame(&frame).expect("a request");
        assert_eq!((read.sequence, read.gap_us), (0xFFFE, 600));
        for (place, member) in members.into_iter().enumerate() {
            assert_eq!(read.of_unit(member.unit), Some((place, member)));
        }
        assert_eq!(read.of_unit(1), None);
        assert!(Request::of_frame(&frame[..frame.len() - 1]).is_none(), "of another length");
    }

    #[test]
    fn as_many_members_as_fit_are_taken_and_neither_more_nor_none() {
        let members = [member(1, Said::Nothing); MOST_MEMBERS + 1];
        assert!(request(1, 500, &members[..MOST_MEMBERS]).is_some_and(|frame| frame.len() <= FRAME_BYTES));
        assert!(request(1, 500, &members).is_none() && request(1, 500, &[]).is_none());
    }

    #[test]
    fn an_answer_is_read_as_it_was_written_and_a_damaged_one_is_none() {
        let answer = Answer {
            unit: 247,
            sequence: 0xFFFE,
            outcome: Outcome::Repeated,
            state: State::Tracking,
            fault: 21,
            ticks: u32::MAX,
            pressure_bar: 1.25,
            contraction_mm: -0.1,
            reference_mm: 20.0,
            command_bar: 3.5,
            supply_bar: 6.5,
            temperature_c: -12.25,
            worst_tick_cycles: 70_000,
        };
        let frame = answer.frame().expect("fits");
        assert_eq!(frame.len(), ANSWER_BYTES);
        let read = Answer::of_frame(&frame).expect("an answer");
        assert!((read.supply_bar - 6.5).abs() < 1e-3 && (read.temperature_c + 12.25).abs() < 1e-2);
        assert_eq!(Answer { supply_bar: 6.5, temperature_c: -12.25, ..read }, answer);
        for place in 0..frame.len() {
            let mut damaged = frame.clone();
            damaged[place] ^= 0x10;
            assert_eq!(Answer::of_frame(&damaged), None, "byte {place}");
        }
    }

    #[test]
    fn what_is_late_too_far_ahead_or_not_newer_is_told_across_the_wraps() {
        let against = Outcome::against;
        assert_eq!(against(100, 100, 1, None), None);
        assert_eq!(against(99, 100, 1, None), Some(Outcome::Late));
        assert_eq!(against(5, u32::MAX, 1, None), None, "the tick wraps");
        assert_eq!(against(u32::MAX, 5, 1, None), Some(Outcome::Late));
        assert_eq!(against(100 + MOST_AHEAD_TICKS, 100, 1, None), None);
        assert_eq!(against(101 + MOST_AHEAD_TICKS, 100, 1, None), Some(Outcome::Ahead));
        for (sequence, last, expected) in [
            (2, 1, None),
            (1, 1, Some(Outcome::Repeated)),
            (0, 1, Some(Outcome::Repeated)),
            (0, u16::MAX, None),
            (u16::MAX, 0, Some(Outcome::Repeated)),
        ] {
            assert_eq!(against(100, 100, sequence, Some(last)), expected, "{sequence} behind {last}");
        }
    }

    #[test]
    fn slots_follow_each_other_by_the_answer_and_the_gap() {
        let bus = BusParameters { baud: 1_000_000, ..BusParameters::STANDARD };
        let slots = Slots::new(&bus, 500);
        assert_eq!([0, 1, 2].map(|place| slots.begin_us(place)), [500, 1_370, 2_240]);
        assert_eq!(Slots::new(&BusParameters::STANDARD, 500).begin_us(1), 500 + 3_212 + 500);
    }
}
