//! A serial port, 8 data bits, one stop bit, in two halves with a queue each way between them: an
//! interrupt above the tick moves bytes, a task below it works on them.
//!
//! # Contract
//! No wait: the interrupt takes and hands over what the port has room for at the moment, whatever
//! tick, lock or request is at work, within some 80 instructions. A byte is lost when the queue is
//! full only, and its frame with it; the frame's checksum tells. Where the line is shared, its
//! transceiver drives it from the first bit to the last and listens at all other times; what comes
//! in meanwhile is an echo, and dropped. Rate and parity change between two frames, by the
//! interrupt. Clock and pins are the caller's business: an emulated board has neither.

use core::ops::Deref;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use cortex_m::peripheral::NVIC;
use heapless::spsc::{Consumer, Producer, Queue};
use stm32f4::stm32f405::Interrupt;
use stm32f4::stm32f405::usart1::RegisterBlock;
use wire::Parity;

/// What a port hangs on, and who works on its bytes.
pub trait Line {
    /// By which it is opened. Unit: bit/s.
    const BAUD: u32;
    /// The port's interrupt.
    const PORT: Interrupt;
    /// The interrupt of the task that works on the bytes; pended by the port.
    const TASK: Interrupt;
    /// Whether the port may hear what it sends.
    const HAS_ECHO: bool;
    /// What is kept of a byte.
    type Received: 'static;

    /// What is kept of a byte that has arrived now.
    fn received(&self, byte: u8) -> Self::Received;

    /// Drives the line, or listens.
    fn drive(&mut self, _drives: bool) {}
}

/// What both halves share, and the memory of the queues. `IN` and `OUT`: one more than they have
/// room for.
pub struct Buffers<R, const IN: usize, const OUT: usize> {
    incoming: Queue<R, IN>,
    outgoing: Queue<u8, OUT>,
    is_sending: AtomicBool,
    /// The format to be taken, as [`Format::packed`]; 0 for none.
    wanted: AtomicU32,
}

impl<R, const IN: usize, const OUT: usize> Buffers<R, IN, OUT> {
    /// Empty.
    pub const fn new() -> Self {
        Self {
            incoming: Queue::new(),
            outgoing: Queue::new(),
            is_sending: AtomicBool::new(false),
            wanted: AtomicU32::new(0),
        }
    }
}

impl<R, const IN: usize, const OUT: usize> Default for Buffers<R, IN, OUT> {
    fn default() -> Self {
        Self::new()
    }
}

/// Rate and parity as the port's registers have them.
struct Format {
    /// Of the peripheral's clock, in sixteenths; above 0.
    divider: u16,
    parity: Parity,
}

impl Format {
    /// The nearest to a rate (bit/s).
    fn new(clock_hz: u32, baud: u32, parity: Parity) -> Self {
        Self { divider: ((clock_hz + baud / 2) / baud.max(1)) as u16, parity }
    }

    /// In a word that is not 0.
    fn packed(&self) -> u32 {
        u32::from(self.parity.number()) << 16 | u32::from(self.divider)
    }

    /// Puts a packed one into the registers of a port that sends nothing. With a parity a byte has
    /// nine bits.
    fn apply(packed: u32, registers: &RegisterBlock) {
        registers.cr1().modify(|_, w| w.ue().disabled());
        // SAFETY: mantissa and fraction together are the divider in sixteenths; any value is
        // allowed.
        registers.brr().write(|w| unsafe { w.bits(packed as u16) });
        let parity = Parity::of_number((packed >> 16) as u16).unwrap_or(Parity::None);
        let has_parity = parity != Parity::None;
        registers.cr1().modify(|_, w| {
            w.m().bit(has_parity).pce().bit(has_parity).ps().bit(parity == Parity::Odd).ue().enabled()
        });
    }
}

/// Enables a port, its reception and the interrupt of that. `clock_hz`: the peripheral's clock.
pub fn open<P: Deref<Target = RegisterBlock>, L: Line, const IN: usize, const OUT: usize>(
    registers: P,
    clock_hz: u32,
    line: L,
    buffers: &'static mut Buffers<L::Received, IN, OUT>,
) -> (Mover<P, L>, Port<L>) {
    Format::apply(Format::new(clock_hz, L::BAUD, Parity::None).packed(), &registers);
    registers.cr1().modify(|_, w| w.te().enabled().re().enabled().rxneie().enabled());
    let (arrived, incoming) = buffers.incoming.split();
    let (outgoing, leaving) = buffers.outgoing.split();
    let (is_sending, wanted) = (&buffers.is_sending, &buffers.wanted);
    (
        Mover { registers, line, arrived, leaving, is_sending, wanted, is_driving: false },
        Port { incoming, outgoing, sending: is_sending, wanted, clock_hz },
    )
}

