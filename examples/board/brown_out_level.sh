#!/bin/sh
# Sets the brown-out reset of an STM32F405 to level 3, 2.7 V, by its option bytes (RM0090, 3.9: BOR_LEV = 0 in FLASH_OPTCR), and reads it
# back behind a reset. Once a board, its valve without pressure. Needs OpenOCD 0.12 and an ST-Link; another probe by
# INTERFACE=interface/cmsis-dap.cfg.
#
# All other option bytes stay as they are. A chip that is protected from reading is left alone: removing that would erase it.
set -eu
openocd -f "${INTERFACE:-interface/stlink.cfg}" -f target/stm32f4x.cfg -c '
    proc option_bytes {} { return [read_memory 0x40023C14 32 1] }
    proc level {} { return [expr {([option_bytes] >> 2) & 3}] }
    init
    reset halt
    if {([option_bytes] >> 8 & 0xFF) != 0xAA} {
        echo "error: the chip is protected from reading; nothing was changed"
        shutdown error
    }
    if {[level] != 0} {
        mww 0x40023C08 0x08192A3B
        mww 0x40023C08 0x4C5D6E7F
        set wanted [expr {[option_bytes] & 0x0FFFFFF0}]
        mww 0x40023C14 $wanted
        mww 0x40023C14 [expr {$wanted | 2}]
        for {set polls 0} {([read_memory 0x40023C0C 32 1] >> 16 & 1) && $polls < 100} {incr polls} { sleep 10 }
        mww 0x40023C14 [expr {$wanted | 1}]
        reset halt
    }
    if {[level] != 0} {
        echo "error: BOR_LEV is [level], wanted 0"
        shutdown error
    }
    echo "the brown-out reset is at level 3 (BOR_LEV = 0)"
    reset run
    shutdown
'
