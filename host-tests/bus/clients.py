"""pymodbus and mbpoll, as they are, against a board on a serial port.

Usage: clients.py PORT REGISTERS.csv CONFIGURATION RANDOM_FRAMES UNIT [OTHER_UNIT…]

The registers come from the documentation's CSV, so what is checked is what a user is told. CONFIGURATION: the bytes of a
model that the board takes, and CONFIGURATION.other those of another one. OTHER_UNIT: boards on the same line, of
which nothing may change. The board is left vented.
"""

import csv
import math
import random
import struct
import subprocess
import sys
import time
import zlib

import serial
from pymodbus.client import ModbusSerialClient
from pymodbus.framer import FramerRTU

PORT, REGISTERS, CONFIGURATION, *NUMBERS = sys.argv[1:]
RANDOM_FRAMES, UNIT, *OTHERS = map(int, NUMBERS)
BAUD = 115_200
# Longer than the silence between two frames, and that on a machine with much else to do.
PAUSE_S, LONG_PAUSE_S = 0.03, 1.0
FUNCTION, ADDRESS, VALUE, BUSY = 1, 2, 3, 6
SILENCE = b""

with open(REGISTERS, newline="") as file:
    TABLE = {row["name"]: row for row in csv.DictReader(file)}
for row in TABLE.values():
    row.update({key: int(row[key]) for key in ("address", "length", "words")})
FORMATS = {"u16": ">H", "i16": ">h", "u32": ">I", "i32": ">i", "f32": ">f"}
checks = 0


def check(is_so, what):
    """Counts what holds, and ends with what does not."""
    global checks
    if not is_so:
        sys.exit(f"failed: {what}")
    checks += 1


def words_of(row, value):
    data = struct.pack(FORMATS[row["type"]], value if row["type"] == "f32" else int(value))
    return [int.from_bytes(data[k : k + 2], "big") for k in range(0, len(data), 2)]


def value_of(row, words):
    return struct.unpack(FORMATS[row["type"]], b"".join(word.to_bytes(2, "big") for word in words))[0]


