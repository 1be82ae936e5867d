//! What a write does: looked at as a whole, then carried out as a whole.
//!
//! A write stays within a group (the table leaves free addresses between them), and each group
//! turns what is written into one change that is taken or refused. So a write that is refused
//! changes nothing.

use heapless::Vec;
use model_core::Mode;
use wire::registers::{
    Access, Command, Exception, Id, Learning, MOST_WRITTEN, Register, STREAM_POINTS, StreamOrder,
    UpdateOrder, UpdateResult, UploadOrder, UploadResult, Value, fields, mode,
};
use wire::{BoardParameters, CaptureOrder, Configuration, Refusal, Request, Response, State, VERSION};

use super::session::Session;
use crate::ceilings;
use crate::node::{Node, carry_out};
use crate::order::Order;
use crate::scaling::{Scalings, VENT};
use crate::store::{Parameters, Sealed};

/// Whom a request is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Audience {
    /// This board, which answers.
    This,
    /// All boards on the bus; none answers.
    All,
}

/// What is written: words from an address on.
pub struct Words {
    address: u16,
    words: Vec<u16, { MOST_WRITTEN as usize }>,
}

/// A value for a register; in a run, for the one of this number.
#[derive(Clone, Copy, Debug)]
struct Assignment {
    id: Id,
    index: u16,
    value: Value,
}

impl Words {
    /// Of big-endian bytes.
    ///
    /// # Errors
    /// They are none, more than a write may have, or half of one is missing.
    pub fn of_bytes(address: u16, bytes: &[u8]) -> Result<Self, Exception> {
        let (pairs, rest) = bytes.as_chunks();
        let words: Vec<_, _> =
            pairs.iter().take(MOST_WRITTEN.into()).map(|pair| u16::from_be_bytes(*pair)).collect();
        if words.is_empty() || words.len() < pairs.len() || !rest.is_empty() {
            return Err(Exception::IllegalValue);
        }
        Ok(Self { address, words })
    }

    /// The values, each within the limits of its register.
    fn assignments(&self) -> impl Iterator<Item = Result<Assignment, Exception>> {
        let mut place = 0;
        core::iter::from_fn(move || {
            let words = self.words.get(place..).filter(|words| !words.is_empty())?;
            let assignment = self.assignment(place, words);
            // Behind one that is wrong nothing is looked at.
            place += assignment.map_or(words.len(), |assignment| assignment.value.kind().words().into());
            Some(assignment)
        })
    }

    fn assignment(&self, place: usize, words: &[u16]) -> Result<Assignment, Exception> {
        let address = self.address.checked_add(place as u16).ok_or(Exception::IllegalAddress)?;
        let register = Register::at(address).ok_or(Exception::IllegalAddress)?;
        if register.access == Access::Read {
            return Err(Exception::IllegalAddress);
        }
        let (offset, width) = (address - register.address, register.kind.words());
        let value = Value::of_words(register.kind, words).ok_or(Exception::IllegalValue)?;
        if offset % width != 0 || !register.takes(value) {
            return Err(Exception::IllegalValue);
        }
        Ok(Assignment { id: register.id, index: offset / width, value })
    }
}

/// Carries a write out.
///
/// # Errors
/// It is refused; nothing has changed. But a device failure: it is carried out, and lost when power
/// is.
pub fn write(
    session: &mut Session,
    words: &Words,
    audience: Audience,
    node: &mut impl Node,
) -> Result<(), Exception> {
    if let Some(error) = words.assignments().find_map(Result::err) {
        return Err(error);
    }
    let values = words.assignments().filter_map(Result::ok);
    match words.address >> 8 {
        1 => control(session, values, audience, node),
        3 => gains(session, values, node),
        4 => protection(session, values, node),
        6 => stream(values, node),
        7 => capture(session, values, node),
        8 => upload(session, values, node),
        9 => line(session, values, audience, node),
        10 => calibration(session, values, audience, node),
        11 => update(session, values, audience, node),
        _ => Err(Exception::IllegalAddress),
    }
}

