"""`blocks.c`, built beside the Python that runs it, and what it shares with the model."""

import ctypes
import hashlib
import os
import pathlib
import subprocess
import sys
import tempfile

from unicorn import UC_HOOK_BLOCK
from unicorn.unicorn_py3.unicorn import uclib

SOURCE = pathlib.Path(__file__).with_suffix(".c")
SLOTS = 65536
ATTEND = ctypes.CFUNCTYPE(ctypes.c_int32)
MEASURE = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_uint64, ctypes.c_uint32, ctypes.POINTER(ctypes.c_double))


class Block(ctypes.Structure):
    _fields_ = [("key", ctypes.c_uint64), ("cycles", ctypes.c_double), ("unmasks", ctypes.c_int32)]


class Time(ctypes.Structure):
    """As in `blocks.c`."""

    _fields_ = [
        ("now", ctypes.c_double), ("next_at", ctypes.c_double), ("stalled_until", ctypes.c_double),
        ("cycles", ctypes.c_double), ("core_hz", ctypes.c_double), ("looks", ctypes.c_int32),
        ("attend", ATTEND), ("measure", MEASURE), ("blocks", Block * SLOTS),
    ]


def _built():
    """The library; the compiler is that which Rust links by."""
    text = SOURCE.read_bytes()
    place = pathlib.Path(sys.prefix) / f"blocks-{hashlib.sha256(text).hexdigest()[:16]}.so"
    if not place.exists():
        # Under a name of its own first: other processes may build it at the same time.
        handle, name = tempfile.mkstemp(suffix=".so", dir=place.parent)
        os.close(handle)
        subprocess.run(
            ["cc", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-o", name, str(SOURCE)],
            check=True,
        )
        os.replace(name, place)
    library = ctypes.CDLL(str(place))
    library.time_bytes.restype = ctypes.c_size_t
    assert library.time_bytes() == ctypes.sizeof(Time), "blocks.c has other structures"
    return library


_library = _built()


def count_time(uc, time, attend, measure):
    """Lets the time pass block by block. `attend()`: stops the emulation where it has to, and says so; `measure(address,
    size)`: cycles of a block, and whether it unmasks exceptions. What they raise ends the emulation."""

    def guarded(work, *arguments):
        try:
            return work(*arguments)
        except BaseException as error:
            uc._hook_exception = uc._hook_exception or error
            uc.emu_stop()
            return None

    def measured(address, size, cycles):
        cycles[0], unmasks = guarded(measure, address, size) or (1.0, False)
        return unmasks

    time.attend = ATTEND(lambda: 1 if guarded(attend) is not False else 0)
    time.measure = MEASURE(measured)
    hook = ctypes.c_size_t()
    status = uclib.uc_hook_add(
        uc._uch, ctypes.byref(hook), UC_HOOK_BLOCK, ctypes.cast(_library.on_block, ctypes.c_void_p), ctypes.byref(time),
        ctypes.c_uint64(1), ctypes.c_uint64(0),
    )
    if status:
        raise RuntimeError(f"Unicorn takes no hook of blocks: {status}")
