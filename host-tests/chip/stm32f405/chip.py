"""The chip: memory, processor, time, resets."""

import heapq
import itertools
import os
import struct

from elftools.elf.elffile import ELFFile
from unicorn import (
    UC_ARCH_ARM,
    UC_HOOK_INTR,
    UC_HOOK_MEM_INVALID,
    UC_HOOK_MEM_READ,
    UC_HOOK_MEM_WRITE,
    UC_MODE_MCLASS,
    UC_MODE_THUMB,
    Uc,
    UcError,
)
from unicorn import arm_const as arm

from .adc import Adc
from .blocks import Time, count_time
from .board import Board
from .core import FIRST_IRQ, HARD_FAULT, Dwt, Nvic, Scb, SysTick
from .dac import Dac
from .dbgmcu import Dbgmcu
from .dma import Dma2
from .exti import Exti
from .flash import START, Flash
from .gpio import GpioA, GpioB, GpioC
from .iwdg import Iwdg
from .pwr import Pwr
from .rcc import Rcc
from .registers import Registers
from .timers import Tim2, Tim3, Tim5, Tim11
from .usart import Usart1, Usart2

# Mean over straight code, branches and loads, from flash with its caches. A stated factor, not a measurement.
CYCLES_PER_INSTRUCTION = 1.3
# Cycles from an interrupt to its first instruction, and back.
ENTRY_CYCLES, RETURN_CYCLES = 12, 10
RAM, RAM_BYTES, CCM, FLASH_BYTES = 0x2000_0000, 0x20000, 0x1000_0000, 0x100000
SYSTEM = 0x1FFF_7000
# Factory values of the temperature's sensor at 30 and 110 °C, and of the reference, at 3.3 V.
TS_CAL1, TS_CAL2, VREFINT_CAL = 0x1FFF_7A2C, 0x1FFF_7A2E, 0x1FFF_7A2A
# The processor's number of 96 bits, lowest word first, and the area that is written once.
UNIQUE_ID, ONCE = 0x1FFF_7A10, 0x1FFF_7800
# Of the flash, in KB.
FLASH_SIZE = 0x1FFF_7A22
# What a handler returns to: thread or handler, main stack, frame with the floating point's registers.
EXIT_HANDLER, EXIT_THREAD = 0xFFFF_FFE1, 0xFFFF_FFE9
EXITS = [EXIT_HANDLER & ~1, EXIT_THREAD & ~1]
FRAME_WORDS = 26
# The bits of the program status that tell how much of an IT block is left.
IT_STATE = 0x0600_FC00
# Where the model's registers are, and how long each range is.
MAPPED = (0x4000_0000, 0x80000), (0xE000_1000, 0x1000), (0xE000_E000, 0x1000), (0xE004_2000, 0x1000)
MASKS = [getattr(arm, f"UC_ARM_REG_{name}") for name in ("PRIMASK", "BASEPRI", "FAULTMASK", "CONTROL")]
CORE = [
    arm.UC_ARM_REG_R0, arm.UC_ARM_REG_R1, arm.UC_ARM_REG_R2, arm.UC_ARM_REG_R3, arm.UC_ARM_REG_R12,
    arm.UC_ARM_REG_LR, arm.UC_ARM_REG_PC, arm.UC_ARM_REG_XPSR,
]
FLOATS = [getattr(arm, f"UC_ARM_REG_S{k}") for k in range(16)] + [arm.UC_ARM_REG_FPSCR]
# What Unicorn calls the return from a handler.
RETURNS = 8


