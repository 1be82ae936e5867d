"""Causes of a reset, and what the board makes of them."""

from stm32f405.case import ChipCase
from stm32f405.host import Master

OFF, FAULT = 0, 5
BROWN_OUT, WATCHDOG_RESET, RESET_LOOP = 24, 28, 29


class Resets(ChipCase):
    def reset(self, chip, cause, times=1, seconds=0.1):
        for _ in range(times):
            chip.reset(cause)
            chip.run(seconds)
        return Master(chip)

    def state(self, master):
        return master.get("state"), master.get("fault")

    def test_power_on_and_the_reset_pin_are_no_faults(self):
        chip, master = self.started()
        self.assertEqual(self.state(master), (OFF, 0))
        master = self.reset(chip, "pin", times=4)
        self.assertEqual(self.state(master), (OFF, 0))

    def test_a_reset_by_the_watchdog_is_fault_28_until_it_is_acknowledged(self):
        chip, _ = self.started()
        master = self.reset(chip, "watchdog")
        self.assertEqual(self.state(master), (FAULT, WATCHDOG_RESET))
        master.set("command", 4)
        self.assertEqual(self.state(master), (OFF, 0))

    def test_a_reset_by_low_voltage_is_fault_24(self):
        chip, _ = self.started()
        master = self.reset(chip, "brown-out")
        self.assertEqual(self.state(master), (FAULT, BROWN_OUT))

    def test_three_resets_by_the_watchdog_are_a_loop_that_takes_power_on(self):
        chip, _ = self.started()
        master = self.reset(chip, "watchdog", times=3)
        self.assertEqual(self.state(master), (FAULT, RESET_LOOP))
        self.assertEqual(self.state(self.start(chip)), (OFF, 0))

    def test_three_resets_by_a_debugger_are_no_loop(self):
        chip, _ = self.started()
        master = self.reset(chip, "software", times=4)
        self.assertEqual(self.state(master), (OFF, 0))

    def test_three_resets_of_the_program_itself_are_a_loop(self):
        chip, _ = self.started()
        for _ in range(3):
            chip.nvic.enabled.add(60)
            chip.nvic.pending.add(60)
            chip.run(0.1)
        self.assertEqual([cause for _, cause in chip.resets].count("software"), 3)
        self.assertEqual(self.state(Master(chip)), (FAULT, RESET_LOOP))
