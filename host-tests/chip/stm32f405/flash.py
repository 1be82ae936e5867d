"""The flash's registers and its sectors (RM0090, chapter 3; times and wear of DS8626, "Flash memory")."""

import random

from .peripheral import Peripheral, Register

START = 0x0800_0000
KEYS = 0x4567_0123, 0xCDEF_89AB
# Ends of the sectors, from the start of the flash. Unit: byte.
ENDS = [0x4000, 0x8000, 0xC000, 0x10000, *range(0x20000, 0x100001, 0x20000)]
# The sector of the starter's log, and those of the two places for an image (memory.x).
LOG, PLACES = 3, (range(4, 8), range(8, 12))
PLACE_A, PLACE_B = START + 0x10000, START + 0x80000
# Typical times at 32 bits. Unit: s.
PROGRAM_S, ERASE_16K_S, ERASE_64K_S, ERASE_128K_S = 16e-6, 0.25, 0.55, 1.0
PG, SER, MER, STRT, LOCK = 0, 1, 2, 16, 31
EOP, OPERR, WRPERR, PGAERR, PGPERR, PGSERR, BSY = 0, 1, 4, 5, 6, 7, 16
# Option bytes as the chip is delivered: no brown-out reset.
DELIVERED = 0x0FFF_AAED


def sector_begin(sector):
    """The address of a sector."""
    return START + ([0, *ENDS])[sector]


