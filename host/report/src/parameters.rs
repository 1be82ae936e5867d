//! The parameters of a model and what is known about them, as a table with words.

use maud::{Markup, html};

use super::table::{Row, table};
use identification::{Estimate, Uncertainty};
use recording::model_file::names::Names;
use recording::numbers::{legible, significant};

const HEADINGS: [&str; 4] = ["parameter (unit)", "value", "standard error", "95 % interval"];
/// Of values and intervals; those that are small have more.
const DECIMALS: usize = 4;

/// The section of a report.
pub fn parameters(known: &Uncertainty, names: &Names) -> Markup {
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".to_owned());
    let rows: Vec<Row> = known
        .estimates
        .iter()
        .map(|Estimate { parameter, standard_error, interval, .. }| {
            let interval = interval.map(|ends| ends.map(|end| legible(end, DECIMALS)).join(" … "));
            vec![
                format!("{} ({})", parameter.name, names.unit(parameter.dimension)),
                legible(parameter.value, DECIMALS),
                or_dash(standard_error.map(significant)),
                or_dash(interval),
            ]
            .into()
        })
        .collect();
    html! {
        h2 { "Parameters" }
        p { "The 95 % intervals hold for a muscle that is a model of this kind, with a disturbance like the residuals. "
            @if known.memory > 1 {
                "Residuals are correlated over about " (known.memory) " rows, which makes the intervals wider. "
            }
            "A dash: the parameter stands at a bound, or the recording says nothing about it." }
        @if let Some(groups) = known.hardly_separable() {
            p { "The recording hardly separates " (groups) ": a change of one is compensated by the others of its "
                "group. The model is as good, but these values cannot be compared one by one with those of another muscle." }
        }
        (table(&HEADINGS.map(str::to_owned), &rows))
    }
}
