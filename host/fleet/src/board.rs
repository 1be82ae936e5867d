//! A board without hardware: the control law, the bus and the link of the firmware, tick by tick.

use firmware::bus::{Bus, Timing};
use firmware::identity::Identity;
use firmware::node::{Node, carry_out};
use firmware::store::{Parameters, SaveError};
use firmware::{Control, LockStepBoard};
use wire::image::Linked;
use wire::registers::{BAUD, UNIT};
use wire::{BusParameters, Protection, Request, Response, TickReply, TickRequest};

use crate::images::RamImages;

/// Ticks of silence before a frame.
pub const SILENCE_TICKS: u32 = 2;
const TIMING: Timing = Timing::Ticks(SILENCE_TICKS);

/// The board.
pub struct Board {
    node: HostNode,
    board: LockStepBoard,
    bus: Bus,
}

/// What bus and link work on.
struct HostNode {
    control: Control,
    parameters: Parameters,
    identity: Identity,
    images: Option<RamImages>,
    /// The last parameters that the bus has asked its line to take.
    line: Option<BusParameters>,
}

/// Who a board says it is.
pub const IDENTITY: Identity = Identity {
    unique_id: [0x0039, 0x0045, 0x3134, 0x510E, 0x3238, 0x3732],
    processor: 0x1007_6413,
    hardware_revision: 3,
};

impl Node for HostNode {
    type Images = RamImages;

    fn control<R>(&mut self, work: impl FnOnce(&mut Control) -> R) -> R {
        work(&mut self.control)
    }

    fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn keep(&mut self, parameters: Parameters) -> Result<(), SaveError> {
        self.parameters = parameters;
        Ok(())
    }

    fn images(&mut self) -> Option<&mut RamImages> {
        self.images.as_mut()
    }
}

impl Board {
    /// A board of this number, whose processor's number ends in it. What the control keeps over a
    /// reset stays in memory as long as the program runs.
    pub fn of_number(unit: u8, protection: Protection) -> Self {
        let control = Control::new(protection, None, Box::leak(Box::default()), Box::leak(Box::default()));
        let mut board = Self::of(control, protection);
        board.node.parameters.bus.unit = unit;
        let [.., last] = &mut board.node.identity.unique_id;
        *last = unit.into();
        board
    }

    /// A board with this control and, in its parameters, these limits.
    pub fn of(control: Control, protection: Protection) -> Self {
        let parameters = Parameters { protection, ..Parameters::FACTORY };
        let node = HostNode { control, parameters, identity: IDENTITY, images: None, line: None };
        Self { node, board: LockStepBoard::new(), bus: Bus::new(TIMING) }
    }

    /// The same board, which takes images; the one that it runs has this head.
    pub fn with_images(mut self, linked: &Linked) -> Self {
        self.node.images = Some(RamImages::new(linked));
        self
    }

    /// The control, when the board ends.
    pub fn into_control(self) -> Control {
        self.node.control
    }

    /// Sends a request over the link.
    pub fn request(&mut self, request: &Request) -> Response {
        carry_out(&mut self.node, request)
    }

    /// The control.
    pub fn control(&mut self) -> &mut Control {
        &mut self.node.control
    }

    /// The set that the board would keep.
    pub fn parameters(&self) -> &Parameters {
        &self.node.parameters
    }

    /// A tick with these samples; the reference stays that of the bus.
    pub fn tick_at(&mut self, pressure_code: u16, contraction_code: u16) -> TickReply {
        self.board.tick(
            &mut self.node.control,
            TickRequest {
                reference_mm: None,
                pressure_code,
                contraction_code,
                load_n: None,
                temperature_c: None,
            },
        )
    }

    /// A moment in which nothing comes; answers what the board sends.
    pub fn idle(&mut self) -> Vec<u8> {
        self.take(None)
    }

    /// What the line has last been asked to be.
    pub fn line(&self) -> Option<BusParameters> {
        self.node.line
    }

    /// The rate of its line. Unit: bit/s.
    pub fn baud(&self) -> u32 {
        self.node.line.map_or(BAUD, |line| line.baud)
    }

    /// The board's number.
    pub fn unit(&self) -> u8 {
        self.node.line.map_or(UNIT, |line| line.unit)
    }

    fn take(&mut self, byte: Option<u8>) -> Vec<u8> {
        let tick = self.node.control.ticks();
        if let Some(line) = self.bus.line(tick, &self.node) {
            self.node.line = Some(line);
        }
        let sent = self.bus.take(byte, tick, &mut self.node).to_vec();
        if let Some(images) = self.node.images.as_mut().filter(|images| images.restarts) {
            images.start();
            self.bus = Bus::new(TIMING);
        }
        sent
    }

    /// Puts bytes on the bus at once; answers what the board sends, a frame each.
    pub fn send_all(&mut self, bytes: &[u8]) -> Vec<Vec<u8>> {
        let answers = bytes.iter().map(|&byte| self.take(Some(byte)));
        answers.filter(|answer| !answer.is_empty()).collect()
    }

    /// The same, one behind the other.
    pub fn send(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.send_all(bytes).concat()
    }
}
