"""The exchange in slots on the wire: when a member's answer begins and ends, by the production image."""

import struct

from stm32f405.case import ChipCase
from stm32f405.host import take, with_crc

FUNCTION, ANSWER_BYTES, GAP_S = 65, 37, 500e-6
TAKEN, LATE, REPEATED = 1, 2, 4
RATES = (115_200, 1_000_000)


def request(members, sequence=1, gap_s=GAP_S):
    """To all; a member is its number, what is said, until which tick, and the set point."""
    content = struct.pack(">BBBHH", 0, FUNCTION, len(members), sequence, round(gap_s * 1e6))
    return with_crc(content + b"".join(struct.pack(">BBIf", *member) for member in members))


def asked(*units):
    return [(unit, 0, 0, 0.0) for unit in units]


def answer_of(unit):
    """Some answer of another member."""
    return with_crc(struct.pack(">BB", unit, FUNCTION) + bytes(ANSWER_BYTES - 4))


class Slots(ChipCase):
    def begin_s(self, chip, place):
        """From the end of the request to the begin of a slot."""
        return GAP_S + place * (ANSWER_BYTES * chip.board.bus.byte_s() + GAP_S)

    def exchange(self, chip, members, place, others=(), **how):
        """Sends a request; from its end to the answer's first bit and to the last, and the answer. The members at the
        places `others` answer too."""
        chip.run(4e-3)
        chip.board.driver_edges.clear()
        chip.board.bus.sent.clear()
        end = chip.board.send(chip.usart1, request(members, **how))
        for other in sorted(others):
            chip.board.send(chip.usart1, answer_of(members[other][0]), at=end + self.begin_s(chip, other) + 20e-6)
        longest_s = self.begin_s(chip, len(members)) + 2e-3
        chip.run(end - chip.now + longest_s)
        edges = [at - end for at, _ in chip.board.driver_edges]
        return edges, bytes(byte for _, byte in chip.board.bus.sent)

    def test_each_slot_begins_at_its_time_and_ends_before_the_next_whatever_the_others_do(self):
        for baud in RATES:
            chip, master = self.started()
            take(master, baud)
            latest = 0.0
            for number, place in enumerate([0, 1, 2, 3, 7, 11, 15] * 3):
                units = list(range(20, 36))
                units[place] = 1
                before = [other for other in range(place) if other % 3 != number % 3]
                # At all moments between two ticks.
                chip.run(number * 0.087e-3)
                edges, answer = self.exchange(chip, asked(*units), place, before)
                what = f"{baud} bit/s, slot {place}"
                self.assertEqual((len(edges), len(answer)), (2, ANSWER_BYTES), what)
                self.assertEqual((with_crc(answer[:-2]), answer[:2]), (answer, bytes([1, FUNCTION])), what)
                late = edges[0] - self.begin_s(chip, place)
                latest = max(latest, late)
                # A moment is cut to microseconds, and a byte is heard 0.04 of its time before its end.
                self.assertGreater(late, -2e-6 - 0.05 * chip.board.bus.byte_s(), what)
                self.assertLess(edges[1], self.begin_s(chip, place + 1), what)
            # 16 us at 115,200 bit/s, 7 us at 1,000,000; between two ticks nothing waits for the next one.
            self.assertLess(latest, 50e-6, f"{baud} bit/s")
            self.assertEqual((chip.board.undriven, chip.board.collisions, chip.board.lost_bytes), (0, 0, 0))

    def test_a_board_that_is_no_member_is_silent_and_answers_the_next_request(self):
        chip, master = self.started()
        edges, _ = self.exchange(chip, asked(2, 3, 4), 0, [0, 1, 2])
        self.assertEqual(edges, [])
        self.assertEqual((master.get("state"), master.get("bus_damaged")), (0, 0))

    def test_while_the_valve_is_driven_slots_are_kept_and_ticks_are_in_time(self):
        chip, master = self.driven()
        take_late = master.get("late_ticks")
        for number in range(12):
            chip.run(number * 0.083e-3)
            edges, answer = self.exchange(chip, asked(9, 1), 1, [0], sequence=number)
            self.assertEqual((len(answer), answer[5]), (ANSWER_BYTES, 6))
            self.assertLess(abs(edges[0] - self.begin_s(chip, 1)), GAP_S / 2)
        self.assertEqual(master.get("late_ticks"), take_late)

    def test_what_is_late_or_repeated_is_told_and_is_no_sign_of_life(self):
        chip, master = self.driven()
        master.set("heartbeat", 100)
        for sequence, ahead, outcome in ((101, -2_000, LATE), (100, 500, REPEATED), (101, 500, TAKEN)):
            until = (master.get("ticks") + ahead) % 2**32
            _, answer = self.exchange(chip, [(1, 1, until, 0.0)], 0, sequence=sequence)
            self.assertEqual((answer[2:4], answer[4]), (sequence.to_bytes(2, "big"), outcome))
            self.assertEqual(master.get("heartbeat"), 101 if outcome == TAKEN else 100)

    def test_a_frame_with_more_members_than_fit_is_silence_and_the_next_one_is_heard(self):
        chip, master = self.started()
        edges, _ = self.exchange(chip, asked(*[1] * 25), 0)
        self.assertEqual(edges, [])
        self.assertEqual(master.get("state"), 0)
