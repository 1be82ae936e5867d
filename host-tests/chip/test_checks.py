"""What the board finds out about itself: at its start, and in each tick."""

from stm32f405.case import ChipCase
from stm32f405.flash import PLACE_A
from stm32f405.gpio import OUTPUT

FAULT, ACQUISITION = 5, 1
STOPPED, STRAY, REFERENCE, IMAGE, MEMORY, HELD = 32, 34, 35, 36, 37, 38
ACKNOWLEDGE, SERVICE = 4, 5
TICK_S = 1e-3
# The reference's code of a chip of the middle of the batch, at 3.3 V.
REFERENCE_CODE = 1501
RAM = 0x2000_0000


class Checks(ChipCase):
    def assert_fault(self, master, number):
        self.assertEqual((master.get("state"), master.get("fault")), (FAULT, number))

    def assert_cannot_be_driven(self, chip, master):
        """Neither of the outputs is switched on, whatever is asked for."""
        for order in (ACKNOWLEDGE, SERVICE):
            try:
                master.set("command", order)
            except Exception:  # pylint: disable=broad-except
                pass
        chip.run(20 * TICK_S)
        self.assert_vented(chip)
        self.assertTrue(chip.board.is_dumping())
        self.assertTrue(chip.dac.is_held() and chip.tim3.is_held(), "the outputs are not held in reset")
        self.assertNotEqual(chip.gpio["B"].mode(13), OUTPUT, "the dump valve's output is one")

    # The output that is read back.

    def test_a_converter_that_does_not_follow_is_fault_34_in_three_ticks_and_dumps(self):
        chip, master = self.driven()
        chip.dac.stuck_v = 2.0
        chip.run(5 * TICK_S)
        self.assert_vented(chip)
        self.assert_fault(master, STRAY)
        self.assertTrue(chip.board.is_dumping())

    def test_a_pin_that_something_else_drives_while_vented_is_fault_34(self):
        chip, master = self.started()
        chip.board.foreign_v = 0.1
        chip.run(6 * TICK_S)
        self.assert_fault(master, STRAY)

    def test_every_set_point_reads_back_as_itself_with_the_buffer_at_its_worst(self):
        chip, master = self.driven()
        for bar in (0.05, 0.3, 0.7, 2.0, 6.0, 0.1, 0.0):
            master.set("setpoint_bar", bar)
            chip.run(0.15)
            self.assertEqual(master.get("fault"), 0, f"{bar} bar")

    def test_the_voltage_that_is_read_back_and_that_of_the_supply_are_told(self):
        chip, master = self.driven()
        chip.run(0.2)
        self.assertAlmostEqual(master.get("output_v"), chip.board.output_v(), delta=0.005)
        self.assertAlmostEqual(master.get("converters_supply_v"), 3.3, delta=0.005)

    # The reference.

    def test_a_supply_of_the_converters_that_is_off_is_fault_35_and_one_within_its_tolerance_is_none(self):
        for volts, fault in ((3.14, 0), (3.46, 0), (3.06, REFERENCE), (3.55, REFERENCE)):
            chip, master = self.started()
            # The supply of the sensors is the same: they are ratiometric, the reference is not.
            for channel, before in list(chip.board.voltages.items()):
                if channel in (0, 1, 10):
                    chip.board.voltages[channel] = before * volts / 3.3
            chip.set_supply(volts)
            chip.run(10 * TICK_S)
            self.assertEqual(master.get("fault"), fault, f"{volts} V")
            if fault == 0:
                self.assertAlmostEqual(master.get("converters_supply_v"), volts, delta=0.01)

    def test_the_reference_is_judged_by_the_chips_own_factory_value(self):
        chip = self.chip()
        # A chip whose reference is 2 % below the typical one.
        chip.memory_write(0x1FFF_7A2A, (1471).to_bytes(2, "little"))
        chip.board.voltages[17] = 1471 / 4095 * 3.3
        master = self.start(chip)
        self.assertAlmostEqual(master.get("converters_supply_v"), 3.3, delta=0.005)

    # The samples.

    def test_a_stream_that_moves_nothing_any_more_is_fault_1(self):
        chip, master = self.driven()
        chip.dma2.is_dead = True
        chip.run(10 * TICK_S)
        self.assert_vented(chip)
        self.assert_fault(master, ACQUISITION)

    def test_an_injected_group_that_is_converted_no_more_is_fault_1(self):
        chip, master = self.driven()
        chip.adc.is_injected_dead = True
        chip.run(10 * TICK_S)
        self.assert_vented(chip)
        self.assert_fault(master, ACQUISITION)

    def test_eight_conversions_a_tick_take_the_noise_of_one_down_and_their_noise_is_told(self):
        chip, master = self.started()
        chip.board.noise_codes = 4.0
        chip.run(0.6)
        shown = [master.get("pressure_bar") for _ in range(40)]
        mean = sum(shown) / len(shown)
        deviation = (sum((bar - mean) ** 2 for bar in shown) / (len(shown) - 1)) ** 0.5 * 327.6
        # 4 codes by the root of 8, and a rounding; the deviation of 40 is known to some 25 %.
        self.assertLess(deviation, 1.35 * (4.0 / 8**0.5 + 0.3))
        self.assertGreater(deviation, 0.5 * 4.0 / 8**0.5)
        self.assertAlmostEqual(master.get("pressure_noise_bar") * 327.6, 4.0, delta=0.8)
        self.assertAlmostEqual(master.get("contraction_noise_mm") * 24.57, 4.0, delta=0.8)

    def test_a_stuck_sensor_is_seen_through_the_noise_of_the_converter(self):
        chip, master = self.driven()
        chip.board.noise_codes = 2.0
        chip.run(0.3)
        self.assertEqual(master.get("fault"), 0)
        held = chip.board.voltages[0]
        self.hold(chip, held)
        master.set("setpoint_bar", 5.5)
        chip.run(0.5)
        self.assertIn(master.get("fault"), (6, 14))

    def hold(self, chip, volts):
        """The sensor of the pressure shows this for ever."""

        def again():
            chip.board.voltages[0] = volts
            chip.after(0.2e-3, again)

        again()

    # The start.

    def test_a_sound_board_has_no_fault_of_its_image_and_its_memory(self):
        _, master = self.started()
        self.assertEqual(master.get("fault"), 0)
        counts = master.words("fault_counts")
        self.assertEqual((counts[IMAGE - 1], counts[MEMORY - 1]), (0, 0))

    def test_a_bit_of_the_image_that_is_lost_is_fault_36_and_nothing_can_be_driven(self):
        # In the vector table, in the code of a panic, and at the end.
        chip = self.chip()
        panic = next(address for name, address in chip.symbols.items() if "panic_fmt" in name) & ~1
        for address in (PLACE_A + 0x60, panic + 2, chip.image_end() - 3):
            chip = self.chip()
            byte = chip.memory_read(address, 1)[0]
            chip.memory_write(address, bytes([byte ^ 0x10]))
            # What hangs on the byte is not asked for: the reserved vectors, that code, its text.
            master = self.start(chip)
            self.assert_fault(master, IMAGE)
            self.assert_cannot_be_driven(chip, master)
            self.assert_fault(master, IMAGE)

    def test_a_cell_of_the_memory_that_is_lost_is_fault_37_and_nothing_can_be_driven(self):
        # Deep in the stack, at its end, and behind the variables.
        for offset, bit in ((0x0, 0), (0x4000, 17), (0x1FE40, 31)):
            chip = self.chip()
            chip.break_memory(RAM + offset, bit)
            master = self.start(chip)
            self.assert_fault(master, MEMORY)
            self.assert_cannot_be_driven(chip, master)

    def test_the_test_of_the_memory_leaves_the_record_of_a_fault(self):
        chip, master = self.driven()
        chip.systick["CTRL"] = 0
        chip.nvic.enabled.clear()
        chip.run(0.3)
        self.assertEqual((master.get("state"), master.get("record_fault")), (FAULT, 28))
        self.assertGreater(master.get("record_entries"), 0)

    # The dump valve's coil.

    def test_a_coil_that_is_held_is_fault_38_before_anything_is_driven(self):
        chip = self.chip(board__is_pump_stuck=True)
        master = self.start(chip)
        chip.run(30 * TICK_S)
        self.assert_fault(master, HELD)

    def test_a_coil_that_is_held_at_another_fault_is_counted_again_and_again(self):
        chip, master = self.driven()
        chip.board.is_pump_stuck = True
        chip.board.is_stop_closed = False
        chip.run(0.1)
        self.assert_fault(master, STOPPED)
        self.assertGreater(master.words("fault_counts")[HELD - 1], 2)
