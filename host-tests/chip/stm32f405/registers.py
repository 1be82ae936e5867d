"""Registers of the processor, several at once, without the layers of Unicorn's Python binding.

An exception reads and writes 25 of them at its begin and at its end: one by one that takes longer than what the processor
does between. What is called here is that of the release which `requirements.txt` pins.
"""

import ctypes

from unicorn.unicorn_py3.unicorn import uclib


class Registers:
    """Registers of the processor that are read and written together."""

    def __init__(self, uc, numbers):
        self._uc, self._count = uc, ctypes.c_int(len(numbers))
        self._numbers = (ctypes.c_int * len(numbers))(*numbers)
        self._values = (ctypes.c_uint64 * len(numbers))()
        size, first = ctypes.sizeof(ctypes.c_uint64), ctypes.addressof(self._values)
        self._places = (ctypes.c_void_p * len(numbers))(*(first + size * k for k in range(len(numbers))))

    def read(self):
        """Their values."""
        ctypes.memset(self._values, 0, ctypes.sizeof(self._values))
        uclib.uc_reg_read_batch(self._uc._uch, self._numbers, self._places, self._count)
        return self._values[:]

    def write(self, values):
        """Sets them all."""
        self._values[:] = values
        uclib.uc_reg_write_batch(self._uc._uch, self._numbers, self._places, self._count)

