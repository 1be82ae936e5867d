"""What takes minutes: requests behind other boards' answers, saves, losses of power.

    MGPI_CHIP_PYTHON=target/chip-model/bin/python MGPI_CHIP_PROGRAM=long_runs.py \
        cargo test -p host-tests --test chip

MGPI_CHIP_SHARE (1 unless it is set) is the share of the numbers that are run, MGPI_CHIP_RUNS names some of the runs:
`requests cuts saves`, MGPI_CHIP_SEED (0) is another course of chance: so a long run may be made in parts.
"""

import os
import random
import struct
import sys
import unittest

from stm32f405.case import ChipCase
from stm32f405.flash import START
from stm32f405.host import read_frame, with_crc, write_frame
from stm32f405.saves import save_again_and_again

REQUESTS, SAVES, CUTS = 10_000, 100_000, 2_000
# A save in so many finds a flash that keeps nothing.
WORN = 100
SILENT_TICKS, SECTORS, STATE = 0x418, START + 0x4000, 0x200
SHARE = float(os.environ.get("MGPI_CHIP_SHARE", "1"))
SEED = int(os.environ.get("MGPI_CHIP_SEED", "0"))


class LongRuns(ChipCase):
    """The runs; each prints what it has counted, and answers what was lost."""

    def requests(self):
        """Behind answers of known and unknown functions, at 1.75 and 0.75 ms, at every phase of the tick."""
        chip, _ = self.started()
        chance, lost, count = random.Random(f"requests {SEED}"), 0, int(REQUESTS * SHARE)
        for number in range(count):
            head = struct.pack(">BBB", 2, (3, 43)[number % 2], 24)
            foreign = with_crc(head + chance.randbytes(24))
            gap_s = (1.75e-3, 0.75e-3)[number // 2 % 2]
            chip.run(4e-3 + chance.random() * 1e-3)
            chip.board.bus.sent.clear()
            end = chip.board.send(chip.usart1, foreign)
            chip.run(end - chip.now + gap_s)
            end = chip.board.send(chip.usart1, read_frame(STATE, 1))
            chip.run(end - chip.now + 3e-3)
            lost += len(chip.board.bus.sent) != 7
        print(f"{count} requests behind other boards' answers: {lost} lost", flush=True)
        return lost

    def saves(self):
        """Some find a worn flash."""
        counted = save_again_and_again(self, int(SAVES * SHARE), WORN, f"saves {SEED}", is_told=True)
        print(counted, flush=True)
        return counted.wrong + counted.lost

    def cuts(self):
        """Power is lost at a random moment of a save, of which each fourth erases."""
        with open(os.environ["MGPI_CHIP_STORE"], "rb") as file:
            full = file.read()
        chip, chance, wrong, partial = self.chip(), random.Random(f"cuts {SEED}"), 0, 0
        count = int(CUTS * SHARE)
        master = self.start(chip)
        for number in range(count):
            erases = number % 4 == 0
            if erases:
                chip.memory_write(SECTORS, full)
                master = self.start(chip)
            old = master.get("bus_silent_ticks")
            new = 2000 + number
            chip.run(4e-3)
            chip.board.bus.sent.clear()
            end = chip.board.send(chip.usart1, write_frame(SILENT_TICKS, struct.pack(">I", new)))
            chip.run(end - chip.now)
            begun = len(chip.flash.erased)
            if erases and chip.run(until=lambda begun=begun: len(chip.flash.erased) > begun, most_s=0.1):
                chip.now += chance.random() * 0.25
            else:
                chip.run(chance.random() * 4e-3)
            is_told = len(chip.board.bus.sent) == 8
            partial += chip.flash.is_busy()
            master = self.start(chip)
            kept, fault = master.get("bus_silent_ticks"), master.get("fault")
            wrong += kept not in ((new,) if is_told else (old, new)) or fault != 0
        print(f"{count} losses of power, {partial} of them within an operation of the flash: {wrong} wrong", flush=True)
        return wrong

    def runTest(self):
        """All of them."""
        chosen = os.environ.get("MGPI_CHIP_RUNS", "requests cuts saves").split()
        failed = sum(getattr(self, name)() for name in chosen)
        self.assertEqual(failed, 0)


if __name__ == "__main__":
    result = unittest.TextTestRunner().run(LongRuns())
    sys.exit(not result.wasSuccessful())
