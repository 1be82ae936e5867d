"""IWDG: the independent watchdog on its own oscillator (RM0090, chapter 21)."""

from .peripheral import Peripheral, Register

# An update of a register takes so many periods of the oscillator (RM0090, 21.4.4).
UPDATE_CLOCKS = 5
FREEZE = 12


class Iwdg(Peripheral):
    NAME, BASE = "IWDG", 0x4000_3000
    REGISTERS = {
        0x00: Register("KR", 0, 0xFFFF),
        0x04: Register("PR", 0, 0x7),
        0x08: Register("RLR", 0xFFF, 0xFFF),
        0x0C: Register("SR"),
    }

    def __init__(self, chip):
        # 17 to 47 kHz (DS8626). Unit: Hz.
        self.lsi_hz = 32e3
        super().__init__(chip)

    def reset(self):
        super().reset()
        self.is_open = self.is_running = False
        self.busy_until = {"PR": 0.0, "RLR": 0.0}
        # What the counter uses: prescaler and reload, once their update is over.
        self.used = {"PR": 0, "RLR": 0xFFF}
        self.generation = getattr(self, "generation", 0) + 1
        self.epoch = getattr(self, "epoch", 0) + 1
        self.frozen_left = None

    def read_SR(self, _):
        busy = [self.chip.now < self.busy_until[name] for name in ("PR", "RLR")]
        return busy[0] | busy[1] << 1

    def write_KR(self, value):
        self.is_open = value == 0x5555
        if value == 0xCCCC:
            self.is_running = True
        if value in (0xCCCC, 0xAAAA):
            self._reload()

    def write_PR(self, value):
        self._update("PR", value)

    def write_RLR(self, value):
        self._update("RLR", value)

    def _update(self, name, value):
        if not self.is_open:
            self.violation(f"{name} is written without the key")
            return
        if self.chip.now < self.busy_until[name]:
            self.violation(f"{name} is written while its update is not over: lost")
            return
        self[name] = min(value, 6) if name == "PR" else value
        self.busy_until[name] = self.chip.now + UPDATE_CLOCKS / self.lsi_hz
        epoch = self.epoch

        def done():
            if epoch != self.epoch:
                return
            # A new prescaler acts on what is left of the count; a new reload value at the next reload.
            left_s = (self.bites_at - self.chip.now) / (4 << self.used["PR"]) if self.is_running else None
            self.used[name] = self[name]
            if left_s is not None:
                self._bite_in(left_s * (4 << self.used["PR"]))

        self.chip.after(UPDATE_CLOCKS / self.lsi_hz, done)

    def period_s(self):
        """Time from a reload to the reset."""
        return (self.used["RLR"] + 1) * (4 << self.used["PR"]) / self.lsi_hz

    def _reload(self):
        if self.is_running:
            self._bite_in(self.period_s())

    def _bite_in(self, seconds):
        self.generation += 1
        generation = self.generation
        self.bites_at = self.chip.now + seconds

        def bite():
            if generation == self.generation:
                self.chip.reset("watchdog")

        self.chip.after(seconds, bite)

    def halt(self, is_halted):
        """A debugger halts the core, or lets it go on."""
        if not self.is_running or not self.chip.dbgmcu.bit("APB1_FZ", FREEZE):
            return
        if is_halted:
            self.frozen_left = self.bites_at - self.chip.now
            self.generation += 1
        elif self.frozen_left is not None:
            self._bite_in(self.frozen_left)
