"""A model of the STM32F405, as far as the production image uses it.

The processor is Unicorn's Cortex-M4; each peripheral is a file, strict as the reference manual (RM0090) is:
what the manual forbids is written down in `Chip.violations` and fails the test that it happens in. Time is
that of instructions times `chip.CYCLES_PER_INSTRUCTION`, and of the peripherals' own clocks.

# Limits
The model holds the image against the manual as it was read here, not against silicon. Instructions take the
same time each; wait states, caches, DMA and the bus matrix are not modelled.
"""

from .chip import Chip

__all__ = ["Chip"]