/// The half of the interrupt.
pub struct Mover<P, L: Line> {
    registers: P,
    line: L,
    arrived: Producer<'static, L::Received>,
    leaving: Consumer<'static, u8>,
    is_sending: &'static AtomicBool,
    wanted: &'static AtomicU32,
    is_driving: bool,
}

impl<P: Deref<Target = RegisterBlock>, L: Line> Mover<P, L> {
    /// What the interrupt does.
    pub fn advance(&mut self) {
        // In this order: the last byte's echo is there before its end is, and nobody has sent it.
        self.receive();
        if self.is_sending.load(Ordering::Acquire) {
            self.send();
        } else {
            // Whoever wants it sends nothing yet, and waits for this.
            let wanted = self.wanted.load(Ordering::Acquire);
            if wanted != 0 {
                Format::apply(wanted, &self.registers);
                self.wanted.store(0, Ordering::Release);
            }
        }
    }

    fn receive(&mut self) {
        let status = self.registers.sr().read();
        if status.rxne().bit_is_clear() && status.ore().bit_is_clear() {
            return;
        }
        // Reading the data register also clears an overrun, which would raise the interrupt for
        // ever.
        let byte = self.registers.dr().read().dr().bits() as u8;
        let is_echo = L::HAS_ECHO && self.is_sending.load(Ordering::Acquire);
        if status.rxne().bit_is_set() && !is_echo {
            let _ = self.arrived.enqueue(self.line.received(byte));
            NVIC::pend(L::TASK);
        }
    }

    /// Hands over what the port takes, and gives the line free behind the last bit.
    fn send(&mut self) {
        if !self.is_driving {
            self.is_driving = true;
            self.line.drive(true);
        }
        while self.registers.sr().read().txe().bit_is_set()
            && let Some(byte) = self.leaving.dequeue()
        {
            self.registers.dr().write(|w| w.dr().set(byte.into()));
        }
        let is_handed_over = !self.leaving.ready();
        if is_handed_over && self.registers.sr().read().tc().bit_is_set() {
            self.line.drive(false);
            self.is_driving = false;
            self.is_sending.store(false, Ordering::Release);
            NVIC::pend(L::TASK);
        }
        // The next interrupt: room for a byte, or the end of the last one.
        let is_driving = self.is_driving;
        self.registers.cr1().modify(|_, w| {
            w.txeie().bit(is_driving && !is_handed_over).tcie().bit(is_driving && is_handed_over)
        });
    }
}

/// The half of the task.
pub struct Port<L: Line> {
    incoming: Consumer<'static, L::Received>,
    outgoing: Producer<'static, u8>,
    /// Whether the port has something to send, or the line.
    pub sending: &'static AtomicBool,
    wanted: &'static AtomicU32,
    clock_hz: u32,
}

impl<L: Line> Port<L> {
    /// The next byte that has arrived.
    pub fn read(&mut self) -> Option<L::Received> {
        self.incoming.dequeue()
    }

    /// Whether the port has something to send, or the line.
    pub fn is_sending(&self) -> bool {
        self.sending.load(Ordering::Acquire)
    }

    /// Takes a rate (bit/s) and a parity, at once; for a port that is not sending.
    pub fn set(&mut self, baud: u32, parity: Parity) {
        self.wanted.store(Format::new(self.clock_hz, baud, parity).packed(), Ordering::Release);
        NVIC::pend(L::PORT);
    }

    /// Begins to send; nothing is sent if there is nothing. For a port that is not sending: a frame
    /// is whole in the queue before its first byte leaves.
    pub fn send(&mut self, bytes: &[u8]) {
        if bytes.is_empty() || bytes.len() > self.outgoing.capacity() - self.outgoing.len() {
            return;
        }
        for &byte in bytes {
            let _ = self.outgoing.enqueue(byte);
        }
        self.sending.store(true, Ordering::Release);
        NVIC::pend(L::PORT);
    }
}
