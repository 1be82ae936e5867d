"""What the sensors have shown is kept without power, and comes back before the first tick that uses it."""

import struct
import zlib

from stm32f405.case import ChipCase
from stm32f405.host import TABLE, Refused, write_frame

FIRST = 0xA00
# Zero and gain of pressure, contraction, supply and command: a pressure sensor that shows 0.5 bar where the standard one shows 0.
LINES = (409.5 - 0.5 * 330.0, 330.0, 204.75, 24.57, 409.5, 327.6, 12.0, 400.0)
DAY = 20_000
REFUSED, CORRUPT = 3, 22


def calibrate(master, lines=LINES, checksum=None):
    """Writes a calibration as a whole."""
    data = struct.pack(">8fI", *lines, DAY)
    data += struct.pack(">I", zlib.crc32(data) if checksum is None else checksum)
    master.ask(write_frame(FIRST, data), timeout_s=2.0)


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
        group = [row for row in TABLE.values() if FIRST <= int(row["address"]) < FIRST + 0x100]
        self.assertEqual(sum(int(row["words"]) for row in group), 20)
