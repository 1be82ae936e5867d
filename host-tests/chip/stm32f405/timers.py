"""TIM2, TIM3, TIM5 and TIM11: counting up, trigger output, pulses of channel 1, captures of oscillators (RM0090,
chapters 18 and 19)."""

from .peripheral import Register, Source

CEN, UDIS, OPM, ARPE = 0, 1, 3, 7
# What each timer's update starts at the converter's injected group, by JEXTSEL.
INJECTED_TRIGGER = {"TIM2": 3}
# Prescaler of what is captured, by ICxPSC.
EDGES = (1, 2, 4, 8)


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
    # The bus that clocks it; the channel that captures an oscillator, and the setting of OR that connects it.
    BUS = 1
    CAPTURES = None

    def reset(self):
        super().reset()
        self.captures = getattr(self, "captures", 0) + 1
        self["ARR"] = self.most = 0xFFFF_FFFF if self.NAME in ("TIM2", "TIM5") else 0xFFFF
        self.prescaler, self.compare = 0, 0
        # When the next update takes the compare value that waits in the preload; none where none does.
        self.preloaded_until = None
        self.since, self.base = 0.0, 0
        self.generation = getattr(self, "generation", 0) + 1

    def hz(self):
        """The counter's clock."""
        return self.chip.rcc.timer_hz(self.BUS) / (self.prescaler + 1)

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

    def write_CCER(self, value):
        self["CCER"] = value
        self._capture_from_now()

    def _capture_from_now(self):
        """Captures edges of the oscillator that is connected, if any."""
        self.captures += 1
        hz = self._captured_hz()
        if hz:
            self._capture(self.captures, EDGES[self.field(self._mode(), self._shift() + 2, 2)] / hz)

    def _mode(self):
        return "CCMR1" if self.CAPTURES[0] < 3 else "CCMR2"

    def _shift(self):
        return 0 if self.CAPTURES[0] % 2 else 8

    def _captured_hz(self):
        """What is captured; None where nothing is."""
        if self.CAPTURES is None or not self.bit("CCER", 4 * (self.CAPTURES[0] - 1)):
            return None
        channel, setting = self.CAPTURES
        if self.field(self._mode(), self._shift(), 2) != 1 or self["OR"] != setting:
            self.violation(f"channel {channel} captures what the model has not")
            return None
        return self.oscillator_hz()

    def _capture(self, captures, each_s):
        def captured():
            if captures != self.captures or not self.oscillator_hz():
                return
            if self.bit("CR1", CEN):
                channel = self.CAPTURES[0]
                self["SR"] |= 1 << channel | (1 << channel + 8 if self.bit("SR", channel) else 0)
                self[f"CCR{channel}"] = self.count()
            self._capture(captures, each_s)

        self.chip.after(each_s, captured)

    def _read_capture(self, channel, value):
        self["SR"] &= ~(1 << channel)
        return value

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
        self._take_compare()
        self["CCR1"] = value
        if not self.bit("CCMR1", 3):
            self.compare = value
        elif self.bit("CR1", CEN):
            self.preloaded_until = self.chip.now + (self["ARR"] + 1 - self.count()) / self.hz()

    def _take_compare(self):
        """What an update has taken since the last look: updates that nobody waits for are not followed."""
        if self.preloaded_until is not None and self.chip.now >= self.preloaded_until:
            self.compare, self.preloaded_until = self["CCR1"], None

    def _take_preloads(self):
        self.prescaler = self["PSC"]
        self.compare, self.preloaded_until = self["CCR1"], None

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
        self._take_compare()
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
    # Channel 4 captures the watchdog's oscillator.
    CAPTURES = 4, 1 << 6

    def oscillator_hz(self):
        return self.chip.iwdg.lsi_hz if self.chip.rcc.bit("CSR", 1) else None

    def read_CCR4(self, value):
        return self._read_capture(4, value)


class Tim11(Timer):
    NAME, BASE, CLOCK, IRQ, BUS = "TIM11", 0x4001_4800, ("APB2ENR", 18), 26, 2
    REGISTERS = {
        **{offset: Timer.REGISTERS[offset] for offset in (0x00, 0x0C, 0x10, 0x14, 0x18, 0x20, 0x24, 0x28, 0x2C, 0x34)},
        0x50: Register("OR", 0, 0x3),
    }
    # Channel 1 captures the crystal's clock, divided as for a real-time clock.
    CAPTURES = 1, 2

    def oscillator_hz(self):
        rcc = self.chip.rcc
        divider = rcc.field("CFGR", 16, 5)
        return rcc.hse_hz / divider if rcc.bit("CR", 17) and divider > 1 else None

    def read_CCR1(self, value):
        return self._read_capture(1, value)
