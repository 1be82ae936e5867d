"""The chip at a serial port of this machine, for programs that know nothing of a model.

    MGPI_CHIP_IMAGE=… terminal.py bus|bring-up|joint

The board with its production image at its bus, or one with the bring-up image, or with that of two channels and a joint, at its
service link. Prints the path of the
terminal that a program opens once it listens, then runs until its standard input is closed, no faster than time passes.
"""

import os
import pty
import select
import sys
import time
import tty

from stm32f405 import Chip, bring_up, joint

# How long the chip runs between two looks at the port. Unit: s.
STEP_S = 1e-3


def powered(kind):
    """A chip that listens, and the port that is meant."""
    if kind == "joint":
        chip, plant = joint.joint_chip()
        bring_up.begin(chip)
        plant.step()
        return chip, chip.usart2
    is_new = kind == "bring-up"
    chip = bring_up.chip() if is_new else Chip()
    bring_up.begin(chip)
    return chip, chip.usart2 if is_new else chip.usart1


def main():
    chip, usart = powered(sys.argv[1])
    line = chip.board.line(usart)
    ours, theirs = pty.openpty()
    # It stays open here, lest the terminal is gone between two programs.
    tty.setraw(theirs)
    print(os.ttyname(theirs), flush=True)
    ahead = time.monotonic() - chip.now
    while True:
        # What the chip is ahead of the clock.
        left_s = max(0.0, ahead + chip.now - time.monotonic())
        readable, _, _ = select.select([ours, sys.stdin], [], [], left_s)
        if sys.stdin in readable:
            break
        if ours in readable:
            chip.board.send(usart, os.read(ours, 4096))
        chip.run(STEP_S)
        if line.sent:
            os.write(ours, bytes(byte for _, byte in line.sent))
            line.sent.clear()
    print(*chip.violations, sep="\n", flush=True)


if __name__ == "__main__":
    main()
