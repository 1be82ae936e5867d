"""How the board is reached: number, rate, parity, turn-around, and the way back from a wrong rate."""

import struct

from stm32f405.case import ChipCase
from stm32f405.host import Master, Silent, keep, read_frame

STATE = 0x200
# How long a board listens by the same parameters while nobody is heard.
SILENT_S = 10.0
TICK_S = 1e-3


class Line(ChipCase):
    def reached_by(self, chip, number=1, baud=115_200, parity="none"):
        """A master that speaks by other parameters."""
        chip.board.bus.baud, chip.board.bus.parity = baud, parity
        return Master(chip, number)

    def test_number_rate_and_parity_are_taken_at_the_next_start_and_not_before(self):
        chip, master = self.started()
        keep(master, 17, 19_200, "even")
        self.assertEqual((master.get("state"), master.get("bus_listens")), (0, 1))
        self.start(chip)
        master = self.reached_by(chip, 17, 19_200, "even")
        self.assertEqual((master.get("bus_number"), master.get("bus_listens")), (17, 0))
        with self.assertRaises(Silent):
            self.reached_by(chip, 1, 19_200, "even").get("state")
        with self.assertRaises(Silent):
            self.reached_by(chip, 17).get("state")

    def test_a_command_takes_them_behind_its_answer(self):
        chip, master = self.started()
        keep(master, 17, 250_000, "odd")
        master.set("bus_take", 1)
        master = self.reached_by(chip, 17, 250_000, "odd")
        self.assertEqual(master.get("bus_rate_bit_per_s"), 250_000)

    def test_every_rate_is_answered_with_its_bit_times_the_driver_freed_behind_the_last(self):
        chip, master = self.started()
        for baud, parity in ((9_600, "none"), (19_200, "even"), (57_600, "odd"), (460_800, "none"), (1_000_000, "even")):
            keep(master, 1, baud, parity)
            master.set("bus_take", 1)
            master = self.reached_by(chip, 1, baud, parity)
            chip.board.driver_edges.clear()
            master.ask(read_frame(STATE, 12), timeout_s=0.2)
            line = chip.board.bus
            # Gaps between the bytes: none.
            times = [moment for moment, _ in line.sent]
            longest = max(later - sooner for sooner, later in zip(times, times[1:]))
            self.assertLess(longest, 1.02 * line.byte_s(), f"{baud} bit/s")
            edges = chip.board.driver_edges
            self.assertEqual([is_high for _, is_high in edges], [True, False])
            end = times[-1] + 0.4 / baud
            self.assertGreater(edges[1][0], end - 1e-9)
            # A bit of the line, but at the highest rates the interrupt's own time.
            self.assertLess(edges[1][0] - end, max(1 / baud, 2e-6), f"{baud} bit/s")
        self.assertEqual((chip.board.undriven, chip.board.collisions), (0, 0))

    def test_requests_at_the_highest_rate_are_heard_byte_behind_byte(self):
        chip, master = self.started()
        keep(master, 1, 1_000_000)
        master.set("bus_take", 1)
        master = self.reached_by(chip, 1, 1_000_000)
        for step in range(40):
            chip.run(step * 23e-6)
            master.ask(read_frame(STATE, 30))
        self.assertEqual((master.get("bus_damaged"), chip.board.lost_bytes), (0, 0))

    def test_an_answer_waits_for_the_turn_around(self):
        chip, master = self.started()
        keep(master, turnaround_us=3_000)
        master.set("bus_take", 1)
        for step in range(12):
            chip.run(4e-3 + step * 0.087e-3)
            chip.board.driver_edges.clear()
            end = chip.board.send(chip.usart1, read_frame(STATE, 1))
            chip.run(end - chip.now + 5e-3)
            waited = chip.board.driver_edges[0][0] - end
            self.assertGreater(waited, 3e-3 - 10e-6)
            self.assertLess(waited, 3e-3 + 1.1 * TICK_S)

    def test_a_rate_that_no_master_has_loses_no_board(self):
        chip, master = self.started()
        keep(master, 5, 9_600, "odd")
        self.start(chip)
        # The master speaks as to a new board, all the time, and is not heard in the first seconds.
        master = self.reached_by(chip, 5)
        begin = chip.now
        heard_at = None
        while heard_at is None and chip.now - begin < 1.2 * SILENT_S:
            chip.run(0.5)
            try:
                master.get("state")
                heard_at = chip.now - begin
            except Silent:
                pass
        self.assertIsNotNone(heard_at, "the board is lost")
        self.assertGreater(heard_at, 0.9 * SILENT_S)
        self.assertEqual((master.get("bus_rate_bit_per_s"), master.get("bus_listens")), (9_600, 2))
        keep(master, 5)
        master.set("bus_take", 1)
        self.assertEqual(master.get("bus_listens"), 0)

    def test_the_processors_number_and_revision_are_told(self):
        _, master = self.started()
        self.assertEqual(master.words("unique_id"), (0x3238, 0x3732, 0x3134, 0x510E, 0x0039, 0x0045))
        self.assertEqual(master.get("processor") & 0xFFF, 0x413)
        self.assertEqual(master.get("hardware_revision"), 0)

    def test_the_commit_of_the_images_sources_is_told(self):
        _, master = self.started()
        if not any(master.words("source_commit")):
            self.skipTest("the image was built outside of git")
        self.assertIn(master.get("source_modified"), (0, 1))

    def test_the_boards_revision_is_what_its_maker_has_written_once(self):
        chip = self.chip()
        chip.memory_write(0x1FFF_7800, struct.pack("<H", 3))
        self.assertEqual(self.start(chip).get("hardware_revision"), 3)
