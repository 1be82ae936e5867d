"""What peripherals have in common: registers with reset values and valid bits, a clock, a record of misuse."""


class Register:
    """A register of 32 bits. `valid`: the bits that are not reserved."""

    def __init__(self, name, reset=0, valid=0xFFFF_FFFF):
        self.name, self.reset, self.valid = name, reset, valid


class Peripheral:
    """Registers at an address. A subclass may define `read_NAME(value)` and `write_NAME(value)` for each."""

    NAME = ""
    BASE = 0
    SIZE = 0x400
    # Which bit of which register of the RCC clocks it; None: it is always clocked.
    CLOCK = None
    REGISTERS = {}

    def __init__(self, chip):
        self.chip = chip
        self._readers = {o: getattr(self, f"read_{r.name}", None) for o, r in self.REGISTERS.items()}
        self._writers = {o: getattr(self, f"write_{r.name}", None) for o, r in self.REGISTERS.items()}
        self.values = {}
        self.reset()

    def reset(self):
        """As behind a reset of the system."""
        self.values = {register.name: register.reset for register in self.REGISTERS.values()}

    def __getitem__(self, name):
        return self.values[name]

    def __setitem__(self, name, value):
        self.values[name] = value & 0xFFFF_FFFF

    def bit(self, name, place):
        """Whether a bit is set."""
        return bool(self.values[name] >> place & 1)

    def field(self, name, place, width):
        """A field of a register."""
        return self.values[name] >> place & (1 << width) - 1

    def violation(self, what):
        """Writes down what the manual forbids."""
        self.chip.violation(f"{self.NAME}: {what}")

    def _register(self, offset, how):
        register = self.REGISTERS.get(offset)
        if register is None:
            self.violation(f"{how} of offset {offset:#x}, where the model has no register")
        elif self.CLOCK and not self.chip.rcc.bit(*self.CLOCK):
            self.violation(f"{how} of {register.name} without a clock")
            return None
        return register

    def is_held(self):
        """Whether the RCC holds it in reset."""
        return self.CLOCK is not None and self.chip.rcc.bit(self.CLOCK[0].replace("ENR", "RSTR"), self.CLOCK[1])

    def read(self, offset, size):
        """What the processor reads."""
        register = self._register(offset & ~3, "read")
        if register is None:
            return 0
        value = self.values[register.name]
        reader = self._readers[offset & ~3]
        if reader is not None:
            value = reader(value)
        return value >> 8 * (offset & 3) & (1 << 8 * size) - 1

    def write(self, offset, size, value):
        """What the processor writes."""
        register = self._register(offset & ~3, "write")
        if register is None or self.is_held():
            return
        if size < 4:
            shift, mask = 8 * (offset & 3), (1 << 8 * size) - 1
            value = self.values[register.name] & ~(mask << shift) | (value & mask) << shift
        changed = (value ^ register.reset) & ~register.valid & 0xFFFF_FFFF
        if changed:
            self.violation(f"reserved bits {changed:#x} of {register.name} are changed")
        writer = self._writers[offset & ~3]
        if writer is None:
            self.values[register.name] = value
        else:
            writer(value)


class Source(Peripheral):
    """One that wants interrupts: `lines()` says which. The controller asks only behind a change of its registers."""

    def reset(self):
        super().reset()
        self.chip.lines_have_changed = True

    def __setitem__(self, name, value):
        super().__setitem__(name, value)
        self.chip.lines_have_changed = True

    def write(self, offset, size, value):
        super().write(offset, size, value)
        self.chip.lines_have_changed = True
