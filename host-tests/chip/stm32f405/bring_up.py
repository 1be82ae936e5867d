"""The host at the link of a board with the bring-up image: a request, and the report as lines."""

import os
import pathlib
import struct
import zlib

from .chip import UNIQUE_ID, Chip
from .flash import LOG

IMAGE = pathlib.Path(os.environ.get("MGPI_CHIP_IMAGE", "")).with_name("bring_up")
# The option bytes that the board needs: the highest level of the brown-out reset.
PREPARED = 0x0FFF_AAE1
# Longest time of a run.
RUN_S = 3.0


def chip():
    """A sound board with this image, not yet powered."""
    chip = Chip(str(IMAGE))
    chip.flash.option_bytes = PREPARED
    chip.flash.of_bring_up = {LOG}
    return chip


def begin(chip):
    """Powers a chip, and waits until it listens."""
    before = chip.sleeps
    chip.power_on()
    return chip.run(until=lambda: chip.sleeps > before, most_s=3.0)


def send(chip, line):
    """Sends a line; returns when its last byte is there."""
    chip.board.link.sent.clear()
    end = chip.board.send(chip.usart2, line.encode() + b"\n")
    chip.run(end - chip.now)


def run(chip, request="run"):
    """The lines of a report, by the names of the parts; None where it has no end, or a wrong checksum."""
    send(chip, request)
    # Once a millisecond: looking at all that was sent takes longer than running.
    for _ in range(int(RUN_S * 1e3)):
        chip.run(1e-3)
        sent = bytes(byte for _, byte in chip.board.link.sent[-64:])
        if sent.endswith(b"\n") and sent.splitlines()[-1].startswith(b"end "):
            break
    else:
        return None
    chip.run(1e-3)
    return parsed(bytes(byte for _, byte in chip.board.link.sent))


def parsed(text):
    *lines, end = text.decode("ascii").splitlines()
    before = text[: text.rindex(b"end ")]
    parts = {name: (value, verdict) for name, value, _, _, verdict in (line.split() for line in lines)}
    faulty = [name for name, (_, verdict) in parts.items() if verdict != "ok"]
    if end.split() != ["end", str(len(lines)), str(len(faulty)), f"{zlib.crc32(before):08x}"]:
        return None
    return parts


def faults(parts):
    """The names of the parts that are told as faulty."""
    return {name for name, (_, verdict) in parts.items() if verdict == "FAULT"}


def forget_unique_id(chip):
    """A processor that tells no number."""
    chip.memory_write(UNIQUE_ID, struct.pack("<III", *[0xFFFF_FFFF] * 3))
