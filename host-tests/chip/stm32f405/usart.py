"""USART1 and USART2 with the times of their bits (RM0090, chapter 30)."""

from .peripheral import Peripheral, Register

PE, FE, NF, ORE, IDLE, RXNE, TC, TXE = range(8)
UE, TE, RE, RXNEIE, TCIE, TXEIE, IDLEIE = 13, 3, 2, 5, 6, 7, 4
# 8 data bits, one start bit, one stop bit.
BITS = 10
# When within a byte it is known: in the middle of the stop bit.
KNOWN_BITS = 9.6
# How far the rates of both sides may be apart.
TOLERANCE = 0.03


class Usart(Peripheral):
    REGISTERS = {
        0x00: Register("SR", 0xC0, 0x3FF),
        0x04: Register("DR", 0, 0x1FF),
        0x08: Register("BRR", 0, 0xFFFF),
        0x0C: Register("CR1", 0, 0xBFFF),
        0x10: Register("CR2", 0, 0x7F6F),
        0x14: Register("CR3", 0, 0xFFF),
        0x18: Register("GTPR", 0, 0xFFFF),
    }
    BUS, IRQ, LINE_BAUD = 1, 0, 0

    def reset(self):
        super().reset()
        self.waiting = self.shifting = None
        self.was_read = self.sr_read = False
        self.received = 0
        self.generation = getattr(self, "generation", 0) + 1

    def baud(self):
        """The rate by the divider."""
        return self.chip.rcc.apb_hz(self.BUS) / max(self["BRR"], 1)

    def byte_s(self):
        return BITS / self.baud()

    def read_SR(self, value):
        self.sr_read = True
        return value

    def read_DR(self, _):
        self["SR"] &= ~(1 << RXNE)
        if self.sr_read:
            self["SR"] &= ~(1 << ORE | 1 << NF | 1 << FE | 1 << PE | 1 << IDLE)
        return self.received

    def write_SR(self, value):
        self["SR"] &= value | ~(1 << RXNE | 1 << TC)

    def write_CR1(self, value):
        if value >> TE & 1 and not self.chip.board.is_connected(self.TX, 7):
            self.violation(f"the transmitter is enabled while {self.TX} is not its pin")
        self["CR1"] = value

    def write_BRR(self, value):
        if self.bit("CR1", UE) and self.shifting is not None:
            self.violation("the rate is changed while a byte is sent")
        self["BRR"] = value

    def write_DR(self, value):
        if not self.bit("CR1", TE) or not self.bit("CR1", UE):
            self.violation("a byte is sent by a transmitter that is off")
            return
        if not self.bit("SR", TXE):
            self.violation("a byte is sent over one that waits: lost")
        if self.sr_read:
            self["SR"] &= ~(1 << TC)
        self.sr_read = False
        self.waiting = value & 0xFF
        self["SR"] &= ~(1 << TXE)
        if self.shifting is None:
            self._shift()

    def _shift(self):
        self.shifting, self.waiting = self.waiting, None
        self["SR"] = self["SR"] | 1 << TXE
        self.chip.board.byte_begins(self, self.shifting)
        generation, byte = self.generation, self.shifting
        self.chip.after(KNOWN_BITS / self.baud(), lambda: self._known(generation, byte))
        self.chip.after(self.byte_s(), lambda: self._shifted(generation))

    def _known(self, generation, byte):
        if generation == self.generation:
            self.chip.board.byte_sent(self, byte)

    def _shifted(self, generation):
        if generation != self.generation:
            return
        self.shifting = None
        if self.waiting is not None:
            self._shift()
        else:
            self["SR"] |= 1 << TC
            self.chip.board.all_sent(self)

    def receive(self, byte, line_baud):
        """A byte has arrived, its stop bit seen."""
        if not self.bit("CR1", UE) or not self.bit("CR1", RE):
            return
        if abs(self.baud() / line_baud - 1) > TOLERANCE:
            byte = byte ^ 0x55
            self["SR"] |= 1 << FE
        if self.bit("SR", RXNE):
            self["SR"] |= 1 << ORE
            self.chip.board.lost_bytes += 1
            return
        self.received = byte
        self["SR"] |= 1 << RXNE

    def lines(self):
        """Whether the interrupt is wanted."""
        status, enabled = self["SR"], self["CR1"]
        wanted = (
            enabled >> RXNEIE & 1 and status & (1 << RXNE | 1 << ORE)
            or enabled >> TCIE & 1 and status & 1 << TC
            or enabled >> TXEIE & 1 and status & 1 << TXE
            or enabled >> IDLEIE & 1 and status & 1 << IDLE
        )
        return [self.IRQ] if wanted and enabled >> UE & 1 else []


class Usart1(Usart):
    NAME, BASE, CLOCK, BUS, IRQ = "USART1", 0x4001_1000, ("APB2ENR", 4), 2, 37
    TX, RX = "PA9", "PA10"


class Usart2(Usart):
    NAME, BASE, CLOCK, BUS, IRQ = "USART2", 0x4000_4400, ("APB1ENR", 17), 1, 38
    TX, RX = "PA2", "PA3"
