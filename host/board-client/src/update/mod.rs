//! A new image to a board: the file that it comes in, and the way over the bus.
//!
//! The board looks at everything itself, and signature and checksum only the board: what is looked
//! at here spares the minute that a transfer takes.

mod package;
mod transfer;

pub use package::{Package, PackageError};
pub use transfer::{Step, UpdateError, restart, send, watch};
