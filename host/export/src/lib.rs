//! Identified models for other people's programs: source code of C ([`c`]), units of FMI ([`fmu`]).

pub mod c;
pub mod fmu;
pub mod name;
