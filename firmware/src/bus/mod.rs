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
//!   hears that it does.
//! * A request is carried out as a whole, or refused as a whole with an exception.
//! * Every frame for this board counts as a sign of life of the host.
//!
//! # Limits
//! Whoever sends while the board answers is not heard. Where moments are numbers of ticks, as in an
//! emulator, a broken-off frame waits for them.

mod functions;
pub mod player;
mod read;
mod receiver;
mod server;
mod session;
mod upload;
mod write;

use heapless::Vec;
use wire::registers::FRAME_BYTES;

use crate::node::Node;
use receiver::Receiver;
use session::Session;

/// The bus of a board.
#[derive(Debug)]
pub struct Bus {
    receiver: Receiver,
    session: Session,
    response: Vec<u8, FRAME_BYTES>,
}

impl Bus {
    /// A bus on which a frame may begin after a pause, and does after a silence: times from the end
    /// of a byte to the end of the next. Unit: that of the moments which [`Bus::take`] is told.
    pub const fn new(pause: u32, silence: u32) -> Self {
        Self { receiver: Receiver::new(pause, silence), session: Session::new(), response: Vec::new() }
    }

    /// Takes a received byte, or `None` if none has come, at a moment of a clock that wraps; to be
    /// called at least every few ticks. Answers what is to be sent.
    pub fn take(&mut self, byte: Option<u8>, moment: u32, node: &mut impl Node) -> &[u8] {
        self.response.clear();
        if let Some(frame) = self.receiver.take(byte, moment) {
            server::answer(&mut self.session, frame, node, &mut self.response);
        }
        self.session.damaged = self.receiver.damaged();
        &self.response
    }
}
