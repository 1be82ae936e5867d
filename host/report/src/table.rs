//! Tables: rows and columns on a desk, and a card for each row on a phone, so that no column is
//! cut.

use maud::{Markup, html};

/// A row of a table.
pub struct Row {
    /// A text for each column; the first one names the row.
    pub cells: Vec<String>,
    /// Whether it is the one that was chosen.
    pub is_chosen: bool,
}

impl From<Vec<String>> for Row {
    fn from(cells: Vec<String>) -> Self {
        Self { cells, is_chosen: false }
    }
}

/// A table whose columns have these headings.
pub fn table(headings: &[String], rows: &[Row]) -> Markup {
    grouped_table(&[("", headings.to_vec())], rows)
}

/// A table whose columns stand in groups, each with its name, which may be empty, and its headings.
pub fn grouped_table(groups: &[(&str, Vec<String>)], rows: &[Row]) -> Markup {
    let labels: Vec<String> = groups
        .iter()
        .flat_map(|(name, headings)| headings.iter().map(move |heading| format!("{name} {heading}")))
        .collect();
    html! {
        div.wide { table {
            thead {
                @if groups.len() > 1 {
                    tr { @for (name, headings) in groups { th colspan=(headings.len()) { (name) } } }
                }
                tr { @for (_, headings) in groups { @for heading in headings { th { (heading) } } } }
            }
            tbody { @for row in rows {
                tr.best[row.is_chosen] { @for (cell, label) in row.cells.iter().zip(&labels) {
                    td data-label=(label.trim()) { (cell) }
                } }
            } }
        } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_says_which_column_of_which_group_it_is_of() {
        let groups = [("", vec!["model".to_owned()]), ("held out", vec!["RMSE (mm)".to_owned()])];
        let rows = [Row { cells: ["mgpi", "0.5"].map(str::to_owned).to_vec(), is_chosen: true }];
        let drawn = grouped_table(&groups, &rows).into_string();
        for wanted in [
            "<td data-label=\"model\">mgpi</td>",
            "<td data-label=\"held out RMSE (mm)\">0.5</td>",
            "<tr class=\"best\">",
        ] {
            assert!(drawn.contains(wanted), "{wanted}: {drawn}");
        }
    }
}
