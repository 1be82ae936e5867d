"""Saves without end: whether each is told right, and whether what was accepted is there."""

import dataclasses
import random

from .host import Refused

DEVICE_FAILURE = 4
# Between a frame and the next: more than 3.5 characters. Unit: s.
PAUSE_S = 2e-3
# The board is switched off behind each save of this number.
OFF_EACH = 50
# The values that are saved in turn, each another one than that before.
LOWEST, VALUES = 1000, 50_000


@dataclasses.dataclass
class Counted:
    """What has become of saves: `refused`: failed and were told; `wrong`: told wrongly; `lost`: accepted, and not there."""

    saves: int = 0
    erasures: int = 0
    refused: int = 0
    wrong: int = 0
    lost: int = 0

    def __str__(self):
        return (
            f"{self.saves} saves, {self.erasures} erasures: {self.refused} failed and were told, "
            f"{self.wrong} told wrongly, {self.lost} lost silently"
        )


def save_again_and_again(case, count, worn_one_in, seed, is_told=False):
    """Saves by the bus, of which one in so many, by chance, finds a flash that keeps nothing. What was accepted has to stand in
    the flash, word for word; behind each fiftieth the board is switched off, and has to have the last that was accepted."""
    chip, master = case.started()
    counted, chance, kept = Counted(), random.Random(seed), master.get("bus_silent_ticks")
    for number in range(1, count + 1):
        value = LOWEST + number % VALUES
        chip.flash.is_worn = chance.randrange(worn_one_in) == 0
        chip.flash.asked.clear()
        told = None
        try:
            master.set("bus_silent_ticks", value, timeout_s=3.0, pause_s=PAUSE_S)
            kept = value
        except Refused as refusal:
            told = refusal.number
        # What is there already is not written again, so each of them writes.
        counted.wrong += told != (DEVICE_FAILURE if chip.flash.is_worn else None)
        counted.refused += told is not None
        stands = all(chip.memory_read(address, len(data)) == data for address, data in chip.flash.asked)
        counted.lost += told is None and not (stands and chip.flash.asked)
        if number % OFF_EACH == 0:
            chip.flash.is_worn = False
            master = case.start(chip)
            counted.lost += told is None and master.get("bus_silent_ticks") != kept
            counted.wrong += master.get("fault") != 0
            # One that was refused may be there or not.
            kept = master.get("bus_silent_ticks")
        counted.saves, counted.erasures = number, len(chip.flash.erased)
        if is_told and number % 1000 == 0:
            print(f"of {count}: {counted}", flush=True)
    return counted
