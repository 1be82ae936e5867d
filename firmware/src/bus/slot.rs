//! A member's part of the exchange in slots ([`wire::slots`]): what it is told counts until a tick
//! of its own and by its sequence; what it answers waits for its slot.

use heapless::Vec;
use wire::registers::{FRAME_BYTES, Id, Value};
use wire::slots::{Answer, FUNCTION, LEAST_GAP_US, Member, Outcome, Request, Said, Slots};

use super::receiver::BROADCAST;
use super::session::Session;
use super::write;
use crate::node::Node;

/// When an answer is sent behind its request.
#[derive(Clone, Copy, Debug)]
pub struct Slot {
    /// From the end of the request. Unit: µs.
    pub begin_us: u32,
    /// Behind the slot. Unit: µs.
    pub gap_us: u32,
}

/// Whether a frame is a member's answer, which no other board has anything to do with.
pub fn is_answer(frame: &[u8]) -> bool {
    matches!(frame, [unit, FUNCTION, ..] if *unit != BROADCAST)
}

/// Carries out what a request tells this board, and fills in its answer; nothing for a board that
/// is no member, or has been told to wait longer than the gap.
// Not inlined: what it needs of the stack is not needed by other requests.
#[inline(never)]
pub fn answer(
    session: &mut Session,
    frame: &[u8],
    node: &mut impl Node,
    response: &mut Vec<u8, FRAME_BYTES>,
) -> Option<Slot> {
    let request = Request::of_frame(frame)?;
    let bus = *session.listening.in_use();
    let (place, member) = request.of_unit(bus.unit)?;
    if request.gap_us < LEAST_GAP_US || u32::from(request.gap_us) < bus.turnaround_us {
        return None;
    }
    session.frames = session.frames.wrapping_add(1);
    let outcome = take(session, &member, request.sequence, node);
    let is_refused = !matches!(outcome, Outcome::Asked | Outcome::Taken);
    session.refused = session.refused.wrapping_add(u32::from(is_refused));
    let (telemetry, outputs) = node.control(|control| (control.telemetry(), control.outputs()));
    let answer = Answer {
        unit: bus.unit,
        sequence: request.sequence,
        outcome,
        state: telemetry.state,
        fault: telemetry.fault.map_or(0, |fault| fault.code()),
        ticks: telemetry.ticks,
        pressure_bar: telemetry.signals.pressure_bar,
        contraction_mm: telemetry.signals.contraction_mm,
        reference_mm: outputs.reference_mm,
        command_bar: outputs.command_bar,
        supply_bar: telemetry.signals.supply_bar,
        temperature_c: telemetry.signals.temperature_c,
        worst_tick_cycles: telemetry.worst_tick_cycles,
    };
    *response = answer.frame()?;
    let slots = Slots::new(&bus, request.gap_us);
    Some(Slot { begin_us: slots.begin_us(place), gap_us: request.gap_us.into() })
}

/// Takes what the board is told, if nothing speaks against it; else nothing has changed.
fn take(session: &mut Session, member: &Member, sequence: u16, node: &mut impl Node) -> Outcome {
    let mm = match member.said {
        Said::Nothing => return Outcome::Asked,
        Said::Lives => None,
        Said::SetPoint(mm) => Some(mm),
    };
    let (now, last) = node.control(|control| (control.ticks(), control.heartbeat));
    if let Some(outcome) = Outcome::against(member.until, now, sequence, last) {
        return outcome;
    }
    let set_point = mm.map(|mm| (Id::SetpointMm, Value::F32(mm)));
    let said = set_point.into_iter().chain([(Id::Heartbeat, Value::U16(sequence))]);
    if write::say(session, said, node).is_err() { Outcome::Refused } else { Outcome::Taken }
}
