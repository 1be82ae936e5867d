"""The second path: a dump valve that opens unless each tick keeps it closed (docs/safety.md)."""

from stm32f405.board import PUMP_S
from stm32f405.case import ChipCase

TICK_S = 1e-3
FAULT, STOPPED, INEFFECTIVE, WATCHDOG = 5, 32, 33, 28
STOP = 2


class Dump(ChipCase):
    def assert_dumps_within(self, chip, seconds):
        at = chip.now
        self.assertTrue(chip.run(until=chip.board.is_dumping, most_s=seconds), "the dump valve stays closed")
        return chip.now - at

    def test_it_is_open_from_power_on_until_something_is_to_be_driven(self):
        chip = self.chip()
        chip.power_on()
        for _ in range(100):
            chip.run(5e-3)
            self.assertTrue(chip.board.is_dumping())

    def test_a_driven_valve_keeps_it_closed_by_a_change_each_tick(self):
        chip, _ = self.driven()
        for _ in range(200):
            chip.run(TICK_S)
            self.assertFalse(chip.board.is_dumping())
            self.assertLess(chip.now - chip.board.dump_edge_at, 1.2 * TICK_S)

    def test_a_fault_opens_it(self):
        chip, master = self.driven()
        chip.board.voltages[0] = 3.3
        self.assert_dumps_within(chip, PUMP_S + 5 * TICK_S)
        self.assertEqual(master.get("state"), FAULT)

    def test_a_processor_that_stands_still_opens_it_before_the_watchdog_bites(self):
        chip, master = self.driven()
        chip.nvic.enabled.clear()
        chip.systick["CTRL"] = 0
        self.assert_dumps_within(chip, PUMP_S + TICK_S)
        self.assertEqual(len(chip.resets), 1)

    def test_a_halted_core_opens_it(self):
        chip, _ = self.driven()
        chip.halt(PUMP_S + TICK_S)
        self.assertTrue(chip.board.is_dumping())

    def test_the_emergency_stop_is_read_back_and_latched(self):
        chip, master = self.driven()
        chip.board.is_stop_closed = False
        chip.run(5 * TICK_S)
        self.assert_vented(chip)
        chip.board.is_stop_closed = True
        chip.run(PUMP_S)
        self.assertTrue(chip.board.is_dumping(), "the release of the button alone closes the dump valve")
        self.assertEqual((master.get("state"), master.get("fault")), (FAULT, STOPPED))

    def test_an_emergency_stop_that_stays_pressed_cannot_be_acknowledged_away(self):
        chip, master = self.driven()
        chip.board.is_stop_closed = False
        chip.run(5 * TICK_S)
        master.set("command", 4)
        chip.run(10 * TICK_S)
        self.assertEqual((master.get("state"), master.get("fault")), (FAULT, STOPPED))

    def test_a_spark_at_the_emergency_stop_is_no_fault(self):
        chip, master = self.driven()
        chip.board.is_stop_closed = False
        chip.run(1.5 * TICK_S)
        chip.board.is_stop_closed = True
        chip.run(5 * TICK_S)
        self.assertEqual(master.get("fault"), 0)
