//! Which rows of a table a recording is made of: some are left out, some brought together.

use std::ops::Range;

/// The rows of a recording, by those of its table.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    /// The table's rows that are used; `None` for all.
    kept: Option<Vec<usize>>,
    /// Where, among those, each row of the recording begins; `None` for one each.
    begins: Option<Vec<usize>>,
}

impl Rows {
    /// The rows where all columns have a value; each column has a value a row, NaN where it is
    /// missing.
    pub fn whole(columns: &[&[f64]]) -> Self {
        let is_whole = |row: &usize| columns.iter().all(|column| !column[*row].is_nan());
        let rows = columns.first().map_or(0, |column| column.len());
        let kept = (0..rows).any(|row| !is_whole(&row)).then(|| (0..rows).filter(is_whole).collect());
        Self { kept, begins: None }
    }

    /// Brings rows together that begin at these places.
    pub fn brought_together(self, begins: Option<Vec<usize>>) -> Self {
        Self { begins, ..self }
    }

    /// The table's row that a row of the recording begins with.
    pub fn source(&self, row: usize) -> usize {
        let place = self.begins.as_ref().map_or(row, |begins| begins[row]);
        self.kept.as_ref().map_or(place, |kept| kept[place])
    }

    /// A column of the recording out of one of its table: the mean of the values that are brought
    /// together, without those that are missing; NaN where all are.
    pub fn take(&self, column: &[f64]) -> Vec<f64> {
        let kept: Vec<f64> = match &self.kept {
            Some(kept) => kept.iter().map(|&row| column[row]).collect(),
            None => column.to_vec(),
        };
        let Some(begins) = &self.begins else { return kept };
        let ends = begins.iter().skip(1).copied().chain([kept.len()]);
        begins.iter().zip(ends).map(|(&from, to)| mean(&kept[from..to])).collect()
    }
}

fn mean(values: &[f64]) -> f64 {
    let present = || values.iter().filter(|value| !value.is_nan());
    let count = present().count() as f64;
    // Divided first: the sum of large values may be no number.
    if count == 0.0 { f64::NAN } else { present().map(|value| value / count).sum() }
}

/// Stretches of missing values: from where to where.
pub fn holes(values: &[f64]) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    for (row, _) in values.iter().enumerate().filter(|(_, value)| value.is_nan()) {
        match found.last_mut() {
            Some(last) if last.end == row => last.end = row + 1,
            _ => found.push(row..row + 1),
        }
    }
    found
}

/// Puts straight lines over the holes, and the nearest value before the first and behind the last
/// one; `false`, and nothing done, where there is no value.
pub fn fill(time_s: &[f64], values: &mut [f64]) -> bool {
    for hole in holes(values) {
        let before = hole.start.checked_sub(1).map(|row| (time_s[row], values[row]));
        let behind = values.get(hole.end).map(|&value| (time_s[hole.end], value));
        for row in hole {
            values[row] = match (before, behind) {
                (Some((from_s, from)), Some((to_s, to))) => {
                    from + (to - from) * (time_s[row] - from_s) / (to_s - from_s)
                }
                (Some((_, value)), None) | (None, Some((_, value))) => value,
                (None, None) => return false,
            };
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAN: f64 = f64::NAN;

    #[test]
    fn rows_are_left_out_and_brought_together() {
        let rows = Rows::whole(&[&[0.0, 1.0, NAN, 3.0, 4.0], &[0.0, NAN, 2.0, 3.0, 4.0]]);
        assert_eq!(rows.take(&[10.0, 11.0, 12.0, 13.0, 14.0]), [10.0, 13.0, 14.0]);
        let rows = rows.brought_together(Some(vec![0, 1]));
        assert_eq!(rows.take(&[10.0, 11.0, 12.0, 13.0, 14.0]), [10.0, 13.5]);
        assert_eq!(rows.take(&[10.0, 11.0, 12.0, NAN, 14.0]), [10.0, 14.0]);
        assert_eq!((rows.source(0), rows.source(1)), (0, 3));
    }

    #[test]
    fn holes_are_filled_by_straight_lines() {
        let mut values = [NAN, 1.0, NAN, NAN, 4.0, NAN];
        assert!(fill(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0], &mut values));
        assert_eq!(values, [1.0, 1.0, 2.0, 3.0, 4.0, 4.0]);
        assert!(!fill(&[0.0], &mut [NAN]));
    }
}
