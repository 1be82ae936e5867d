"""A valve is opened in two steps, and stays open as long as its host shows that it lives."""

import struct

from stm32f405.case import ChipCase
from stm32f405.host import ARM, SERVICE, STOP, Refused, write_frame
from stm32f405.link import Link

COMMAND, EVERYBODY = 0x100, 0
BUSY = 6
SILENT, STANDS = 21, 40
# A fifth of what a board is delivered with, and what a host's turn and a request take. Unit: s.
PATIENCE_S, TURN_S, MARGIN_S = 0.1, 0.02, 0.01


class TwoSteps(ChipCase):
    def test_no_valve_is_opened_by_one_command(self):
        chip, master = self.started()
        with self.assertRaises(Refused) as refused:
            master.set("command", SERVICE)
        self.assertEqual(refused.exception.number, BUSY)
        master.drive(1.0)
        self.assertEqual(master.get("state"), 6)

    def test_a_broadcast_starts_nothing_and_stops_all(self):
        chip, master = self.started()

        def to_all(command):
            end = chip.board.send(chip.usart1, write_frame(COMMAND, struct.pack(">H", command), EVERYBODY))
            chip.run(end - chip.now + 5e-3)

        master.set("command", ARM)
        to_all(SERVICE)
        self.assertEqual(master.get("state"), 0)
        master.set("command", STOP)
        to_all(ARM)
        self.assertEqual(master.get("armed_ticks"), 0)
        master.drive(1.0)
        to_all(STOP)
        self.assertEqual(master.get("state"), 0)

    def vented_after(self, chip, work):
        """How long the valve stays open while a host does this again and again."""
        begin = chip.now
        while chip.board.output_v() > 0.01 and chip.now - begin < 3 * PATIENCE_S:
            chip.run(until=lambda: chip.board.output_v() < 0.01, most_s=TURN_S)
            work()
        return chip.now - begin

    def in_service(self):
        chip, master = self.started()
        master.set("bus_silent_ticks", int(1000 * PATIENCE_S), timeout_s=1.0)
        self.follow(chip)
        master.drive(2.0)
        chip.run(0.05)
        master.set("heartbeat", 7)
        return chip, master

    def test_a_heartbeat_that_stands_still_vents_as_fault_40(self):
        chip, master = self.in_service()
        after = self.vented_after(chip, lambda: master.set("heartbeat", 7))
        self.assertLess(abs(after - PATIENCE_S), TURN_S + MARGIN_S)
        self.assertEqual(master.get("fault"), STANDS)
        self.assert_vented(chip)

    def test_a_host_that_only_reads_is_silent_and_one_whose_heart_beats_is_not(self):
        chip, master = self.in_service()
        after = self.vented_after(chip, lambda: master.get("pressure_bar"))
        self.assertLess(abs(after - PATIENCE_S), TURN_S + MARGIN_S)
        self.assertEqual(master.get("fault"), SILENT)
        chip, master = self.in_service()
        numbers = iter(range(1000))
        self.assertGreater(self.vented_after(chip, lambda: master.set("heartbeat", next(numbers))), 2.9 * PATIENCE_S)

    def test_no_limit_by_the_link_exceeds_what_is_compiled_in(self):
        chip, master = self.started()
        link = Link(chip)
        # Limits of a simulation, which are off.
        self.assertNotEqual(link.ask("beyond"), link.response("accepted"))
        self.assertAlmostEqual(master.get("overpressure_hard_bar"), 7.5)
        self.assertEqual(link.ask("protect"), link.response("accepted"))
        self.assertAlmostEqual(master.get("overpressure_hard_bar"), 8.5)
