"""What vents at any moment of a tick vents at once, and that tick's write of the valve does not undo it."""

from unicorn import UC_HOOK_BLOCK

from stm32f405.case import VENTED_V, ChipCase
from stm32f405.dac import EN1
from stm32f405.fork import in_a_fork

# A tick, whose longest is below 10 µs here, and what comes behind it. Unit: s.
TICK_S = 20e-6
# An interrupt above all others: its entry, some ten instructions, and the block that it waits for. Unit: core clock cycle.
AT_ONCE_CYCLES = 168
# The tick's way to the valve alone has more blocks of instructions.
LEAST_BLOCKS = 40


def beginnings(chip, end):
    """When the blocks of instructions begin until then: the model takes an interrupt between two of them."""
    moments = []
    chip.uc.hook_add(UC_HOOK_BLOCK, lambda *_: moments.append(chip.now))
    # What was translated before knows of one hook only.
    chip.uc.ctl_flush_tb()
    chip.run(end - chip.now)
    return moments


def vented(chip, at, how):
    """What is wrong with a chip that something vents at a moment."""
    said, vented_at = [], []
    write = chip.dac.write

    def watched(*what):
        write(*what)
        if not chip.dac.bit("CR", EN1):
            vented_at.append(chip.now)
        elif vented_at:
            said.append(f"driven again {(chip.now - vented_at[0]) * 1e6:.2f} µs after it was vented")

    chip.dac.write = watched
    chip.at(at, how)
    chip.run(2e-3)
    if not vented_at or (vented_at[0] - at) * chip.core_hz > AT_ONCE_CYCLES:
        said.append("not vented at once")
    if chip.board.output_v() >= VENTED_V:
        said.append("driven in the end")
    return said + chip.violations


class Moments(ChipCase):
    def assert_vented(self, how):
        """By something that is done to a chip."""
        chip, _ = self.driven()
        due = chip.systick.due
        chip.run(due - chip.now)
        moments = in_a_fork(lambda: beginnings(chip, due + TICK_S))
        self.assertGreater(len(moments), LEAST_BLOCKS)
        for at in moments:
            said = in_a_fork(lambda at=at: vented(chip, at, lambda: how(chip)))
            self.assertEqual(said, [], f"{(at - due) * 1e6:.3f} µs behind the beginning of the tick")

    def test_a_low_supply(self):
        self.assert_vented(lambda chip: chip.set_supply(2.8))

    def test_a_crystal_that_stops(self):
        self.assert_vented(lambda chip: chip.rcc.lose_crystal())

    def test_an_interrupt_that_nobody_expects(self):
        def unexpected(chip):
            chip.nvic.enabled.add(60)
            chip.nvic.pending.add(60)

        self.assert_vented(unexpected)
