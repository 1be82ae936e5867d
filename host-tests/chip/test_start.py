"""What interrupts find on the stack."""

from stm32f405.case import ChipCase
from stm32f405.host import BYTE_S

USART1 = 16 + 37
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
        self.assertIn(USART1, chip.below)
        self.assertLess(chip.below[USART1], IDLE_BYTES)
