"""The unmodified bring-up image: a sound board passes, and the fault of each part is told by its own line."""

from stm32f405 import bring_up
from stm32f405.case import ChipCase
from stm32f405.flash import DELIVERED, LOG, sector_begin

# What is told of a whole run of a sound board, in order.
PARTS = [
    "unique_id", "flash_size_kb", "reset_cause", "brown_out_level", "memory", "supply_detector", "crystal_hz", "clock",
    "watchdog_oscillator_hz", "pulse_output_resistor", "bus_driver_resistor", "dump_output_resistor", "emergency_stop",
    "dump_coil_contact", "bus_driver", "converter_supply_v", "processor_temperature_c", "pressure_code",
    "contraction_code", "supply_pressure_code", "pressure_noise_codes", "contraction_noise_codes",
    "supply_pressure_noise_codes", "output_vented_v", "output_low_error_codes", "output_middle_error_codes",
    "output_high_error_codes", "output_vented_again_v", "bus_echo_bytes", "bus_driver_after", "flash_wrong_words",
    "flash_erase_ms", "flash_program_us",
]
OF_OUTPUT = {"output_low_error_codes", "output_middle_error_codes", "output_high_error_codes", "output_vented_again_v"}
OF_ECHO = {"bus_echo_bytes", "bus_driver_after"}