/// Writes these registers of the group Control, each a run of its own.
///
/// # Errors
/// A value is out of its limits, or the state does not take it; nothing has changed.
pub fn say(
    session: &mut Session,
    said: impl Iterator<Item = (Id, Value)> + Clone,
    node: &mut impl Node,
) -> Result<(), Exception> {
    if !said.clone().all(|(id, value)| id.register().takes(value)) {
        return Err(Exception::IllegalValue);
    }
    let values = said.map(|(id, value)| Assignment { id, index: 0, value });
    control(session, values, Audience::This, node)
}

fn control(
    session: &mut Session,
    values: impl Iterator<Item = Assignment>,
    audience: Audience,
    node: &mut impl Node,
) -> Result<(), Exception> {
    let (mut command, mut wanted, mut mm, mut bar) = (Command::None, None, None, None);
    let (mut heartbeat, mut learning) = (None, None);
    for Assignment { id, value, .. } in values {
        match (id, value) {
            (Id::Command, Value::U16(number)) => command = Command::of_number(number).unwrap_or(command),
            (Id::Mode, Value::U16(number)) => wanted = mode(number),
            (Id::SetpointMm, Value::F32(value)) => mm = Some(value),
            (Id::SetpointBar, Value::F32(value)) => bar = Some(value),
            (Id::Heartbeat, Value::U16(number)) => heartbeat = Some(number),
            (Id::Adaptation, Value::U16(number)) => learning = Learning::of_number(number),
            _ => {}
        }
    }
    if audience == Audience::All && matches!(command, Command::Arm | Command::Start | Command::Service) {
        // Nobody would hear which valves have opened.
        return Err(Exception::DeviceBusy);
    }
    if command == Command::Stop {
        // Whatever else is written with it cannot keep the valve from being vented.
        (mm, bar) = (None, None);
    }
    let new_mode = wanted.unwrap_or(session.mode);
    let done = node.control(|control| {
        let state = control.state();
        // Outside the service state it is 0: who writes the whole group all the time writes that.
        let bar = bar.filter(|bar| state == State::Service || *bar != 0.0);
        let is_set = mm.is_some() || bar.is_some();
        if is_set && control.player.is_playing() || bar.is_some() && state != State::Service {
            return Err(Refusal::WrongState(state));
        }
        // What is forgotten at once would be missing at once.
        if learning == Some(Learning::Off)
            && control.adaptation.learning() != Learning::Off
            && state.is_driven()
        {
            return Err(Refusal::WrongState(state));
        }
        let order = match command {
            Command::None if state == State::Tracking => wanted.map(Order::SetMode),
            Command::None => None,
            Command::Start if state == State::Holding => Some(Order::SetMode(new_mode)),
            Command::Start => Some(Order::Start(new_mode)),
            Command::Stop => Some(Order::Stop),
            Command::Hold => Some(Order::SetMode(Mode::Hold)),
            Command::Acknowledge => Some(Order::Acknowledge),
            Command::Service => Some(Order::Service(VENT.0)),
            Command::Arm => Some(Order::Arm),
        };
        // A start begins with the reference that comes with it.
        let before_mm = control.next_reference_mm;
        control.next_reference_mm = mm.unwrap_or(before_mm);
        let done = order.map_or(Ok(()), |order| accepted(control.apply(order)));
        match (&done, bar) {
            (Ok(()), Some(bar)) => {
                let code = control.scalings.command_code(bar);
                drop(control.apply(Order::Service(code.0)));
            }
            (Ok(()), None) => {}
            (Err(_), _) => control.next_reference_mm = before_mm,
        }
        if done.is_ok() {
            heartbeat.into_iter().for_each(|number| control.beat(number));
            learning.into_iter().for_each(|learning| control.adaptation.switch(learning));
        }
        done
    });
    done.map_err(|refusal| session.refuse(refusal))?;
    session.mode = new_mode;
    if command != Command::None {
        session.command = command;
    }
    Ok(())
}

