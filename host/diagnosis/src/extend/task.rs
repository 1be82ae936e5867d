//! What a model is fitted to.

use crate::Columns;

/// Which rows of a recording a model is fitted to.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    pub columns: &'a Columns,
    /// In order.
    pub scored: &'a [usize],
    /// Root mean square error of the search with the same effects; the price of an uneven curve is in proportion to it. Output
    /// unit.
    pub reached: f64,
    /// Whether a rest after a swing counts once ([`super::rests`]): for the model that is kept, not where models are compared by the errors of
    /// all rows.
    pub rests_once: bool,
}

impl<'a> Task<'a> {
    /// Of a model without effects. An operator alone may be as uneven as it likes: no search is asked what that costs.
    pub fn alone(columns: &'a Columns, scored: &'a [usize]) -> Self {
        Self { columns, scored, reached: 0.0, rests_once: false }
    }
}