class BringUp(ChipCase):
    def setUp(self):
        super().setUp()
        if not bring_up.IMAGE.is_file():
            self.skipTest(f"no {bring_up.IMAGE}; `cargo xtask firmware` builds it")

    def board(self, prepare=None):
        """A board that listens; `prepare` breaks something of it before power comes."""
        chip = bring_up.chip()
        self.chips.append(chip)
        if prepare:
            prepare(chip)
        self.assertTrue(bring_up.begin(chip), "it does not start")
        return chip

    def run_of(self, chip, request="run"):
        parts = bring_up.run(chip, request)
        self.assertIsNotNone(parts, "the report has no end, or its checksum is wrong")
        return parts

    def assert_told(self, chip, told, request="run"):
        parts = self.run_of(chip, request)
        self.assertEqual(bring_up.faults(parts), set(told), parts)
        return parts

    # A sound board.

    def test_a_sound_board_passes_in_every_part_and_tells_what_it_is(self):
        chip = self.board()
        chip.board.noise_codes = 2.0
        parts = self.run_of(chip, "run output echo")
        self.assertEqual(list(parts), PARTS)
        self.assertEqual(bring_up.faults(parts), set())
        self.assertEqual(parts["unique_id"][0], "323837323134510e00390045")
        self.assertAlmostEqual(float(parts["crystal_hz"][0]), 8e6, delta=8e6 / 10_000)
        self.assertAlmostEqual(float(parts["watchdog_oscillator_hz"][0]), 32e3, delta=32.0)
        self.assertAlmostEqual(float(parts["converter_supply_v"][0]), 3.3, delta=0.005)
        for name in ("pressure", "contraction", "supply_pressure"):
            self.assertAlmostEqual(float(parts[f"{name}_noise_codes"][0]), 2.0, delta=0.25)
        self.assertAlmostEqual(float(parts["flash_erase_ms"][0]), 250.0, delta=1.0)

    def test_nothing_is_driven_that_was_not_asked_for(self):
        chip = self.board()
        driven, taken = [], chip.dac.write_CR
        chip.dac._writers[0x00] = lambda value: (driven.append(value & 1), taken(value))
        parts = self.run_of(chip)
        self.assertFalse(set(parts) & (OF_OUTPUT | OF_ECHO))
        self.assertNotIn(1, driven)
        self.assertEqual((chip.board.driver_edges, chip.board.bus.sent), ([], []))
        self.run_of(chip, "run output")
        self.assertIn(1, driven)
        self.assert_vented(chip)
        # Throughout: no change of the output that keeps the dump valve closed.
        self.assertIsNone(chip.board.dump_edge_at)

    def test_what_is_no_request_is_not_answered(self):
        chip = self.board()
        for line in ("", "output", "run away", "x" * 300, "\x00\x05\x01"):
            bring_up.send(chip, line)
            chip.run(0.02)
            self.assertEqual(chip.board.link.sent, [])
        self.assertEqual(bring_up.faults(self.run_of(chip)), set())

    def test_what_the_board_stores_stays_and_the_sector_of_the_cycle_is_blank(self):
        chip = bring_up.chip()
        self.chips.append(chip)
        stored = bytes(range(256)) * 128
        chip.memory_write(sector_begin(1), stored)
        self.assertTrue(bring_up.begin(chip))
        self.run_of(chip)
        self.assertEqual(chip.memory_read(sector_begin(1), len(stored)), stored)
        self.assertEqual(chip.memory_read(sector_begin(LOG), 0x4000), b"\xff" * 0x4000)
        self.assertEqual(chip.flash.erased, [LOG, LOG])

    def test_a_processor_that_stands_still_is_reset_by_the_watchdog_and_that_is_told(self):
        chip = self.board()
        chip.halt(8.0)
        self.assertEqual([cause for _, cause in chip.resets], ["power", "watchdog"])
        self.assert_vented(chip)
        chip.run(0.2)
        self.assertEqual(bring_up.faults(self.run_of(chip)), {"reset_cause"})

    # Faults: those of a run are of parts that have nothing to do with each other, and each is told by its line alone.

    def test_each_fault_that_is_there_at_the_start_is_told_by_its_line(self):
        def first(chip):
            bring_up.forget_unique_id(chip)
            chip.flash.option_bytes = DELIVERED
            chip.break_memory(0x2001_8000, 7)
            chip.rcc.hse_works = False
            chip.board.to_ground.discard("PA6")

        def second(chip):
            chip.rcc.hse_hz = 7.5e6
            chip.board.to_ground.discard("PA8")

        def third(chip):
            chip.rcc.pll_works = False
            chip.board.to_ground.discard("PB13")

        def fourth(chip):
            chip.board.stuck.update(PA8=True)

        of_first = ["unique_id", "brown_out_level", "memory", "crystal_hz", "clock", "pulse_output_resistor"]
        for prepare, told in (
            (first, of_first),
            (second, ["crystal_hz", "clock", "bus_driver_resistor"]),
            (third, ["clock", "dump_output_resistor"]),
            (fourth, ["bus_driver_resistor", "bus_driver"]),
        ):
            with self.subTest(prepare.__name__):
                self.assert_told(self.board(prepare), told)

    def test_each_fault_of_a_board_that_runs_is_told_by_its_line(self):
        chip = self.board()
        chip.iwdg.lsi_hz = 50e3
        chip.board.is_stop_closed = False
        chip.board.stuck.update(PB15=True)
        chip.board.voltages.update({0: 0.0, 1: 3.3, 10: 0.0, 16: 1.1})
        chip.board.foreign_v = 0.1
        chip.flash.is_worn = True
        of_pins = ["watchdog_oscillator_hz", "emergency_stop", "dump_coil_contact"]
        of_inputs = ["pressure_code", "contraction_code", "supply_pressure_code", "processor_temperature_c"]
        parts = self.assert_told(chip, [*of_pins, *of_inputs, "output_vented_v", "flash_wrong_words"])
        self.assertEqual(parts["flash_wrong_words"][0], "4096")

        chip = self.board()
        chip.iwdg.lsi_hz = 16e3
        chip.board.voltages[17] = 1.09
        chip.board.noise_codes = 9.0
        chip.dac.stuck_v = 1.65
        chip.board.has_echo = False
        chip.flash.protected.add(LOG)
        noise = [f"{name}_noise_codes" for name in ("pressure", "contraction", "supply_pressure")]
        of_output = ["output_low_error_codes", "output_high_error_codes", "bus_echo_bytes"]
        of_flash = ["flash_wrong_words", "flash_erase_ms", "flash_program_us"]
        told = ["watchdog_oscillator_hz", "converter_supply_v", *noise, *of_output, *of_flash]
        parts = self.assert_told(chip, told, "run output echo")
        self.assertEqual(parts["flash_erase_ms"][0], "-")
