//! A row that is scored, and where it stands among the blocks of time.

/// Folds of the cross-validation.
pub const FOLDS: usize = 4;

/// Rows of one block.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Its place among the kept rows.
    pub at: usize,
    /// The block of time it lies in.
    pub block: usize,
    /// The fold whose block is near, if it is not its own.
    pub near: Option<usize>,
}

impl Row {
    /// The fold that it is held out in.
    pub fn fold(&self) -> usize {
        self.block % FOLDS
    }
}
