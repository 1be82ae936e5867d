"""The processor's own registers: interrupt controller, system control, SysTick, cycle counter (PM0214)."""

from .peripheral import Peripheral, Register

NMI, HARD_FAULT, SYSTICK, FIRST_IRQ = 2, 3, 15, 16
IRQS = 82
# 4 bits of priority, the upper ones of a byte.
PRIORITY_BITS = 0xF0


class Nvic(Peripheral):
    """Which interrupts are enabled, pending and active, and which comes next."""

    NAME, BASE, SIZE = "NVIC", 0xE000_E100, 0xC00
    BANKS = {0x00: "ISER", 0x80: "ICER", 0x100: "ISPR", 0x180: "ICPR"}

    def reset(self):
        self.enabled, self.pending, self.exceptions = set(), set(), set()
        self.priority = [0] * IRQS
        # Exception numbers, the innermost last.
        self.active = []

    def read(self, offset, size):
        if offset >= 0x300:
            return int.from_bytes(bytes(self.priority[offset - 0x300 : offset - 0x300 + size]), "little")
        numbers = self.pending if offset & 0x100 else self.enabled
        first = (offset & 0x7F) * 8
        return sum(1 << k for k in range(32) if first + k in numbers)

    def write(self, offset, size, value):
        # What was cleared, and is wanted still, is pending again.
        self.chip.lines_have_changed = True
        if offset >= 0x300:
            for k in range(size):
                self.priority[offset - 0x300 + k] = value >> 8 * k & PRIORITY_BITS
            return
        first = (offset & 0x7F) * 8
        numbers = {first + k for k in range(32) if value >> k & 1}
        bank = self.BANKS.get(offset & ~0x7F)
        if bank == "ISER":
            self.enabled |= numbers
        elif bank == "ICER":
            self.enabled -= numbers
        elif bank == "ISPR":
            self.pending |= numbers
        elif bank == "ICPR":
            self.pending -= numbers
        else:
            self.violation(f"write of offset {offset:#x}")

    def pend_exception(self, number):
        self.exceptions.add(number)

    def gather(self):
        """Takes what the peripherals want."""
        if not self.chip.lines_have_changed:
            return
        self.chip.lines_have_changed = False
        for source in self.chip.sources:
            for irq in source.lines():
                if irq + FIRST_IRQ not in self.active:
                    self.pending.add(irq)

    def priority_of(self, number):
        """Of an exception; the lower the more urgent."""
        if number < 4:
            return number - 4
        if number >= FIRST_IRQ:
            return self.priority[number - FIRST_IRQ]
        return self.chip.scb.priority_of(number)

    def level(self):
        """What runs now: its priority."""
        return min((self.priority_of(number) for number in self.active), default=256)

    def next(self):
        """The exception that would be taken, if nothing masks it."""
        if not self.pending and not self.exceptions:
            return None
        waiting = [irq + FIRST_IRQ for irq in self.pending & self.enabled] + list(self.exceptions)
        return min(waiting, key=lambda number: (self.priority_of(number), number), default=None)

    def take(self, number):
        """An exception begins."""
        self.active.append(number)
        if number >= FIRST_IRQ:
            self.pending.discard(number - FIRST_IRQ)
        else:
            self.exceptions.discard(number)


