"""Lists the tests, a name a line, as `python -m unittest NAME` takes it."""

import unittest


def names(suite):
    for test in suite:
        if isinstance(test, unittest.TestSuite):
            yield from names(test)
        else:
            yield test.id()


for name in names(unittest.defaultTestLoader.discover(".")):
    print(name)
