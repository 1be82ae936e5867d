"""TIM2, TIM3 and TIM5: counting up, trigger output, pulses of channel 1 (RM0090, chapter 18)."""

from .peripheral import Register, Source

CEN, UDIS, OPM, ARPE = 0, 1, 3, 7
# What each timer's update starts at the converter's injected group, by JEXTSEL.
INJECTED_TRIGGER = {"TIM2": 3}


class Timer(Source):
    REGISTERS = {
        0x00: Register("CR1", 0, 0x3FF),
        0x04: Register("CR2", 0, 0xF8),
        0x08: Register("SMCR", 0, 0xFFF7),
        0x0C: Register("DIER", 0, 0x5F5F),
        0x10: Register("SR", 0, 0x1E5F),
        0x14: Register("EGR", 0, 0x5F),
        0x18: Register("CCMR1", 0, 0xFFFF),
        0x1C: Register("CCMR2", 0, 0xFFFF),
        0x20: Register("CCER", 0, 0xBBBB),
        0x24: Register("CNT"),
        0x28: Register("PSC", 0, 0xFFFF),
        0x2C: Register("ARR", 0xFFFF_FFFF),
        **{0x34 + 4 * k: Register(f"CCR{k + 1}") for k in range(4)},
        0x50: Register("OR", 0, 0xC0),
    }
    FREEZE = None

    def reset(self):
        super().reset()
        self["ARR"] = self.most = 0xFFFF_FFFF if self.NAME in ("TIM2", "TIM5") else 0xFFFF
        self.prescaler, self.compare = 0, 0
        self.since, self.base = 0.0, 0
        self.generation = getattr(self, "generation", 0) + 1

    def hz(self):
        """The counter's clock."""
        return self.chip.rcc.timer_hz(1) / (self.prescaler + 1)

    def count(self):
        """Where the counter stands."""
        if not self.bit("CR1", CEN):
            return self.base
        # Half a millionth of a count: what rounding of the time makes.
        passed = int((self.chip.now - self.since) * self.hz() + 1e-6)
        return (self.base + passed) % (self["ARR"] + 1)

    def read_CNT(self, _):
        return self.count()

    def write_CNT(self, value):
        self.base, self.since = value, self.chip.now
        self._plan()

    def write_CR1(self, value):
        self.base, self.since = self.count(), self.chip.now
        self["CR1"] = value
        self._plan()

    def write_ARR(self, value):
        if value > self.most:
            self.violation(f"ARR takes {value:#x}")
        if not self.bit("CR1", ARPE):
            self.base, self.since = self.count(), self.chip.now
            self["ARR"] = value
            self._plan()
        else:
            self.violation("ARR with preload is not modelled")

    def write_EGR(self, value):
        if value & 1:
            self.base, self.since = 0, self.chip.now
            self._take_preloads()
            self._plan()

    def write_SR(self, value):
        self["SR"] &= value

    def write_CCR1(self, value):
        self["CCR1"] = value
        if not self.bit("CCMR1", 3):
            self.compare = value

    def _take_preloads(self):
        self.prescaler = self["PSC"]
        self.compare = self["CCR1"]

    def _plan(self):
        """Plans the next update."""
        self.generation += 1
        if not self.bit("CR1", CEN) or self["ARR"] == 0:
            return
        generation = self.generation
        until = (self["ARR"] + 1 - self.base) / self.hz()
        # A timer that nobody waits for is not followed.
        if self.NAME in INJECTED_TRIGGER or self["DIER"] & 1 or self.prescaler != self["PSC"]:
            self.chip.after(until, lambda: self._update(generation))

    def replan(self):
        """The clock has changed."""
        if self.bit("CR1", CEN):
            self.base, self.since = self.count(), self.chip.now
            self._plan()

    def _update(self, generation):
        if generation != self.generation:
            return
        self.base, self.since = 0, self.chip.now
        self["SR"] |= 1
        self._take_preloads()
        if self.field("CR2", 4, 3) == 2 and self.NAME in INJECTED_TRIGGER:
            self.chip.adc.trigger(INJECTED_TRIGGER[self.NAME])
        self._plan()

    def duty(self):
        """Share of the time that channel 1 is high, and its frequency in Hz; None while it is off."""
        if not self.bit("CR1", CEN) or not self.bit("CCER", 0) or self.field("CCMR1", 4, 3) != 6:
            return None
        period = self["ARR"] + 1
        return min(self.compare / period, 1.0), self.hz() / period

    def lines(self):
        """Whether the interrupt is wanted."""
        return (self.IRQ,) if self.values["SR"] & self.values["DIER"] & 0x5F else ()


class Tim2(Timer):
    NAME, BASE, CLOCK, IRQ, FREEZE = "TIM2", 0x4000_0000, ("APB1ENR", 0), 28, 0


class Tim3(Timer):
    NAME, BASE, CLOCK, IRQ, FREEZE = "TIM3", 0x4000_0400, ("APB1ENR", 1), 29, 1


class Tim5(Timer):
    NAME, BASE, CLOCK, IRQ, FREEZE = "TIM5", 0x4000_0C00, ("APB1ENR", 3), 50, 3
