"""The hardware watchdog bites a program that hangs, whatever its oscillator does, driven and vented."""

from stm32f405.case import LINK_TASK, ChipCase

LSI_HZ = 17e3, 32e3, 47e3


class Watchdog(ChipCase):
    def bitten_after(self, chip, most_s):
        at, before = chip.now, len(chip.resets)
        chip.halt(most_s)
        self.assertGreater(len(chip.resets), before, "the watchdog does not bite")
        self.assertEqual(chip.resets[-1][1], "watchdog")
        return chip.resets[-1][0] - at

    def test_a_driven_valve_is_vented_within_100_ms_of_a_hang(self):
        for hz in LSI_HZ:
            chip, _ = self.driven(iwdg__lsi_hz=hz)
            chip.run(0.05)
            self.assertLess(self.bitten_after(chip, 6.0), 0.1)
            self.assert_vented(chip)

    def test_a_vented_board_that_hangs_is_reset_within_8_s_and_survives_an_erasure(self):
        for hz in LSI_HZ:
            chip, _ = self.started(iwdg__lsi_hz=hz)
            after = self.bitten_after(chip, 9.0)
            self.assertLess(after, 8.0)
            self.assertGreater(after, 2.6)

    def test_a_board_that_runs_is_not_bitten(self):
        for hz in LSI_HZ:
            chip, _ = self.driven(iwdg__lsi_hz=hz)
            chip.run(0.3)
            self.assertEqual([cause for _, cause in chip.resets], ["power"])

    def test_a_link_that_hangs_is_fault_20_and_then_a_reset(self):
        chip, master = self.driven()
        # Its interrupt never comes.
        chip.nvic.enabled.discard(LINK_TASK)
        self.assertTrue(chip.run(until=lambda: chip.board.output_v() < 0.01, most_s=0.5))
        self.assertTrue(chip.run(until=lambda: len(chip.resets) > 1, most_s=9.0))
        self.assertEqual(chip.resets[-1][1], "watchdog")
        self.assert_vented(chip)
