"""The image that drives a coil by pulses (feature `solenoid`): duty cycle, and what vents it."""

import os
import pathlib

from stm32f405 import Chip
from stm32f405.case import ChipCase

IMAGE = pathlib.Path(os.environ.get("MGPI_CHIP_IMAGE", "")).with_name("stm32f405_coil")
TICK_S, PERIOD_S = 1e-3, 1 / 20_000
CODES_PER_BAR, CODES = 409.5, 4095
STOP, FAULT, CLOCK, BROWN_OUT = 2, 5, 30, 24
# Of TIM3 at PA6; of its channel, the preload of the duty cycle.
TIMER_FUNCTION, PRELOAD = 2, 3


class Coil(ChipCase):
    def setUp(self):
        super().setUp()
        if not IMAGE.is_file():
            self.skipTest(f"no {IMAGE}; `cargo xtask test` builds it")

    def chip(self, **what):
        chip = Chip(str(IMAGE))
        self.chips.append(chip)
        return chip

    def in_service(self, bar):
        """A board that puts out a pressure; what is measured follows it."""
        chip = self.chip()
        master = self.start(chip)
        master.set("bus_silent_ticks", 60_000, timeout_s=1.0)
        chip.board.asked_bar = lambda: self.duty(chip) * CODES / CODES_PER_BAR
        self.follow(chip)
        master.drive(bar)
        self.assertTrue(chip.run(until=lambda: self.duty(chip) * CODES > (bar - 0.1) * CODES_PER_BAR, most_s=2.0))
        return chip, master

    def duty(self, chip):
        """The share of the time that the coil's driver is on."""
        duty = chip.tim3.duty()
        return 0.0 if duty is None or chip.gpio["A"].function(6) != TIMER_FUNCTION else duty[0]

    def assert_without_pulses_within(self, chip, seconds):
        self.assertTrue(chip.run(until=lambda: self.duty(chip) == 0.0, most_s=seconds), "there are pulses")
        chip.run(20 * TICK_S)
        self.assertEqual(self.duty(chip), 0.0)
        self.assert_vented(chip)

    def test_a_board_that_starts_makes_no_pulse_from_its_first_instruction(self):
        chip = self.chip()
        chip.power_on()
        for _ in range(200):
            chip.run(100e-6)
            self.assertEqual(self.duty(chip), 0.0)

    def test_the_duty_cycle_is_the_codes_share_at_20_khz_from_none_to_the_whole(self):
        chip, master = self.in_service(5.0)
        for bar in (5.0, 2.5, 0.0, 6.0):
            master.set("setpoint_bar", bar)
            chip.run(0.3)
            self.assertAlmostEqual(self.duty(chip), round(bar * CODES_PER_BAR) / CODES, delta=1e-3)
            self.assertAlmostEqual(chip.tim3.duty()[1], 1 / PERIOD_S, delta=1.0)
        self.assertEqual(master.get("fault"), 0)
        # A duty cycle that changes in the middle of a pulse would make a second one, or none.
        self.assertTrue(chip.tim3.bit("CCMR1", PRELOAD))
        # The whole range of the driver: no command reaches it, whose pressure is limited.
        chip.tim3.write_CCR1(chip.tim3["ARR"] + 1)
        chip.now += 2 * PERIOD_S
        self.assertEqual(self.duty(chip), 1.0)

    def test_stop_a_low_supply_and_a_crystal_that_stops_end_the_pulses_with_their_period(self):
        chip, master = self.in_service(3.0)
        master.set("command", STOP)
        self.assert_without_pulses_within(chip, TICK_S + PERIOD_S)

        chip, master = self.in_service(3.0)
        chip.set_supply(2.8)
        self.assert_without_pulses_within(chip, 20e-6 + PERIOD_S)
        chip.set_supply(3.3)
        self.assertEqual((master.get("state"), master.get("fault")), (FAULT, BROWN_OUT))

        chip, master = self.in_service(3.0)
        chip.rcc.lose_crystal()
        self.assert_without_pulses_within(chip, 100e-6)
        chip.run(0.6)
        self.assertEqual((master.get("state"), master.get("fault")), (FAULT, CLOCK))

    def test_a_halted_core_is_reset_and_makes_no_pulse(self):
        chip, _ = self.in_service(3.0)
        chip.halt(0.5)
        self.assertEqual(chip.resets[-1][1], "watchdog")
        self.assertEqual(self.duty(chip), 0.0)
        chip.run(0.05)
        self.assertEqual(self.duty(chip), 0.0)
