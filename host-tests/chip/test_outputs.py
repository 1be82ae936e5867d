"""What the valve's output puts out: vented is 0 V at the pin, from every state and behind every reset."""

from stm32f405.case import DRIVEN_BAR, VENTED_V, ChipCase
from stm32f405.dac import EN1


class Outputs(ChipCase):
    def test_a_board_that_starts_vents_from_its_first_instruction(self):
        chip = self.chip()
        chip.power_on()
        for _ in range(200):
            chip.run(50e-6)
            self.assert_vented(chip)

    def test_a_service_pressure_is_put_out_and_stop_vents(self):
        chip, master = self.driven()
        self.assertTrue(chip.dac.bit("CR", EN1))
        master.set("command", 2)
        chip.run(2e-3)
        self.assert_vented(chip)

    def test_a_set_point_of_0_bar_is_0_volts(self):
        chip, master = self.driven()
        master.set("setpoint_bar", 0.0)
        chip.run(0.2)
        self.assert_vented(chip)
        master.set("setpoint_bar", 1.0)
        chip.run(0.1)
        self.assertAlmostEqual(chip.board.output_bar(), 1.0, delta=0.02)

    def test_a_silent_host_vents(self):
        chip, master = self.driven()
        master.set("command", 2)
        master.set("bus_silent_ticks", 100, timeout_s=1.0)
        master.drive(DRIVEN_BAR)
        chip.run(0.15)
        self.assertEqual(master.get("fault"), 21)
        self.assert_vented(chip)

    def test_a_converter_that_follows_nothing_any_more_is_let_go_of(self):
        chip, master = self.driven()
        chip.dac.stuck_v = 3.0
        master.set("command", 2)
        chip.run(2e-3)
        self.assert_vented(chip)

    def test_an_unexpected_interrupt_vents_before_the_reset_and_is_kept(self):
        chip, master = self.driven()
        vented = []
        reset = chip.reset

        def seen(cause):
            vented.append((chip.board.output_v(), cause))
            reset(cause)

        chip.reset = seen
        chip.nvic.enabled.add(60)
        chip.nvic.pending.add(60)
        chip.run(0.2)
        self.assertEqual([cause for _, cause in vented], ["software"])
        self.assertLess(vented[0][0], VENTED_V)
        self.assertEqual((master.get("state"), master.get("fault")), (5, 26))
        self.assert_vented(chip)
