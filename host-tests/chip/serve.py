"""Runs the tests that are named on its standard input, a line each, and answers each by a line of JSON: `ok` and `said`.

A start, and a board that is driven, take longer than most of the tests. So they are done once, here, and each test runs in a
process that is forked from this one: it finds the chip as it is, and what it does to it is gone with it.
"""

import io
import json
import os
import sys
import unittest

from stm32f405 import case


def ready():
    """What tests begin with: made here, for them to find."""
    from test_joint import JointCase
    from test_link import LinkAndBus

    made = {}
    for kind, how in ((case.ChipCase, "started"), (case.ChipCase, "driven"), (LinkAndBus, "tracking"), (JointCase, "starting")):
        test = kind()
        try:
            test.setUp()
            made[getattr(kind, how).__qualname__] = getattr(test, how)()
        except Exception:
            # A test that needs it will fail, or be skipped where its image was not built, and say why.
            pass
    case.READY.update(made)


def run(name):
    """Whether a test passes, and what it says, from a process of its own."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        said = io.StringIO()
        try:
            suite = unittest.defaultTestLoader.loadTestsFromName(name)
            is_ok = unittest.TextTestRunner(stream=said, verbosity=0).run(suite).wasSuccessful()
        except BaseException as error:
            is_ok = False
            said.write(repr(error))
        with os.fdopen(writing, "w") as pipe:
            pipe.write(said.getvalue())
        os._exit(0 if is_ok else 1)
    os.close(writing)
    with os.fdopen(reading) as pipe:
        said = pipe.read()
    return os.waitpid(child, 0)[1] == 0, said


def main():
    ready()
    for line in sys.stdin:
        is_ok, said = run(line.strip())
        print(json.dumps({"ok": is_ok, "said": said}), flush=True)


if __name__ == "__main__":
    main()