class Board:
    """The board by pymodbus, or another one on its line."""

    def __init__(self, unit=UNIT):
        self.unit = unit
        self.client = ModbusSerialClient(PORT, baudrate=BAUD, timeout=3, retries=0)
        check(self.client.connect(), f"{PORT} opens")

    def words(self, row, function=3):
        read = self.client.read_holding_registers if function == 3 else self.client.read_input_registers
        answer = read(row["address"], count=row["words"], device_id=self.unit)
        check(not answer.isError(), f"{row['name']} is read by function {function}: {answer}")
        return answer.registers

    def get(self, name):
        row = TABLE[name]
        return value_of(row, self.words(row)[: row["words"] // row["length"]])

    def write(self, address, words):
        """0, or the exception."""
        answer = self.client.write_registers(address, words, device_id=self.unit)
        return answer.exception_code if answer.isError() else 0

    def set(self, name, value):
        row = TABLE[name]
        return self.write(row["address"], words_of(row, value))

    def demand(self, name, value):
        check(self.set(name, value) == 0, f"{name} = {value} is taken")

    def contents(self):
        """Everything but measurements, clocks and what tells of the requests themselves."""
        moving = ("ticks", "_bar", "_mm", "_c", "cycles", "bus_", "upload_result", "message", "capture", "samples")
        rows = [row for row in TABLE.values() if row["access"] == "write" or not any(m in row["name"] for m in moving)]
        return {row["name"]: self.words(row) for row in rows if not row["name"].startswith("capture")}


def every_register_is_read(board):
    for row in TABLE.values():
        by_3, by_4 = board.words(row), board.words(row, 4)
        is_alike = row["access"] == "write" or any(m in row["name"] for m in ("version", "code", "release"))
        check(by_3 == by_4 or not is_alike, f"{row['name']} reads alike by functions 3 and 4")


def every_register_is_written(board):
    """Each at both its limits, and beyond them; what has an effect of its own has tests of its own."""
    own = ("command", "setpoint_bar", "stream_order", "stream_play_in_ticks", "push_number", "push_points",
           "upload_order", "bus_take", "update_order", "update_older", "update_offset", "update_window")
    together = {"command_min_bar": [0.0, 0.5], "command_max_bar": [4.0, 8.0]}
    for row in TABLE.values():
        name = row["name"]
        if row["access"] == "read":
            check(board.write(row["address"], [0] * row["words"]) == ADDRESS if row["words"] <= 120 else True, f"{name} is only read")
            continue
        if row["words"] > row["length"]:
            check(board.write(row["address"] + 1, [0]) == VALUE, f"half of {name} is not written")
        # A calibration is written as a whole.
        if name in own or name.startswith("calibrat") or "_input" in name or name == "inputs_checksum":
            continue
        before = board.words(row)
        low, high = float(row["min"]), float(row["max"])
        for number in together.get(name, [low, high]):
            board.demand(name, number)
            words = words_of(row, number)
            check(board.words(row)[: len(words)] == words, f"{name} reads as {number}")
        last = board.words(row)
        beyond = [math.nan, math.inf, -math.inf, low - 1, high + 1] if row["type"] == "f32" else []
        if row["type"] == "u16" and high < 65535:
            beyond = [high + 1]
        for number in beyond:
            check(board.set(name, number) == VALUE, f"{name} = {number} is refused")
        check(board.words(row) == last, f"{name} is what it was")
        # What the board starts with in the emulator, without protection, is beyond the limits.
        if row["length"] == 1 and low <= value_of(row, before) <= high:
            check(board.write(row["address"], before) == 0, f"{name} takes back what it was")


def upload(board, content, blocks=None):
    """Writes the blocks, or only so many, and commits."""
    offset, order = TABLE["upload_offset"]["address"], range(0, len(content), 240)
    for start in list(order)[:blocks]:
        block = content[start : start + 240] + b"\0" * (len(content[start : start + 240]) % 2)
        words = [int.from_bytes(block[k : k + 2], "big") for k in range(0, len(block), 2)]
        check(board.write(offset, [start, *words]) == 0, f"the block at {start} is taken")
    board.demand("upload_length", len(content))
    board.demand("upload_checksum", zlib.crc32(content))
    return board.set("upload_order", 1)


def fetch(board):
    board.demand("upload_order", 2)
    length, content = board.get("upload_length"), b""
    while len(content) < length:
        board.demand("upload_offset", len(content))
        content += b"".join(word.to_bytes(2, "big") for word in board.words(TABLE["upload_window"]))
    return content[:length]


def uploads(board, content, other):
    check(upload(board, content) == 0 and board.get("upload_result") == 1, "a configuration is installed")
    check(fetch(board) == content, "it reads back as it was")
    for blocks in range(len(other) // 240 + 1):
        check(upload(board, other, blocks) == VALUE, f"one of {blocks} blocks is not installed")
        check(board.get("state") == 2 and board.get("upload_result") == 2, "the board stays ready")
        check(fetch(board) == content, "the old one is there")
    check(upload(board, other) == 0 and fetch(board) == other, "a repeat succeeds")
    check(upload(board, content) == 0, "and the first one again")


def wrong_requests(board):
    check(board.client.read_coils(0, count=1, device_id=UNIT).exception_code == FUNCTION, "there are no coils")
    check(board.client.read_holding_registers(0x00FF, count=1, device_id=UNIT).exception_code == ADDRESS, "nothing at 0x00ff")
    check(board.client.read_holding_registers(0xFFFF, count=1, device_id=UNIT).exception_code == ADDRESS, "nothing at the end")
    check(board.set("mode", 3) == VALUE, "there is no mode 3")
    check(board.set("setpoint_bar", 1.0) == BUSY, "no command but in the service state")
    check(board.set("command", 3) == BUSY, "nothing to hold")


def other_functions(board):
    client, mode = board.client, TABLE["mode"]["address"]
    answer = client.diag_query_data(b"\xa5\x37", device_id=UNIT)
    check(not answer.isError() and answer.message == b"\xa5\x37", f"function 8 sends data back: {answer}")
    answer = client.diag_restart_communication(False, device_id=UNIT)
    check(answer.isError() and answer.exception_code == FUNCTION, "a restart is refused")
    answer = client.diag_read_device_message_count(device_id=UNIT)
    check(not answer.isError() and answer.message is not None, f"function 8 counts: {answer}")
    answer = client.report_device_id(device_id=UNIT)
    check(not answer.isError() and b"valve board" in answer.identifier, f"function 17 names the board: {answer}")
    board.demand("mode", 0b10)
    answer = client.mask_write_register(address=mode, and_mask=0xFFFC, or_mask=0b01, device_id=UNIT)
    check(not answer.isError() and board.get("mode") == 0b01, f"function 22 sets a bit and clears one: {answer}")
    answer = client.mask_write_register(address=mode, and_mask=0, or_mask=9, device_id=UNIT)
    check(answer.exception_code == VALUE and board.get("mode") == 1, "beyond the limit it is refused")
    answer = client.readwrite_registers(
        read_address=mode, read_count=1, write_address=mode, values=[0], device_id=UNIT
    )
    check(not answer.isError() and answer.registers == [0], f"function 23 reads what it has written: {answer}")
    answer = client.read_device_information(read_code=2, object_id=0, device_id=UNIT)
    release = ".".join(str(word) for word in board.words(TABLE["release"]))
    check(not answer.isError() and answer.information[2] == release.encode(), f"function 43 tells the release: {answer}")
    check(answer.information[5] == b"STM32F405", f"function 43 tells the processor: {answer}")
    answer = client.read_device_information(read_code=4, object_id=1, device_id=UNIT)
    check(list(answer.information) == [1], f"and an object alone: {answer}")
    # To all boards, which answer nothing: none starts.
    board.demand("command", 6)
    client.write_register(TABLE["command"]["address"], 1, device_id=0, no_response_expected=True)
    time.sleep(PAUSE_S)
    check(board.get("state") == 2, "no broadcast starts")


def tracks(board):
    board.demand("setpoint_mm", 0.0)
    board.demand("mode", 0)
    check(board.set("command", 1) == BUSY, "no start without its first step")
    board.demand("command", 6)
    board.demand("command", 1)
    check(board.get("state") == 3, "the board tracks")
    board.demand("setpoint_mm", 40.0)
    for _ in range(50):
        time.sleep(0.1)
        if abs(board.get("contraction_mm") - 40.0) < 2.0:
            break
    check(abs(board.get("contraction_mm") - 40.0) < 2.0, f"the muscle is at {board.get('contraction_mm')} mm")
    check(board.set("kp_bar_per_mm", 0.1) == BUSY, "no gains while tracking")


def exchange(line, data, pause_s=PAUSE_S):
    """What the board answers to these bytes within a while."""
    line.reset_input_buffer()
    line.write(data)
    time.sleep(pause_s)
    return line.read(line.in_waiting)


def framed(content):
    return content + FramerRTU.compute_CRC(content).to_bytes(2, "big")


def frames(line):
    """Frames that no client sends."""
    mode = TABLE["mode"]["address"].to_bytes(2, "big")
    good = framed(bytes([UNIT, 16]) + mode + bytes([0, 1, 2, 0, 1]))
    for bit in range(8 * len(good)):
        damaged = bytearray(good)
        damaged[bit // 8] ^= 1 << bit % 8
        check(exchange(line, bytes(damaged)) == SILENCE, f"silence with bit {bit} flipped")
    for length in range(1, len(good)):
        check(exchange(line, good[:length]) == SILENCE, f"silence to {length} bytes of a frame")
    for more in (1, 2, 100, 243, 400):
        check(exchange(line, framed(good[:-2] + bytes(more))) == SILENCE, f"silence to {more} bytes too many")
    for unit in {5, 17, 247, 255} - {UNIT, *OTHERS}:
        check(exchange(line, framed(bytes([unit]) + good[1:-2])) == SILENCE, f"silence to a frame for {unit}")
    unknown = framed(bytes([UNIT, 99, 1, 2, 3]))
    time.sleep(LONG_PAUSE_S)
    answer = exchange(line, unknown, LONG_PAUSE_S)
    check(answer == framed(bytes([UNIT, 99 | 0x80, FUNCTION])), f"function 99 is refused: {answer!r}")
    check(exchange(line, good, LONG_PAUSE_S) == framed(good[:6]), "and a good frame is answered")


def random_frames(line):
    source = random.Random(7)
    for number in range(RANDOM_FRAMES):
        data = source.randbytes(source.randint(1, 300))
        if number % 4 == 0:
            # Whole ones, to ask for functions that there are not.
            data = framed(bytes([UNIT, source.randint(44, 127)]) + data[:200])
        answer = exchange(line, data)
        # An exception, or what is left of one that came late: every other answer is longer.
        check(len(answer) <= 5, f"random frame {number} is met with silence or an exception: {answer!r}")
    time.sleep(LONG_PAUSE_S)


def mbpoll(row, *values, table=4):
    kind = {"u16": "", "i16": "", "u32": ":int", "i32": ":int", "f32": ":float"}[row["type"]]
    count = [] if values else ["-c", str(row["length"])]
    command = ["mbpoll", "-q", "-m", "rtu", "-a", str(UNIT), "-b", str(BAUD), "-P", "none", "-0", "-B", "-1", "-o", "3"]
    command += ["-t", f"{table}{kind}", "-r", str(row["address"]), *count, PORT, *map(str, values)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60)


def by_mbpoll():
    for row in TABLE.values():
        for table in (3, 4):
            ran = mbpoll(row, table=table)
            shown = [line for line in ran.stdout.splitlines() if line.startswith("[")]
            check(ran.returncode == 0 and len(shown) == row["length"], f"mbpoll reads {row['name']}: {ran.stderr}{ran.stdout}")
    written = [("mode", 2), ("mode", 0), ("setpoint_mm", 12.5), ("capture_from", 77), ("vented_bar", 0.75)]
    for name, value in written:
        check(mbpoll(TABLE[name], value).returncode == 0, f"mbpoll writes {name}")
        check(str(value) in mbpoll(TABLE[name]).stdout, f"mbpoll reads {name} as {value}")
    for name, value, exception in [("mode", 9, "value"), ("state", 1, "address"), ("command", 3, "busy")]:
        ran = mbpoll(TABLE[name], value)
        check(exception in (ran.stderr + ran.stdout).lower(), f"mbpoll is refused {name} = {value}: {ran.stderr}")


def contents_of_others():
    contents = []
    for unit in OTHERS:
        other = Board(unit)
        contents.append(other.contents())
        other.client.close()
    return contents


def main():
    others = contents_of_others()
    ids = [tuple(contents["unique_id"]) for contents in others]
    with open(CONFIGURATION, "rb") as one, open(f"{CONFIGURATION}.other", "rb") as other:
        content, other = one.read(), other.read()
    board = Board()
    check(board.get("state") == 0, "the board is off")
    check(board.get("bus_number") == UNIT, "it is the one that is meant")
    check(len({tuple(board.words(TABLE["unique_id"])), *ids}) == len(ids) + 1, "each processor has a number of its own")
    check(board.set("kp_bar_per_mm", 0.1) == BUSY, "there are no gains without a configuration")
    every_register_is_read(board)
    uploads(board, content, other)
    every_register_is_written(board)
    # With some of the limits at 0 the board was at fault, as it should be.
    board.demand("command", 4)
    wrong_requests(board)
    other_functions(board)
    check(upload(board, content) == 0, "the gains as they were")
    tracks(board)
    before = board.contents()
    board.client.close()
    with serial.Serial(PORT, BAUD, timeout=0) as line:
        frames(line)
        random_frames(line)
    board = Board()
    before["mode"] = [1]
    check(board.contents() == before, "nothing has changed but the mode, which one good frame set")
    check(board.get("state") == 3, "the board still tracks")
    # In lock-step no tick can be late; `--test production` counts them where they can.
    check(board.get("overruns") == 0, "no tick has found the one before unfinished")
    board.demand("command", 2)
    check(board.get("state") == 2, "the board is vented")
    board.client.close()
    by_mbpoll()
    check(contents_of_others() == others, "nothing has changed in the other boards")
    print(f"{checks} checks")


main()
