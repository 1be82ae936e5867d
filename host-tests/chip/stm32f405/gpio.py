"""GPIO: modes, pulls, alternate functions, levels (RM0090, chapter 8)."""

from .peripheral import Peripheral, Register

INPUT, OUTPUT, ALTERNATE, ANALOG = range(4)


def _registers(moder, ospeedr, pupdr):
    return {
        0x00: Register("MODER", moder),
        0x04: Register("OTYPER", 0, 0xFFFF),
        0x08: Register("OSPEEDR", ospeedr),
        0x0C: Register("PUPDR", pupdr),
        0x10: Register("IDR"),
        0x14: Register("ODR", 0, 0xFFFF),
        0x18: Register("BSRR"),
        0x1C: Register("LCKR", 0, 0x1FFFF),
        0x20: Register("AFRL"),
        0x24: Register("AFRH"),
    }


class Gpio(Peripheral):
    LETTER = ""

    def mode(self, pin):
        return self.field("MODER", 2 * pin, 2)

    def pull(self, pin):
        """"up", "down" or None."""
        return {0: None, 1: "up", 2: "down"}.get(self.field("PUPDR", 2 * pin, 2))

    def function(self, pin):
        """The alternate function that the pin has."""
        if self.mode(pin) != ALTERNATE:
            return None
        return self.field("AFRL", 4 * pin, 4) if pin < 8 else self.field("AFRH", 4 * (pin - 8), 4)

    def write_BSRR(self, value):
        self._put(self["ODR"] & ~(value >> 16) | value & 0xFFFF)

    def write_ODR(self, value):
        self._put(value)

    def write_MODER(self, value):
        debug = 0x3C00_0000 if self.LETTER == "A" else 0
        if (value ^ self["MODER"]) & debug:
            self.violation("the pins of the debugger are taken from it")
        self["MODER"] = value

    def _put(self, value):
        changed = value ^ self["ODR"]
        self["ODR"] = value
        for pin in range(16):
            if changed >> pin & 1:
                self.chip.board.pin_changed(f"P{self.LETTER}{pin}", bool(value >> pin & 1))

    def read_IDR(self, _):
        level = 0
        for pin in range(16):
            name = f"P{self.LETTER}{pin}"
            is_high = self.chip.board.level(name)
            if is_high is None and self.mode(pin) == OUTPUT:
                is_high = bool(self["ODR"] >> pin & 1)
            elif is_high is None:
                # A pull-up inside makes at most 0.83 V of a resistor of 10 kilohm.
                is_high = self.pull(pin) == "up" and name not in self.chip.board.to_ground
            level |= is_high << pin
        return level


class GpioA(Gpio):
    NAME, BASE, CLOCK, LETTER = "GPIOA", 0x4002_0000, ("AHB1ENR", 0), "A"
    REGISTERS = _registers(0xA800_0000, 0, 0x6400_0000)


class GpioB(Gpio):
    NAME, BASE, CLOCK, LETTER = "GPIOB", 0x4002_0400, ("AHB1ENR", 1), "B"
    REGISTERS = _registers(0x280, 0xC0, 0x100)


class GpioC(Gpio):
    NAME, BASE, CLOCK, LETTER = "GPIOC", 0x4002_0800, ("AHB1ENR", 2), "C"
    REGISTERS = _registers(0, 0, 0)
