"""What the image of two channels keeps in its flash, what it makes of it at the next start, and what who sends it is told."""

import os

from stm32f405.case import ChipCase
from stm32f405.flash import ERASE_16K_S, LOCK, START
from stm32f405.joint import FAULT, OFF, READY, SERVICE, STARTING, Status, press
from test_joint import TICK_S, JointCase

SECTORS = START + 0x4000
CORRUPT, VERSION = 22, 23


def contents(variable):
    """Both sectors, full: the next save erases."""
    with open(os.environ[variable], "rb") as file:
        return file.read()


class JointStore(JointCase):
    def with_store(self, store, **what):
        """A board that has started with these sectors, and its joint."""
        chip, joint = self.joint(**what)
        chip.memory_write(SECTORS, store)
        self.start(chip)
        return chip, joint

    def assert_rests(self, chip, seconds=0.3):
        """Vented all the time."""
        for _ in range(round(seconds / (10 * TICK_S))):
            self.assert_vented(chip)
            chip.run(10 * TICK_S)

    def assert_has(self, joint, name):
        """Which joint it has."""
        self.assertEqual(joint.link.ask("joint_installed"), joint.link.response(name))

    def give(self, joint):
        """Settings and a joint."""
        self.assertEqual(joint.link.ask("joint_settings"), joint.link.response("joint_is_set"))
        self.assertTrue(joint.order("joint_configure"))

    def test_a_joint_and_its_settings_are_there_at_the_next_start_and_move_nothing_until_two_steps(self):
        chip, joint = self.begun()
        joint.step()
        self.give(joint)
        self.assertEqual(chip.flash["CR"], 1 << LOCK)
        words = chip.flash.programmed_words
        self.give(joint)
        self.assertEqual(chip.flash.programmed_words, words, "what is stored already is written again")
        self.start(chip)
        self.assertEqual(joint.ask().state, OFF)
        self.assertTrue(chip.board.is_dumping(), "its coil is looked at")
        self.assert_rests(chip)
        report = joint.ask()
        self.assertEqual((report.state, report.fault), (READY, 0))
        self.assert_has(joint, "joint_has_it")
        self.assertEqual(joint.link.ask("joint_settings_asked"), joint.link.response("joint_is_set"))
        for name in ("joint_aim", "joint_press", "joint_start", "joint_service"):
            self.assertNotEqual(joint.link.ask(name), joint.link.response("joint_accepted"))
            self.assert_rests(chip, 0.02)
        for name in ("joint_arm", "joint_start"):
            self.assertTrue(joint.order(name), name)
        report = joint.keep(0.4)
        self.assertEqual((report.state, report.fault), (STARTING, 0))
        self.assert_driven(chip)

    def assert_reads_back(self, joint, name="joint_control_is"):
        """Every bit of the joint that it has, and of its settings."""
        self.assertEqual(joint.link.ask("joint_control"), joint.link.response(name))
        if name == "joint_control_is":
            self.assertEqual(joint.link.ask("joint_settings_asked"), joint.link.response("joint_is_set"))

    def test_a_joint_is_read_back_bit_by_bit_vented_driven_and_behind_a_restart(self):
        chip, joint = self.begun()
        joint.step()
        self.assert_reads_back(joint, "joint_control_none")
        self.give(joint)
        self.assert_reads_back(joint)
        self.start(chip)
        self.assert_reads_back(joint)
        self.assert_rests(chip, 0.1)
        for name in ("joint_arm", "joint_start"):
            self.assertTrue(joint.order(name), name)
        joint.keep(0.3)
        before = joint.ask()
        for _ in range(8):
            self.assert_reads_back(joint)
            joint.link.ask("joint_status")
            report = joint.keep(0.05, every_s=0.02)
        self.assertEqual((report.state, report.fault, report.late_ticks), (STARTING, 0, before.late_ticks))
        self.assert_driven(chip)
        chip, joint = self.with_store(contents("MGPI_CHIP_JOINT_STORE"))
        self.assert_reads_back(joint, "joint_control_stored")

    def test_what_a_board_says_of_itself_is_what_its_pins_have(self):
        chip, joint = self.begun()
        chip.board.voltages[10] = (409.5 + 327.6 * 7.0) / 4095 * 3.3
        joint.step()
        chip.run(0.1)
        status = Status(joint.link.ask("joint_status"))
        self.assertEqual((status.state, status.fault, status.resets, status.overruns), (OFF, 0, 0, 0))
        self.assertAlmostEqual(status.supply_bar, 7.0, delta=0.02)
        self.assertAlmostEqual(status.converters_supply_v, 3.3, delta=0.01)
        self.assertTrue(10.0 < status.temperature_c < 60.0, status.temperature_c)
        self.assertTrue(all(volts < 0.02 for volts in status.outputs_v), status.outputs_v)
        self.assertTrue(0 < status.mean_cycles <= status.worst_cycles < status.deadline_cycles)
        for name in ("joint_arm", "joint_service"):
            self.assertTrue(joint.order(name), name)
        for _ in range(40):
            joint.ask(press(2.5, 1.5))
            chip.run(20 * TICK_S)
        status = Status(joint.link.ask("joint_status"))
        self.assertEqual((status.state, status.fault), (SERVICE, 0))
        for read, volts in zip(status.outputs_v, self.outputs(chip)):
            self.assertAlmostEqual(read, volts, delta=0.02)
        self.assertGreater(status.outputs_v[0], 1.2 * status.outputs_v[1])

    def test_a_store_that_is_damaged_or_of_a_board_with_one_muscle_is_a_fault_at_one_start(self):
        for store, fault in ((bytes(0x8000), CORRUPT), (contents("MGPI_CHIP_STORE"), VERSION)):
            chip, joint = self.with_store(store)
            report = joint.ask()
            self.assertEqual((report.state, report.fault), (FAULT, fault))
            self.assert_rests(chip)
            self.assertTrue(chip.board.is_dumping())
            self.assert_has(joint, "joint_has_none")
            self.assertEqual(joint.link.ask("joint_configure"), joint.link.response("joint_at_fault"))
            self.start(chip)
            report = joint.ask()
            self.assertEqual((report.state, report.fault), (OFF, 0))
            # And is a board like any other.
            self.give(joint)
            self.start(chip)
            self.assert_has(joint, "joint_has_it")

    def test_a_coil_that_is_held_is_fault_38_at_a_start_with_a_joint(self):
        chip, joint = self.with_store(contents("MGPI_CHIP_JOINT_STORE"), board__is_pump_stuck=True)
        chip.run(60 * TICK_S)
        self.assertEqual(joint.ask().fault, 38)

    def test_power_lost_at_any_moment_of_a_save_leaves_the_joint_before_or_the_new_one(self):
        found = []
        for share in (0.02, 0.2, 0.5, 0.9, 0.99, 1.01, 1.02, 1.1):
            chip, joint = self.with_store(contents("MGPI_CHIP_JOINT_STORE"))
            self.assert_has(joint, "joint_has_the_stored")
            joint.link.send("joint_configure")
            chip.run(until=lambda chip=chip: chip.flash.erased, most_s=2.0)
            # The erasure takes the longest; behind it the record is programmed.
            if share < 1.0:
                chip.now += share * ERASE_16K_S
            else:
                chip.run(ERASE_16K_S + (share - 1.0) * 0.1)
            self.start(chip)
            found.append(joint.link.ask("joint_installed"))
            self.assertEqual(joint.ask().fault, 0)
            self.assert_rests(chip, 0.1)
        before, new = (joint.link.response(name) for name in ("joint_has_the_stored", "joint_has_it"))
        self.assertEqual(set(found), {before, new})
        self.assertEqual((found[0], found[-1]), (before, new))

    def test_what_a_worn_flash_does_not_keep_is_in_use_and_who_sent_it_is_told(self):
        chip, joint = self.begun()
        chip.flash.is_worn = True
        for name in ("joint_settings", "joint_configure"):
            answer = joint.link.ask(name, timeout_s=3.0)
            self.assertEqual(answer, joint.link.response("joint_not_stored"), name)
        self.assert_has(joint, "joint_has_it")
        self.assertEqual(joint.link.ask("joint_settings_asked"), joint.link.response("joint_is_set"))
        chip.flash.is_worn = False
        self.assertTrue(joint.order("joint_configure"))
        self.start(chip)
        self.assert_has(joint, "joint_has_it")

    def test_a_save_right_behind_a_stop_is_not_cut_off_by_the_watchdog_of_driven_valves(self):
        for lsi_hz in (17e3, 47e3):
            chip, joint = self.begun(iwdg__lsi_hz=lsi_hz)
            joint.step()
            for name in ("joint_arm", "joint_service"):
                self.assertTrue(joint.order(name), name)
            chip.run(0.1)
            self.assertEqual(joint.ask(press(2.5, 1.5)).state, SERVICE)
            # The next save erases.
            chip.memory_write(SECTORS, contents("MGPI_CHIP_JOINT_STORE"))
            chip.flash.erased.clear()
            joint.link.send("joint_stop")
            self.assertTrue(joint.order("joint_configure"))
            chip.run(1.0)
            self.assertEqual(len(chip.flash.erased), 1)
            self.assertEqual([cause for _, cause in chip.resets], ["power"])
            self.assert_has(joint, "joint_has_it")


class JointStoreAtOneMuscle(ChipCase):
    def test_the_store_of_a_joint_is_a_fault_at_one_start_of_a_board_with_one_muscle(self):
        chip = self.chip()
        chip.memory_write(SECTORS, contents("MGPI_CHIP_JOINT_STORE"))
        self.assertEqual(self.start(chip).get("fault"), VERSION)
        self.assertEqual(self.start(chip).get("fault"), 0)
