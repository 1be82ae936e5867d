"""A debugger that halts the core does not leave the valve open."""

from stm32f405.case import ChipCase
from stm32f405.iwdg import FREEZE

TIM3_FREEZE = 1


class Debugger(ChipCase):
    def test_a_core_that_is_halted_while_the_valve_is_driven_is_reset_and_vents(self):
        chip, _ = self.driven()
        chip.halt(0.5)
        chip.run(0.05)
        self.assertEqual(chip.resets[-1][1], "watchdog")
        self.assert_vented(chip)

    def test_what_a_debugger_left_behind_does_not_stop_the_watchdog(self):
        chip = self.chip()
        chip.power_on()
        chip.dbgmcu["APB1_FZ"] = 1 << FREEZE
        chip.run(0.05)
        self.assertFalse(chip.dbgmcu.bit("APB1_FZ", FREEZE))

    def test_pulses_stand_still_with_the_core(self):
        chip, _ = self.started()
        self.assertTrue(chip.dbgmcu.bit("APB1_FZ", TIM3_FREEZE))
