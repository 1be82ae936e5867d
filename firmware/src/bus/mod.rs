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
pub use timing::Timing;

/// The bus of a board.
#[derive(Debug)]
pub struct Bus {
    timing: Timing,
    receiver: Receiver,
    session: Session,
    response: Vec<u8, FRAME_BYTES>,
    /// When the request came whose response waits.
    asked: Option<u32>,
    has_begun: bool,
}

impl Bus {
    /// A bus that has heard nothing, and listens to nobody before the first [`Bus::line`].
    pub const fn new(timing: Timing) -> Self {
        Self {
            timing,
            receiver: Receiver::new(),
            session: Session::new(),
            response: Vec::new(),
            asked: None,
            has_begun: false,
        }
    }

    /// Takes a received byte, or `None` if none has come, at a moment of a clock that wraps; to be
    /// called at least every few ticks. Answers what is to be sent.
    pub fn take(&mut self, byte: Option<u8>, moment: u32, node: &mut impl Node) -> &[u8] {
        update::look(&mut self.session.update, self.session.frames > 0, node);
        if self.session.update.restarts && self.asked.is_none() {
            // The answer has left: who sends does not ask.
            node.images().into_iter().for_each(|images| images.restart());
        }
        if byte.is_some() {
            // Who speaks again does not wait for the answer any more.
            self.asked = None;
        }
        if let Some(frame) = self.receiver.take(byte, moment) {
            self.session.listening.hear();
            self.response.clear();
            server::answer(&mut self.session, frame, node, &mut self.response);
            self.asked = (!self.response.is_empty()).then_some(moment);
        }
        self.session.damaged = self.receiver.damaged();
        let patience = self.timing.turnaround(self.session.listening.in_use());
        match self.asked.take_if(|asked| moment.wrapping_sub(*asked) >= patience) {
            Some(_) => &self.response,
            None => &[],
        }
    }

    /// The parameters of the line, where they are others than at the last call; to be asked for,
    /// and followed, before each look at what has come, while nothing is sent.
    pub fn line(&mut self, moment: u32, node: &impl Node) -> Option<BusParameters> {
        if self.asked.is_some() {
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
