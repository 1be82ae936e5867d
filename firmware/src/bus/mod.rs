//! The users' bus: Modbus RTU over the registers of [`wire::registers`].
//!
//! # Design
//! ```text
//! bytes ─▶ receiver ─▶ frame ─▶ server ─┬─▶ read  ◀── view of the control
//!                                       └─▶ write ──▶ orders to the control, upload, player
//! ```
//! What requests leave for later ones is the session's; server, read and write work on it. The
//! player belongs to the control, since it is the tick that plays; all else runs below the tick and
//! holds the control's lock only to copy from it or to carry out an order.
//!
//! # Contract
//! * What is no whole frame, or one for somebody else, is met with silence; address 0 is carried
//!   out and not answered, but nothing that opens a valve: who drives several boards asks each, and
//!   hears that it does. A stop, and a heartbeat, are for all that hear it.
//! * A request is carried out as a whole, or refused as a whole with an exception.
//! * A sign of life is what a host cannot repeat whose program stands: another number of the
//!   heartbeat, or points of the stream that the board had not yet.
//! * Of the exchange in slots ([`wire::slots`]) a set point is taken by its sequence and until its
//!   tick, and answered in the board's slot, others' answers or not. An answer that is late by the
//!   gap is not sent. A board whose own turn-around is longer than the gap is no member.
//! * Parameters of the line change between two frames only, behind the answer to whoever has asked
//!   for it.
//!
//! # Limits
//! Whoever sends while the board answers is not heard. Where moments are numbers of ticks, as in an
//! emulator, a broken-off frame waits for them.

mod functions;
mod listening;
pub mod player;
mod read;
mod receiver;
mod server;
mod session;
mod slot;
mod timing;
mod upload;
mod write;

use heapless::Vec;
use wire::BusParameters;
use wire::registers::FRAME_BYTES;

use crate::node::Node;
use crate::update::{self, Images};
use receiver::Receiver;
use session::Session;
use slot::Slot;
pub use timing::Timing;

/// The bus of a board.
#[derive(Debug)]
pub struct Bus {
    timing: Timing,
    receiver: Receiver,
    session: Session,
    response: Vec<u8, FRAME_BYTES>,
    /// When the response is sent, if one waits.
    waiting: Option<Waiting>,
    has_begun: bool,
}

/// When a response is sent. Unit: that of the moments.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    /// When its request came.
    asked: u32,
    /// How long it waits behind that.
    patience: u32,
    /// In its slot, by how much it may be late at the most: then the slot is left to the others.
    slack: Option<u32>,
}

/// How far ahead a slot counts as near: a tick and a half, so that one tick at least sees it come,
/// late as it may be. Unit: µs.
const NEAR_US: u32 = 1_500;

impl Bus {
    /// A bus that has heard nothing, and listens to nobody before the first [`Bus::line`].
    pub const fn new(timing: Timing) -> Self {
        Self {
            timing,
            receiver: Receiver::new(),
            session: Session::new(),
            response: Vec::new(),
            waiting: None,
            has_begun: false,
        }
    }

    /// Takes a received byte, or `None` if none has come, at a moment of a clock that wraps; to be
    /// called at least every few ticks. Answers what is to be sent.
    pub fn take(&mut self, byte: Option<u8>, moment: u32, node: &mut impl Node) -> &[u8] {
        update::look(&mut self.session.update, self.session.frames > 0, node);
        if self.session.update.restarts && self.waiting.is_none() {
            // The answer has left: who sends does not ask.
            node.images().into_iter().for_each(|images| images.restart());
        }
        if byte.is_some() {
            // Who speaks again does not wait for the answer any more; in slots the others speak.
            self.waiting.take_if(|waiting| waiting.slack.is_none());
        }
        if let Some(frame) = self.receiver.take(byte, moment) {
            self.session.listening.hear();
            if !slot::is_answer(frame) {
                self.response.clear();
                let slot = server::answer(&mut self.session, frame, node, &mut self.response);
                let waits = Waiting::new(&self.timing, self.session.listening.in_use(), slot, moment);
                self.waiting = (!self.response.is_empty()).then_some(waits);
            }
        }
        self.session.damaged = self.receiver.damaged();
        let over = |waiting: &Waiting| moment.wrapping_sub(waiting.asked).checked_sub(waiting.patience);
        // The moment of another member's byte is its interrupt's, which may be a tick ahead.
        let is_looked_at = byte.is_none();
        let is_due =
            |waiting: &mut Waiting| (is_looked_at || waiting.slack.is_none()) && over(waiting).is_some();
        match self.waiting.take_if(is_due) {
            Some(waiting) if waiting.slack.is_none_or(|slack| over(&waiting) <= Some(slack)) => {
                &self.response
            }
            _ => &[],
        }
    }

    /// Whether a slot of this board is about to begin: then [`Bus::take`] is to be called as often
    /// as can be, since a tick is too coarse for it.
    pub fn is_slot_near(&self, moment: u32) -> bool {
        self.waiting.as_ref().is_some_and(|waiting| {
            let left = waiting.patience.saturating_sub(moment.wrapping_sub(waiting.asked));
            waiting.slack.is_some() && self.timing.has_microseconds() && left < NEAR_US
        })
    }

    /// The parameters of the line, where they are others than at the last call; to be asked for,
    /// and followed, before each look at what has come, while nothing is sent.
    pub fn line(&mut self, moment: u32, node: &impl Node) -> Option<BusParameters> {
        if self.waiting.is_some() {
            return None;
        }
        let listening = &mut self.session.listening;
        let before = *listening.in_use();
        let is_first = !core::mem::replace(&mut self.has_begun, true);
        if core::mem::take(&mut self.session.takes_line) || is_first {
            listening.begin(&node.parameters().bus, moment);
        }
        listening.look(self.timing.patience(), moment);
        let in_use = *listening.in_use();
        (is_first || in_use != before).then(|| {
            self.receiver.set(in_use.unit, self.timing.pauses(&in_use));
            in_use
        })
    }
}

impl Waiting {
    /// Behind a request that came at this moment: for the line's patience, or for a slot.
    fn new(timing: &Timing, bus: &BusParameters, slot: Option<Slot>, asked: u32) -> Self {
        match slot {
            None => Self { asked, patience: timing.turnaround(bus), slack: None },
            Some(Slot { begin_us, gap_us }) => Self {
                asked,
                patience: timing.of_us(begin_us),
                // With its bytes it would reach into the next one.
                slack: Some(timing.of_us(gap_us)),
            },
        }
    }
}