fn accepted(response: Response) -> Result<(), Refusal> {
    if let Response::Refused(refusal) = response { Err(refusal) } else { Ok(()) }
}

// Not inlined, like others below: what they need of the stack is then not needed at once.
#[inline(never)]
fn gains(
    session: &mut Session,
    values: impl Iterator<Item = Assignment>,
    node: &mut impl Node,
) -> Result<(), Exception> {
    let mut tracking = node.parameters().tracking.clone().ok_or(Exception::DeviceBusy)?;
    for Assignment { id, value, .. } in values {
        fields::of_controller(&mut tracking, id).into_iter().for_each(|field| field.set(value));
    }
    install(session, tracking, node)
}

/// Installs a configuration and keeps it.
#[inline(never)]
fn install(
    session: &mut Session,
    mut tracking: BoardParameters,
    node: &mut impl Node,
) -> Result<(), Exception> {
    session.message.clear();
    let state = node.control(|control| control.state());
    let done = if state.is_driven() {
        // Before the long work is done for nothing.
        Err(Refusal::WrongState(state))
    } else if let Err(refusal) = ceilings::refused(fields::excess(&mut tracking)) {
        Err(refusal)
    } else {
        accepted(carry_out(node, &Request::Configure(Configuration { version: VERSION, tracking })))
    };
    session.result = match &done {
        Ok(()) => UploadResult::Installed,
        Err(Refusal::WrongState(_)) => UploadResult::WrongState,
        Err(Refusal::Version(_)) => UploadResult::Version,
        Err(Refusal::NotStored) => UploadResult::NotStored,
        Err(_) => UploadResult::Parameter,
    };
    done.map_err(|refusal| session.refuse(refusal))
}

fn protection(
    session: &mut Session,
    values: impl Iterator<Item = Assignment>,
    node: &mut impl Node,
) -> Result<(), Exception> {
    let mut protection = node.control(|control| control.protection);
    for Assignment { id, value, .. } in values {
        fields::of_protection(&mut protection, id).into_iter().for_each(|field| field.set(value));
    }
    accepted(carry_out(node, &Request::Protect(protection))).map_err(|refusal| session.refuse(refusal))
}

#[inline(never)]
fn stream(values: impl Iterator<Item = Assignment>, node: &mut impl Node) -> Result<(), Exception> {
    let (mut order, mut interval, mut number, mut play_in) = (None, None, None, None);
    let mut points = Vec::<f32, { STREAM_POINTS as usize }>::new();
    for Assignment { id, value, .. } in values {
        match (id, value) {
            (Id::StreamOrder, Value::U16(value)) => order = StreamOrder::of_number(value),
            (Id::StreamInterval, Value::U16(value)) => interval = Some(value),
            (Id::StreamPlayIn, Value::U16(ticks)) => play_in = Some(ticks),
            (Id::PushNumber, Value::U32(value)) => number = Some(value),
            // The window has as many.
            (_, Value::F32(point)) => drop(points.push(point)),
            _ => {}
        }
    }
    if number.is_none() && !points.is_empty() {
        return Err(Exception::IllegalValue);
    }
    node.control(|control| {
        let state = control.state();
        let takes = |point: &f32| Id::SetpointBar.register().takes(Value::F32(*point));
        let drives =
            number.is_some() || play_in.is_some() || order.is_some_and(|order| order != StreamOrder::Clear);
        if !state.is_driven() && drives {
            Err(Exception::DeviceBusy)
        } else if state == State::Service && !points.iter().all(takes) {
            Err(Exception::IllegalValue)
        } else if let Some(number) = number {
            let before = control.player.pushed();
            let done = control.player.push(number, &points);
            if control.player.pushed() != before {
                // Points that it had not yet: a program that stands has none.
                control.live();
            }
            done
        } else if let Some(ticks) = play_in {
            let held = match state {
                State::Service => control.scalings.command.value(control.service_code.0),
                _ => control.next_reference_mm,
            };
            control.player.play_in(ticks, held)
        } else {
            control.player.order(order, interval)
        }
    })
}

