"""Crystal, multiplier, buses; what happens when a part of them does not start or stops."""

from stm32f405.case import ChipCase
from stm32f405.host import Master
from stm32f405.rcc import CSSON, FREE_SHARE

CLOCK = 30
OFF, FAULT = 0, 5


class Clock(ChipCase):
    def test_the_core_runs_at_168_mhz_its_buses_at_42_and_84_and_the_tick_at_1_khz(self):
        chip, master = self.started()
        self.assertEqual(chip.core_hz, 168e6)
        self.assertEqual((chip.rcc.apb_hz(1), chip.rcc.apb_hz(2)), (42e6, 84e6))
        before, at = master.get("ticks"), chip.now
        chip.run(0.1)
        after, later = master.get("ticks"), chip.now
        self.assertAlmostEqual((after - before) / (later - at), 1000.0, delta=15.0)
        self.assertEqual(master.get("state"), OFF)

    def test_a_tick_is_a_millisecond_to_the_cycle_and_the_caches_are_on(self):
        chip, _ = self.started()
        self.assertEqual(chip.systick["LOAD"] + 1, chip.core_hz / 1000)
        self.assertEqual(chip.tim2["ARR"] + 1, chip.rcc.timer_hz(1) / 1000)
        self.assertEqual([chip.flash.bit("ACR", place) for place in (9, 10)], [True, True])

    def test_the_flash_of_the_first_revision_is_not_prefetched(self):
        for idcode, prefetches in ((0x1000_0413, False), (0x1007_6413, True)):
            chip = self.chip()
            chip.dbgmcu.identity = idcode
            self.start(chip)
            self.assertEqual(chip.flash.bit("ACR", 8), prefetches)

    def assert_on_fall_back(self, chip):
        self.assertEqual(chip.core_hz, 16e6)
        master = Master(chip)
        self.assertEqual(master.get("state"), OFF)
        # A tick of 1 ms all the same, and the bus's rate.
        before, at = master.get("ticks"), chip.now
        chip.run(0.1)
        after, later = master.get("ticks"), chip.now
        self.assertAlmostEqual((after - before) / (later - at), 1000.0, delta=15.0)

    def test_a_dead_crystal_leaves_the_board_on_its_internal_oscillator(self):
        chip, _ = self.started(rcc__hse_works=False)
        self.assert_on_fall_back(chip)

    def test_a_dead_multiplier_leaves_the_board_on_its_internal_oscillator(self):
        chip, _ = self.started(rcc__pll_works=False)
        self.assert_on_fall_back(chip)

    def test_a_crystal_that_stops_while_the_valve_is_driven_vents_resets_and_is_kept(self):
        chip, master = self.driven()
        self.assertTrue(chip.rcc.bit("CR", CSSON))
        at = chip.now
        chip.rcc.lose_crystal()
        self.assertTrue(chip.run(until=lambda: chip.board.output_v() < 0.01, most_s=1e-3))
        self.assertLess(chip.now - at, 100e-6)
        # The checksum of the firmware takes 0.3 s by the internal oscillator.
        chip.run(0.6)
        self.assertEqual(chip.resets[-1][1], "software")
        self.assertEqual((master.get("state"), master.get("fault")), (FAULT, CLOCK))
        self.assertEqual(chip.core_hz, 16e6)

    def test_the_model_of_a_lost_reference_slows_all_clocks(self):
        chip, _ = self.started()
        chip.rcc["CR"] &= ~(1 << CSSON)
        chip.rcc.lose_crystal()
        self.assertEqual(chip.core_hz, 168e6 * FREE_SHARE)
