"""What the sensors have shown is kept without power, and comes back before the first tick that uses it."""

import struct
import zlib

from stm32f405.case import ChipCase
from stm32f405.host import TABLE, Refused, write_frame

FIRST, INPUTS = 0xA00, 0xA20
# Zero and gain of pressure, contraction, supply and command: a pressure sensor that shows 0.5 bar where the standard one shows 0.
LINES = (409.5 - 0.5 * 330.0, 330.0, 204.75, 24.57, 409.5, 327.6, 12.0, 400.0)
DAY = 20_000
REFUSED, CORRUPT = 3, 22
PRESSURE_SENSOR, FAULT = 2, 5
RATIOMETRIC, CURRENT, VOLTAGE = 0, 1, 2
STANDARD = (RATIOMETRIC, 0.0, 0.0, 0.0)
BURDEN_OHM = 150.0


def calibrate(master, lines=LINES, checksum=None):
    """Writes a calibration as a whole."""
    data = struct.pack(">8fI", *lines, DAY)
    data += struct.pack(">I", zlib.crc32(data) if checksum is None else checksum)
    master.ask(write_frame(FIRST, data), timeout_s=2.0)


def connect(master, pressure, contraction=STANDARD, supply=STANDARD, checksum=None):
    """Tells how the sensors are connected: signal, voltage at the pin, range."""
    data = b"".join(struct.pack(">H3f", *sensor) for sensor in (pressure, contraction, supply))
    data += struct.pack(">I", zlib.crc32(data) if checksum is None else checksum)
    master.ask(write_frame(INPUTS, data), timeout_s=2.0)