fn capture(
    session: &mut Session,
    values: impl Iterator<Item = Assignment>,
    node: &mut impl Node,
) -> Result<(), Exception> {
    for Assignment { id, value, .. } in values {
        match (id, value) {
            (Id::CaptureEvery, Value::U16(every)) => {
                let order = if every == 0 { CaptureOrder::Stop } else { CaptureOrder::Start(every) };
                node.control(|control| drop(control.apply(Order::Capture(order))));
            }
            (_, Value::U32(from)) => session.capture_from = from,
            _ => {}
        }
    }
    Ok(())
}

#[inline(never)]
fn upload(
    session: &mut Session,
    values: impl Iterator<Item = Assignment>,
    node: &mut impl Node,
) -> Result<(), Exception> {
    let (mut order, mut offset, mut first) = (UploadOrder::None, session.upload.offset, None);
    let mut words = Vec::<u16, { MOST_WRITTEN as usize }>::new();
    for Assignment { id, index, value } in values {
        match (id, value) {
            (Id::UploadOrder, Value::U16(number)) => order = UploadOrder::of_number(number).unwrap_or(order),
            (Id::UploadLength, Value::U16(length)) => session.upload.length = length,
            (Id::UploadOffset, Value::U16(value)) => offset = value,
            (Id::UploadWindow, Value::U16(word)) => {
                first.get_or_insert(index);
                // A write has no more.
                let _ = words.push(word);
            }
            (_, Value::U32(checksum)) => session.upload.checksum = checksum,
            _ => {}
        }
    }
    session.upload.write(offset, first.unwrap_or(0), &words)?;
    match order {
        UploadOrder::None => Ok(()),
        UploadOrder::Commit => commit(session, node),
        UploadOrder::Fetch => {
            let tracking = node.parameters().tracking.as_ref().ok_or(Exception::DeviceBusy)?;
            session.upload.fill(tracking)
        }
    }
}

#[inline(never)]
fn commit(session: &mut Session, node: &mut impl Node) -> Result<(), Exception> {
    match session.upload.content() {
        Ok(tracking) => install(session, tracking, node),
        Err(result) => {
            session.result = result;
            session.message.clear();
            Err(Exception::IllegalValue)
        }
    }
}

/// How the board is reached: kept here, taken by [`super::Bus::line`].
#[inline(never)]
fn line(
    session: &mut Session,
    values: impl Iterator<Item = Assignment>,
    audience: Audience,
    node: &mut impl Node,
) -> Result<(), Exception> {
    let kept = node.parameters().bus;
    let (mut bus, mut is_taken) = (kept, false);
    for Assignment { id, value, .. } in values {
        match id {
            Id::BusTake => is_taken |= value == Value::U16(1),
            _ => fields::of_bus(&mut bus, id).into_iter().for_each(|field| field.set(value)),
        }
    }
    let state = node.control(|control| control.state());
    if state.is_driven() {
        return Err(session.refuse(Refusal::WrongState(state)));
    }
    if bus != kept {
        if audience == Audience::All {
            // All boards would have one number, and nobody would hear which have kept the rest.
            return Err(Exception::DeviceBusy);
        }
        let parameters = Parameters { bus, ..node.parameters().clone() };
        node.keep(parameters).map_err(|_| session.refuse(Refusal::NotStored))?;
    }
    session.takes_line |= is_taken;
    Ok(())
}

fn other_sum() -> Refusal {
    Refusal::parameter(format_args!("the checksum is not that of the calibration"))
}

