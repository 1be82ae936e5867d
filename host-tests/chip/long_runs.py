"""What takes minutes: requests behind other boards' answers, saves, losses of power, updates.

    MGPI_CHIP_PYTHON=target/chip-model/bin/python MGPI_CHIP_PROGRAM=long_runs.py \
        cargo test -p host-tests --test chip

MGPI_CHIP_SHARE (1 unless it is set) is the share of the numbers that are run, MGPI_CHIP_RUNS names some of the runs:
`requests rates cuts saves updates deaf`, MGPI_CHIP_SEED (0) is another course of chance: so a long run may be made in parts.
"""

import os
import random
import struct
import sys
import unittest

from stm32f405 import update
from stm32f405.flash import PLACES, START, sector_begin
from stm32f405.fork import begun
from stm32f405.host import Master, read_frame, take, with_crc, write_frame
from stm32f405.saves import save_again_and_again
from test_link import FORMATS, LinkAndBus

REQUESTS, SAVES, CUTS = 10_000, 100_000, 2_000
# Requests at each rate of the bus to a board that tracks.
OF_A_RATE = 500
# Losses of power at random moments of an update, beside those before each block.
UPDATE_CUTS = 500
# The highest rate of the bus, by which an update takes a fifth of the time. Unit: bit/s.
FAST_BAUD = 1_000_000
# A save in so many finds a flash that keeps nothing.
WORN = 100
SILENT_TICKS, SECTORS, STATE = 0x418, START + 0x4000, 0x200
SHARE = float(os.environ.get("MGPI_CHIP_SHARE", "1"))
SEED = int(os.environ.get("MGPI_CHIP_SEED", "0"))


