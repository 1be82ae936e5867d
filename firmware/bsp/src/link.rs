//! What a board answers to what it received over the link, and what it logs about it: the same for
//! every image.

use firmware::joint::{self, JointNode};
use firmware::node::{Node, carry_out};
use serde::{Serialize, de::DeserializeOwned};
use wire::joint::{JointRequest, JointResponse};
use wire::{FRAME_BYTES, FrameError, Receiver, Refusal, Request, Response};

use stm32f4::stm32f405::Interrupt;

use crate::serial::{Buffers, Line, Port};

/// The link, which has a wire each way.
pub struct LinkLine;

impl Line for LinkLine {
    /// At 42 MHz and at 16 MHz the divider is within 0.9 % of it.
    const BAUD: u32 = 460_800;
    const PORT: Interrupt = Interrupt::USART2;
    const TASK: Interrupt = Interrupt::SPI2;
    const HAS_ECHO: bool = false;
    type Received = u8;

    fn received(&self, byte: u8) -> u8 {
        byte
    }
}

/// Room for a frame each way: a request that comes while another port is served waits as a whole.
pub type LinkBuffers = Buffers<u8, { FRAME_BYTES + 1 }, { FRAME_BYTES + 1 }>;

/// The next complete frame: the request in it, or why it holds none.
pub fn next<L: Line<Received = u8>, M: DeserializeOwned>(
    port: &mut Port<L>,
    receiver: &mut Receiver,
) -> Option<Result<M, FrameError>> {
    while let Some(byte) = port.read() {
        if let Some(received) = receiver.push(byte) {
            return Some(received);
        }
    }
    None
}

/// The response to a frame, carried out if it is a request.
pub fn answer(received: Result<Request, FrameError>, node: &mut impl Node) -> Response {
    match received {
        Ok(request) => carry_out(node, &request),
        Err(_) => Response::Refused(Refusal::Unreadable),
    }
}

/// The same of a board with a joint.
pub fn answer_of_joint(
    received: Result<JointRequest, FrameError>,
    node: &mut impl JointNode,
) -> JointResponse {
    match received {
        Ok(request) => joint::carry_out(node, &request),
        Err(_) => JointResponse::Refused(Refusal::Unreadable),
    }
}

/// Sends a response, framed in `buffer`. One too long for the buffer is not sent; none of ours is.
pub fn send<L: Line>(port: &mut Port<L>, buffer: &mut [u8], response: &impl Serialize) {
    if let Ok(frame) = wire::encode(response, buffer) {
        port.send(frame);
    }
}

/// Logs a state that is not the one logged last.
pub fn log_change<S: PartialEq + Copy + core::fmt::Debug>(logged: &mut S, state: S) {
    if state != *logged {
        defmt::info!("state {}", defmt::Debug2Format(&state));
        *logged = state;
    }
}
