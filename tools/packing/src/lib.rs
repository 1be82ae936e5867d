//! Images of the board as they are flashed and sent.
//!
//! | module | what it does |
//! |---|---|
//! | [`seal`](mod@seal) | puts length and checksum into an image's ELF file, and the starter before it |
//! | [`sign`](mod@sign) | keys, signatures, and the package of both images for `mgpi update` |

pub mod seal;
pub mod sign;

pub use seal::{flat, seal};
pub use sign::{linked, new_key, package, read_key, small};
