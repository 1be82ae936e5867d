"""A joint at a board with two channels: its host at the link, and a plant without friction."""

import math
import os
import pathlib
import struct

from .board import GAIN
from .chip import Chip
from .link import Link

IMAGE = pathlib.Path(os.environ.get("MGPI_CHIP_IMAGE", "")).with_name("stm32f405_joint")
# Channels of the converter: pressure a, the angle, pressure b, the supply.
PRESSURES, ANGLE, SUPPLY = (0, 11), 1, 10
# Places in the messages' enumerations (`wire::joint`), as postcard numbers them.
AIM, PRESS, REPORT, STATUS = 7, 9, 5, 9
OFF, READY, STARTING, TRACKING, FAULT, SERVICE = range(6)
STIFFNESS = 40.0
PERIOD_S = 1e-3
CODES = 4095


def crc16(content):
    """CRC-16/IBM-SDLC."""
    crc = 0xFFFF
    for byte in content:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0x8408 if crc & 1 else crc >> 1
    return crc ^ 0xFFFF


def framed(content):
    """A message as a frame: checksum, stuffing, zero. For fewer than 254 bytes."""
    content = bytes(content) + struct.pack("<H", crc16(content))
    return b"".join(bytes([len(part) + 1]) + part for part in content.split(b"\0")) + b"\0"


def unframed(frame):
    """The message in a frame."""
    content, place = bytearray(), 0
    while frame[place]:
        content += frame[place + 1 : place + frame[place]] + b"\0"
        place += frame[place]
    content = bytes(content[:-1])
    if struct.unpack("<H", content[-2:])[0] != crc16(content[:-2]):
        raise AssertionError(f"the answer {frame.hex()} is damaged")
    return content[:-2]


def varint(number):
    """A whole number as postcard writes it."""
    content = bytearray()
    while number >= 0x80:
        content.append(number & 0x7F | 0x80)
        number >>= 7
    return bytes(content) + bytes([number])


def aim(angle, stiffness=STIFFNESS, by_tick=0):
    """The frame by which a joint is told where to go, at once or by a tick. Unit: rad, N m/rad."""
    return framed(bytes([AIM, 1]) + struct.pack("<fff", angle, stiffness, 0.0) + varint(by_tick))


def press(a, b):
    """The frame by which a joint in service is told both pressures. Unit: bar."""
    return framed(bytes([PRESS]) + struct.pack("<ff", a, b))


# The frame that only asks.
ASK = framed([AIM, 0])


class Report:
    """What a board has answered to that."""

    KIND = REPORT

    def __init__(self, frame):
        self.content, self.place = unframed(frame), 0
        if self.number() != self.KIND:
            raise AssertionError(f"{self.content.hex()} is no {type(self).__name__.lower()}")
        self.ticks = self.number()
        self.pressure_codes = [self.number(), self.number()]
        self.angle_code, self.supply_code, self.late_ticks = self.number(), self.number(), self.number()
        self.noted = self.number() + 1 if self.number() else 0
        self.dac_codes = [self.number(), self.number()]
        self.state = self.number()
        self.fault = self.fault_number() if self.number() else 0
        self.due, self.stiffness, self.feedback = self.floats(3)
        self.is_limited, self.is_as_stiff = self.number(), self.number()

    def number(self):
        value = shift = 0
        while True:
            byte = self.content[self.place]
            self.place += 1
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value

    def floats(self, count):
        self.place += 4 * count
        return struct.unpack_from(f"<{count}f", self.content, self.place - 4 * count)

    def fault_number(self):
        """As docs/joint.md has it; the enumeration of the board's own faults begins at 0, their numbers at 1."""
        kind = self.number()
        if kind == 0:
            return 100 * (self.number() + 1) + self.number() + 1
        if kind == 3:
            return self.number() + 1
        if kind in (4, 5, 7):
            self.floats(3)
        return {1: 301, 2: 302, 4: 303, 5: 304, 6: 305, 7: 306, 8: 307}[kind]


class Status(Report):
    """What a board has answered to the question how it is: the report of its last tick, and what it reads of itself."""

    KIND = STATUS

    def __init__(self, frame):
        super().__init__(frame)
        self.supply_bar, self.temperature_c = self.floats(2)
        self.outputs_v = self.floats(2) if self.number() else None
        self.converters_supply_v = self.floats(1)[0] if self.number() else None
        self.has_clock = self.number()
        self.worst_cycles, self.mean_cycles, self.deadline_cycles, self.overruns = (self.number() for _ in range(4))
        self.resets = self.number()


class Joint:
    """The host of a board, and what hangs on the board."""

    def __init__(self, chip):
        self.chip, self.link = chip, Link(chip)
        numbers = struct.unpack("<14f", self.link.frames["joint_numbers"])
        self.arms, self.passive = (numbers[0:3], numbers[3:6]), numbers[6:10]
        self.lag_s, self.lowest, self.highest, self.knee = numbers[10:]
        self.bar = [0.0, 0.0]
        self.angle = 0.5 * (self.lowest + self.highest)
        # What the last reports said.
        self.reports = []

    # The plant.

    def torque(self, angle):
        """Of both muscles without friction. Unit: N m."""

        def of(coefficients):
            return sum(c * angle**k for k, c in enumerate(coefficients))

        a, b = (bar + self.knee / bar if bar > 0.2 else 0.0 for bar in self.bar)
        return a * of(self.arms[0]) - b * of(self.arms[1]) - of(self.passive)

    def step(self):
        """Pressures follow their set points by a lag; the angle is where the torques cancel, with a lag of 20 ms."""
        for place in (0, 1):
            asked = self.chip.board.output_bar(place + 1)
            self.bar[place] += (asked - self.bar[place]) * (1 - math.exp(-PERIOD_S / self.lag_s))
        low, high = -0.7, 0.7
        for _ in range(12):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.torque(middle) > 0 else (low, middle)
        self.angle += (0.5 * (low + high) - self.angle) * 0.05
        self.show()
        self.chip.after(PERIOD_S, self.step)

    def show(self):
        """Puts what is measured to the pins."""
        volts = self.chip.board.voltages
        for channel, bar in zip(PRESSURES, self.bar):
            volts[channel] = (409.5 + 327.6 * bar) / CODES * 3.3
        volts[ANGLE] = (2047.5 + 1173.0 * self.angle) / CODES * 3.3

    # The host.

    def ask(self, frame=ASK, timeout_s=0.1):
        report = Report(self.link.exchange(frame, timeout_s=timeout_s))
        self.reports.append(report)
        return report

    def order(self, name):
        """Whether a request is accepted."""
        return self.link.ask(name) == self.link.response("joint_accepted")

    def start(self):
        """The two steps. Returns when both valves are open."""
        for name in ("joint_configure", "joint_arm", "joint_start"):
            if not self.order(name):
                raise AssertionError(f"{name} is not accepted: {self.ask().fault}")

    def keep(self, seconds, angle=0.0, stiffness=STIFFNESS, every_s=0.1, until=None):
        """Shows that it lives, for a time or until a report says so."""
        for _ in range(round(seconds / every_s)):
            report = self.ask(aim(angle, stiffness))
            if until and until(report):
                return report
            self.chip.run(every_s)
        return self.ask(aim(angle, stiffness))


def joint_chip():
    """A chip with the image of two channels, not yet powered, and its joint."""
    chip = Chip(str(IMAGE))
    chip.board.voltages[PRESSURES[1]] = chip.board.voltages[PRESSURES[0]]
    chip.board.voltages[ANGLE] = 2047.5 / CODES * 3.3
    return chip, Joint(chip)
