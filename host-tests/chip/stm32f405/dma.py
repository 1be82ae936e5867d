"""DMA2: a stream that takes what the converter has converted (RM0090, chapter 10)."""

from .peripheral import Peripheral, Register

EN, CIRC, MINC = 0, 8, 10
# Which flags of LISR are those of stream 0: end, half, errors.
TCIF0, FLAGS0 = 5, 0x3D
# The request of ADC1 at stream 0.
CHANNEL = 0
RAM, RAM_END = 0x2000_0000, 0x2002_0000


class Dma2(Peripheral):
    NAME, BASE = "DMA2", 0x4002_6400
    CLOCK = ("AHB1ENR", 22)
    REGISTERS = {
        0x00: Register("LISR"),
        0x04: Register("HISR"),
        0x08: Register("LIFCR", 0, 0x0F7D_0F7D),
        0x0C: Register("HIFCR", 0, 0x0F7D_0F7D),
        0x10: Register("S0CR", 0, 0x0FEF_FFFF),
        0x14: Register("S0NDTR", 0, 0xFFFF),
        0x18: Register("S0PAR"),
        0x1C: Register("S0M0AR"),
        0x20: Register("S0M1AR"),
        0x24: Register("S0FCR", 0x21, 0xBF),
    }

    def __init__(self, chip):
        # Whether it does nothing any more.
        self.is_dead = False
        super().__init__(chip)

    def reset(self):
        super().reset()
        self.count = self.place = 0

    def write_LIFCR(self, value):
        self["LISR"] &= ~value

    def write_S0NDTR(self, value):
        self._locked("S0NDTR", value)
        self.count = value

    def write_S0PAR(self, value):
        self._locked("S0PAR", value)

    def write_S0M0AR(self, value):
        self._locked("S0M0AR", value)

    def _locked(self, name, value):
        if self.bit("S0CR", EN):
            self.violation(f"{name} is written while the stream is enabled")
            return
        self[name] = value

    def write_S0CR(self, value):
        is_begun = value & 1 and not self.bit("S0CR", EN)
        if self.bit("S0CR", EN) and value & 1 and value != self["S0CR"]:
            self.violation("the stream's configuration is changed while it is enabled")
        self["S0CR"] = value
        if is_begun:
            if self["LISR"] & FLAGS0:
                self.violation("a stream is enabled with flags set")
            self.count, self.place = self["S0NDTR"], self["S0M0AR"]

    def read_S0NDTR(self, _):
        return self.count

    def take(self, source, value):
        """A request of the converter, whose data register is at `source`; whether it was taken."""
        control = self["S0CR"]
        if not control & 1 or self.is_dead or control >> 25 & 7 != CHANNEL:
            return False
        if self["S0PAR"] != source:
            self.violation(f"the stream reads {self['S0PAR']:#010x}, not the converter's data at {source:#010x}")
            return False
        if control >> 6 & 3 or control >> 11 & 3 != 1 or control >> 13 & 3 != 1 or control >> 9 & 1:
            self.violation("the stream does not move half words from the converter to memory")
        if not RAM <= self.place < RAM_END or self.place % 2:
            self.violation(f"a half word to {self.place:#010x}")
            return False
        self.chip.memory_write(self.place, (value & 0xFFFF).to_bytes(2, "little"))
        self.place += 2 * (control >> MINC & 1)
        self.count -= 1
        if self.count == 0:
            self["LISR"] |= 1 << TCIF0
            if control >> CIRC & 1:
                self.count, self.place = self["S0NDTR"], self["S0M0AR"]
            else:
                self["S0CR"] = control & ~1
        return True
