"""PWR: the voltage detector (RM0090, 5.4; thresholds of DS8626, "Embedded reset and power control block")."""

from .peripheral import Peripheral, Register

# Typical thresholds of a falling supply by PLS. Unit: V.
FALLING = (2.04, 2.19, 2.35, 2.50, 2.65, 2.76, 2.93, 3.03)
# How much higher those of a rising one are. Unit: V.
HYSTERESIS = 0.1
# Interrupt line of the detector.
LINE = 16


class Pwr(Peripheral):
    NAME, BASE = "PWR", 0x4000_7000
    CLOCK = ("APB1ENR", 28)
    REGISTERS = {0x00: Register("CR", 0x4000, 0x0000_43FF), 0x04: Register("CSR", 0, 0x0000_031F)}

    # How far the thresholds of this chip are from the typical ones. Unit: V.
    offset_v = 0.0

    def reset(self):
        super().reset()
        self.is_low = False

    def write_CR(self, value):
        self["CR"] = value
        self.watch()

    def watch(self):
        """Compares the supply with the threshold."""
        threshold = FALLING[self.field("CR", 5, 3)] + self.offset_v + (HYSTERESIS if self.is_low else 0.0)
        was_low = self.is_low
        self.is_low = self.bit("CR", 4) and self.chip.supply_v < threshold
        if was_low != self.is_low:
            self.chip.exti.edge(LINE, is_rising=self.is_low)

    def read_CSR(self, value):
        return value & ~4 | self.is_low << 2
