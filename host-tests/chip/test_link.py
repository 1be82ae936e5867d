"""Link and bus at once: what one of them does takes no byte from the other."""

import os
import random

from stm32f405.case import ChipCase, prepared
from stm32f405.host import BYTE_S, STOP, TABLE, UNIT, read_frame, take, with_crc
from stm32f405.link import Link

STATE = 0x200
# As many registers as there are from there on. Unit: register.
LONG = 38
LINK_BYTE_S = 10 / 460_800
TICK_S = 1e-3
# Rates of the bus and parities: that of a new board, and others from the lowest rate to the highest.
NEW = 115_200, "none"
FORMATS = (9_600, "even"), (19_200, "odd"), (57_600, "none"), NEW, (460_800, "even"), (1_000_000, "none")


class LinkAndBus(ChipCase):
    @prepared
    def tracking(self):
        """A board that tracks by the paper's model with every extension, whose tick takes longer than a byte of the link."""
        chip, master = self.started()
        return chip, master, self.track(chip)

    def track(self, chip):
        """Lets a board do that; the host at its link."""
        link = Link(chip)
        for name in ("protect", "extended", "arm", "start"):
            self.assertEqual(link.ask(name), link.response("accepted"), name)
        chip.run(0.2)
        return link

    def assert_whole(self, chip, answer_bytes):
        """The board's last answer on the bus: without gaps, the driver on from its first bit to within a bit of its last."""
        moments = [moment for moment, _ in chip.board.bus.sent]
        self.assertEqual(len(moments), answer_bytes)
        gaps = [later - earlier for earlier, later in zip(moments, moments[1:])]
        # A pause of less than a bit between two bytes.
        line = chip.board.bus
        byte_s, bit_s = line.byte_s(), 1 / line.baud
        self.assertLess(max(gaps), byte_s + bit_s)
        edges = [(moment, is_high) for moment, is_high in chip.board.driver_edges if moment > moments[0] - 2 * byte_s]
        self.assertEqual([is_high for _, is_high in edges], [True, False])
        # Within a bit of the last, but at the highest rates the interrupt's own time.
        self.assertLess(edges[1][0] - moments[-1] - 0.4 * bit_s, max(bit_s, 2e-6))
        self.assertEqual(chip.board.undriven, 0)

    def test_the_link_loses_no_byte_while_the_tick_takes_longer_than_one(self):
        chip, _, link = self.tracking()
        for step in range(30):
            chip.run(step * 17e-6)
            self.assertTrue(link.is_hello(link.ask("identify")))
        self.assertEqual(chip.board.lost_bytes, 0)

    def test_an_answer_on_the_bus_has_no_gap_while_the_tick_takes_longer_than_a_byte_of_the_link(self):
        chip, master, link = self.tracking()
        for step in range(10):
            chip.run(step * 97e-6)
            link.send("identify")
            master.ask(read_frame(STATE, 12))
            self.assert_whole(chip, 29)
        self.assertEqual(chip.board.lost_bytes, 0)

    def test_the_tick_goes_on_and_the_bus_is_answered_while_the_link_prepares_a_configuration(self):
        chip, master = self.started()
        link = Link(chip)
        self.assertEqual(link.ask("protect"), link.response("accepted"))
        overruns = master.get("overruns")
        for lead_s in (0.0, 0.5e-3, 1e-3, 2e-3):
            chip.board.driver_edges.clear()
            chip.board.bus.sent.clear()
            link.line.sent.clear()
            end = link.send("extended")
            chip.run(max(end - chip.now - lead_s, 0.0))
            chip.board.send(chip.usart1, read_frame(STATE, 12))
            chip.run(0.2)
            self.assert_whole(chip, 29)
            self.assertEqual(link.received(), link.response("accepted"))
        self.assertEqual(chip.board.lost_bytes, 0)
        self.assertEqual(master.get("overruns"), overruns)

    def test_a_request_by_link_waits_as_a_whole_while_the_bus_is_served(self):
        chip, master, link = self.tracking()
        for step in range(10):
            link.line.sent.clear()
            chip.board.send(chip.usart1, read_frame(STATE, LONG))
            chip.run(8 * BYTE_S - 4 * LINK_BYTE_S + step * 20e-6)
            link.send("identify")
            chip.run(0.02)
            self.assertTrue(link.is_hello(link.received()))
        self.assertEqual(chip.board.lost_bytes, 0)
        self.assertEqual(master.get("bus_damaged"), 0)

    def test_an_answer_has_no_gap_at_any_rate_while_the_board_tracks_and_answers_on_its_link(self):
        chip, master, link = self.tracking()
        for baud, parity in FORMATS:
            master.set("command", STOP)
            take(master, baud, parity)
            for name in ("arm", "start"):
                self.assertEqual(link.ask(name), link.response("accepted"), name)
            for step in range(5):
                # At whatever moment of a tick.
                chip.run(step * 207e-6)
                chip.board.driver_edges.clear()
                link.send("identify")
                master.ask(read_frame(STATE, 12), timeout_s=0.2)
                self.assert_whole(chip, 29)
            self.assertEqual(chip.board.lost_bytes, 0, f"{baud} bit/s")

    def test_what_the_bus_is_sending_leaves_before_the_link_stores_and_erases(self):
        path = os.environ.get("MGPI_CHIP_STORE")
        if path is None:
            self.skipTest("MGPI_CHIP_STORE names no contents of a full store; host-tests/tests/chip.rs makes one")
        with open(path, "rb") as file:
            contents = file.read()
        # The longest answer: 21 ms at 115,200 bit/s, 280 at the lowest rate. The store alone looks through its sectors for
        # 8 ms before it erases.
        window = TABLE["capture_window"]
        words = int(window["words"])
        rounds = (FORMATS[0], 0.4e-3), (NEW, 0.4e-3), (NEW, 0.7e-3), (FORMATS[-1], 0.4e-3)
        for (baud, parity), lead_s in rounds:
            chip = self.chip()
            # By the parameters of the full store, then by those of this round, which are not kept.
            chip.memory_write(0x0800_4000, contents)
            master = self.start(chip)
            take(master, baud, parity)
            chip.memory_write(0x0800_4000, contents)
            link, byte_s = Link(chip), chip.board.bus.byte_s()
            chip.run(5e-3)
            chip.board.driver_edges.clear()
            chip.board.bus.sent.clear()
            chip.flash.erased.clear()
            request = read_frame(int(window["address"]), words)
            # The link's request is there once the answer has begun.
            link_s = len(link.frames["protect"]) * LINK_BYTE_S
            before_s = (len(request) + 2) * byte_s + lead_s
            end = chip.now + max(link_s, before_s) + TICK_S
            chip.board.send(chip.usart1, request, at=end - before_s)
            chip.run(end - link_s - chip.now)
            link.send("protect")
            chip.run(end - chip.now)
            self.assertTrue(chip.board.bus.sent, "the answer has not begun")
            chip.run(1.0)
            self.assertEqual(link.received(), link.response("accepted"))
            self.assertEqual(len(chip.flash.erased), 1)
            self.assert_whole(chip, 5 + 2 * words)
            self.assertEqual(master.get("fault"), 0)

    def test_random_frames_on_the_bus_make_no_tick_late_while_the_board_tracks(self):
        chip, master, _ = self.tracking()
        before = [master.get(name) for name in ("overruns", "late_ticks")]
        chance = random.Random(7)
        for _ in range(60):
            frame, gap_s = chance.randbytes(chance.randrange(2, 60)), 2e-3
            if chance.random() < 0.5:
                # The board answers that its function is none: a tick and five bytes behind the silence.
                # What came before that would collide with it, as on any line.
                frame, gap_s = with_crc(bytes([UNIT]) + frame[1:]), 4e-3
            end = chip.board.send(chip.usart1, frame)
            chip.run(end - chip.now + gap_s)
        chip.run(5e-3)
        self.assertEqual([master.get(name) for name in ("overruns", "late_ticks")], before)
        self.assertEqual(chip.board.lost_bytes, 0)

    def test_a_damaged_frame_is_told_and_the_next_one_answered(self):
        chip, _ = self.started()
        link = Link(chip)
        frame = bytearray(link.frames["identify"])
        frame[0] ^= 1
        self.assertEqual(link.exchange(bytes(frame)), link.response("unreadable"))
        self.assertTrue(link.is_hello(link.ask("identify")))
