//! The rows of a recording that are enough where what comes out is a direction or a rank: the scored ones.
//!
//! Where others lie between, so many of them are kept that no step is longer than is asked for, or than from one scored row to the
//! next.

use std::ops::Range;

use recording::numbers::median;

/// Kept rows, in order.
pub struct Thinning {
    /// Their places in the recording.
    pub rows: Vec<usize>,
    /// The places of the scored ones among them.
    pub scored: Vec<usize>,
}

impl Thinning {
    /// To these scored rows, which are in order, and what leads to them.
    pub fn to(scored: &[usize]) -> Self {
        let mut apart: Vec<f64> = scored.windows(2).map(|pair| (pair[1] - pair[0]) as f64).collect();
        Self::by((median(&mut apart) as usize).max(1), scored)
    }

    /// To every so many rows on the way to these scored ones, which are in order.
    pub fn by(step: usize, scored: &[usize]) -> Self {
        Self::through(scored, |_| step)
    }

    /// To these scored rows, which are in order, and of the rows from each to the next, or from the first to the first scored one, every
    /// so many as `step` says, which is 1 or more.
    pub fn through(scored: &[usize], step: impl Fn(Range<usize>) -> usize) -> Self {
        let mut thinning =
            Self { rows: Vec::with_capacity(scored.len()), scored: Vec::with_capacity(scored.len()) };
        let mut before = None;
        for &row in scored {
            let way = before.unwrap_or(0)..row;
            let between = way.clone().step_by(step(way)).skip(usize::from(before.is_some()));
            thinning.rows.extend(between);
            thinning.scored.push(thinning.rows.len());
            thinning.rows.push(row);
            before = Some(row);
        }
        thinning
    }

    /// What is kept of a column.
    pub fn of<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.rows.iter().map(|&row| values[row]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_scored_is_kept_and_what_leads_to_it_in_steps_that_are_no_longer() {
        // Every third row, then none from 9 to 20.
        let scored = [3, 6, 9, 20, 23];
        let thinning = Thinning::to(&scored);
        assert_eq!(thinning.rows, [0, 3, 6, 9, 12, 15, 18, 20, 23]);
        let kept: Vec<usize> = thinning.scored.iter().map(|&place| thinning.rows[place]).collect();
        assert_eq!(kept, scored);
    }

    #[test]
    fn every_so_many_rows_lead_to_what_is_scored() {
        let thinning = Thinning::by(2, &[4, 8, 13]);
        assert_eq!(thinning.rows, [0, 2, 4, 6, 8, 10, 12, 13]);
        assert_eq!(thinning.scored, [2, 4, 7]);
    }

    #[test]
    fn what_leads_to_a_scored_row_is_as_dense_as_is_said_of_it() {
        let thinning = Thinning::through(&[2, 6, 12], |way| if way.contains(&4) { 1 } else { 4 });
        assert_eq!(thinning.rows, [0, 2, 3, 4, 5, 6, 10, 12]);
        assert_eq!(thinning.scored, [1, 5, 7]);
    }

    #[test]
    fn where_all_rows_are_scored_none_goes() {
        let thinning = Thinning::to(&[0, 1, 2, 3]);
        assert_eq!(thinning.rows, [0, 1, 2, 3]);
        assert_eq!(thinning.scored, thinning.rows);
    }
}
