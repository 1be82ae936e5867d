//! A recording thinned for the screening of the starts, which only has to tell good from bad.
//!
//! Of each block of neighbouring rows the lowest and the highest input are kept, in their order in time:
//! rate-independent models remember extremes only, so that the history stays nearly what it was, however
//! fast the input moves.

use super::data::{Data, Drive};

/// About how many rows that count screening needs: many for each of a few dozen parameters.
const ROWS: usize = 2000;

impl Data {
    /// The recording with about [`ROWS`] rows that count, if it has more.
    pub fn thinned(&self) -> Self {
        let block = 2 * (self.rows.len() / ROWS).max(1);
        let inputs = &self.drive.inputs;
        let mut kept: Vec<usize> = Vec::with_capacity(2 * inputs.len() / block + 2);
        for first in (0..inputs.len()).step_by(block) {
            let rows = first..(first + block).min(inputs.len());
            let lowest = rows.clone().min_by(|&i, &j| inputs[i].total_cmp(&inputs[j]));
            let highest = rows.max_by(|&i, &j| inputs[i].total_cmp(&inputs[j]));
            kept.extend(lowest.min(highest));
            kept.extend(lowest.max(highest).filter(|_| lowest != highest));
        }
        // The kept rows that count: their places among the kept ones, and among all that count.
        let counted = |(place, row): (usize, &usize)| Some((place, self.rows.binary_search(row).ok()?));
        let (rows, counted): (Vec<usize>, Vec<usize>) = kept.iter().enumerate().filter_map(counted).unzip();
        let choose = |values: &[f64]| counted.iter().map(|&row| values[row]).collect();
        Self {
            drive: Drive::new(kept.iter().map(|&row| inputs[row]).collect()),
            outputs: choose(&self.outputs),
            added: self.added.iter().map(|column| choose(column)).collect(),
            rows,
            coordinates: self.coordinates.clone(),
            ..*self
        }
    }
}