class Scb(Peripheral):
    NAME, BASE, SIZE = "SCB", 0xE000_ED00, 0x300
    REGISTERS = {
        0x00: Register("CPUID", 0x410F_C241),
        0x04: Register("ICSR"),
        0x08: Register("VTOR", 0x0800_0000),
        0x0C: Register("AIRCR", 0xFA05_0000),
        0x10: Register("SCR"),
        0x14: Register("CCR", 0x200),
        0x18: Register("SHPR1"),
        0x1C: Register("SHPR2"),
        0x20: Register("SHPR3"),
        0x24: Register("SHCSR"),
        0x28: Register("CFSR"),
        0x2C: Register("HFSR"),
        0x34: Register("MMFAR"),
        0x38: Register("BFAR"),
        0x88: Register("CPACR"),
        0xF0: Register("DHCSR"),
        0xFC: Register("DEMCR"),
        0x200: Register("STIR"),
        0x234: Register("FPCCR", 0xC000_0000),
        0x238: Register("FPCAR"),
        0x23C: Register("FPDSCR"),
    }

    def priority_of(self, number):
        name, place = f"SHPR{number // 4}", 8 * (number % 4)
        return self[name] >> place & PRIORITY_BITS

    def read_ICSR(self, _):
        nvic = self.chip.nvic
        active = nvic.active[-1] if nvic.active else 0
        return active | (SYSTICK in nvic.exceptions) << 26 | (NMI in nvic.exceptions) << 31

    def write_ICSR(self, value):
        exceptions = self.chip.nvic.exceptions
        for place, number in ((31, NMI), (28, 14), (26, SYSTICK)):
            if value >> place & 1:
                exceptions.add(number)
        for place, number in ((27, 14), (25, SYSTICK)):
            if value >> place & 1:
                exceptions.discard(number)

    def read_SHCSR(self, value):
        return value & ~(1 << 11) | (SYSTICK in self.chip.nvic.active) << 11

    def write_CFSR(self, value):
        self["CFSR"] &= ~value

    def write_AIRCR(self, value):
        if value >> 16 != 0x05FA:
            self.violation("AIRCR is written without its key")
        elif value >> 2 & 1:
            self.chip.reset("software")


class SysTick(Peripheral):
    NAME, BASE, SIZE = "SysTick", 0xE000_E000, 0x100
    REGISTERS = {
        0x04: Register("ACTLR"),
        0x10: Register("CTRL", 0, 0x1_0007),
        0x14: Register("LOAD", 0, 0xFF_FFFF),
        0x18: Register("VAL"),
        0x1C: Register("CALIB", 0xC000_0000),
    }

    def reset(self):
        super().reset()
        self.generation = getattr(self, "generation", 0) + 1
        self.due = 0.0
        # When it was raised, for the tests.
        self.raised = []

    def _hz(self):
        return self.chip.core_hz if self.bit("CTRL", 2) else self.chip.core_hz / 8

    def read_VAL(self, _):
        if not self.bit("CTRL", 0):
            return 0
        return max(int((self.due - self.chip.now) * self._hz()), 0) % (self["LOAD"] + 1)

    def write_VAL(self, _):
        self["VAL"] = 0
        self._plan()

    def write_CTRL(self, value):
        self["CTRL"] = value & 7
        self._plan()

    def read_CTRL(self, value):
        self["CTRL"] &= ~(1 << 16)
        return value

    def _plan(self):
        self.generation += 1
        if self.bit("CTRL", 0) and self["LOAD"]:
            self.due = self.chip.now + (self["LOAD"] + 1) / self._hz()
            self._wait(self.generation)

    def _wait(self, generation):
        def reached():
            if generation == self.generation:
                self["CTRL"] |= 1 << 16
                if self.bit("CTRL", 1):
                    self.chip.nvic.pend_exception(SYSTICK)
                self.due += (self["LOAD"] + 1) / self._hz()
                self._wait(generation)

        self.chip.at(self.due, reached)

    def replan(self, old_hz):
        """The core's clock has changed: what is left goes on at the new one."""
        if self.bit("CTRL", 0) and self["LOAD"]:
            left = max(self.due - self.chip.now, 0.0) * old_hz / self.chip.core_hz
            self.generation += 1
            self.due = self.chip.now + left
            self._wait(self.generation)

    def halt(self, is_halted):
        """It stands still with the core."""
        if is_halted:
            self.left = self.due - self.chip.now
            self.generation += 1
        elif self.bit("CTRL", 0):
            self.generation += 1
            self.due = self.chip.now + self.left
            self._wait(self.generation)


class Dwt(Peripheral):
    """The cycle counter."""

    NAME, BASE, SIZE = "DWT", 0xE000_1000, 0x1000
    REGISTERS = {0x00: Register("CTRL", 0x4000_0000), 0x04: Register("CYCCNT"), 0xFB0: Register("LAR")}

    def read_CYCCNT(self, _):
        return int(self.chip.cycles) & 0xFFFF_FFFF if self.bit("CTRL", 0) else 0