class Chip:
    """A chip with an image in its flash, not yet powered."""

    # What the blocks of instructions change, and the model with them: moments in s, a rate in Hz; whether an exception may
    # be taken before the next block.
    now = property(lambda self: self._time.now, lambda self, value: setattr(self._time, "now", value))
    _next_at = property(lambda self: self._time.next_at, lambda self, value: setattr(self._time, "next_at", value))
    _stalled_until = property(
        lambda self: self._time.stalled_until, lambda self, value: setattr(self._time, "stalled_until", value)
    )
    cycles = property(lambda self: self._time.cycles, lambda self, value: setattr(self._time, "cycles", value))
    core_hz = property(lambda self: self._time.core_hz, lambda self, value: setattr(self._time, "core_hz", value))
    _looks = property(lambda self: self._time.looks, lambda self, value: setattr(self._time, "looks", value))

    def __init__(self, image=None):
        self.image = image or os.environ["MGPI_CHIP_IMAGE"]
        self.violations = []
        self.allowed = []
        self._time = Time(core_hz=16e6, next_at=float("inf"))
        self.supply_v = 3.3
        self.resets = []
        self._events, self._order = [], itertools.count()
        self._reset_wanted = None
        # Whether a peripheral may want another interrupt than when they were asked last.
        self.lines_have_changed = True
        self.is_halted = self._is_asleep = self._is_stopped = False
        # How often the processor has waited for an interrupt.
        self.sleeps = 0
        # What lay on the stack when an exception began, at the most. Unit: byte.
        self.below = {}
        self._make_processor()
        self._make_peripherals()

    # How it is made.

    def _make_processor(self):
        with open(self.image, "rb") as file:
            elf = ELFFile(file)
            symbols = elf.get_section_by_name(".symtab").iter_symbols()
            self.symbols = {symbol.name: symbol["st_value"] for symbol in symbols}
            segments = [(s["p_paddr"], s.data()) for s in elf.iter_segments() if s["p_type"] == "PT_LOAD"]
        self._image_end = max(a + len(d) for a, d in segments if START <= a < START + FLASH_BYTES)
        self.uc = uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
        uc.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M4)
        for address, size in ((START, FLASH_BYTES), (RAM, RAM_BYTES), (CCM, 0x10000), (SYSTEM, 0x1000)):
            uc.mem_map(address, size)
        uc.mem_write(START, b"\xff" * FLASH_BYTES)
        for address, data in segments:
            if data and START <= address < START + FLASH_BYTES:
                uc.mem_write(address, data)
        # Of a chip of the middle of the batch: 0.76 V at 25 °C, 2.5 mV/K.
        uc.mem_write(VREFINT_CAL, struct.pack("<HHH", 1501, 959, 1207))
        uc.mem_write(UNIQUE_ID, struct.pack("<III", 0x0039_0045, 0x3134_510E, 0x3238_3732))
        uc.mem_write(ONCE, b"\xff" * 0x210)
        uc.mem_write(FLASH_SIZE, struct.pack("<H", FLASH_BYTES >> 10))
        for base, size in MAPPED:
            uc.mmio_map(
                base, size,
                lambda _, offset, n, __, base=base: self._read(base + offset, n), None,
                lambda _, offset, n, value, __, base=base: self._write(base + offset, n, value), None,
            )
        count_time(uc, self._time, self._attend, self._measure)
        # What an exception saves; what it gives back, the program counter apart; where it is looked for.
        self._saved = Registers(uc, [*CORE, *FLOATS, arm.UC_ARM_REG_SP])
        self._restored = Registers(uc, [n for n in CORE + FLOATS if n != arm.UC_ARM_REG_PC] + [arm.UC_ARM_REG_SP])
        self._begun = Registers(uc, [arm.UC_ARM_REG_XPSR, arm.UC_ARM_REG_SP, arm.UC_ARM_REG_LR])
        self._masks = Registers(uc, MASKS[:3])
        uc.hook_add(UC_HOOK_INTR, self._unexpected)
        uc.hook_add(UC_HOOK_MEM_INVALID, lambda *_: False)
        uc.hook_add(
            UC_HOOK_MEM_WRITE,
            lambda _, __, address, size, value, ___: self.flash.store(
                address, size, value & (1 << 8 * size) - 1
            ),
            None, START, START + FLASH_BYTES - 1,
        )
        uc.ctl_exits_enabled(True)
        uc.ctl_set_exits(EXITS)

    def _make_peripherals(self):
        self.flash = Flash(self)
        self.rcc = Rcc(self)
        self.pwr, self.exti, self.dac, self.adc = Pwr(self), Exti(self), Dac(self), Adc(self)
        self.dma2 = Dma2(self)
        self.tim2, self.tim3, self.tim5, self.tim11 = Tim2(self), Tim3(self), Tim5(self), Tim11(self)
        self.iwdg, self.dbgmcu = Iwdg(self), Dbgmcu(self)
        self.gpio = {"A": GpioA(self), "B": GpioB(self), "C": GpioC(self)}
        self.usart1, self.usart2 = Usart1(self), Usart2(self)
        self.nvic, self.scb, self.systick, self.dwt = Nvic(self), Scb(self), SysTick(self), Dwt(self)
        self.timers = [self.tim2, self.tim3, self.tim5, self.tim11]
        self.sources = [self.usart1, self.usart2, self.exti, *self.timers]
        self.peripherals = [
            self.rcc, self.flash, self.pwr, self.exti, self.dac, self.adc, self.dma2, self.iwdg, self.dbgmcu,
            self.usart1, self.usart2, *self.timers, *self.gpio.values(), self.nvic, self.scb, self.systick, self.dwt,
        ]
        self._pages = {}
        for peripheral in self.peripherals:
            for page in range(peripheral.BASE >> 8, peripheral.BASE + peripheral.SIZE >> 8):
                self._pages[page] = peripheral
        self.board = Board(self)

    def image_end(self):
        """The address behind the image's last byte."""
        return self._image_end

    # What goes wrong.

    def violation(self, what):
        """Writes down what the manual forbids."""
        at = self.program_counter() if hasattr(self, "uc") else 0
        self.violations.append(f"{what} (at {at:#010x}, {self.now * 1e3:.3f} ms)")

    def program_counter(self):
        return self.uc.reg_read(arm.UC_ARM_REG_PC)

    def _unexpected(self, _, number, __):
        if number != RETURNS:
            self.violation(f"the processor takes exception {number} of its own")
        self.uc.emu_stop()

    # Memory.

    def memory_read(self, address, size):
        return bytes(self.uc.mem_read(address, size))

    def memory_write(self, address, data):
        self.uc.mem_write(address, data)

    def break_memory(self, address, bit):
        """A cell of the RAM is 0 for ever."""

        def read(uc, _, at, size, *__):
            if at <= address + bit // 8 < at + size:
                byte = address + bit // 8
                uc.mem_write(byte, bytes([uc.mem_read(byte, 1)[0] & ~(1 << bit % 8)]))

        self.uc.hook_add(UC_HOOK_MEM_READ, read, None, address & ~3, (address & ~3) + 3)

    def _read(self, address, size):
        peripheral = self._pages.get(address >> 8)
        if peripheral is None:
            self.violation(f"read of {address:#010x}, where the model has nothing")
            return 0
        self.flash.settle()
        return peripheral.read(address - peripheral.BASE, size)

    def _write(self, address, size, value):
        peripheral = self._pages.get(address >> 8)
        if peripheral is None:
            self.violation(f"write of {address:#010x}, where the model has nothing")
            return
        self.flash.settle()
        peripheral.write(address - peripheral.BASE, size, value)
        self._looks = True

    # Time.

    def at(self, moment, work):
        """Does something at a moment. Unit: s."""
        heapq.heappush(self._events, (moment, next(self._order), work))
        self._next_at = self._events[0][0]

    def after(self, seconds, work):
        """Does something some time from now."""
        self.at(self.now + seconds, work)

    def stall_until(self, moment):
        """The processor waits for the flash."""
        self._stalled_until = max(self._stalled_until, moment)

    def set_core_hz(self, hz):
        """The core's clock has changed."""
        old, self.core_hz = self.core_hz, hz
        if old != hz and hasattr(self, "systick"):
            self.systick.replan(old)
            for timer in self.timers:
                timer.replan()

    def _do_events(self):
        """Each at its own moment: while the processor waits for the flash the peripherals go on."""
        events, time = self._events, self._time
        now = time.now
        if not events or events[0][0] > now:
            return
        while events and events[0][0] <= now:
            time.now, _, work = heapq.heappop(events)
            work()
        time.now = now
        time.next_at = events[0][0] if events else float("inf")

    def _measure(self, address, size):
        """Cycles of a block, and whether an exception that waits may be taken behind it."""
        code, at, count = self.memory_read(address, size), 0, 0
        unmasks = False
        while at < size:
            first = code[at] | code[at + 1] << 8
            # cpsie, and msr to a special register.
            unmasks |= first & 0xFFF0 == 0xB660 or first & 0xFFE0 == 0xF380
            at += 4 if first >> 11 in (0b11101, 0b11110, 0b11111) else 2
            count += 1
        return max(count, 1) * CYCLES_PER_INSTRUCTION, unmasks

    def _attend(self):
        """Stops the emulation before a block, where something else comes first; whether it does."""
        is_stalled = self._stalled_until > self.now
        if is_stalled or self._next_at <= self.now or self._looks and self._taken() is not None:
            self._is_stopped = True
            self.uc.emu_stop()
            return True
        return False

    def _spend(self, cycles):
        self.cycles += cycles
        self.now += cycles / self.core_hz

    # Exceptions.

    def _taken(self):
        """The exception that is taken now, if any."""
        self._looks = False
        self.nvic.gather()
        number = self.nvic.next()
        if number is None:
            return None
        priority = self.nvic.priority_of(number)
        if priority >= self.nvic.level():
            return None
        primask, base, faultmask = self._masks.read()
        is_masked = priority >= 0 and primask & 1 or priority >= -1 and faultmask & 1 or 0 < base <= priority
        return None if is_masked else number

    def _enter(self, number):
        """An exception begins: the frame goes to the stack, the processor to the vector."""
        *values, stack = self._saved.read()
        values[6] = self._pc & ~1
        used = struct.unpack("<I", self.memory_read(self.scb["VTOR"], 4))[0] - stack
        self.below[number] = max(used, self.below.get(number, 0))
        is_odd = stack >> 2 & 1
        stack = (stack & ~7) - 4 * FRAME_WORDS
        if not RAM <= stack:
            self.violation(f"the stack overflows at {stack:#010x}")
            number, stack = HARD_FAULT, RAM
        values[7] |= is_odd << 9
        self.memory_write(stack, struct.pack("<25I4x", *values))
        # The frame keeps the state of an IT block that is interrupted; the handler begins outside of one.
        self._begun.write([values[7] & ~IT_STATE, stack, EXIT_HANDLER if self.nvic.active else EXIT_THREAD])
        self.nvic.take(number)
        self._pc = struct.unpack("<I", self.memory_read(self.scb["VTOR"] + 4 * number, 4))[0]
        self._spend(ENTRY_CYCLES)

    def _leave(self):
        """A handler returns."""
        stack = self.uc.reg_read(arm.UC_ARM_REG_SP)
        values = struct.unpack("<25I4x", self.memory_read(stack, 4 * FRAME_WORDS))
        status = values[7]
        stack += 4 * FRAME_WORDS + 4 * (status >> 9 & 1)
        self._restored.write([*values[:6], status & ~(1 << 9), *values[8:], stack])
        self.nvic.active.pop()
        self.lines_have_changed = True
        self._looks = True
        self._pc = values[6] | 1
        self._spend(RETURN_CYCLES)

    # Running.

    def power_on(self):
        """Power comes on: RAM holds noise, flags tell why."""
        self.flash.cut(seed=len(self.resets))
        self.uc.mem_write(RAM, b"\xa5\x5a\xc3\x3c" * (RAM_BYTES // 4))
        self.rcc.power_off()
        self.dbgmcu.power_on()
        self._reset("power")

    def reset(self, cause):
        """A reset, as soon as the processor is between two instructions."""
        self._reset_wanted = self._reset_wanted or cause
        self._next_at = self.now

    def _reset(self, cause):
        self.resets.append((self.now, cause))
        self._reset_wanted = None
        self._is_asleep = False
        self._stalled_until = self.now
        self.core_hz = 16e6
        self.rcc.has_been_reset(cause)
        for peripheral in self.peripherals:
            peripheral.reset()
        self.set_core_hz(self.rcc.core_hz())
        self._next_at = self._events[0][0] if self._events else float("inf")
        if self.flash.has_changed:
            # What was translated of other contents.
            self.uc.ctl_flush_tb()
            self.flash.has_changed = False
        stack, self._pc = struct.unpack("<II", self.memory_read(START, 8))
        for register in MASKS:
            self.uc.reg_write(register, 0)
        self.uc.reg_write(arm.UC_ARM_REG_XPSR, 1 << 24)
        self.uc.reg_write(arm.UC_ARM_REG_SP, stack)
        self.uc.reg_write(arm.UC_ARM_REG_LR, 0xFFFF_FFFF)

    def set_supply(self, volts):
        """Changes the supply; the brown-out reset holds the chip below its level."""
        self.supply_v = volts
        level = self.flash.option_bytes >> 2 & 3
        falling = {0: 2.83, 1: 2.53, 2: 2.25, 3: 1.68}[level]
        if volts < falling:
            self.reset("power" if level == 3 else "brown-out")
        self.pwr.watch()

    def halt(self, seconds):
        """A debugger halts the core for a time; a reset lets it go on."""
        self.is_halted = True
        resets = len(self.resets)
        for part in (self.systick, self.iwdg):
            part.halt(True)
        end = self.now + seconds
        while self._events and self._events[0][0] <= end and not self._reset_wanted:
            self.now = max(self.now, self._events[0][0])
            self._do_events()
        self.is_halted = False
        if self._reset_wanted:
            self._reset(self._reset_wanted)
        elif len(self.resets) == resets:
            self.now = max(self.now, end)
            for part in (self.systick, self.iwdg):
                part.halt(False)

    def run(self, seconds=None, until=None, most_s=10.0):
        """Runs for a time, or until something is so; whether it is."""
        end = self.now + (seconds if seconds is not None else most_s)
        is_over = [False]

        def stop():
            is_over[0] = True

        self.at(end, stop)
        while True:
            self._do_events()
            if until is not None and until():
                return True
            if is_over[0]:
                return until is None
            self._step()

    def _step(self):
        """Until the next event, exception or reset."""
        if self._reset_wanted:
            self._reset(self._reset_wanted)
        if self._stalled_until > self.now:
            self._wait_for_flash()
            return
        if self._is_asleep:
            self._sleep()
            return
        number = self._taken()
        if number is not None:
            self._enter(number)
        self._is_stopped = False
        try:
            self.uc.emu_start(self._pc | 1, 0)
        except UcError as error:
            self._fault(error)
            return
        pc = self.program_counter()
        if pc & ~1 in EXITS:
            self._leave()
            return
        self._pc = pc | 1
        self._is_asleep = not self._is_stopped

    def _wait_for_flash(self):
        """The processor stands still until the next event; all else goes on."""
        self.now = max(self.now, min(self._next_at, self._stalled_until))
        self._do_events()
        if self._stalled_until <= self.now:
            self.flash.settle()

    def _sleep(self):
        """The processor waits for an interrupt until the next event."""
        self.sleeps += 1
        self.nvic.gather()
        self._is_asleep = self.nvic.next() is None and not self._reset_wanted
        if self._is_asleep:
            self.now = max(self.now, self._next_at)

    def _fault(self, error):
        if self._reset_wanted:
            return
        self.violation(f"the processor faults: {error}")
        self._pc = self.program_counter() | 1
        self.scb["CFSR"] |= 1 << 15
        self._enter(HARD_FAULT)
