"""What is around the chip (docs/board.md): sensors, the valve's amplifier, a transceiver, two hosts."""

import collections
import random

# The amplifier behind PA4, and the resistor from there to ground.
GAIN, TO_GROUND_OHM = 3.03, 6.8e3
# How long the pump keeps the dump valve closed behind the last change of PB13.
PUMP_S = 0.010
# Unit: bit/s.
BUS_BAUD, LINK_BAUD = 115_200, 460_800
# The channels of PA4 and PA5, the valves' outputs, and the channels of the converter that makes them.
OUTPUTS = {4: 1, 5: 2}
# Pins with a resistor to ground, by which they are low in a reset.
TO_GROUND = "PA6", "PA8", "PB13"
# Codes at 3.3 V, by channel: 25 °C, the reference, 8 bar of supply, no pressure, no contraction.
AT_REST = {16: 943.0, 17: 1501.0, 10: 3030.0, 0: 410.0, 1: 205.0}


class Line:
    """A host at a serial port of the board."""

    def __init__(self, baud):
        self.baud = baud
        # "none", "even" or "odd".
        self.parity = "none"
        # (moment when it is complete, byte), what the board has sent.
        self.sent = []
        self.is_plugged = True
        # When the host is done with what it sends.
        self.free_at = 0.0

    def bits(self):
        """Of a byte: start, data, what checks them, stop."""
        return 10 if self.parity == "none" else 11

    def byte_s(self):
        return self.bits() / self.baud


