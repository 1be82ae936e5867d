"""ADC1: a regular group started by a timer and taken by DMA, the injected one behind it (RM0090, chapter 13)."""

from .gpio import ANALOG
from .peripheral import Peripheral, Register

SAMPLING = (3, 15, 28, 56, 84, 112, 144, 480)
CONVERSION = 12
# Unit: Hz.
MOST_HZ = 36e6
TEMPERATURE, REFERENCE = 16, 17
PINS = {0: "PA0", 1: "PA1", 4: "PA4", 5: "PA5", 10: "PC0", 11: "PC1"}
# Least time to sample the sensor of the temperature and the reference. Unit: s.
INTERNAL_S = 10e-6
# Time from switching on to the first conversion. Unit: s.
STABLE_S = 3e-6
EOC, JEOC, JSTRT, STRT, OVR = 1, 2, 3, 4, 5
# Of CR1: the injected group follows the regular one by itself. Of CR2: requests to the DMA, and behind the last too.
JAUTO, DMA, DDS = 10, 8, 9


class Adc(Peripheral):
    NAME, BASE = "ADC1", 0x4001_2000
    CLOCK = ("APB2ENR", 8)
    # By the number of an event as the injected group's trigger, that as the regular group's.
    REGULAR_BY = {3: 6}
    REGISTERS = {
        0x00: Register("SR", 0, 0x3F),
        0x04: Register("CR1", 0, 0x07C0_FFFF),
        0x08: Register("CR2", 0, 0x7F7F_0F03),
        0x0C: Register("SMPR1", 0, 0x07FF_FFFF),
        0x10: Register("SMPR2", 0, 0x3FFF_FFFF),
        **{0x14 + 4 * k: Register(f"JOFR{k + 1}", 0, 0xFFF) for k in range(4)},
        0x24: Register("HTR", 0xFFF, 0xFFF),
        0x28: Register("LTR", 0, 0xFFF),
        **{0x2C + 4 * k: Register(f"SQR{k + 1}") for k in range(3)},
        0x38: Register("JSQR", 0, 0x003F_FFFF),
        **{0x3C + 4 * k: Register(f"JDR{k + 1}") for k in range(4)},
        0x4C: Register("DR"),
        0x304: Register("CCR", 0, 0x00C3_EF1F),
    }

    def __init__(self, chip):
        self.scans = 0
        # Whether the converter does nothing any more.
        self.is_dead = False
        # Whether the injected group does nothing any more.
        self.is_injected_dead = False
        super().__init__(chip)

    def reset(self):
        super().reset()
        self.on_at = None
        self.generation = getattr(self, "generation", 0) + 1
        self.is_scanning = False

    def write_SR(self, value):
        # Zeros clear, ones are without effect.
        self["SR"] &= value

    def write_CR2(self, value):
        if value & 1 and not self["CR2"] & 1:
            self.on_at = self.chip.now
        if value & 0x4000_0000 or value & 0x0040_0000:
            self.violation("a conversion is started by software: the model has the trigger only")
        self["CR2"] = value

    def clock_hz(self):
        return self.chip.rcc.apb_hz(2) / (2, 4, 6, 8)[self.field("CCR", 16, 2)]

    def _sampling(self, channel):
        name, place = ("SMPR2", channel) if channel < 10 else ("SMPR1", channel - 10)
        return SAMPLING[self.field(name, 3 * place, 3)]

    def trigger(self, source):
        """An event of a timer; starts the group whose chosen one it is."""
        if not self["CR2"] & 1 or self.is_dead:
            return
        is_regular = self.field("CR2", 28, 2) == 1 and self.field("CR2", 24, 4) == self.REGULAR_BY.get(source)
        is_injected = self.field("CR2", 20, 2) == 1 and self.field("CR2", 16, 4) == source
        if not is_regular and not is_injected:
            return
        if self.on_at is None or self.chip.now - self.on_at < STABLE_S:
            self.violation("a conversion is started before the converter is stable")
        if self.is_scanning:
            self.violation("a conversion is started while the one before is not finished")
            return
        hz = self.clock_hz()
        if hz > MOST_HZ:
            self.violation(f"the converter runs at {hz / 1e6} MHz, at most {MOST_HZ / 1e6} are allowed")
        if not self.bit("CR1", 8):
            self.violation("the group is started without SCAN: only its first channel would be converted")
        if self.bit("CR1", JAUTO) and self.field("CR2", 20, 2):
            self.violation("the injected group has a trigger of its own beside JAUTO")
        injected = self.field("JSQR", 20, 2) + 1
        steps = []
        if is_regular:
            count = self.field("SQR1", 20, 4) + 1
            fields = [("SQR3", k) for k in range(6)] + [("SQR2", k) for k in range(6)] + [("SQR1", k) for k in range(4)]
            steps += [(self.field(name, 5 * k, 5), None) for name, k in fields[:count]]
        if (is_injected or self.bit("CR1", JAUTO)) and not self.is_injected_dead:
            channels = [self.field("JSQR", 5 * k, 5) for k in range(4 - injected, 4)]
            steps += [(channel, place) for place, channel in enumerate(channels)]
        self.is_scanning = True
        self["SR"] |= 1 << (STRT if is_regular else JSTRT)
        self._convert(steps, 0, hz, self.generation)

    def _regular(self, code):
        """A conversion of the regular group has ended."""
        if self.bit("SR", OVR):
            return
        self["DR"] = code
        self["SR"] |= 1 << EOC
        if not self.bit("CR2", DMA):
            return
        if not self.bit("CR2", DDS):
            self.violation("without DDS no request follows the last of the stream's")
        if self.chip.dma2.take(self.BASE + 0x4C, code):
            self["SR"] &= ~(1 << EOC)
        else:
            self["SR"] |= 1 << OVR

    def _convert(self, steps, place, hz, generation):
        if generation != self.generation:
            return
        if place == len(steps):
            self.is_scanning = False
            self.scans += 1
            if steps[-1][1] is not None:
                self["SR"] |= 1 << JEOC
            return
        channel, injected = steps[place]
        sampling = self._sampling(channel)
        if channel in (TEMPERATURE, REFERENCE):
            if not self.bit("CCR", 23):
                self.violation(f"channel {channel} is converted, which is not enabled")
            if sampling / hz < INTERNAL_S:
                self.violation(f"channel {channel} is sampled for {sampling / hz * 1e6} us, at least 10 are due")

        pin = PINS.get(channel)
        if pin and self.chip.gpio[pin[1]].mode(int(pin[2:])) != ANALOG:
            self.violation(f"{pin} is converted, which is not analogue")

        def converted():
            if generation != self.generation:
                return
            # What was sampled half a microsecond before: an event less for each of twenty conversions a tick.
            code = self.chip.board.code(channel)
            if injected is None:
                self._regular(code)
            else:
                self[f"JDR{injected + 1}"] = code - self[f"JOFR{injected + 1}"]
            self._convert(steps, place + 1, hz, generation)

        self.chip.after((sampling + CONVERSION) / hz, converted)
