//! A board on the bus: its registers over a serial port, and what they are for.
//!
//! | file | what it does |
//! |---|---|
//! | [`port`] | the serial port by its name |
//! | [`client`] | registers read and written, lost answers asked for again |
//! | [`board`] | a board that is the right one, its state and orders |
//! | [`status`] | all that it says of itself |
//! | [`about`] | which board it is, and what its firmware was built from |
//! | [`calibration`] | sensors and regulator against a gauge |
//! | [`reached`] | number, rate and parity that it keeps |
//! | [`scan`] | which boards are on a line; all of them vented |
//! | [`settings`] | gains and limits of a new configuration: which stay, which change |
//! | [`upload`] | a configuration to the board, and back |
//! | [`play`] | set points streamed ahead, ticks recorded, to the end or a stop |
//! | [`recording`] | the rows of a recording, and where it goes on after an interruption |
//! | [`excitation`] | what is played where nobody says what |
//! | [`error`] | why not |
//!
//! The registers themselves are those of [`wire::registers`].

pub mod about;
pub mod adapted;
pub mod board;
pub mod calibration;
pub mod client;
pub mod error;
pub mod excitation;
pub mod play;
pub mod port;
pub mod reached;
pub mod recording;
pub mod scan;
pub mod settings;
pub mod status;
pub mod upload;

pub use board::Board;
pub use error::BoardError;