class Calibration(ChipCase):
    def test_a_calibration_is_used_at_once_and_behind_the_next_start(self):
        chip, master = self.started()
        calibrate(master)
        chip.run(0.1)
        self.assertAlmostEqual(master.get("pressure_bar"), 0.5, delta=0.01)
        master = self.start(chip)
        chip.run(0.1)
        self.assertAlmostEqual(master.get("pressure_bar"), 0.5, delta=0.01)
        self.assertEqual((master.get("calibration_day"), master.get("fault")), (DAY, 0))
        self.assertAlmostEqual(master.get("calibrated_command_codes_per_bar"), 400.0)

    def test_a_calibrated_zero_of_the_command_opens_nothing_at_0_bar(self):
        chip, master = self.started()
        calibrate(master)
        self.follow(chip)
        master.drive(0.0)
        chip.run(0.1)
        self.assert_vented(chip)
        master.set("setpoint_bar", 2.0)
        master.set("heartbeat", 1)
        chip.run(0.4)
        self.assertAlmostEqual(chip.dac["DOR1"], 12 + 2 * 400, delta=1)

    def test_one_with_another_checksum_or_of_no_working_sensor_is_refused_and_none_is_kept(self):
        chip, master = self.started()
        wrong = [409.5, 500.0, *LINES[2:]]
        for how in ({"checksum": 1}, {"lines": wrong}):
            with self.assertRaises(Refused) as refused:
                calibrate(master, **how)
            self.assertEqual(refused.exception.number, REFUSED)
        with self.assertRaises(Refused):
            master.set("calibrated_pressure_zero_code", 400.0)
        self.assertEqual(self.start(chip).get("calibration_day"), 0)

    def test_every_register_of_the_group_is_written_at_once(self):
        for first, behind, words in ((FIRST, INPUTS, 20), (INPUTS, FIRST + 0x100, 23)):
            group = [row for row in TABLE.values() if first <= int(row["address"]) < behind]
            self.assertEqual(sum(int(row["words"]) for row in group), words)

    def current(self):
        """A board whose pressure sensor puts out 4 to 20 mA for 0 to 10 bar, and what sets that. Unit: mA."""
        chip, master = self.started()
        connect(master, (CURRENT, 20e-3 * BURDEN_OHM, 0.0, 10.0))
        return chip, master, lambda current_ma: chip.board.voltages.__setitem__(0, current_ma * 1e-3 * BURDEN_OHM)

    def test_a_sensor_of_4_to_20_ma_shows_its_range_and_does_so_behind_the_next_start(self):
        chip, master, sensor = self.current()
        for start in (False, True):
            master = self.start(chip) if start else master
            for current_ma, bar in ((4.0, 0.0), (12.0, 5.0), (20.0, 10.0)):
                sensor(current_ma)
                chip.run(5e-3)
                self.assertAlmostEqual(master.get("pressure_bar"), bar, delta=0.01)
        self.assertEqual((master.get("pressure_input"), master.get("fault")), (CURRENT, 0))

    def test_a_current_below_3_6_ma_or_above_21_is_fault_2_and_vents(self):
        for good_ma, bad_ma in ((3.65, 3.55), (20.95, 21.05)):
            chip, master, sensor = self.current()
            master.set("pressure_jump_bar", 8.0, timeout_s=1.0)
            sensor(4.0)
            master.set("bus_silent_ticks", 60_000, timeout_s=1.0)
            master.drive(0.0)
            chip.run(20e-3)
            if good_ma < 4.0:
                sensor(good_ma)
                chip.run(20e-3)
                self.assertEqual(master.get("fault"), 0)
            sensor(bad_ma)
            chip.run(20e-3)
            self.assertEqual((master.get("state"), master.get("fault")), (FAULT, PRESSURE_SENSOR))
            self.assert_vented(chip)

    def test_a_sensor_of_0_to_10_v_shows_its_range_and_leaves_the_others_lines(self):
        chip, master = self.started()
        calibrate(master)
        connect(master, (VOLTAGE, 3.0, 0.0, 10.0))
        for volts, bar in ((0.0, 0.0), (1.5, 5.0), (2.7, 9.0)):
            chip.board.voltages[0] = volts
            chip.run(5e-3)
            self.assertAlmostEqual(master.get("pressure_bar"), bar, delta=0.01)
        self.assertAlmostEqual(master.get("calibrated_command_codes_per_bar"), 400.0)
        # Its line may be calibrated, by what is credible of its own range.
        calibrate(master, (10.0, 375.0, *LINES[2:]))
        chip.board.voltages[0] = (10.0 + 4.0 * 375.0) / 4095 * 3.3
        chip.run(5e-3)
        self.assertAlmostEqual(master.get("pressure_bar"), 4.0, delta=0.01)

    def test_contraction_and_supply_have_inputs_of_their_own(self):
        chip, master = self.started()
        connect(master, STANDARD, (VOLTAGE, 3.0, 0.0, 150.0), (CURRENT, 20e-3 * BURDEN_OHM, 0.0, 16.0))
        chip.board.voltages.update({1: 1.5, 10: 12e-3 * BURDEN_OHM})
        chip.run(5e-3)
        self.assertAlmostEqual(master.get("contraction_mm"), 75.0, delta=0.1)
        self.assertAlmostEqual(master.get("supply_bar"), 8.0, delta=0.02)

    def test_an_input_that_cannot_be_or_comes_damaged_or_in_part_is_refused_and_none_is_kept(self):
        chip, master = self.started()
        for how in (
            {"pressure": (CURRENT, 3.2, 0.0, 10.0)},
            {"pressure": (VOLTAGE, 3.0, 0.0, 8.0)},
            {"pressure": (CURRENT, 3.0, 10.0, 0.0)},
            {"pressure": (CURRENT, 3.0, 0.0, 10.0), "checksum": 1},
        ):
            with self.assertRaises(Refused) as refused:
                connect(master, **how)
            self.assertEqual(refused.exception.number, REFUSED)
        with self.assertRaises(Refused):
            master.set("pressure_input", CURRENT)
        self.assertEqual(self.start(chip).get("pressure_input"), RATIOMETRIC)