class LongRuns(LinkAndBus):
    """The runs; each prints what it has counted, and answers what was lost."""

    def behind_others(self, chip, count, chance):
        """Requests behind answers of known and unknown functions to other boards, at the standard's silence and at 0.75 ms, on
        slow lines 1.5 characters, at every phase of the tick; how many are lost, and how many answers have gaps."""
        line, lost, torn = chip.board.bus, 0, 0
        byte_s = line.byte_s()
        for number in range(count):
            head = struct.pack(">BBB", 2, (3, 43)[number % 2], 24)
            foreign = with_crc(head + chance.randbytes(24))
            gap_s = (max(1.75e-3, 3.5 * byte_s), max(0.75e-3, 1.5 * byte_s))[number // 2 % 2]
            chip.run(3e-3 + 3.5 * byte_s + chance.random() * 1e-3)
            line.sent.clear()
            end = chip.board.send(chip.usart1, foreign)
            chip.run(end - chip.now + gap_s)
            end = chip.board.send(chip.usart1, read_frame(STATE, 1))
            chip.run(end - chip.now + 2.4e-3 + 7 * byte_s)
            moments = [moment for moment, _ in line.sent]
            lost += len(moments) != 7
            torn += any(later - earlier > byte_s + 1 / line.baud for earlier, later in zip(moments, moments[1:]))
        return lost, torn

    def requests(self):
        """To a board that is vented, at the rate of a new one."""
        chip, _ = self.started()
        count = int(REQUESTS * SHARE)
        lost, torn = self.behind_others(chip, count, random.Random(f"requests {SEED}"))
        print(f"{count} requests behind other boards' answers: {lost} lost, {torn} answers with gaps", flush=True)
        return lost + torn

    def rates(self):
        """To a board that tracks with every extension, at each rate."""
        chance, failed = random.Random(f"rates {SEED}"), 0
        count = int(OF_A_RATE * SHARE)
        for baud, parity in FORMATS:
            chip, master = self.started()
            take(master, baud, parity)
            self.track(chip)
            begun, state = chip.now, master.get("state", timeout_s=0.2)
            lost, torn = 0, 0
            for number in range(0, count, 25):
                # A sign of life.
                master.set("heartbeat", number + 1, timeout_s=0.2)
                of_these = self.behind_others(chip, min(25, count - number), chance)
                lost, torn = lost + of_these[0], torn + of_these[1]
            drives = master.get("state", timeout_s=0.2) == state
            failed += lost + torn + chip.board.lost_bytes + (not drives)
            print(
                f"{count} requests at {baud} bit/s, parity {parity}, in {chip.now - begun:.1f} s of the board: {lost} lost, {torn} answers "
                f"with gaps, {chip.board.lost_bytes} bytes lost, {'still tracking' if drives else 'vented'}",
                flush=True,
            )
        return failed

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

    def updates(self):
        """Power is lost before each block of a whole image, and at random moments of blocks, erasures, look, restart and trial."""
        chance = random.Random(f"updates {SEED}")
        chip, master = self.started()
        master.set("bus_silent_ticks", 777, timeout_s=1.0)
        master.put("bus_rate_bit_per_s", struct.pack(">I", FAST_BAUD), timeout_s=1.0)
        master.set("bus_take", 1)
        chip.run(0.01)
        chip.board.bus.baud = FAST_BAUD
        for sector in PLACES[1]:
            chip.memory_write(sector_begin(sector), bytes(64))
        running, done = [], []
        counted = {"before a block": 0, "at a random moment": 0, "within an operation of the flash": 0, "wrong": 0}

        def collect(most):
            while len(running) > most:
                kind, allowed, outcome = running.pop(0)
                *found, is_within = outcome()
                counted[kind] += 1
                counted["within an operation of the flash"] += is_within
                is_wrong = tuple(found[0] or ()) not in allowed or found[1:] != [0, 777, []]
                counted["wrong"] += is_wrong
                if is_wrong:
                    print(f"wrong: {kind}, {len(done)}: {found}", flush=True)
                done.append(found[0])
                if len(done) % 100 == 0:
                    print(f"{len(done)} losses of power: {counted}", flush=True)

        def cut(kind, later_s, allowed):
            collect(max(1, len(os.sched_getaffinity(0))) - 1)

            def work():
                chip.run(later_s)
                is_within = chip.flash.is_busy()
                self.start(chip)
                chip.board.bus.baud = FAST_BAUD
                found = [update.reached(master), master.get("fault"), master.get("bus_silent_ticks"), chip.violations]
                return [*found, is_within]

            running.append((kind, allowed, begun(work)))

        before, tried = (update.A, update.FOR_GOOD), (update.B, update.ON_TRIAL)
        blocks = update.blocks(update.image("b"))
        count = int(UPDATE_CUTS * SHARE)
        begins = [sector_begin(k) - update.PLACE_B for k in PLACES[1]]
        erasing = [n for n, (offset, block) in enumerate(blocks) if any(offset <= at < offset + len(block) for at in begins)]
        # Of a hundred random moments six are in each erasure that the image needs, and sixteen behind the last block.
        in_erasures, behind = count * 6 // 100, count * 16 // 100
        chosen = chance.choices(range(len(blocks)), k=count - len(erasing) * in_erasures - behind // 2 * 2)
        update.order(master, update.BEGIN)
        for number, (offset, block) in enumerate(blocks):
            if chance.random() < SHARE:
                cut("before a block", 0.0, [before])
            chip.run(1.8e-3)
            chip.board.bus.sent.clear()
            chip.board.send(chip.usart1, write_frame(0xB08, struct.pack(">I", offset) + block))
            for _ in range(chosen.count(number)):
                cut("at a random moment", chance.random() * 5e-3, [before])
            for _ in range(in_erasures if number in erasing else 0):
                cut("at a random moment", 3e-3 + chance.random(), [before])
            assert chip.run(until=lambda: len(chip.board.bus.sent) == 8, most_s=3.0)
            chip.run(2e-5)
        orders = [(update.TAKE, 0.18, [before, tried]), (update.RESTART, 10.2, [tried, (update.B, update.FOR_GOOD)])]
        for order, for_s, allowed in orders:
            chip.board.bus.sent.clear()
            chip.board.send(chip.usart1, write_frame(0xB00, struct.pack(">HH", order, 0)))
            moments = sorted(chance.random() * for_s for _ in range(behind // 2))
            begin = chip.now
            # A board that hears nobody for ten seconds tries another rate, and stays on trial.
            for moment in moments:
                chip.run(max(begin + moment - chip.now, 1e-6))
                cut("at a random moment", 0.0, allowed)
                if moment > 1.0:
                    master.get("state")
            chip.run(begin + for_s - chip.now + 0.2)
            master.get("state")
        collect(0)
        chip.run(1.0)
        at_last = update.reached(master)
        print(f"an update of {len(blocks)} blocks, losses of power: {counted}; without one the board ends as {at_last}", flush=True)
        return counted["wrong"] + (at_last != (update.B, update.FOR_GOOD))

    def deaf(self):
        """An image that nobody reaches while it is on trial: the former runs again behind three minutes."""
        chip, _ = self.started()
        update.put(chip, update.image("b"))
        update.append(chip, update.TRY_B)
        begin = chip.now
        chip.power_on()
        count = len(chip.resets) + 3
        is_back = chip.run(until=lambda: len(chip.resets) >= count, most_s=240.0) and update.settle(chip)
        print(f"an image that nobody reaches: {update.log_codes(chip)}, {chip.now - begin:.0f} s", flush=True)
        return not is_back or update.reached(Master(chip)) != (update.A, update.ROLLED_BACK)

    def runTest(self):
        """All of them."""
        chosen = os.environ.get("MGPI_CHIP_RUNS", "requests rates cuts saves updates deaf").split()
        failed = sum(getattr(self, name)() for name in chosen)
        self.assertEqual(failed, 0)


if __name__ == "__main__":
    result = unittest.TextTestRunner().run(LongRuns())
    sys.exit(not result.wasSuccessful())
