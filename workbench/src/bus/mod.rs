//! A board on the bus: its registers over a serial port, and what they are for.
//!
//! | file | what it does |
//! |---|---|
//! | [`port`] | the serial port by its name |
//! | [`client`] | registers read and written, lost answers asked for again |

pub mod client;
pub mod port;
