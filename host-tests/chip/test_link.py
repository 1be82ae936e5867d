"""Link and bus at once: what one of them does takes no byte from the other."""

import os
import random

from stm32f405.case import ChipCase, prepared
from stm32f405.host import BYTE_S, TABLE, UNIT, read_frame, with_crc
from stm32f405.link import Link

STATE = 0x200
# As many registers as there are from there on. Unit: register.
LONG = 38
LINK_BYTE_S = 10 / 460_800


class LinkAndBus(ChipCase):
    @prepared
    def tracking(self):
        """A board that tracks by the paper's model with every extension, whose tick takes longer than a byte of the link."""
        chip, master = self.started()
        link = Link(chip)
        for name in ("protect", "extended", "arm", "start"):
            self.assertEqual(link.ask(name), link.response("accepted"), name)
        chip.run(0.2)
        return chip, master, link

    def assert_whole(self, chip, answer_bytes):
        """The board's last answer on the bus: without gaps, the driver on from its first bit to within a bit of its last."""
        moments = [moment for moment, _ in chip.board.bus.sent]
        self.assertEqual(len(moments), answer_bytes)
        gaps = [later - earlier for earlier, later in zip(moments, moments[1:])]
        # A pause of less than a bit between two bytes.
        self.assertLess(max(gaps), 1.1 * BYTE_S)
        edges = [(moment, is_high) for moment, is_high in chip.board.driver_edges if moment > moments[0] - 2 * BYTE_S]
        self.assertEqual([is_high for _, is_high in edges], [True, False])
        self.assertLess(edges[1][0] - moments[-1], 1.4 * BYTE_S / 10)
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

    def test_what_the_bus_is_sending_leaves_before_the_link_stores_and_erases(self):
        path = os.environ.get("MGPI_CHIP_STORE")
        if path is None:
            self.skipTest("MGPI_CHIP_STORE names no contents of a full store; host-tests/tests/chip.rs makes one")
        with open(path, "rb") as file:
            contents = file.read()
        # 21 ms of it: the store alone looks through its sectors for 8 ms before it erases.
        window = TABLE["capture_window"]
        words = int(window["words"])
        for lead_s in (0.4e-3, 0.7e-3):
            chip = self.chip()
            chip.memory_write(0x0800_4000, contents)
            self.start(chip)
            link = Link(chip)
            chip.board.driver_edges.clear()
            chip.board.bus.sent.clear()
            end = link.send("protect")
            chip.run(end - chip.now - 8 * BYTE_S - lead_s)
            chip.board.send(chip.usart1, read_frame(int(window["address"]), words))
            chip.run(end - chip.now)
            self.assertTrue(chip.board.bus.sent, "the answer has not begun")
            chip.run(1.0)
            self.assertEqual(link.received(), link.response("accepted"))
            self.assertEqual(len(chip.flash.erased), 1)
            self.assert_whole(chip, 5 + 2 * words)

    def test_random_frames_on_the_bus_make_no_tick_late_while_the_board_tracks(self):
        chip, master, _ = self.tracking()
        before = [master.get(name) for name in ("overruns", "late_ticks")]
        chance = random.Random(7)
        for _ in range(60):
            frame = chance.randbytes(chance.randrange(2, 60))
            if chance.random() < 0.5:
                frame = with_crc(bytes([UNIT]) + frame[1:])
            end = chip.board.send(chip.usart1, frame)
            chip.run(end - chip.now + 2e-3)
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
