"""DAC: channel 1 at PA4, channel 2 at PA5 (RM0090, chapter 14)."""

from .gpio import ANALOG
from .peripheral import Peripheral, Register

# Of channel 1; those of channel 2 are 16 bits above.
EN1, BOFF1, TEN1 = 0, 1, 2
CHANNELS = 1, 2
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
        0x20: Register("DHR12RD", 0, 0x0FFF_0FFF),
        0x2C: Register("DOR1"),
        0x30: Register("DOR2"),
        0x34: Register("SR", 0, 0x2000_2000),
    }
    # How near to the rails the buffer gets: the data sheet's guarantee. Unit: V.
    WORST_BUFFER_V = 0.2

    def __init__(self, chip):
        # A converter whose output does not follow its register any more, by channel.
        self.stuck = {}
        super().__init__(chip)

    @property
    def stuck_v(self):
        """That of channel 1."""
        return self.stuck.get(1)

    @stuck_v.setter
    def stuck_v(self, volts):
        self.stuck[1] = volts

    def _of(self, bit, channel):
        """A bit of CR of a channel."""
        return bit + 16 * (channel - 1)

    def write_CR(self, value):
        # RM0090, 14.3.1: the pin is analogue before the channel is enabled.
        for channel in CHANNELS:
            if value >> self._of(EN1, channel) & 1 and self.chip.gpio["A"].mode(3 + channel) != ANALOG:
                self.violation("the converter takes a pin that is not analogue")
        self["CR"] = value

    def _put(self, channel, value):
        self[f"DHR12R{channel}"] = value
        if not self.bit("CR", self._of(TEN1, channel)):
            self[f"DOR{channel}"] = value

    def write_DHR12R1(self, value):
        self._put(1, value)

    def write_DHR12R2(self, value):
        self._put(2, value)

    def write_DHR12RD(self, value):
        self["DHR12RD"] = value
        self._put(1, value & 0xFFF)
        self._put(2, value >> 16)

    def output(self, to_ground_ohm, channel=1):
        """Voltage that a channel puts out; None when it has let go of its pin. Unit: V."""
        if not self.bit("CR", self._of(EN1, channel)):
            return None
        stuck_v = self.stuck.get(channel)
        ideal = self[f"DOR{channel}"] / 4095 * self.chip.supply_v if stuck_v is None else stuck_v
        if self.bit("CR", self._of(BOFF1, channel)):
            return ideal * to_ground_ohm / (to_ground_ohm + UNBUFFERED_OHM)
        return min(max(ideal, self.WORST_BUFFER_V), self.chip.supply_v - self.WORST_BUFFER_V)
