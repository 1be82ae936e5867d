"""Pins: what is not connected does not float, what is read is what is connected there."""

import struct

from stm32f405.adc import MOST_HZ
from stm32f405.case import ChipCase
from stm32f405.chip import TS_CAL1
from stm32f405.core import SYSTICK
from stm32f405.gpio import OUTPUT


class Pins(ChipCase):
    def test_an_unplugged_link_and_bus_see_no_bytes(self):
        chip, master = self.started()
        for usart in (chip.usart1, chip.usart2):
            self.assertFalse(chip.board.is_floating(usart.RX))
            chip.board.unplug(usart)
            self.assertEqual(chip.gpio["A"].pull(int(usart.RX[2:])), "up")
        chip.run(0.1)
        chip.board.bus.is_plugged = chip.board.link.is_plugged = True
        self.assertEqual(master.get("bus_damaged"), 0)

    def test_each_quantity_is_read_at_its_own_pin(self):
        chip, master = self.started()
        # Codes at 3.3 V: 3 bar in the muscle, 40 mm, 7 bar before the valve.
        for channel, code in ((0, 409.5 + 3 * 327.6), (1, 204.75 + 40 * 24.57), (10, 409.5 + 7 * 327.6)):
            chip.board.voltages[channel] = code / 4095 * 3.3
        chip.run(0.3)
        self.assertAlmostEqual(master.get("pressure_bar"), 3.0, delta=0.01)
        self.assertAlmostEqual(master.get("contraction_mm"), 40.0, delta=0.1)
        self.assertAlmostEqual(master.get("supply_bar"), 7.0, delta=0.01)

    def test_the_temperature_is_that_of_the_chips_own_factory_values(self):
        # A sensor 30 K off the typical one, at 60 °C: codes of 30 and 110 °C, and the one between.
        chip = self.chip()
        chip.memory_write(TS_CAL1, struct.pack("<HH", 866, 1114))
        chip.board.voltages[16] = (866 + (1114 - 866) * 30 / 80) / 4095 * 3.3
        master = self.start(chip)
        chip.run(0.3)
        self.assertAlmostEqual(master.get("temperature_c"), 60.0, delta=1.0)

    def test_the_samples_of_a_tick_are_converted_before_it_and_the_converter_is_not_too_fast(self):
        chip, master = self.started()
        self.assertLessEqual(chip.adc.clock_hz(), MOST_HZ)
        scans, ticks = chip.adc.scans, master.get("ticks")
        chip.run(0.1)
        self.assertAlmostEqual(chip.adc.scans - scans, 100, delta=30)
        self.assertEqual(master.get("fault"), 0)
        self.assertGreater(master.get("ticks"), ticks)

    def test_a_scan_ends_less_than_10_us_before_the_tick_that_uses_it(self):
        chip, _ = self.started()
        at_ticks, ended, pend = [], [0.0], chip.nvic.pend_exception

        def pended(number):
            if number == SYSTICK:
                at_ticks.append((chip.adc.is_scanning, chip.now - ended[0]))
            pend(number)

        def watch():
            if chip.adc.scans != count[0]:
                count[0], ended[0] = chip.adc.scans, chip.now
            chip.after(0.5e-6, watch)

        count = [chip.adc.scans]
        chip.nvic.pend_exception = pended
        watch()
        chip.run(5e-3)
        self.assertFalse(any(is_scanning for is_scanning, _ in at_ticks))
        self.assertLess(max(age_s for _, age_s in at_ticks[1:]), 10e-6)

    def test_the_status_light_is_driven_and_blinks_at_a_fault(self):
        chip, master = self.driven()
        self.assertEqual(chip.gpio["B"].mode(12), OUTPUT)
        chip.adc.is_dead = True
        chip.run(1.0)
        self.assertEqual(master.get("fault"), 1)
        self.assertGreater(len(chip.board.light_edges), 1)

    def test_a_converter_that_stops_is_fault_1(self):
        chip, master = self.driven()
        chip.adc.is_dead = True
        chip.run(5e-3)
        self.assertEqual(master.get("fault"), 1)
        self.assert_vented(chip)
