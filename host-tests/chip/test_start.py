"""What interrupts find on the stack."""

from stm32f405.case import BUS_TASK, ChipCase
from stm32f405.core import FIRST_IRQ
from stm32f405.host import BYTE_S

# What the idle task and its locks need. Unit: byte.
IDLE_BYTES = 512


class Start(ChipCase):
    def test_the_ports_wait_until_the_start_has_given_its_stack_back(self):
        chip = self.chip()

        def talk():
            chip.board.send(chip.usart1, bytes(1))
            chip.after(BYTE_S, talk)

        chip.after(0.0, talk)
        self.start(chip)
        self.assertIn(FIRST_IRQ + BUS_TASK, chip.below)
        self.assertLess(chip.below[FIRST_IRQ + BUS_TASK], IDLE_BYTES)
