//! A plugin for QEMU's ARM emulator that counts the instructions of chosen functions of a Cortex-M
//! image.
//!
//! # Design
//! | module | what it does |
//! |---|---|
//! | [`thumb`] | which instructions call, which return |
//! | [`counter`] | from the instructions, one after the other, to calls of functions and what each has cost |
//! | [`arguments`] | what the plugin is started with |
//! | `qemu` | QEMU's plugin interface: the only `unsafe` code |
//!
//! The plugin sees every instruction just before it is executed, but no registers. So it keeps a
//! call stack of its own: calls and returns are told by their encoding, exceptions by the entry
//! addresses of their handlers.
//!
//! # Use
//! `qemu-system-arm … -plugin
//! libinstruction_counter.so,out=FILE,handler=ADDRESS,…,fn=NAME:ADDRESS,…,way=NAME:NAME,…`
//!
//! At the orderly end of the emulator (SIGTERM is one) FILE gets a line a function: its name, then
//! calls, fewest instructions of a call, most, their sum, and the number of the first call with the
//! most, counted from 0. A way from one function to another that it calls gets a line too, named
//! `to_` and the other: up to that one's first return. A line `lost` followed by a text, instead,
//! says that the call stack was lost and the figures are void.
//!
//! # Contract
//! A call counts from the function's first instruction to its return, with what it calls, also by
//! tail calls; without the exceptions that interrupt it. An instruction skipped inside an IT block
//! counts: it takes its cycle too. The same image with the same input gives the same figures.
//!
//! # Limits
//! Version 1 of the plugin interface: QEMU up to 8.2. One processor. Code that returns otherwise
//! than the compiler does (`bx lr`, or a load of the program counter from the stack) loses the call
//! stack.

pub mod arguments;
pub mod counter;
// A test program has no QEMU around it whose functions it could be linked with.
#[cfg(not(test))]
mod qemu;
pub mod thumb;
