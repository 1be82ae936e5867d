//! The test of the RAM, before anything stands in it: the algorithm MATS+ (write 0; read 0, write
//! 1, upwards; read 1, write 0, downwards), which finds each bit that is stuck, and addresses that
//! meet. Its 0 is [`FILL`], so that bits that hold each other are found too; that is what the stack
//! is then filled with.
//!
//! The record of the last fault stays as it is, its checksum tells of it; so do the two words
//! behind it, by which the program is told.
//!
//! # Timing
//! 128 KB in some 45 ms at 16 MHz.

use core::arch::naked_asm;

/// A pattern in which neighbours differ.
const FILL: u32 = 0xA5A5_A5A5;

unsafe extern "C" {
    /// Result of the test, placed by memory.x: an address within 16 bytes of a word that does not
    /// keep what is written to it, or 0 if all words do; then the complement of that.
    static _memory_test: [u32; 2];
}

/// Whether each word has kept what was written to it.
pub fn has_passed() -> bool {
    // SAFETY: the two words are there for this alone; written before the program began.
    unsafe { (&raw const _memory_test).read_volatile() == [0, !0] }
}

/// To be called by cortex-m-rt before the variables have their values: [`crate::test_memory`] does
/// that for an image. It uses no memory, and leaves it
/// filled.
///
/// # Safety
/// To be called by the start-up code only.
#[unsafe(naked)]
pub unsafe extern "C" fn test() {
    naked_asm!(
        "ldr r0, =_stack_end",
        "ldr r1, =_memory_test_end",
        "ldr r2, ={fill}",
        "mvn r3, r2",
        "mov r12, #0",
        // Write 0.
        "mov r4, r0",
        "1:",
        "str r2, [r4], #4",
        "str r2, [r4], #4",
        "str r2, [r4], #4",
        "str r2, [r4], #4",
        "str r2, [r4], #4",
        "str r2, [r4], #4",
        "str r2, [r4], #4",
        "str r2, [r4], #4",
        "cmp r4, r1",
        "blo 1b",
        // Read 0, write 1, upwards. What differs is gathered in r6.
        "mov r4, r0",
        "2:",
        "movs r6, #0",
        "ldr r5, [r4]",
        "eor r5, r5, r2",
        "orr r6, r6, r5",
        "str r3, [r4], #4",
        "ldr r5, [r4]",
        "eor r5, r5, r2",
        "orr r6, r6, r5",
        "str r3, [r4], #4",
        "ldr r5, [r4]",
        "eor r5, r5, r2",
        "orr r6, r6, r5",
        "str r3, [r4], #4",
        "ldr r5, [r4]",
        "eor r5, r5, r2",
        "orr r6, r6, r5",
        "str r3, [r4], #4",
        "cmp r6, #0",
        "it ne",
        "movne r12, r4",
        "cmp r4, r1",
        "blo 2b",
        // Read 1, write 0, downwards.
        "mov r4, r1",
        "3:",
        "movs r6, #0",
        "ldr r5, [r4, #-4]!",
        "eor r5, r5, r3",
        "orr r6, r6, r5",
        "str r2, [r4]",
        "ldr r5, [r4, #-4]!",
        "eor r5, r5, r3",
        "orr r6, r6, r5",
        "str r2, [r4]",
        "ldr r5, [r4, #-4]!",
        "eor r5, r5, r3",
        "orr r6, r6, r5",
        "str r2, [r4]",
        "ldr r5, [r4, #-4]!",
        "eor r5, r5, r3",
        "orr r6, r6, r5",
        "str r2, [r4]",
        "cmp r6, #0",
        "it ne",
        "movne r12, r4",
        "cmp r4, r0",
        "bhi 3b",
        // Read 0.
        "4:",
        "movs r6, #0",
        "ldr r5, [r4], #4",
        "eor r5, r5, r2",
        "orr r6, r6, r5",
        "ldr r5, [r4], #4",
        "eor r5, r5, r2",
        "orr r6, r6, r5",
        "ldr r5, [r4], #4",
        "eor r5, r5, r2",
        "orr r6, r6, r5",
        "ldr r5, [r4], #4",
        "eor r5, r5, r2",
        "orr r6, r6, r5",
        "cmp r6, #0",
        "it ne",
        "movne r12, r4",
        "cmp r4, r1",
        "blo 4b",
        // What was found, and its complement.
        "ldr r4, =_memory_test",
        "mvn r5, r12",
        "str r12, [r4]",
        "str r5, [r4, #4]",
        "bx lr",
        fill = const FILL,
    )
}

/// Makes an image test the memory before it begins.
#[macro_export]
macro_rules! test_memory {
    () => {
        /// Before the variables have their values.
        ///
        /// # Safety
        /// Called by cortex-m-rt only.
        #[unsafe(naked)]
        #[unsafe(export_name = "__pre_init")]
        unsafe extern "C" fn pre_init() {
            core::arch::naked_asm!("b {test}", test = sym $crate::stm32f405::memory_test::test)
        }
    };
}
