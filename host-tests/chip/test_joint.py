"""The image of two channels: what is measured and put out by each, and what vents both."""

import math
import struct

from stm32f405.case import LINK_TASK, VENTED_V, ChipCase, prepared
from stm32f405.flash import PLACE_A
from stm32f405.fork import in_a_fork
from stm32f405.joint import (
    ANGLE, FAULT, IMAGE, OFF, PRESSURES, READY, SERVICE, STARTING, SUPPLY, TRACKING, aim, joint_chip, press,
)

TICK_S = 1e-3
TO_3V3 = 3.3 / 4095
# What a tick takes here at the most, and at how many moments of it something happens. Unit: s.
WHOLE_TICK_S, MOMENTS = 40e-6, 16
# How far a joint without friction may be from what its model, which has some, is asked for: of a range of 1 rad.
RMSE_RAD, LARGEST_RAD = 0.01, 0.03


class JointCase(ChipCase):
    def setUp(self):
        super().setUp()
        if not IMAGE.is_file():
            self.skipTest(f"no {IMAGE}; `cargo xtask firmware` builds it")

    def joint(self, **what):
        """A chip that is not yet powered, and its joint; `what` as `ChipCase.chip` has it."""
        made = []

        def make():
            made.extend(joint_chip())
            return made[0]

        chip = self.chip(make, **what)
        return chip, made[1]

    def begun(self, **what):
        """A board that runs, vented, without a joint."""
        chip, joint = self.joint(**what)
        self.start(chip)
        return chip, joint

    @prepared
    def starting(self, **what):
        """A board that fills both muscles."""
        chip, joint = self.begun(**what)
        joint.step()
        joint.start()
        joint.keep(0.4)
        return chip, joint

    def outputs(self, chip):
        return [chip.board.output_v(channel) for channel in (1, 2)]

    def assert_vented(self, chip):
        self.assertLess(max(self.outputs(chip)), VENTED_V)

    def assert_driven(self, chip):
        self.assertGreater(min(self.outputs(chip)), 0.25)

    def assert_vented_by(self, chip, joint, fault, most_s=6 * TICK_S):
        """Both, at the same time; stays so."""
        vented = lambda: [volts < VENTED_V for volts in self.outputs(chip)]
        self.assertTrue(chip.run(until=lambda: any(vented()), most_s=most_s), f"not vented by {fault}")
        self.assertEqual(vented(), [True, True], "one valve is vented alone")
        # The dump valve's pump lets go within 10 ms.
        chip.run(12 * TICK_S)
        report = joint.ask()
        self.assertEqual((report.state, report.fault), (FAULT, fault))
        self.assert_vented(chip)
        self.assertTrue(chip.board.is_dumping())


