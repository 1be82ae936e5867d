//! The native model behind the functions of FMI 3.0 for co-simulation: the library in the units
//! that `mgpi export --fmu` writes.
//!
//! # Design
//! `instance` is a unit at work, in safe code. `abi` are FMI's functions, which check pointers
//! and modes, and turn errors into a status and a message; all `unsafe` code is there.
//!
//! # Time
//! Initialisation is the first sample. An input that is set before a step is held over it: the
//! output after the step is that of a sample with this input, a step later. So setting the input of
//! row k and stepping from row k - 1 to k gives row k of `mgpi simulate`, bit for bit.

mod abi;
mod instance;
