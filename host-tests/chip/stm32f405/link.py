"""The host at the service link: requests and responses as frames, made by the program that runs the tests."""

import os


def _frames():
    """Name and bytes; a frame a line, as hexadecimal digits."""
    with open(os.environ["MGPI_CHIP_FRAMES"], encoding="ascii") as file:
        return {name: bytes.fromhex(digits) for name, digits in (line.split() for line in file)}


class Link:
    """Asks by whole frames."""

    def __init__(self, chip):
        self.chip, self.line = chip, chip.board.link
        self.frames, self.first = _frames(), None

    def response(self, name):
        """The frame of a response."""
        return self.frames[name]

    def is_hello(self, answer):
        """Whether it is what the board says who it is: a long frame, which differs from the first one in what time changes."""
        self.first = self.first or answer
        return len(answer) > 40 and abs(len(answer) - len(self.first)) < 8 and answer[:24] == self.first[:24]

    def received(self):
        """What the board has sent."""
        return bytes(byte for _, byte in self.line.sent)

    def send(self, name):
        """Sends a request; returns when its last byte is there."""
        return self.chip.board.send(self.chip.usart2, self.frames[name])

    def ask(self, name, **how):
        """Sends a request and returns the response, framed."""
        return self.exchange(self.frames[name], **how)

    def exchange(self, frame, timeout_s=1.0):
        self.line.sent.clear()
        end = self.chip.board.send(self.chip.usart2, frame)
        self.chip.run(end - self.chip.now)
        self.chip.run(until=lambda: self.line.sent and self.line.sent[-1][1] == 0, most_s=timeout_s)
        return self.received()
