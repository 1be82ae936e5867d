"""DBGMCU: what stands still while a debugger halts the core (RM0090, 38.16). Only power-on resets it."""

from .peripheral import Peripheral, Register


class Dbgmcu(Peripheral):
    NAME, BASE = "DBGMCU", 0xE004_2000
    REGISTERS = {
        0x00: Register("IDCODE", 0x1007_6413, 0),
        0x04: Register("CR", 0, 0xE7),
        0x08: Register("APB1_FZ", 0, 0x06E0_1DFF),
        0x0C: Register("APB2_FZ", 0, 0x0007_0003),
    }

    def __init__(self, chip):
        # Revision in the upper half, device in the lower.
        self.identity = 0x1007_6413
        super().__init__(chip)
        self.power_on()

    def reset(self):
        """Keeps what it has."""

    def power_on(self):
        super().reset()

    def read_IDCODE(self, _):
        return self.identity
