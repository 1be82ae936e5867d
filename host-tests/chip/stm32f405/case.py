"""What the tests have in common."""

import functools
import unittest

from .chip import Chip
from .host import Master

# Of the output of the front end when vented. Unit: V.
VENTED_V = 0.010
DRIVEN_BAR = 3.0
# Interrupts of the tasks that answer what link and bus have received: those of SPI2 and SPI1, which the port pends.
LINK_TASK, BUS_TASK = 36, 35

# What `serve.py` has made before the test's process began, by the method's name.
READY = {}


def prepared(make):
    """A method that makes a chip ready: without arguments its outcome may be there already."""

    @functools.wraps(make)
    def ready(self, **what):
        outcome = None if what else READY.pop(make.__qualname__, None)
        if outcome is None:
            return make(self, **what)
        self.chips.append(outcome[0])
        return outcome

    return ready


class ChipCase(unittest.TestCase):
    """A test with a chip; what the manual forbids fails it."""

    def setUp(self):
        self.chips = []

    def chip(self, make=Chip, **what):
        """A chip, not yet powered; `what`: attributes of its peripherals, as `rcc__hse_works=False`."""
        chip = make()
        self.chips.append(chip)
        for path, value in what.items():
            *parts, last = path.split("__")
            place = chip
            for part in parts:
                place = getattr(place, part)
            setattr(place, last, value)
        return chip

    def start(self, chip):
        """Powers a chip, waits until it runs, and returns a master on its bus. A new board erases first."""
        before = chip.sleeps
        chip.power_on()
        self.assertTrue(chip.run(until=lambda: chip.sleeps > before, most_s=3.0), "it does not start")
        chip.run(5e-3)
        return Master(chip)

    @prepared
    def started(self, **what):
        """A chip that runs, and a master on its bus."""
        chip = self.chip(**what)
        return chip, self.start(chip)

    @prepared
    def driven(self, **what):
        """A chip in service, its valve open."""
        chip, master = self.started(**what)
        master.set("bus_silent_ticks", 60_000, timeout_s=1.0)
        master.drive(DRIVEN_BAR)
        self.follow(chip)
        self.assertTrue(chip.run(until=lambda: chip.board.output_bar() > DRIVEN_BAR - 0.1, most_s=2.0))
        return chip, master

    def follow(self, chip):
        """Regulator and muscle: what is asked for is measured within some ticks, and 8 mm a bar."""

        def step():
            asked = min(max(chip.board.asked_bar(), 0.0), 10.0)
            now = (chip.board.voltages[0] * 4095 / 3.3 - 409.5) / 327.6
            bar = now + (asked - now) * 0.2
            chip.board.voltages[0] = (409.5 + 327.6 * bar) / 4095 * 3.3
            chip.board.voltages[1] = (204.75 + 24.57 * 8.0 * bar) / 4095 * 3.3
            chip.after(1e-3, step)

        step()

    def assert_vented(self, chip):
        self.assertLess(chip.board.output_v(), VENTED_V)

    def assert_correct(self):
        """Nothing that the manual forbids has happened."""
        for chip in self.chips:
            self.assertEqual(chip.violations, [])

    def run(self, result=None):
        """Behind each test that has not failed itself, holds its chips against the manual."""
        test = getattr(self, self._testMethodName)

        def checked():
            test()
            self.assert_correct()

        setattr(self, self._testMethodName, checked)
        return super().run(result)