class Joint(JointCase):
    # The start.

    def test_both_valves_are_vented_from_the_first_instruction_until_the_second_of_two_steps(self):
        chip, joint = self.joint()
        chip.power_on()
        for _ in range(200):
            chip.run(50e-6)
            self.assert_vented(chip)
        # A new board erases first.
        chip.run(0.6)
        self.assertEqual(joint.ask().state, OFF)
        self.assertTrue(chip.board.is_dumping())
        for name in ("joint_aim", "joint_start", "joint_arm", "joint_configure"):
            joint.link.ask(name)
            chip.run(5 * TICK_S)
            self.assert_vented(chip)
        self.assertEqual(joint.ask().state, READY)
        self.assertFalse(chip.board.is_dumping())
        self.assertEqual(joint.link.ask("joint_start"), joint.link.response("joint_not_armed"))
        self.assert_vented(chip)
        joint.step()
        self.assertTrue(joint.order("joint_arm") and joint.order("joint_start"))
        joint.keep(0.3)
        self.assert_driven(chip)
        self.assertTrue(joint.order("joint_stop"))
        chip.run(2 * TICK_S)
        self.assert_vented(chip)
        self.assertEqual(joint.ask().state, READY)

    def test_the_frames_of_the_model_are_those_of_the_messages(self):
        _, joint = self.begun()
        self.assertEqual(aim(0.25), joint.link.frames["joint_aim"])
        self.assertEqual(aim(0.25, by_tick=70_000), joint.link.frames["joint_aim_by"])
        self.assertEqual(press(2.5, 1.5), joint.link.frames["joint_press"])

    # What is measured, and what is put out.

    def test_each_input_arrives_where_it_belongs(self):
        chip, joint = self.begun()
        codes = {PRESSURES[0]: 1000, ANGLE: 2200, PRESSURES[1]: 1500, SUPPLY: 2600}
        for channel, code in codes.items():
            chip.board.voltages[channel] = code * TO_3V3
        chip.run(3 * TICK_S)
        report = joint.ask()
        shown = [*report.pressure_codes, report.angle_code, report.supply_code]
        self.assertEqual(shown, [1000, 1500, 2200, 2600])
        self.assertEqual(report.fault, 0)

    def test_five_conversions_a_tick_take_the_noise_down(self):
        chip, joint = self.begun()
        chip.board.noise_codes = 8.0
        shown = []
        for _ in range(60):
            chip.run(1.3 * TICK_S)
            report = joint.ask()
            shown.append([*report.pressure_codes, report.angle_code])
        for codes in zip(*shown):
            mean = sum(codes) / len(codes)
            deviation = (sum((code - mean) ** 2 for code in codes) / (len(codes) - 1)) ** 0.5
            self.assertAlmostEqual(deviation, 8.0 / 5**0.5, delta=1.3)

    def test_a_joint_is_started_and_tracks_and_each_output_is_its_own_channels_command(self):
        chip, joint = self.starting()
        report = joint.keep(15.0, until=lambda report: report.state != STARTING)
        self.assertEqual((report.state, report.fault), (TRACKING, 0))
        joint.keep(0.5)
        errors, begin, differed = [], chip.now, 0
        for _ in range(150):
            wanted = 0.25 * math.sin(2 * math.pi * 0.4 * (chip.now - begin))
            report = joint.ask(aim(wanted))
            self.assertEqual(report.fault, 0)
            errors.append(joint.angle - wanted)
            # Until the next tick the outputs are those of the report.
            for channel, code in enumerate(report.dac_codes, 1):
                self.assertAlmostEqual(chip.board.output_v(channel), code * TO_3V3, delta=0.03)
            differed += abs(report.dac_codes[0] - report.dac_codes[1]) > 200
            chip.run(20 * TICK_S)
        rmse = (sum(error**2 for error in errors[25:]) / len(errors[25:])) ** 0.5
        self.assertLess(rmse, RMSE_RAD)
        self.assertLess(max(map(abs, errors[25:])), LARGEST_RAD)
        self.assertGreater(differed, 75)
        self.assertEqual(report.late_ticks, 0)
        self.assertTrue(joint.order("joint_stop"))
        chip.run(2 * TICK_S)
        self.assert_vented(chip)

    def test_on_the_internal_oscillator_it_is_told_and_no_tick_of_a_driven_joint_is_late(self):
        chip, joint = self.starting(rcc__hse_works=False)
        report = joint.keep(0.2)
        self.assertEqual((chip.core_hz, report.state, report.noted), (16e6, STARTING, 30))
        # Vented, a tick is late where the flash is changed.
        self.assertEqual(report.late_ticks, joint.reports[0].late_ticks)

    # Pressures from the host.

    def served(self):
        """A board in service without a joint, both muscles filled by different pressures."""
        chip, joint = self.begun()
        joint.step()
        for name in ("joint_arm", "joint_service"):
            self.assertTrue(joint.order(name), name)
        for _ in range(8):
            joint.ask(press(2.5, 1.5))
            chip.run(0.1)
        self.assertEqual(joint.ask(press(2.5, 1.5)).state, SERVICE)
        self.assert_driven(chip)
        return chip, joint

    def test_each_output_is_its_pressure_in_service_behind_two_steps_and_without_a_joint(self):
        chip, joint = self.begun()
        self.assertEqual(joint.link.ask("joint_press"), joint.link.response("joint_is_off"))
        self.assertEqual(joint.link.ask("joint_service"), joint.link.response("joint_not_armed"))
        chip.run(5 * TICK_S)
        self.assert_vented(chip)
        chip, joint = self.served()
        self.assertFalse(chip.board.is_dumping())
        self.assertEqual(joint.ask(press(2.5, 1.5)).dac_codes, [1024, 614])
        for channel, bar in enumerate((2.5, 1.5), 1):
            self.assertAlmostEqual(chip.board.output_bar(channel), bar, delta=0.03)
            self.assertAlmostEqual(joint.bar[channel - 1], bar, delta=0.1)
        # More than it may have changes nothing, nor does what has no place here.
        joint.link.ask("joint_press_too_much")
        for name in ("joint_aim", "joint_configure", "joint_start", "joint_arm"):
            self.assertEqual(joint.link.ask(name), joint.link.response("joint_in_service"), name)
        chip.run(3 * TICK_S)
        report = joint.ask(press(2.5, 1.5))
        self.assertEqual((report.dac_codes, report.fault, report.late_ticks), ([1024, 614], 0, 0))
        self.assertTrue(joint.order("joint_stop"))
        chip.run(12 * TICK_S)
        self.assert_vented(chip)
        self.assertEqual(joint.ask().state, OFF)
        self.assertTrue(chip.board.is_dumping())

    def test_half_a_second_without_pressures_vents_both_valves_in_service_whatever_else_is_asked(self):
        chip, joint = self.served()
        begin = chip.now
        while chip.now - begin < 0.7 and max(self.outputs(chip)) > VENTED_V:
            joint.ask()
            joint.link.ask("joint_aim")
            joint.link.ask("joint_press_too_much")
            chip.run(0.02)
        self.assertAlmostEqual(chip.now - begin, 0.5, delta=0.1)
        self.assert_vented(chip)
        self.assertEqual((joint.ask().state, joint.ask().fault), (FAULT, 21))

    def test_a_fault_of_one_channel_vents_both_valves_in_service(self):
        burst = (409.5 + 327.6 * 8.0) * TO_3V3
        cases = [
            (211, self.held(PRESSURES[1], burst), 1.2 * TICK_S),
            (102, self.held(PRESSURES[0], 0.0)),
            (301, self.held(ANGLE, 0.0)),
            (134, lambda chip, _: chip.dac.stuck.update({1: 2.9})),
            (5, lambda chip, _: chip.board.voltages.update({SUPPLY: 0.0})),
            (32, lambda chip, _: setattr(chip.board, "is_stop_closed", False)),
        ]
        self.each(cases, self.served(), ("joint_service", press(2.0, 2.0)))

    # What vents both.

    def each(self, cases, begun=None, again=("joint_start", aim(0.1))):
        """A case from the same beginning each: what is done to a chip that starts a joint, or one that is `begun`, and by
        which fault it vents."""
        chip, joint = begun or self.starting()
        self.assert_driven(chip)
        for fault, work, *most_s in cases:

            def tried(fault=fault, work=work, most_s=most_s):
                work(chip, joint)
                self.assert_vented_by(chip, joint, fault, *most_s)
                # Neither orders nor targets open a valve.
                joint.link.ask("joint_arm")
                start, goes_on = again
                self.assertNotEqual(joint.link.ask(start), joint.link.response("joint_accepted"))
                joint.link.exchange(goes_on)
                chip.run(3 * TICK_S)
                self.assert_vented(chip)

            with self.subTest(fault=fault):
                in_a_fork(tried)

    def held(self, channel, volts):
        """A sensor that shows this from now on."""

        def work(chip, joint):
            show = joint.show

            def shown():
                show()
                chip.board.voltages[channel] = volts

            joint.show = shown
            chip.board.voltages[channel] = volts

        return work

    def test_a_fault_of_one_channel_vents_both_valves_in_the_same_tick(self):
        burst = (409.5 + 327.6 * 8.0) * TO_3V3
        self.each(
            [
                (111, self.held(PRESSURES[0], burst), 1.2 * TICK_S),
                (211, self.held(PRESSURES[1], burst), 1.2 * TICK_S),
                (102, self.held(PRESSURES[0], 0.0)),
                (202, self.held(PRESSURES[1], 0.0)),
                (301, self.held(ANGLE, 0.0)),
                (134, lambda chip, _: chip.dac.stuck.update({1: 2.9})),
                (234, lambda chip, _: chip.dac.stuck.update({2: 2.9})),
            ]
        )

    def test_what_is_wrong_with_the_board_vents_both_valves(self):
        def supply_bar(bar):
            return lambda chip, _: chip.board.voltages.update({SUPPLY: (409.5 + 327.6 * bar) * TO_3V3})

        self.each(
            [
                (13, supply_bar(2.0), 0.2),
                (5, lambda chip, _: chip.board.voltages.update({SUPPLY: 0.0})),
                # Of the factory's two points 90 °C, and then the average.
                (31, lambda chip, _: chip.board.voltages.update({16: (959 + 248 * 65 / 80) * TO_3V3}), 0.3),
                (35, lambda chip, _: chip.board.voltages.update({17: 1650 * TO_3V3})),
                (1, lambda chip, _: setattr(chip.adc, "is_dead", True)),
                (1, lambda chip, _: setattr(chip.dma2, "is_dead", True)),
                (1, lambda chip, _: setattr(chip.adc, "is_injected_dead", True)),
                (32, lambda chip, _: setattr(chip.board, "is_stop_closed", False)),
            ]
        )

    def test_a_pin_that_something_else_drives_while_vented_is_a_fault_of_its_channel(self):
        for name, fault in (("foreign_v", 134), ("second_foreign_v", 234)):
            chip, joint = self.begun()
            setattr(chip.board, name, 0.1)
            chip.run(6 * TICK_S)
            self.assertEqual(joint.ask().fault, fault)

    def test_a_pressure_that_does_not_fall_behind_a_vented_valve_is_a_fault_of_its_channel(self):
        for channel, fault in zip(PRESSURES, (133, 233)):
            chip, joint = self.begun()
            for bar in (0.8, 1.6, 2.4, 3.0):
                chip.board.voltages[channel] = (409.5 + 327.6 * bar) * TO_3V3
                chip.run(2 * TICK_S)
            self.assertTrue(joint.order("joint_configure"))
            chip.run(0.35)
            report = joint.ask()
            self.assertEqual((report.state, report.fault), (FAULT, fault))
            self.assertTrue(chip.board.is_dumping())

    def test_a_silent_host_and_one_that_only_asks_vent_both_valves(self):
        chip, joint = self.starting()
        begin = chip.now
        while chip.now - begin < 0.7 and max(self.outputs(chip)) > VENTED_V:
            joint.ask()
            chip.run(0.02)
        self.assertAlmostEqual(chip.now - begin, 0.5, delta=0.1)
        self.assert_vented(chip)
        self.assertEqual(joint.ask().fault, 21)
        self.assertTrue(joint.order("joint_acknowledge"))
        self.assertEqual(joint.ask().state, READY)
        self.assert_vented(chip)

    def test_a_low_supply_vents_both_valves_at_once_at_any_moment_of_a_tick(self):
        chip, joint = self.starting()
        due = chip.systick.due
        for moment in range(MOMENTS):

            def tried(at=due + WHOLE_TICK_S * moment / MOMENTS):
                chip.run(at - chip.now)
                chip.set_supply(2.8)
                self.assertTrue(chip.run(until=lambda: max(self.outputs(chip)) < VENTED_V, most_s=20e-6))
                for _ in range(40):
                    chip.run(0.1 * TICK_S)
                    self.assert_vented(chip)
                chip.set_supply(3.3)
                report = joint.ask()
                self.assertEqual((report.state, report.fault), (FAULT, 24))

            in_a_fork(tried)

    # What ends the program.

    def assert_restarted_by(self, chip, joint, cause, fault):
        """At fault, with the joint that it has kept, which moves by itself neither then nor behind the acknowledgement."""
        self.assertTrue(chip.run(until=lambda: len(chip.resets) > 1, most_s=9.0), "no reset")
        self.assertEqual(chip.resets[-1][1], cause)
        for _ in range(50):
            self.assert_vented(chip)
            chip.run(10 * TICK_S)
        report = joint.ask()
        self.assertEqual((report.state, report.fault), (FAULT, fault))
        self.assertEqual(joint.link.ask("joint_configure"), joint.link.response("joint_at_fault"))
        self.assertTrue(joint.order("joint_acknowledge"))
        # On the internal oscillator a byte may be lost while the change of state is logged.
        for _ in range(30):
            chip.run(5 * TICK_S)
            self.assert_vented(chip)
        self.assertEqual(joint.ask().state, READY)

    def test_a_hang_is_ended_by_the_watchdog_within_100_ms_and_leaves_both_valves_vented(self):
        # With its oscillator at its slowest.
        chip, joint = self.starting(iwdg__lsi_hz=17e3)
        at = chip.now
        chip.halt(6.0)
        self.assertLess(chip.resets[-1][0] - at, 0.1)
        self.assert_restarted_by(chip, joint, "watchdog", 28)

    def test_a_link_that_hangs_vents_both_valves_before_the_watchdog_bites(self):
        chip, joint = self.starting()
        chip.nvic.enabled.discard(LINK_TASK)
        self.assertTrue(chip.run(until=lambda: max(self.outputs(chip)) < VENTED_V, most_s=0.4))
        self.assertEqual(len(chip.resets), 1)
        self.assert_restarted_by(chip, joint, "watchdog", 28)

    def test_an_unexpected_interrupt_and_a_lost_crystal_vent_both_valves_before_the_reset(self):
        def unexpected(chip):
            chip.nvic.enabled.add(60)
            chip.nvic.pending.add(60)

        for work, fault in ((unexpected, 26), (lambda chip: chip.rcc.lose_crystal(), 30)):
            chip, joint = self.starting()
            before, reset = [], chip.reset

            def seen(cause, chip=chip, before=before, reset=reset):
                before.append(max(self.outputs(chip)))
                reset(cause)

            chip.reset = seen
            work(chip)
            self.assert_restarted_by(chip, joint, "software", fault)
            self.assertLess(before[0], VENTED_V)

    # What the start finds.

    def test_a_damaged_image_or_memory_cannot_drive_either_valve(self):
        def image(chip):
            byte = chip.memory_read(PLACE_A + 0x60, 1)[0]
            chip.memory_write(PLACE_A + 0x60, bytes([byte ^ 0x10]))

        for damage, fault in ((image, 36), (lambda chip: chip.break_memory(0x2000_4000, 17), 37)):
            chip, joint = self.joint()
            damage(chip)
            self.start(chip)
            for name in ("joint_acknowledge", "joint_configure", "joint_arm", "joint_start"):
                self.assertFalse(joint.order(name))
            report = joint.ask()
            self.assertEqual((report.state, report.fault), (FAULT, fault))
            self.assertTrue(chip.dac.is_held() and chip.board.is_dumping())
            self.assert_vented(chip)

    def test_a_coil_that_is_held_is_fault_38_before_a_joint_is_taken(self):
        chip, joint = self.joint(board__is_pump_stuck=True)
        self.start(chip)
        chip.run(30 * TICK_S)
        self.assertEqual(joint.ask().fault, 38)

    def test_a_factory_value_makes_the_temperature(self):
        # A sensor 30 K off the typical one, at 60 °C, which without its factory values were 90 °C and a fault.
        chip, joint = self.joint()
        chip.memory_write(0x1FFF_7A2C, struct.pack("<HH", 866 + 186, 1114 + 186))
        chip.board.voltages[16] = (866 + 186 + 248 * 30 / 80) * TO_3V3
        self.start(chip)
        self.assertTrue(joint.order("joint_configure"))
        chip.run(0.3)
        self.assertEqual(joint.ask().fault, 0)
