"""RCC: oscillators, multiplier, buses, clock security, causes of a reset (RM0090, chapter 7)."""

from .peripheral import Peripheral, Register

HSI_HZ = 16e6
# Times to start. Unit: s.
HSE_START_S, PLL_START_S = 2e-3, 200e-6
# Limits of the manual. Unit: Hz.
CORE_MOST, APB1_MOST, APB2_MOST = 168e6, 42e6, 84e6
# Most frequency of the core for each number of wait states, at 2.7 V and more (RM0090, table 10). Unit: Hz.
HZ_PER_WAIT_STATE = 30e6
# What a multiplier without a reference does. Unit: share of its frequency.
FREE_SHARE = 0.3

HSEON, HSERDY, CSSON, PLLON, PLLRDY = 16, 17, 19, 24, 25
CAUSES = {
    "power": 0x0E00_0000,
    "brown-out": 0x0600_0000,
    "pin": 0x0400_0000,
    "software": 0x1400_0000,
    "watchdog": 0x2400_0000,
}


class Rcc(Peripheral):
    NAME, BASE = "RCC", 0x4002_3800
    REGISTERS = {
        0x00: Register("CR", 0x83, 0x0F0F_FFFB),
        0x04: Register("PLLCFGR", 0x2400_3010, 0x0F43_7FFF),
        0x08: Register("CFGR", 0, 0xFFFF_FCFF),
        0x0C: Register("CIR", 0, 0x00BF_3FBF),
        0x10: Register("AHB1RSTR"),
        0x20: Register("APB1RSTR"),
        0x24: Register("APB2RSTR"),
        0x30: Register("AHB1ENR", 0x0010_0000, 0x7E7C_11FF),
        0x40: Register("APB1ENR", 0, 0x36FE_C9FF),
        0x44: Register("APB2ENR", 0, 0x0007_5F33),
        0x70: Register("BDCR", 0, 0x0001_8307),
        0x74: Register("CSR", 0x0E00_0000, 0xFF00_0003),
    }

    def __init__(self, chip):
        self.hse_works = self.pll_works = True
        self.hse_hz = 8e6
        self.flags = CAUSES["power"]
        self.switched_with_prescalers = False
        super().__init__(chip)

    def reset(self):
        super().reset()
        self["CSR"] = self.flags
        self.generation = getattr(self, "generation", 0) + 1

    def power_off(self):
        self.flags = 0

    def has_been_reset(self, cause):
        """Adds the flags of a reset; they stay until they are cleared."""
        self.flags |= CAUSES[cause]
        self["CSR"] = self.flags

    def write_CR(self, value):
        old, ready = self["CR"], self["CR"] & (1 << HSERDY | 1 << PLLRDY | 2)
        if old >> PLLON & 1 and not value >> PLLON & 1 and self.field("CFGR", 2, 2) == 2:
            self.violation("the multiplier is stopped while it clocks the core")
            value |= 1 << PLLON
        self["CR"] = value & ~(1 << HSERDY | 1 << PLLRDY | 2) | ready
        self._start(value & ~old, HSEON, HSERDY, HSE_START_S, lambda: self.hse_works)
        self._start(value & ~old, PLLON, PLLRDY, PLL_START_S, lambda: self.pll_works and self._source_ready())
        for on, is_ready in ((HSEON, HSERDY), (PLLON, PLLRDY)):
            if not value >> on & 1:
                self["CR"] &= ~(1 << is_ready)

    def _start(self, rising, on, is_ready, after_s, works):
        if rising >> on & 1 and works():
            generation = self.generation

            def done():
                if self.generation == generation and self.bit("CR", on) and works():
                    self["CR"] |= 1 << is_ready

            self.chip.after(after_s, done)

    def _source_ready(self):
        if self.bit("PLLCFGR", 22) and not self.bit("CR", HSERDY):
            self.violation("the multiplier is started before the crystal is ready")
            return False
        return True

    def write_PLLCFGR(self, value):
        if self.bit("CR", PLLON):
            self.violation("PLLCFGR is written while the multiplier runs")
            return
        self["PLLCFGR"] = value

    def write_CFGR(self, value):
        old = self["CFGR"]
        if (value ^ old) & 3 and (value ^ old) & 0xFCF0:
            self.violation("prescalers and switch are changed in one write of CFGR")
        self["CFGR"] = value & ~0xC | old & 0xC
        wanted = value & 3
        is_ready = {0: self.bit("CR", 1), 1: self.bit("CR", HSERDY), 2: self.bit("CR", PLLRDY)}
        if is_ready.get(wanted):
            self["CFGR"] = self["CFGR"] & ~0xC | wanted << 2
        elif wanted != old & 3:
            self.violation(f"the core is switched to clock {wanted}, which is not ready")
        self.check_limits()

    def write_CSR(self, value):
        if value >> 24 & 1:
            self.flags = 0
        self["CSR"] = value & 0x0000_0001 | (value & 1) << 1 | self.flags

    def write_CIR(self, value):
        # The upper byte clears the flags of the lowest.
        self["CIR"] = value & 0x3F00 | self["CIR"] & 0xFF & ~(value >> 16 & 0xFF)

    def vco_hz(self):
        """The frequency of the multiplier's oscillator."""
        source = self.hse_hz if self.bit("PLLCFGR", 22) else HSI_HZ
        into = source / max(self.field("PLLCFGR", 0, 6), 1)
        if not 0.95e6 <= into <= 2.1e6:
            self.violation(f"the multiplier is fed with {into / 1e6} MHz, must be 1 to 2")
        vco = into * self.field("PLLCFGR", 6, 9)
        if not 100e6 <= vco <= 432e6:
            self.violation(f"the multiplier's oscillator runs at {vco / 1e6} MHz, must be 100 to 432")
        if self.bit("PLLCFGR", 22) and not self.hse_works:
            vco *= FREE_SHARE
        return vco

    def core_hz(self):
        """The processor's clock."""
        source = self.field("CFGR", 2, 2)
        if source == 2:
            system = self.vco_hz() / (2 * self.field("PLLCFGR", 16, 2) + 2)
        else:
            system = self.hse_hz if source == 1 else HSI_HZ
        prescaler = self.field("CFGR", 4, 4)
        return system / (1 if prescaler < 8 else (2, 4, 8, 16, 64, 128, 256, 512)[prescaler - 8])

    def _divider(self, place):
        prescaler = self.field("CFGR", place, 3)
        return 1 if prescaler < 4 else 2 << prescaler - 4

    def apb_hz(self, number):
        """The clock of a peripheral bus, 1 or 2."""
        return self.chip.core_hz / self._divider(10 if number == 1 else 13)

    def timer_hz(self, number):
        """The clock of the timers of a bus."""
        divider = self._divider(10 if number == 1 else 13)
        return self.chip.core_hz / divider * (1 if divider == 1 else 2)

    def check_limits(self):
        """Holds the clocks against the manual's limits, and tells the chip of the core's."""
        core = self.core_hz()
        self.chip.set_core_hz(core)
        states = self.chip.flash.field("ACR", 0, 3)
        if core > (states + 1) * HZ_PER_WAIT_STATE:
            self.violation(f"{core / 1e6} MHz with {states} wait states")
        for what, hz, most in (
            ("the core", core, CORE_MOST),
            ("APB1", self.apb_hz(1), APB1_MOST),
            ("APB2", self.apb_hz(2), APB2_MOST),
        ):
            if hz > most:
                self.violation(f"{what} runs at {hz / 1e6} MHz, at most {most / 1e6} are allowed")
        if core > 120e6 and self.chip.supply_v < 2.7:
            self.violation(f"{core / 1e6} MHz at {self.chip.supply_v} V")

    def lose_crystal(self):
        """The crystal stops."""
        self.hse_works = False
        if not self.bit("CR", HSERDY):
            return
        self["CR"] &= ~(1 << HSERDY)
        if self.bit("CR", CSSON):
            self["CR"] &= ~(1 << HSEON | 1 << CSSON)
            if self.field("CFGR", 2, 2):
                self["CFGR"] &= ~0xF
                if self.bit("PLLCFGR", 22):
                    self["CR"] &= ~(1 << PLLON | 1 << PLLRDY)
            self["CIR"] |= 1 << 7
            self.chip.nvic.pend_exception(2)
        self.chip.set_core_hz(self.core_hz())
