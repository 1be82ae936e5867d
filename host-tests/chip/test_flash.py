"""The parameter store on the flash itself: erase, program, lock, wear, and what who saves is told."""

import os
import struct

from stm32f405.case import ChipCase
from stm32f405.flash import ERASE_16K_S, LOCK, START
from stm32f405.host import STOP, Refused, write_frame
from stm32f405.link import Link
from stm32f405.saves import save_again_and_again

SECTORS = START + 0x4000
CORRUPT, DEVICE_FAILURE = 22, 4


class Flash(ChipCase):
    def test_sectors_of_zeros_are_a_fault_at_one_start_and_cured_at_the_next(self):
        chip = self.chip()
        chip.memory_write(SECTORS, bytes(0x8000))
        self.assertEqual(self.start(chip).get("fault"), CORRUPT)
        self.assertTrue(chip.flash.erased)
        self.assertEqual(self.start(chip).get("fault"), 0)

    def test_the_flash_is_locked_whenever_nothing_is_changed(self):
        chip, master = self.started()
        self.assertEqual(chip.flash["CR"], 1 << LOCK)
        master.set("bus_silent_ticks", 700)
        self.assertGreater(chip.flash.programmed_words, 0)
        self.assertEqual(chip.flash["CR"], 1 << LOCK)

    def full_store(self):
        """What stands in both sectors when they are full of records of the paper's model."""
        path = os.environ.get("MGPI_CHIP_STORE")
        if path is None:
            self.skipTest("MGPI_CHIP_STORE names no contents of a full store; host-tests/tests/chip.rs makes one")
        with open(path, "rb") as file:
            return file.read()

    def full(self):
        """A board whose next save erases."""
        chip = self.chip()
        chip.memory_write(SECTORS, self.full_store())
        return chip

    def test_what_was_accepted_is_there_at_the_next_start_through_full_sectors(self):
        chip = self.full()
        master = self.start(chip)
        for told in range(701, 704):
            master.set("bus_silent_ticks", told, timeout_s=2.0)
        self.assertEqual(len(chip.flash.erased), 1)
        # The data cache is on, and was emptied.
        self.assertTrue(chip.flash.bit("ACR", 10))
        self.assertEqual(chip.flash.emptied, 1)
        self.assertEqual(chip.flash["CR"], 1 << LOCK)
        master = self.start(chip)
        self.assertEqual((master.get("bus_silent_ticks"), master.get("fault")), (703, 0))

    def test_power_lost_at_any_moment_of_a_save_leaves_the_old_set_or_the_new(self):
        kept = []
        for share in (0.02, 0.2, 0.5, 0.9, 0.99, 1.01, 1.1):
            chip = self.full()
            master = self.start(chip)
            old = master.get("bus_silent_ticks")
            chip.board.send(chip.usart1, write_frame(0x418, struct.pack(">I", 701)))
            chip.run(until=lambda chip=chip: chip.flash.erased, most_s=2.0)
            # The erasure takes the longest; behind it the record is programmed.
            if share < 1.0:
                chip.now += share * ERASE_16K_S
            else:
                chip.run(ERASE_16K_S + (share - 1.0) * 0.01)
            master = self.start(chip)
            kept.append(master.get("bus_silent_ticks"))
            self.assertIn(kept[-1], (old, 701))
            self.assertEqual(master.get("fault"), 0)
        self.assertNotEqual(kept[0], 701)

    def test_a_save_that_a_worn_flash_does_not_keep_is_refused_and_in_use(self):
        chip, master = self.started()
        chip.flash.is_worn = True
        with self.assertRaises(Refused) as refused:
            master.set("bus_silent_ticks", 700, timeout_s=2.0)
        self.assertEqual(refused.exception.number, DEVICE_FAILURE)
        self.assertEqual(master.get("bus_silent_ticks"), 700)

    def test_a_save_that_a_worn_flash_does_not_keep_is_told_on_the_link_too(self):
        chip, _ = self.started()
        link = Link(chip)
        chip.flash.is_worn = True
        self.assertEqual(link.ask("protect", timeout_s=3.0), link.response("not_stored"))
        chip.flash.is_worn = False
        self.assertEqual(link.ask("protect", timeout_s=3.0), link.response("accepted"))

    def test_a_save_right_behind_a_stop_is_not_cut_off_by_the_watchdog_of_a_driven_valve(self):
        for lsi_hz, later_s in ((17e3, 0.0), (47e3, 0.0), (47e3, 0.4e-3), (47e3, 0.9e-3)):
            chip, _ = self.driven(iwdg__lsi_hz=lsi_hz)
            # The next save erases.
            chip.memory_write(SECTORS, self.full_store())
            chip.flash.erased.clear()
            link = Link(chip)
            # Both are there at once: the stop by the bus, and a set by the link.
            end = chip.board.send(chip.usart1, write_frame(0x100, struct.pack(">H", STOP)))
            link_s = len(link.frames["protect"]) * link.line.byte_s()
            chip.run(end - chip.now + later_s - link_s)
            link.send("protect")
            chip.run(1.0)
            self.assertEqual(link.received(), link.response("accepted"))
            self.assertEqual(len(chip.flash.erased), 1)
            self.assertEqual([cause for _, cause in chip.resets], ["power"])

    def test_of_a_hundred_saves_none_is_lost_silently_and_each_that_fails_is_told(self):
        counted = save_again_and_again(self, 100, 10, "a hundred")
        self.assertEqual((counted.saves, counted.wrong, counted.lost), (100, 0, 0), str(counted))
        self.assertGreater(counted.refused, 3)
        self.assertGreater(counted.erasures, 3)

    def test_a_save_into_a_protected_sector_is_refused(self):
        chip, master = self.started()
        chip.flash.protected = {1, 2}
        with self.assertRaises(Refused) as refused:
            master.set("bus_silent_ticks", 700, timeout_s=2.0)
        self.assertEqual(refused.exception.number, DEVICE_FAILURE)
        chip.flash.protected = set()
        master.set("bus_silent_ticks", 701, timeout_s=2.0)
        self.assertEqual(self.start(chip).get("bus_silent_ticks"), 701)
