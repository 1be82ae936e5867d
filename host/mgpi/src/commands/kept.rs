//! What a recording leaves that is interrupted.

use board_client::growing::Growing;

/// Leaves what was recorded, if anything was, and says where.
pub fn keep(growing: Growing) {
    if let Some(part) = growing.abandon() {
        eprintln!("what was recorded is kept in {}; --resume continues it", part.display());
    }
}
