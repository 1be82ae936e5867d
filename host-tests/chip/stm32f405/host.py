"""A Modbus master on the board's bus, which names registers as docs/registers.csv does."""

import csv
import pathlib
import struct

REGISTERS = pathlib.Path(__file__).parents[3] / "docs" / "registers.csv"
FORMATS = {"u16": ">H", "i16": ">h", "u32": ">I", "i32": ">i", "f32": ">f"}
UNIT = 1
BYTE_S = 10 / 115_200
START, STOP, ACKNOWLEDGE, SERVICE, ARM = 1, 2, 4, 5, 6
PARITIES = ["none", "even", "odd"]

with open(REGISTERS, newline="", encoding="utf-8") as file:
    TABLE = {row["name"]: row for row in csv.DictReader(file)}


class Refused(Exception):
    """The board has answered with an exception."""

    def __init__(self, number):
        super().__init__(f"exception {number}")
        self.number = number


class Silent(Exception):
    """The board has not answered."""


def with_crc(content):
    """A frame."""
    crc = 0xFFFF
    for byte in content:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0xA001 if crc & 1 else crc >> 1
    return bytes(content) + crc.to_bytes(2, "little")


def read_frame(address, count, unit=UNIT):
    return with_crc(struct.pack(">BBHH", unit, 3, address, count))


def write_frame(address, data, unit=UNIT):
    return with_crc(struct.pack(">BBHHB", unit, 16, address, len(data) // 2, len(data)) + data)


class Master:
    """Asks by whole frames; a request waits for the answer."""

    def __init__(self, chip, unit=UNIT):
        self.chip = chip
        self.unit = unit

    def exchange(self, frame, timeout_s=0.1, pause_s=4e-3):
        """Sends a frame, and returns the answer, empty if there is none."""
        chip, line = self.chip, self.chip.board.bus
        chip.run(pause_s)
        line.sent.clear()
        end = chip.board.send(chip.usart1, frame)
        chip.run(end - chip.now)
        expected = [5]

        def is_whole():
            sent = line.sent
            if len(sent) >= 3:
                expected[0] = 5 if sent[1][1] & 0x80 else 5 + sent[2][1] if sent[1][1] in (3, 4) else 8
            return len(sent) >= expected[0]

        chip.run(until=is_whole, most_s=timeout_s)
        # The last bit has to leave, too.
        chip.run(2 * line.byte_s())
        return bytes(byte for _, byte in line.sent)

    def ask(self, frame, **how):
        """The content of the answer."""
        answer = self.exchange(frame, **how)
        if not answer:
            raise Silent
        if with_crc(answer[:-2]) != answer:
            raise AssertionError(f"the answer {answer.hex()} is damaged")
        if answer[1] & 0x80:
            raise Refused(answer[2])
        return answer[2:-2]

    def get(self, name, **how):
        """Reads a register."""
        row = TABLE[name]
        data = self.ask(read_frame(int(row["address"]), int(row["words"]), self.unit), **how)[1:]
        return struct.unpack(FORMATS[row["type"]], data[: struct.calcsize(FORMATS[row["type"]])])[0]

    def set(self, name, value, **how):
        """Writes a register."""
        row = TABLE[name]
        data = struct.pack(FORMATS[row["type"]], value)
        self.ask(write_frame(int(row["address"]), data, self.unit), **how)

    def put(self, name, data, **how):
        """Writes bytes to the registers from this one on."""
        self.ask(write_frame(int(TABLE[name]["address"]), data, self.unit), **how)

    def words(self, name):
        """Reads all words of a run."""
        row = TABLE[name]
        data = self.ask(read_frame(int(row["address"]), int(row["words"]), self.unit))[1:]
        return struct.unpack(f">{len(data) // 2}H", data)

    def drive(self, bar):
        """Service: a pressure at the valve, without a controller."""
        self.set("command", ARM)
        self.set("command", SERVICE)
        self.set("setpoint_bar", bar)


def keep(master, number=1, baud=115_200, parity="none", turnaround_us=0):
    """Lets a board keep how it is reached."""
    data = struct.pack(">HHII", number, PARITIES.index(parity), baud, turnaround_us)
    master.put("bus_number", data, timeout_s=2.0)


def take(master, baud, parity="none"):
    """Lets a board keep a rate and a parity and speak by them at once, as its master does then."""
    keep(master, master.unit, baud, parity)
    master.set("bus_take", 1)
    # The old rate ends behind the answer.
    line = master.chip.board.bus
    line.baud, line.parity = baud, parity
