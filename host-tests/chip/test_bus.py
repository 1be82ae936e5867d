"""The bus on the wire: its driver, its echo, others' answers."""

import struct

from stm32f405.case import ChipCase
from stm32f405.host import BYTE_S, read_frame, with_crc

STATE = 0x200
# The shortest silence that masters leave before a request, and that of the standard. Unit: s.
SHORT_S, STANDARD_S = 0.75e-3, 1.75e-3
REQUEST = read_frame(STATE, 1)
# Of another board: 12 registers, and an answer of a function that this board does not know.
ANSWER = with_crc(struct.pack(">BBB", 2, 3, 24) + bytes(range(24)))
UNKNOWN = with_crc(struct.pack(">BBB", 2, 43, 14) + bytes(range(31)))


class Bus(ChipCase):
    def test_the_driver_is_enabled_before_the_first_bit_and_freed_within_a_bit_of_the_last(self):
        for has_echo in (True, False):
            chip, master = self.started(board__has_echo=has_echo)
            chip.board.driver_edges.clear()
            master.ask(read_frame(STATE, 12))
            edges = chip.board.driver_edges
            self.assertEqual([is_high for _, is_high in edges], [True, False])
            self.assertEqual(chip.board.undriven, 0)
            # The stop bit ends 0.4 bits after it was seen.
            end = chip.board.bus.sent[-1][0] + 0.4 * BYTE_S / 10
            self.assertGreater(edges[1][0], end - 1e-9)
            self.assertLess(edges[1][0] - end, BYTE_S / 10)

    def test_an_echo_is_never_taken_for_a_request_at_whatever_moment_the_answer_ends(self):
        chip, master = self.started()
        for step in range(60):
            chip.run(step * 17e-6)
            master.ask(REQUEST)
        self.assertEqual(master.get("bus_damaged"), 0)

    def answered(self, gap_s, requests, foreign=ANSWER, phase_s=37e-6):
        """How many requests are answered that come `gap_s` behind another board's answer."""
        chip, _ = self.started()
        count = 0
        for number in range(requests):
            chip.run(4e-3 + number * phase_s % 1e-3)
            chip.board.bus.sent.clear()
            end = chip.board.send(chip.usart1, foreign)
            chip.run(end - chip.now + gap_s)
            end = chip.board.send(chip.usart1, REQUEST)
            chip.run(end - chip.now + 3e-3)
            count += len(chip.board.bus.sent) == 7
        return count

    def test_no_request_is_lost_behind_another_boards_answer_at_the_standards_silence(self):
        self.assertEqual(self.answered(STANDARD_S, 60), 60)

    def test_no_request_is_lost_behind_an_answer_of_unknown_length_at_the_standards_silence(self):
        self.assertEqual(self.answered(STANDARD_S, 60, foreign=UNKNOWN), 60)

    def test_no_request_is_lost_behind_another_boards_answer_at_three_quarters_of_a_millisecond(self):
        self.assertEqual(self.answered(SHORT_S, 60), 60)

    def test_no_request_is_lost_behind_an_answer_of_unknown_length_at_three_quarters_of_a_millisecond(self):
        self.assertEqual(self.answered(SHORT_S, 60, foreign=UNKNOWN), 60)

    def test_a_request_whose_bytes_come_with_pauses_of_1_5_characters_or_1_6_ms_is_answered(self):
        chip, _ = self.started()
        for gap_s in (1.5 * BYTE_S, 1.6e-3):
            chip.board.bus.sent.clear()
            end = chip.board.send(chip.usart1, REQUEST, gap_s=gap_s)
            chip.run(end - chip.now + 3e-3)
            self.assertEqual(len(chip.board.bus.sent), 7)
