//! A comparison as a table: for people, as CSV and as JSON.

use serde_json::{Value, json};

use super::{Comparison, HeldOut, Row};
use crate::Weights;
use recording::figures::Figures;
use recording::unit::Unit;

/// What stands where there is nothing to say.
const NOTHING: &str = "–";
/// How many digits of an error are shown, counted from the first one of the stroke.
const DIGITS: f64 = 6.0;

impl Comparison<'_> {
    /// The headings of the columns of [`Comparison::cells`], in groups: the group's name, and its
    /// headings.
    pub fn headings(&self) -> Vec<(&'static str, Vec<String>)> {
        let unit = self.unit();
        let figures = [
            format!("ME ({unit})"),
            format!("MAE ({unit})"),
            format!("RMSE ({unit})"),
            "RMSE (%)".to_owned(),
        ]
        .to_vec();
        let mut groups = vec![
            ("", ["model", "n", "m", "parameters"].map(str::to_owned).to_vec()),
            ("training", figures.clone()),
        ];
        if self.has_heldout() {
            groups.push(("held out", figures));
        }
        groups.push(("", ["search (s)", "tick (instructions)"].map(str::to_owned).to_vec()));
        groups
    }

    /// The cells of a row, as people read them.
    pub fn cells(&self, row: &Row) -> Vec<String> {
        let stroke = self.recording.stroke();
        let decimals = (DIGITS - stroke.log10().floor()).clamp(0.0, 12.0) as usize;
        let figures = |figures: Option<&Figures>| match figures {
            Some(Figures { rmse, mae, max_error }) => {
                let [max_error, mae, rmse_in_unit] =
                    [max_error, mae, rmse].map(|value| format!("{value:.decimals$}"));
                [max_error, mae, rmse_in_unit, format!("{:.2}", 100.0 * rmse / stroke)]
            }
            None => [NOTHING; 4].map(str::to_owned),
        };
        let made = row.outcome.as_ref().ok();
        let mut cells = vec![
            row.model(),
            row.options.plays.to_string(),
            row.dead_zones().map_or(NOTHING.to_owned(), |count| count.to_string()),
            row.options.unknowns().to_string(),
        ];
        cells.extend(figures(made.map(|outcome| &outcome.training)));
        if self.has_heldout() {
            cells.extend(figures(made.and_then(|outcome| outcome.heldout.as_ref())));
        }
        cells.push(format!("{:.2}", row.seconds));
        cells.push(row.tick_instructions.map_or(NOTHING.to_owned(), |count| count.to_string()));
        cells
    }

    /// What the models were tried on, as a sentence.
    pub fn heldout_in_words(&self) -> String {
        match self.heldout {
            HeldOut::Recording(other) => format!("Held out is {}.", other.drive.file.display()),
            HeldOut::LaterCycles if self.has_heldout() => {
                "Held out is the second half of the cycles; another model of the first half was tried on it."
                    .to_owned()
            }
            HeldOut::EachByOthers if self.has_heldout() => {
                "Held out is each recording; a model of the others was tried on it.".to_owned()
            }
            HeldOut::LaterCycles | HeldOut::EachByOthers | HeldOut::Nothing => {
                "Nothing was held out: how the models do on what they have not seen is not known.".to_owned()
            }
        }
    }

    /// The table in columns of fixed width; a model that could not be made says why below it.
    pub fn to_text(&self) -> String {
        let groups = self.headings();
        // The name of a group stands over its first column.
        let names = groups.iter().flat_map(|(name, columns)| {
            columns
                .iter()
                .enumerate()
                .map(move |(i, _)| if i == 0 { (*name).to_owned() } else { String::new() })
        });
        let headings = groups.iter().flat_map(|(_, columns)| columns.iter().cloned());
        let lines: Vec<Vec<String>> = [names.collect(), headings.collect()]
            .into_iter()
            .chain(self.rows.iter().map(|row| self.cells(row)))
            .collect();
        let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..lines[0].len()).map(width).collect();
        let mut text = String::new();
        for line in &lines {
            let first = format!("{:<width$}", line[0], width = widths[0]);
            let others = line.iter().zip(&widths).skip(1).map(|(cell, width)| format!("  {cell:>width$}"));
            text += &((first + &others.collect::<String>()).trim_end().to_owned() + "\n");
        }
        for (row, error) in self.refused() {
            text += &format!("{}: {error}\n", row.name());
        }
        text
    }

    /// The models that could not be made, and why.
    pub fn refused(&self) -> impl Iterator<Item = (&Row, String)> {
        self.rows.iter().filter_map(|row| Some((row, row.outcome.as_ref().err()?.to_string())))
    }

    /// The table as CSV: all digits; a field is empty where there is nothing to say.
    pub fn to_csv(&self) -> String {
        let unit = self.unit();
        let mut names: Vec<String> =
            ["model", "plays", "dead_zones", "parameters"].map(str::to_owned).to_vec();
        for before in ["", "heldout_"] {
            let of_unit =
                ["max_error", "mae", "rmse"].map(|name| format!("{before}{name}_{}", unit.suffix()));
            names.extend(of_unit.into_iter().chain([format!("{before}rmse_percent")]));
        }
        names.extend(["seconds", "tick_instructions"].map(str::to_owned));
        let mut text = names.join(",") + "\n";
        for row in &self.rows {
            let made = row.outcome.as_ref().ok();
            let figures = |figures: Option<&Figures>| match figures {
                Some(Figures { rmse, mae, max_error }) => {
                    [*max_error, *mae, *rmse, 100.0 * rmse / self.recording.stroke()]
                        .map(|value| value.to_string())
                }
                None => std::array::from_fn(|_| String::new()),
            };
            let mut fields = vec![
                row.model(),
                row.options.plays.to_string(),
                row.dead_zones().map_or(String::new(), |count| count.to_string()),
                row.options.unknowns().to_string(),
            ];
            fields.extend(figures(made.map(|outcome| &outcome.training)));
            fields.extend(figures(made.and_then(|outcome| outcome.heldout.as_ref())));
            fields.push(row.seconds.to_string());
            fields.push(row.tick_instructions.map_or(String::new(), |count| count.to_string()));
            text += &(fields.join(",") + "\n");
        }
        text
    }

    /// The table as JSON, with how each search ended.
    pub fn to_json(&self) -> Value {
        let unit = self.unit();
        let row = |row: &Row| {
            let made = row.outcome.as_ref().ok();
            json!({
                "model": row.options.model.name(),
                "knots": row.options.knots,
                "free_weights": row.options.weights == Weights::Free,
                "plays": row.options.plays,
                "dead_zones": row.dead_zones(),
                "parameters": row.options.unknowns(),
                "training": made.map(|outcome| outcome.training.to_json(unit)),
                "heldout": made.and_then(|outcome| Some(outcome.heldout?.to_json(unit))),
                "seconds": row.seconds,
                "tick_instructions": row.tick_instructions,
                "starts": row.options.starts,
                "termination": match &row.outcome {
                    Ok(outcome) => outcome.termination.clone(),
                    Err(error) => error.to_string(),
                },
            })
        };
        let mut json = json!({ "rows": self.rows.iter().map(row).collect::<Vec<_>>() });
        json["left_out"] = self.recording.left_out.to_json();
        json["notes"] = self.recording.drive.notes.clone().into();
        json[format!("stroke_{}", unit.suffix())] = self.recording.stroke().into();
        json
    }

    fn unit(&self) -> Unit {
        self.recording.output.channel.unit
    }
}
