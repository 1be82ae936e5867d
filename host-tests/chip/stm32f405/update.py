"""A new image to the board by its bus, as `mgpi update` sends it."""

import os
import pathlib
import struct

from .flash import PLACE_A, PLACE_B, START
from .host import Refused, Silent

A, B = 1, 2
BEGIN, TAKE, RESTART = 1, 2, 3
# What `update_result` and `update_trial` say.
TAKEN, NOT_WHOLE, OTHER_BOARD, OTHER_PLACE, OLDER, SIGNATURE = range(1, 7)
FOR_GOOD, ON_TRIAL, ROLLED_BACK, WAITS = range(4)
# Bytes of a block.
BLOCK = 240
# The longest that an erasure, or the look at an image, takes by the board. Unit: s.
LONG_S = 3.0
# Steps of the log.
FOR_GOOD_A, FOR_GOOD_B, TRY_A, TRY_B, TRIED = 0x11, 0x12, 0x21, 0x22, 0x30
TRIAL_S = 10.0
LOG = START + 0xC000


def image(name):
    """An image with its signature, as host-tests/tests/chip.rs makes it; none where it does not."""
    folder = os.environ.get("MGPI_CHIP_IMAGES")
    path = folder and pathlib.Path(folder) / name
    return path.read_bytes() if path and path.exists() else None


def blocks(content):
    """Offset and content of each."""
    return [(offset, content[offset : offset + BLOCK]) for offset in range(0, len(content), BLOCK)]


def send(master, content, told=lambda offset: None, first=0):
    """Writes an image, from a block on."""
    for offset, block in blocks(content):
        if offset >= first:
            told(offset)
            write_block(master, offset, block)


def write_block(master, offset, block, timeout_s=LONG_S):
    """Writes a block, and waits for the answer."""
    # The pause before a frame is 3.5 characters, 1.75 ms at least.
    master.put("update_offset", struct.pack(">I", offset) + block, timeout_s=timeout_s, pause_s=1.8e-3)


def put(chip, content, place=PLACE_B):
    """An image stands in the flash, as if it had been sent."""
    chip.memory_write(place, content + b"\xff" * (-len(content) % 4))


def order(master, number, older=0):
    """An order; those that the board refuses raise `Refused`."""
    master.put("update_order", struct.pack(">HH", number, older), timeout_s=LONG_S)


def restart(chip, master):
    """Restarts the board, and returns once it has started."""
    resets = len(chip.resets)
    order(master, RESTART)
    return chip.run(until=lambda: len(chip.resets) > resets, most_s=0.5) and settle(chip)


def settle(chip, most_s=3.0):
    """Waits until the program that is started waits for its ticks."""
    sleeps = chip.sleeps
    is_there = chip.run(until=lambda: chip.sleeps > sleeps, most_s=most_s)
    chip.run(5e-3)
    return is_there


def reached(master):
    """Where the image runs, and what is said of its trial; None of a board that does not answer."""
    try:
        return master.get("update_place"), master.get("update_trial")
    except (Silent, Refused):
        return None


def word(code):
    """A step as it stands in the log: with its complement."""
    return code | (~code & 0xFFFF) << 16


def append(chip, code):
    """Writes a step into the log, as if the board had."""
    chip.memory_write(LOG + 4 * len(log_codes(chip)), word(code).to_bytes(4, "little"))


def log_codes(chip):
    """The steps in the log, up to the first blank word."""
    words = struct.unpack("<64I", chip.memory_read(LOG, 256))
    return [word & 0xFFFF for word in words[: words.index(0xFFFF_FFFF)]]
