"""EXTI: lines to interrupts (RM0090, 12.2), of which the model has one: 16, the voltage detector."""

from .peripheral import Register, Source

INTERRUPTS = {16: 1}


class Exti(Source):
    NAME, BASE = "EXTI", 0x4001_3C00
    REGISTERS = {
        0x00: Register("IMR", 0, 0x007F_FFFF),
        0x04: Register("EMR", 0, 0x007F_FFFF),
        0x08: Register("RTSR", 0, 0x007F_FFFF),
        0x0C: Register("FTSR", 0, 0x007F_FFFF),
        0x10: Register("SWIER", 0, 0x007F_FFFF),
        0x14: Register("PR", 0, 0x007F_FFFF),
    }

    def edge(self, line, is_rising):
        """A line changes."""
        if self.bit("RTSR" if is_rising else "FTSR", line):
            self["PR"] |= 1 << line

    def write_PR(self, value):
        self["PR"] &= ~value

    def lines(self):
        """The interrupts that are wanted."""
        wanted = self.values["PR"] & self.values["IMR"]
        return [irq for line, irq in INTERRUPTS.items() if wanted & 1 << line] if wanted else ()
