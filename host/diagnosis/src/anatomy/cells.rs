//! Fewer rows for the same answer: means of the residual over equal steps of time.

use recording::noise::steps;

/// The most cells.
const MOST: usize = 4096;

/// Means over equal steps of time, of which those without rows are left out.
#[derive(Clone, Debug)]
pub struct Cells {
    /// Rows in each cell.
    pub weight: Vec<f64>,
    /// Mean residual of each cell, less the mean of all rows.
    pub value: Vec<f64>,
    /// The middle row of each cell.
    pub row: Vec<usize>,
    /// Width of a cell. Unit: s.
    pub width_s: f64,
    /// Sum of squares of all rows' residuals about their mean: more than the cells' where they hold several rows.
    pub energy: f64,
}

impl Cells {
    /// Gathers rows into cells.
    pub fn of(time_s: &[f64], residual: &[f64]) -> Self {
        let mean = residual.iter().sum::<f64>() / residual.len() as f64;
        let (step_s, gap_s) = steps(time_s);
        let covered_s: f64 =
            time_s.windows(2).map(|pair| pair[1] - pair[0]).filter(|step_s| *step_s < gap_s).sum();
        let width_s = step_s.max(covered_s / MOST as f64);
        let place = |row: &usize| ((time_s[*row] - time_s[0]) / width_s).round();
        let rows: Vec<usize> = (0..time_s.len()).collect();
        let mut cells = Self {
            weight: Vec::new(),
            value: Vec::new(),
            row: Vec::new(),
            width_s,
            energy: residual.iter().map(|e| (e - mean).powi(2)).sum(),
        };
        for cell in rows.chunk_by(|one, other| place(one) == place(other)) {
            let count = cell.len() as f64;
            cells.weight.push(count);
            cells.value.push(cell.iter().map(|&row| residual[row]).sum::<f64>() / count - mean);
            cells.row.push(cell[cell.len() / 2]);
        }
        cells
    }

    /// The value of a column in each cell.
    pub fn pick(&self, column: &[f64]) -> Vec<f64> {
        self.row.iter().map(|&row| column[row]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_equally_spaced_rows_are_cells_of_their_own() {
        let time_s: Vec<f64> = (0..1000).map(|row| f64::from(row) * 0.01).collect();
        let residual: Vec<f64> = (0..1000).map(|row| f64::from(row % 7)).collect();
        let cells = Cells::of(&time_s, &residual);
        assert_eq!(cells.weight, vec![1.0; 1000]);
        assert_eq!(cells.pick(&time_s), time_s);
    }

    #[test]
    fn many_rows_become_few_cells_and_a_gap_makes_none() {
        let time_s: Vec<f64> =
            (0..20_000).map(|row| f64::from(row) * 0.01 + if row < 10_000 { 0.0 } else { 1e6 }).collect();
        let cells = Cells::of(&time_s, &vec![1.0; 20_000]);
        assert!((4000..=4100).contains(&cells.weight.len()), "{}", cells.weight.len());
        assert_eq!(cells.weight.iter().sum::<f64>(), 20_000.0);
        assert!(cells.energy < 1e-9);
    }
}
