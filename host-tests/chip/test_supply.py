"""Low voltage: at the start, in operation, while something is stored."""

from stm32f405.case import ChipCase
from stm32f405.flash import DELIVERED
from stm32f405.host import TABLE, Master, Refused, read_frame

FAULT, BROWN_OUT = 5, 24


class Supply(ChipCase):
    def test_a_supply_that_is_low_at_the_start_keeps_the_board_slow_vented_and_from_saving(self):
        chip, master = self.started(supply_v=2.6)
        self.assertEqual(chip.core_hz, 16e6)
        self.assertEqual(chip.flash.programmed_words, 0)
        self.assertEqual((master.get("state"), master.get("fault")), (FAULT, BROWN_OUT))

    def test_a_supply_that_comes_up_slowly_is_waited_for(self):
        chip = self.chip(supply_v=2.6)
        chip.power_on()
        chip.run(8e-3)
        chip.set_supply(3.3)
        chip.run(0.4)
        self.assertEqual(chip.core_hz, 168e6)
        self.assertEqual(Master(chip).get("fault"), 0)

    def test_a_supply_that_falls_while_the_valve_is_driven_vents_at_once(self):
        chip, master = self.driven()
        at = chip.now
        chip.set_supply(2.8)
        self.assertTrue(chip.run(until=lambda: chip.board.output_v() < 0.01, most_s=2e-3))
        self.assertLess(chip.now - at, 20e-6)
        chip.run(2e-3)
        chip.set_supply(3.3)
        self.assertEqual((master.get("state"), master.get("fault")), (FAULT, BROWN_OUT))
        self.assert_vented(chip)

    def test_a_dip_between_two_ticks_is_a_fault_all_the_same(self):
        chip, master = self.driven()
        chip.run(0.3e-3)
        chip.set_supply(2.8)
        chip.run(50e-6)
        chip.set_supply(3.3)
        chip.run(3e-3)
        self.assertEqual(master.get("fault"), BROWN_OUT)
        self.assert_vented(chip)

    def brown_outs(self, master):
        row = TABLE["fault_counts"]
        data = master.ask(read_frame(int(row["address"]) + BROWN_OUT - 1, 1))[1:]
        return int.from_bytes(data, "big")

    def test_a_chip_whose_brown_out_reset_is_off_counts_it_at_each_start_and_runs(self):
        for option_bytes, counted in ((DELIVERED, 1), (DELIVERED & ~0xC, 0)):
            _, master = self.started(flash__option_bytes=option_bytes)
            self.assertEqual((master.get("fault"), self.brown_outs(master)), (0, counted))

    def test_a_supply_of_3_3_v_less_5_percent_is_no_fault(self):
        chip, master = self.started()
        chip.set_supply(3.3 * 0.95)
        chip.run(0.02)
        self.assertEqual(master.get("fault"), 0)

    def test_behind_a_dip_3_3_v_less_5_percent_is_good_again_with_the_highest_thresholds(self):
        chip, master = self.started(pwr__offset_v=0.06)
        chip.set_supply(2.8)
        chip.run(2e-3)
        chip.set_supply(3.3 * 0.95)
        chip.run(2e-3)
        self.assertEqual(master.get("fault"), BROWN_OUT)
        master.set("command", 4)
        chip.run(0.02)
        self.assertEqual(master.get("fault"), 0)

    def test_a_low_supply_before_the_write_of_the_valve_lets_the_dump_valve_open_from_that_tick_on(self):
        chip, _ = self.driven()
        # Before a tick that would raise PB13, and so between two.
        chip.run(chip.systick.due + 0.5e-3 - chip.now)
        chip.run(1e-3 if chip.gpio["B"].bit("ODR", 13) else 0.0)
        due = chip.systick.due
        chip.at(due + 1e-6, lambda: chip.set_supply(2.8))
        chip.run(3e-3)
        self.assertLess(chip.board.dump_edge_at, due)

    def test_nothing_is_stored_at_a_low_supply(self):
        chip, master = self.started()
        chip.set_supply(2.8)
        chip.run(2e-3)
        words = chip.flash.programmed_words
        with self.assertRaises(Refused):
            master.set("bus_silent_ticks", 700, timeout_s=1.0)
        self.assertEqual(chip.flash.programmed_words, words)
