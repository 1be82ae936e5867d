"""DAC: channel 1 at PA4 (RM0090, chapter 14)."""

from .gpio import ANALOG
from .peripheral import Peripheral, Register

EN1, BOFF1, TEN1 = 0, 1, 2
# Impedance without the buffer. Unit: ohm.
UNBUFFERED_OHM = 15e3


class Dac(Peripheral):
    NAME, BASE = "DAC", 0x4000_7400
    CLOCK = ("APB1ENR", 29)
    REGISTERS = {
        0x00: Register("CR", 0, 0x3FFF_3FFF),
        0x04: Register("SWTRIGR", 0, 0x3),
        0x08: Register("DHR12R1", 0, 0xFFF),
        0x14: Register("DHR12R2", 0, 0xFFF),
        0x2C: Register("DOR1"),
        0x34: Register("SR", 0, 0x2000_2000),
    }
    # How near to the rails the buffer gets: the data sheet's guarantee. Unit: V.
    WORST_BUFFER_V = 0.2

    def __init__(self, chip):
        # A converter whose output does not follow its register any more.
        self.stuck_v = None
        super().__init__(chip)

    def write_CR(self, value):
        # RM0090, 14.3.1: the pin is analogue before the channel is enabled.
        if value >> EN1 & 1 and self.chip.gpio["A"].mode(4) != ANALOG:
            self.violation("the converter takes a pin that is not analogue")
        self["CR"] = value

    def write_DHR12R1(self, value):
        self["DHR12R1"] = value
        if not self.bit("CR", TEN1):
            self["DOR1"] = value

    def output(self, to_ground_ohm):
        """Voltage and impedance that the converter puts out; None when it has let go of the pin. Unit: V."""
        if not self.bit("CR", EN1):
            return None
        ideal = self["DOR1"] / 4095 * self.chip.supply_v if self.stuck_v is None else self.stuck_v
        if self.bit("CR", BOFF1):
            return ideal * to_ground_ohm / (to_ground_ohm + UNBUFFERED_OHM)
        return min(max(ideal, self.WORST_BUFFER_V), self.chip.supply_v - self.WORST_BUFFER_V)