/// What the sensors have shown, or how they are connected: as a whole or not at all.
#[inline(never)]
fn calibration(
    session: &mut Session,
    values: impl Iterator<Item = Assignment>,
    audience: Audience,
    node: &mut impl Node,
) -> Result<(), Exception> {
    if audience == Audience::All {
        // No two boards have the same sensors.
        return Err(Exception::DeviceBusy);
    }
    let before = node.control(|control| control.scalings);
    let mut calibration = before.calibration();
    let (mut lines, mut inputs, mut checksum) = (0, 0, None);
    for Assignment { id, value, .. } in values {
        match (id, value) {
            (Id::CalibrationChecksum | Id::InputsChecksum, Value::U32(sum)) => checksum = Some((id, sum)),
            _ => {
                if let Some(field) = fields::of_calibration(&mut calibration, id) {
                    lines += 1;
                    field.set(value);
                } else if let Some(field) = fields::of_inputs(&mut calibration.inputs, id) {
                    inputs += 1;
                    field.set(value);
                }
            }
        }
    }
    let (all_lines, all_inputs) = (fields::CALIBRATION.len(), fields::INPUTS.len());
    let scalings = match checksum {
        Some((Id::CalibrationChecksum, sum)) if (lines, inputs) == (all_lines, 0) => {
            if sum == calibration.checksum() { Scalings::calibrated(&calibration) } else { Err(other_sum()) }
        }
        Some((_, sum)) if (lines, inputs) == (0, all_inputs) => {
            if sum == calibration.inputs.checksum() {
                before.connected(&calibration.inputs)
            } else {
                Err(other_sum())
            }
        }
        _ => Err(Refusal::parameter(format_args!("a calibration is written as a whole, in one write"))),
    };
    let done = scalings.and_then(|scalings| {
        node.control(|control| control.calibrate(&scalings).map(|()| control.scalings.calibration()))
    });
    let kept = done.map_err(|refusal| session.refuse(refusal))?;
    let sealed = match checksum {
        // That of the host goes with it, to the moment at which it is used.
        Some((Id::CalibrationChecksum, sum)) => Sealed::under(kept, sum),
        _ => Some(Sealed::new(kept)),
    };
    let parameters = Parameters { calibration: sealed, ..node.parameters().clone() };
    node.keep(parameters).map_err(|_| session.refuse(Refusal::NotStored))
}

/// A new image: a block of it, or what is to be done with it.
#[inline(never)]
fn update(
    session: &mut Session,
    values: impl Iterator<Item = Assignment>,
    audience: Audience,
    node: &mut impl Node,
) -> Result<(), Exception> {
    let (mut order, mut takes_older, mut offset, mut first) = (UpdateOrder::None, false, None, None);
    let mut bytes = Vec::<u8, { 2 * MOST_WRITTEN as usize }>::new();
    for Assignment { id, index, value } in values {
        match (id, value) {
            (Id::UpdateOrder, Value::U16(number)) => order = UpdateOrder::of_number(number).unwrap_or(order),
            (Id::UpdateOlder, value) => takes_older = value == Value::U16(1),
            (Id::UpdateWindow, Value::U16(word)) => {
                first.get_or_insert(index);
                // A write has no more.
                let _ = bytes.extend_from_slice(&word.to_be_bytes());
            }
            (_, Value::U32(value)) => offset = Some(value),
            _ => {}
        }
    }
    let state = node.control(|control| control.state());
    if state.is_driven() || audience == Audience::All {
        return Err(Exception::DeviceBusy);
    }
    let revision = node.identity().hardware_revision;
    let images = node.images().ok_or(Exception::DeviceFailure)?;
    let update = &mut session.update;
    if let Some(first) = first {
        // A block says where it belongs.
        let offset = offset.filter(|_| first == 0).ok_or(Exception::IllegalValue)?;
        update.write(images, offset, &bytes)?;
    }
    update.offset = offset.unwrap_or(update.offset);
    match order {
        UpdateOrder::None => Ok(()),
        UpdateOrder::Begin => update.begin(images),
        UpdateOrder::Take => update.take(images, revision, takes_older),
        UpdateOrder::Restart if update.result == UpdateResult::Taken => {
            update.restarts = true;
            Ok(())
        }
        UpdateOrder::Restart => Err(Exception::DeviceBusy),
    }
}
