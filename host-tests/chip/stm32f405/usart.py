"""USART1 and USART2 with the times of their bits (RM0090, chapter 30)."""

from .peripheral import Register, Source

PE, FE, NF, ORE, IDLE, RXNE, TC, TXE = range(8)
UE, TE, RE, RXNEIE, TCIE, TXEIE, IDLEIE = 13, 3, 2, 5, 6, 7, 4
M, PCE, PS = 12, 10, 9
# When a byte is known before its end: in the middle of the stop bit. Unit: bit.
UNKNOWN_BITS = 0.4
# How far the rates of both sides may be apart.
TOLERANCE = 0.03


class Usart(Source):
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

    def parity(self):
        """The bit that checks the others: "none", "even" or "odd"."""
        return ("even", "odd")[self.bit("CR1", PS)] if self.bit("CR1", PCE) else "none"

    def bits(self):
        """Of a byte: start, 8 or, with M, 9, of which the last may check the others, and stop."""
        return 10 + self.bit("CR1", M)

    def byte_s(self):
        return self.bits() / self.baud()

    def agrees(self, line):
        """Whether both sides have one format."""
        is_same = self.parity() == line.parity and self.bits() == line.bits()
        return is_same and abs(self.baud() / line.baud - 1) <= TOLERANCE

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
        changed = value ^ self["CR1"]
        if self.shifting is not None and changed & (1 << M | 1 << PCE | 1 << PS | 1 << UE):
            self.violation("the format is changed while a byte is sent")
        if value >> PCE & 1 and not value >> M & 1:
            self.violation("with a parity and without M a byte has seven bits")
        self["CR1"] = value

    def write_BRR(self, value):
        if value < 16:
            self.violation(f"the divider {value} is below 16, a bit's samples")
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
        self.chip.after((self.bits() - UNKNOWN_BITS) / self.baud(), lambda: self._known(generation, byte))
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

    def receive(self, byte, line):
        """A byte has arrived, its stop bit seen."""
        if not self.bit("CR1", UE) or not self.bit("CR1", RE):
            return
        if line is not self and not self.agrees(line):
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
        status, enabled = self.values["SR"], self.values["CR1"]
        if not enabled >> UE & 1:
            return ()
        wanted = (
            enabled >> RXNEIE & 1 and status & (1 << RXNE | 1 << ORE)
            or enabled >> TCIE & 1 and status & 1 << TC
            or enabled >> TXEIE & 1 and status & 1 << TXE
            or enabled >> IDLEIE & 1 and status & 1 << IDLE
        )
        return (self.IRQ,) if wanted else ()


class Usart1(Usart):
    NAME, BASE, CLOCK, BUS, IRQ = "USART1", 0x4001_1000, ("APB2ENR", 4), 2, 37
    TX, RX = "PA9", "PA10"


class Usart2(Usart):
    NAME, BASE, CLOCK, BUS, IRQ = "USART2", 0x4000_4400, ("APB1ENR", 17), 1, 38
    TX, RX = "PA2", "PA3"
