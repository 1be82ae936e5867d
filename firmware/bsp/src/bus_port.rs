//! Modbus on a port: bytes with their moments in, answers out.

use firmware::bus::Bus;
use firmware::node::Node;
use wire::registers::FRAME_BYTES;

use crate::serial::{Buffers, Line, Port};

/// A byte, and when its last bit came. Unit: that of the bus's silence.
pub type Stamped = (u8, u32);

/// Room for a frame each way, and for the first bytes of the next.
pub type BusBuffers = Buffers<Stamped, { FRAME_BYTES + 65 }, { FRAME_BYTES + 1 }>;

/// Works on what has arrived, until there is an answer to send. `now` tells the moment.
pub fn serve<L: Line<Received = Stamped>>(
    port: &mut Port<L>,
    modbus: &mut Bus,
    now: impl Fn() -> u32,
    node: &mut impl Node,
) {
    while !port.is_sending() {
        // Before the look into the queue: a byte that comes in between is not taken for a silence.
        let moment = now();
        if let Some(parameters) = modbus.line(moment, node) {
            port.set(parameters.baud, parameters.parity);
        }
        let received = port.read();
        let (byte, moment) = received.map_or((None, moment), |(byte, moment)| (Some(byte), moment));
        port.send(modbus.take(byte, moment, node));
        if received.is_none() {
            break;
        }
    }
}
