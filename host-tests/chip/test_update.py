"""A new image over the bus: transfer, erasing and programming, trial, roll-back, cuts of power.

The images that are sent here are of a few instructions; `long_runs.py` sends a whole one. A whole one that is tried here
stands in the flash from the start, with the words of the log that a transfer leaves.
"""

import random

from stm32f405 import update
from stm32f405.case import ChipCase
from stm32f405.flash import LOG, PLACES
from stm32f405.fork import in_a_fork
from stm32f405.host import Refused, write_frame
from stm32f405.update import A, B, FOR_GOOD, ON_TRIAL, PLACE_B, ROLLED_BACK, WAITS

VALUE, DEVICE_FAILURE, BUSY = 3, 4, 6
SILENT_TICKS = 777
IMAGE_DAMAGED, WATCHDOG = 36, 28
# Bytes of a small image with its signature, and of its code.
CODE, GAP = 0x300, 0x380
CUTS = 24


class Update(ChipCase):
    def setUp(self):
        super().setUp()
        if update.image("b") is None:
            self.skipTest("MGPI_CHIP_IMAGES names no images; host-tests/tests/chip.rs makes them")

    def kept(self):
        """A board with a stored value by which its store is known again; something stands in the first sector of B."""
        chip, master = self.started()
        master.set("bus_silent_ticks", SILENT_TICKS, timeout_s=1.0)
        chip.memory_write(PLACE_B, b"\x00\x55" * 64)
        return chip, master

    def sent(self, content):
        """A board to which an image has come."""
        chip, master = self.kept()
        update.order(master, update.BEGIN)
        update.send(master, content)
        return chip, master

    def assert_runs(self, master, place=A, trial=FOR_GOOD, fault=0):
        self.assertEqual(update.reached(master), (place, trial))
        self.assertEqual((master.get("fault"), master.get("bus_silent_ticks")), (fault, SILENT_TICKS))

    def assert_refused(self, number, work):
        with self.assertRaises(Refused) as refused:
            work()
        self.assertEqual(refused.exception.number, number)

    def on_trial(self):
        """A board that has just begun with a whole image in B."""
        chip, master = self.kept()
        update.put(chip, update.image("b"))
        update.append(chip, update.TRY_B)
        return chip, self.start(chip)

    # What is taken.

    def test_an_image_that_does_not_fit_is_refused_by_its_reason_and_is_not_tried(self):
        whole, flipped, gap = (bytearray(update.image("hangs")) for _ in range(3))
        flipped[CODE + 1] ^= 4
        gap[GAP] ^= 4
        for name, content, result in (
            ("cut off", whole[:-4], update.NOT_WHOLE),
            ("a bit of it is another", flipped, update.NOT_WHOLE),
            ("a bit between what the checksum is over", gap, update.SIGNATURE),
            ("another's signature", update.image("forged"), update.SIGNATURE),
            ("another kind of board", update.image("coil"), update.OTHER_BOARD),
            ("another revision", update.image("revision"), update.OTHER_BOARD),
            ("older", update.image("older"), update.OLDER),
            ("for A", update.image("place_a"), update.OTHER_PLACE),
            ("nothing", bytes(480), update.NOT_WHOLE),
        ):
            with self.subTest(name):
                chip, master = self.sent(bytes(content))
                self.assert_refused(VALUE, lambda master=master: update.order(master, update.TAKE))
                self.assertEqual(master.get("update_result"), result)
                self.assert_refused(BUSY, lambda master=master: update.order(master, update.RESTART))
                self.assertEqual(update.log_codes(chip), [update.FOR_GOOD_A])
                self.assert_runs(self.start(chip))

    def test_an_older_release_is_taken_by_whoever_says_so(self):
        chip, master = self.sent(update.image("older"))
        update.order(master, update.TAKE, older=1)
        self.assertEqual(update.log_codes(chip), [update.FOR_GOOD_A, update.TRY_B])

    def test_nothing_is_done_while_the_valve_is_driven_or_by_broadcast(self):
        chip, master = self.kept()
        update.order(master, update.BEGIN)
        first, second, *_ = update.blocks(update.image("hangs"))
        update.write_block(master, *first)
        master.set("bus_silent_ticks", 60_000, timeout_s=1.0)
        master.drive(1.0)
        for work in (
            lambda: update.order(master, update.BEGIN),
            lambda: update.write_block(master, *second),
            lambda: update.order(master, update.TAKE),
        ):
            self.assert_refused(BUSY, work)
        chip.board.send(chip.usart1, write_frame(0xB00, b"\x00\x01", unit=0))
        chip.run(0.02)
        self.assertGreater(chip.board.output_bar(), 0.5)
        self.assertEqual(master.get("update_next"), len(first[1]))

    def test_a_block_may_come_again_and_none_may_be_left_out_or_be_another(self):
        chip, master = self.kept()
        update.order(master, update.BEGIN)
        (_, one), (at, two), (third, three), *_ = update.blocks(update.image("hangs"))
        update.write_block(master, 0, one)
        programmed = chip.flash.programmed_words
        update.write_block(master, 0, one)
        self.assertEqual(chip.flash.programmed_words, programmed)
        self.assertEqual(chip.flash.erased.count(PLACES[1][0]), 1)
        for offset, block in ((third, three), (0, two), (at + 2, two), (at, two[:-2]), (0x80000 - 4, two)):
            self.assert_refused(VALUE, lambda offset=offset, block=block: update.write_block(master, offset, block))
        update.write_block(master, at, two)
        self.assertEqual(master.get("update_next"), len(one + two))
        self.assertEqual(chip.memory_read(PLACE_B, len(one + two)), one + two)
        # Reading shows what stands there.
        master.put("update_offset", at.to_bytes(4, "big"))
        words = master.words("update_window")
        self.assertEqual(b"".join(word.to_bytes(2, "big") for word in words), two)

    def test_a_block_that_a_worn_flash_does_not_keep_is_told(self):
        chip, master = self.kept()
        update.order(master, update.BEGIN)
        chip.flash.is_worn = True
        self.assert_refused(DEVICE_FAILURE, lambda: update.write_block(master, *update.blocks(update.image("hangs"))[0]))
        self.assertEqual(master.get("update_next"), 0)

    # What is tried.

    def test_an_image_that_runs_stays_once_it_has_run_for_ten_seconds_and_answered(self):
        chip, master = self.on_trial()
        self.assert_runs(master, B, ON_TRIAL)
        self.assertEqual(update.log_codes(chip)[1:], [update.TRY_B, update.TRIED])
        # What is on trial neither takes an image nor stores.
        self.assert_refused(BUSY, lambda: update.order(master, update.BEGIN))
        self.assert_refused(DEVICE_FAILURE, lambda: master.set("bus_silent_ticks", 700))
        programmed = chip.flash.programmed_words
        chip.run(update.TRIAL_S - 0.5)
        self.assertEqual(chip.flash.programmed_words, programmed)
        chip.run(0.7)
        self.assertEqual(update.reached(master), (B, FOR_GOOD))
        self.assertEqual(update.log_codes(chip)[1:], [update.TRY_B, update.TRIED, update.FOR_GOOD_B])
        # What was changed meanwhile is stored now.
        master = self.start(chip)
        self.assertEqual(update.reached(master), (B, FOR_GOOD))
        self.assertEqual((master.get("fault"), master.get("bus_silent_ticks")), (0, 700))
        # And the next goes into A.
        chip.memory_write(PLACE_B - 0x70000, b"\x00" * 16)
        update.order(master, update.BEGIN)
        update.send(master, update.image("place_a"))
        self.assertIn(PLACES[0][0], chip.flash.erased)
        update.order(master, update.TAKE)
        self.assertEqual(update.reached(master), (B, WAITS))

    def test_what_is_on_trial_in_place_a_stores_nothing_either(self):
        chip, _ = self.kept()
        update.put(chip, update.image("b"))
        for code in (update.FOR_GOOD_B, update.TRY_A):
            update.append(chip, code)
        master = self.start(chip)
        self.assert_runs(master, A, ON_TRIAL)
        programmed = chip.flash.programmed_words
        self.assert_refused(DEVICE_FAILURE, lambda: master.set("bus_silent_ticks", 700))
        self.assertEqual((master.get("bus_silent_ticks"), chip.flash.programmed_words), (700, programmed))

    def test_an_image_that_hangs_or_faults_is_tried_three_times_and_the_former_runs_again(self):
        for name in ("hangs", "faults"):
            with self.subTest(name):
                chip, master = self.sent(update.image(name))
                update.order(master, update.TAKE)
                self.assertEqual(update.reached(master), (A, WAITS))
                update.order(master, update.RESTART)
                self.assertTrue(chip.run(until=lambda chip=chip: len(chip.resets) == 5, most_s=40.0))
                self.assertTrue(update.settle(chip))
                codes = update.log_codes(chip)
                self.assertEqual(codes, [update.FOR_GOOD_A, update.TRY_B, *[update.TRIED] * 3])
                self.assertEqual(update.reached(master), (A, ROLLED_BACK))
                self.assertEqual(master.get("bus_silent_ticks"), SILENT_TICKS)
                self.assert_vented(chip)
                chip.violations.clear()
                # Power, and it is as if nothing had been.
                self.assert_runs(self.start(chip), A, ROLLED_BACK)

    def test_a_damaged_image_is_not_begun_with(self):
        chip, master = self.sent(update.image("hangs"))
        update.order(master, update.TAKE)
        byte = chip.memory_read(PLACE_B + CODE, 1)[0]
        chip.memory_write(PLACE_B + CODE, bytes([byte & 0x7F]))
        self.assert_runs(self.start(chip), A, ROLLED_BACK)

    def test_a_trial_at_a_low_supply_waits_for_a_start_with_a_good_one(self):
        chip, _ = self.kept()
        update.put(chip, update.image("b"))
        update.append(chip, update.TRY_B)
        chip.supply_v = 2.75
        chip.power_on()
        chip.run(1.5)
        self.assertEqual(update.log_codes(chip), [update.FOR_GOOD_A, update.TRY_B])
        chip.supply_v = 3.3
        self.assert_runs(self.start(chip), B, ON_TRIAL)

    # Power.

    def test_power_lost_at_any_block_erasure_or_word_of_the_log_leaves_a_board_that_runs(self):
        chance = random.Random("cuts of an update")
        chip, master = self.kept()
        cuts = []

        def cut(later_s):
            """What runs behind a loss of power some time from now."""

            def work():
                chip.run(later_s)
                is_within = chip.flash.is_busy()
                master = self.start(chip)
                return update.reached(master), master.get("fault"), master.get("bus_silent_ticks"), is_within

            cuts.append(in_a_fork(work))

        update.order(master, update.BEGIN)
        for offset, block in update.blocks(update.image("hangs")):
            cut(0.0)
            chip.run(2e-3)
            end = chip.board.send(chip.usart1, write_frame(0xB08, offset.to_bytes(4, "big") + block))
            chip.run(end - chip.now)
            chip.board.bus.sent.clear()
            # The first erases for a second.
            for _ in range(CUTS // 4):
                cut(chance.random() * (1.0 if offset == 0 else 4e-3))
            self.assertTrue(chip.run(until=lambda: len(chip.board.bus.sent) == 8, most_s=3.0))
        self.assertEqual(master.get("update_next"), len(update.image("hangs")))
        for outcome in cuts:
            self.assertEqual(outcome[:3], ((A, FOR_GOOD), 0, SILENT_TICKS))
        self.assertGreater(sum(outcome[3] for outcome in cuts), CUTS // 4)

    def test_what_power_leaves_of_a_word_of_the_log_is_a_step_that_was_not_taken(self):
        chance = random.Random("words of the log")
        chip, _ = self.kept()
        update.put(chip, update.image("b"))
        for _ in range(6):
            word = update.word(update.TRY_B) | chance.getrandbits(32) & 0xFFFF
            is_whole = word == update.word(update.TRY_B)

            def work(word=word):
                chip.memory_write(update.LOG + 4, word.to_bytes(4, "little"))
                return update.reached(self.start(chip))

            self.assertEqual(in_a_fork(work), (B, ON_TRIAL) if is_whole else (A, FOR_GOOD))
        self.assertEqual(chip.flash.erased.count(LOG), 0)
