"""Drives a board over its bus with pymodbus: looks who it is, moves the valve in the service state, and vents.

    python3 board.py PORT

The registers are those of docs/registers.md. The highest command here is 2 bar.
"""
import struct
import sys
import time

from pymodbus.client import ModbusSerialClient

UNIT = 1
REGISTERS_VERSION, COMMAND, SETPOINT_BAR, STATE, PRESSURE_BAR, CONTRACTION_MM = 0x0000, 0x0100, 0x0104, 0x0200, 0x0204, 0x0206
HEARTBEAT = 0x0106
STOP, SERVICE, ARM = 2, 5, 6
STATES = ["off", "self-test", "ready", "tracking", "holding", "fault", "service"]


def read(address, count):
    answer = client.read_holding_registers(address, count=count, device_id=UNIT)
    if answer.isError():
        raise SystemExit(f"the board refuses to read {address:#06x}: {answer}")
    return answer.registers


def write(address, words):
    answer = client.write_registers(address, words, device_id=UNIT)
    if answer.isError():
        raise SystemExit(f"the board refuses to write {address:#06x}: {answer}")


def number(address):
    """A register of two words, the high one first: single precision."""
    return struct.unpack(">f", struct.pack(">HH", *read(address, 2)))[0]


def words(value):
    return list(struct.unpack(">HH", struct.pack(">f", value)))


client = ModbusSerialClient(sys.argv[1], baudrate=115200, timeout=1)
if not client.connect():
    raise SystemExit(f"{sys.argv[1]} cannot be opened")
try:
    print(f"registers of version {read(REGISTERS_VERSION, 1)[0]}, state {STATES[read(STATE, 1)[0]]}")
    # In two steps, so that no single request opens a valve.
    write(COMMAND, [ARM])
    write(COMMAND, [SERVICE])
    beats = 0
    for command_bar in (0.5, 1.0, 2.0, 1.0, 0.0):
        write(SETPOINT_BAR, words(command_bar))
        # The board vents by itself where no other number comes for longer than its limit, half a second by default.
        for _ in range(5):
            time.sleep(0.1)
            beats = (beats + 1) % 65536
            write(HEARTBEAT, [beats])
            pressure_bar = number(PRESSURE_BAR)
        print(f"{command_bar:.1f} bar asked for: {pressure_bar:.2f} bar, {number(CONTRACTION_MM):6.2f} mm")
finally:
    write(COMMAND, [STOP])
    print(f"vented, state {STATES[read(STATE, 1)[0]]}")
    client.close()
