//! Identified models as source code for other people's programs: [`c`].

pub mod c;