class Board:
    """The surroundings."""

    def __init__(self, chip):
        self.chip = chip
        # Unit: V, at the pin, where it is not that of a code at 3.3 V.
        self.voltages = {channel: code / 4095 * 3.3 for channel, code in AT_REST.items()}
        # Of each conversion, one standard deviation. Unit: code.
        self.noise_codes = 0.0
        self._chance = random.Random(1)
        # What else drives PA4, through a resistor, where the converter has let go of it; and PA5. Unit: V.
        self.foreign_v, self.second_foreign_v = 0.0, 0.0
        # Follows the valve's output, as a muscle's pressure does; None: `voltages` alone.
        self.plant = None
        self.bus, self.link = Line(BUS_BAUD), Line(LINK_BAUD)
        # Whether the receiver of the bus's transceiver stays on while it drives.
        self.has_echo = True
        # (moment, whether PA8 is high).
        self.driver_edges = []
        # Bytes that were lost because the transceiver did not drive, and that collided with another's.
        self.undriven, self.collisions = 0, 0
        self.lost_bytes = 0
        self.light_edges = []
        # When PB13 has last changed, and whether the emergency stop's contacts are closed.
        self.dump_edge_at = None
        self.is_stop_closed = True
        # Whether the pump holds the dump valve whatever PB13 does.
        self.is_pump_stuck = False
        # Pins whose resistor is there; pins that stay at a level whatever is done.
        self.to_ground, self.stuck = set(TO_GROUND), {}
        # (begin, end) of bytes of others on the bus.
        self.others = collections.deque(maxlen=4096)

    # Pins.

    def is_connected(self, pin, function):
        """Whether a pin has an alternate function."""
        port = self.chip.gpio[pin[1]]
        return port.function(int(pin[2:])) == function

    def level(self, pin):
        """The level from outside; None where nothing drives the pin."""
        if pin in self.stuck:
            return self.stuck[pin]
        if pin == "PB14":
            return False if self.is_stop_closed else None
        if pin == "PB15":
            return None if self.has_coil_voltage() else False
        lines = {"PA10": self.bus, "PA3": self.link}
        return True if pin in lines and lines[pin].is_plugged else None

    def is_floating(self, pin):
        port, number = self.chip.gpio[pin[1]], int(pin[2:])
        return self.level(pin) is None and port.pull(number) is None

    def pin_changed(self, pin, is_high):
        if pin == "PA8":
            self.driver_edges.append((self.chip.now, is_high))
        elif pin == "PB12":
            self.light_edges.append((self.chip.now, is_high))
        elif pin == "PB13":
            self.dump_edge_at = self.chip.now

    def has_coil_voltage(self):
        """Whether the pump holds the dump valve: for some time behind the last change of PB13."""
        is_pumped = self.dump_edge_at is not None and self.chip.now - self.dump_edge_at < PUMP_S
        return self.is_pump_stuck or is_pumped and self.chip.gpio["B"].mode(13) == 1

    def is_dumping(self):
        """Whether the dump valve is open: without the pump, or by the emergency stop's contacts, which are in its line."""
        return not (self.has_coil_voltage() and self.is_stop_closed)

    def drives_bus(self):
        """Whether the transceiver drives the bus: PA8 has 10 kilohm to ground."""
        port = self.chip.gpio["A"]
        return port.mode(8) == 1 and port.bit("ODR", 8)

    # The analogue side.

    def code(self, channel):
        """What the converter makes of the voltage at a channel."""
        volts = self.output_v(OUTPUTS[channel]) if channel in OUTPUTS else self.voltages.get(channel)
        if volts is None:
            self.chip.violation(f"board: nothing is at channel {channel}")
            return 0
        noise = self._chance.gauss(0.0, self.noise_codes) if self.noise_codes else 0.0
        return min(max(round(volts / self.chip.supply_v * 4095 + noise), 0), 4095)

    def output_v(self, channel=1):
        """The voltage at PA4, or PA5. A resistor to ground makes it 0 where nothing drives the pin."""
        volts = self.chip.dac.output(TO_GROUND_OHM, channel)
        return volts if volts is not None else self.foreign_v if channel == 1 else self.second_foreign_v

    def output_bar(self, channel=1):
        """What the regulator is asked for, 1 bar per V behind the amplifier."""
        return self.output_v(channel) * GAIN

    def asked_bar(self):
        """What the valve is asked for, which is a regulator unless a test has another."""
        return self.output_bar()

    # The lines.

    def send(self, usart, frame, gap_s=0.0, at=None):
        """A host sends bytes, with a gap between them; returns when the last is complete."""
        line = self.line(usart)
        begin = max(at if at is not None else self.chip.now, line.free_at, self.chip.now)
        byte_s = line.byte_s()
        for byte in frame:
            end = begin + byte_s
            if line is self.bus:
                self.others.append((begin, end))
            self.chip.at(begin + 0.96 * byte_s, lambda byte=byte: self._arrive(usart, byte, line))
            begin = end + gap_s
        line.free_at = end
        return end

    def _arrive(self, usart, byte, line):
        if line.is_plugged and self.is_connected(usart.RX, 7):
            if line is self.bus and self.drives_bus():
                self.collisions += 1
            usart.receive(byte, line)

    def unplug(self, usart, seed_hz=2_000.0):
        """Takes the cable off: a floating input sees noise, so many false bytes a second."""
        line = self.line(usart)
        line.is_plugged = False

        def noise():
            if self.is_floating(usart.RX) and self.is_connected(usart.RX, 7):
                usart.receive(0xFF, line)
            if not line.is_plugged:
                self.chip.after(1 / seed_hz, noise)

        self.chip.after(1 / seed_hz, noise)

    def line(self, usart):
        return self.bus if usart.NAME == "USART1" else self.link

    def byte_begins(self, usart, _):
        if usart.NAME == "USART1" and not self.drives_bus():
            self.undriven += 1

    def byte_sent(self, usart, byte):
        """The stop bit of a byte of the board is seen by whoever listens."""
        line = self.line(usart)
        if usart.NAME == "USART1":
            if not self.drives_bus():
                self.undriven += 1
                return
            if self.has_echo:
                usart.receive(byte, usart)
        if not usart.agrees(line):
            byte ^= 0x55
        line.sent.append((self.chip.now, byte))

    def all_sent(self, usart):
        """The last bit has left."""