class Flash(Peripheral):
    NAME, BASE = "FLASH", 0x4002_3C00
    REGISTERS = {
        0x00: Register("ACR", 0, 0x1F07),
        0x04: Register("KEYR"),
        0x08: Register("OPTKEYR"),
        0x0C: Register("SR", 0, 0x0001_00F3),
        0x10: Register("CR", 1 << LOCK, 0x8301_037F),
        0x14: Register("OPTCR", DELIVERED, 0x0FFF_FFEF),
    }

    def __init__(self, chip):
        # Sectors that were erased, in order.
        self.erased = []
        # How often the data cache was.
        self.emptied = 0
        # What is being done: address, contents before, contents behind.
        self.operation = None
        self.programmed_words = 0
        # What the program has asked for since somebody has last emptied this: address, bytes.
        self.asked = []
        # Whether contents have changed since the last reset.
        self.has_changed = False
        # Whether its cells do not keep what is programmed.
        self.is_worn = False
        # Sectors that refuse, by write protection.
        self.protected = set()
        self.option_bytes = DELIVERED
        # Sectors that the program may erase which has no starter.
        self.of_bring_up = set()
        super().__init__(chip)

    def reset(self):
        super().reset()
        self["OPTCR"] = self.option_bytes
        self.keys_seen, self.is_blocked = 0, False
        self.busy_until = 0.0
        self._waiting = []

    # The registers.

    def write_ACR(self, value):
        if value >> 12 & 1 and self["ACR"] >> 10 & 1:
            self.violation("the data cache is emptied while it is enabled")
        if value >> 11 & 1 and self["ACR"] >> 9 & 1:
            self.violation("the instruction cache is emptied while it is enabled")
        self.emptied += value >> 12 & 1 & ~(self["ACR"] >> 12)
        self["ACR"] = value
        self.chip.rcc.check_limits()

    def write_KEYR(self, value):
        if self.is_blocked or not self.bit("CR", LOCK) or value != KEYS[self.keys_seen]:
            self.violation("a wrong key, or keys for an open flash: it stays locked until the next reset")
            self.is_blocked = True
            self["CR"] |= 1 << LOCK
            return
        self.keys_seen = (self.keys_seen + 1) % 2
        if self.keys_seen == 0:
            self["CR"] &= ~(1 << LOCK)

    def read_SR(self, value):
        self.settle()
        return value & 0xFFFF | self.is_busy() << BSY

    def write_SR(self, value):
        self["SR"] &= ~(value & 0xF3)

    def is_busy(self):
        return self.chip.now < self.busy_until

    def write_CR(self, value):
        if self.is_busy():
            self.violation("CR is written while the flash is busy")
        if self.bit("CR", LOCK):
            if value != self["CR"]:
                self.violation(f"CR is written while it is locked, {value:#010x}: ignored")
            return
        self["CR"] = value & ~(1 << STRT)
        if value >> LOCK & 1:
            if value & 7:
                self.violation("locked while programming or erasing is selected: it stays selected")
            return
        if value >> STRT & 1:
            if value >> MER & 1 or not value >> SER & 1:
                self.violation("an erasure of the whole chip, or of nothing, is started")
            else:
                self._erase(value >> 3 & 0xF)

    def _erase(self, sector):
        if self.field("CR", 8, 2) == 2 and self.chip.supply_v < 2.7:
            self.violation(f"32 bits in parallel at {self.chip.supply_v} V")
        if sector in self.protected or sector >= len(ENDS):
            self["SR"] |= 1 << WRPERR
            return
        first, end = ([0, *ENDS])[sector], ENDS[sector]
        if sector not in self.free() - ({LOG} - self.of_bring_up):
            self.violation(f"the sector {sector} is erased by what runs at {self.chip.scb['VTOR']:#010x}")
        self.has_changed = True
        self.erased.append(sector)
        length = end - first
        before = self.chip.memory_read(START + first, length)
        self.operation = START + first, before, b"\xff" * length
        self.chip.memory_write(START + first, b"\xff" * length)
        self._work(ERASE_16K_S if length == 0x4000 else ERASE_64K_S if length == 0x10000 else ERASE_128K_S)

    def _work(self, for_s):
        self.busy_until = max(self.busy_until, self.chip.now) + for_s
        # Whoever fetches from the flash meanwhile waits, which is the whole program.
        self.chip.stall_until(self.busy_until)

    # Stores of the program.

    def store(self, address, size, value):
        """A store to the flash; the memory takes what comes of it before the next block of instructions."""
        old = int.from_bytes(self.chip.memory_read(address, size), "little")
        self._waiting.append((address, size, self._programmed(address, size, old, value)))

    def _programmed(self, address, size, old, value):
        parallel = 1 << self.field("CR", 8, 2)
        if self.bit("CR", LOCK) or not self.bit("CR", PG):
            self["SR"] |= 1 << PGSERR
            self.violation(f"a store to {address:#010x} while programming is not selected")
            return old
        if self.is_busy():
            self.violation("a word is programmed while the flash is busy")
        if size != parallel:
            self["SR"] |= 1 << PGPERR
            return old
        if address % size:
            self["SR"] |= 1 << PGAERR
            return old
        if parallel == 4 and self.chip.supply_v < 2.7:
            self.violation(f"32 bits in parallel at {self.chip.supply_v} V")
        sector = next(k for k, end in enumerate(ENDS) if address - START < end)
        if sector in self.protected:
            self["SR"] |= 1 << WRPERR
            return old
        self.has_changed = True
        if sector not in self.free():
            self.violation(f"the code at {address:#010x} is programmed")
        self.programmed_words += 1
        self.asked.append((address, (old & value).to_bytes(size, "little")))
        self._work(PROGRAM_S)
        new = old if self.is_worn else old & value
        self.operation = address, old.to_bytes(size, "little"), new.to_bytes(size, "little")
        return new

    def free(self):
        """Sectors that the program which runs may change: the log, and, behind the starter, store and other place."""
        others = {PLACE_A: PLACES[1], PLACE_B: PLACES[0]}.get(self.chip.scb["VTOR"])
        return {LOG} if others is None else {LOG, 1, 2, *others}

    def cut(self, seed):
        """Power is lost: of an operation that runs some bits are as before, some as behind."""
        self.settle()
        if self.is_busy():
            address, before, behind = self.operation
            chosen = random.Random(seed).randbytes(len(before))
            mixed = bytes(b & ~c | n & c for b, n, c in zip(before, behind, chosen))
            self.chip.memory_write(address, mixed)

    def settle(self):
        """Puts into the memory what became of stores."""
        for address, size, value in self._waiting:
            self.chip.memory_write(address, value.to_bytes(size, "little"))
        self._waiting.clear()
