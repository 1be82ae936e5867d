//! The parameters of a model and what is known about them, as a table with words.

use maud::{Markup, html};

use identification::Uncertainty;
use recording::model_file::names::Names;

/// The section of a report.
pub fn parameters(known: &Uncertainty, names: &Names) -> Markup {
    html! {
        h2 { "Parameters" }
        p { "The 95 % intervals hold for a muscle that is a model of this kind, but for a disturbance like the residuals. "
            @if known.memory > 1 {
                "Neighbouring residuals are alike, up to about " (known.memory) " rows on; the intervals are the wider for "
                "it. "
            }
            "A dash: the parameter stands at a bound, or no row tells anything of it." }
        @if let Some(groups) = known.hardly_separable() {
            p { "The recording hardly separates " (groups) ": a change of one is made good by the others of its group. The "
                "model is none the worse, but these values are not to be compared one by one with those of another muscle." }
        }
        div.wide { table {
            thead { tr { th { "name" } th { "value (unit of the row)" } th { "standard error (unit of the row)" }
                th { "95 % interval (unit of the row)" } th { "unit" } } }
            tbody { @for estimate in &known.estimates {
                tr {
                    td { (estimate.parameter.name) }
                    td { (format!("{:.5}", estimate.parameter.value)) }
                    td { @match estimate.standard_error {
                        Some(error) => (format!("{error:.2e}")),
                        None => "–",
                    } }
                    td { @match estimate.interval {
                        Some([low, high]) => (format!("{low:.5} … {high:.5}")),
                        None => "–",
                    } }
                    td { (names.unit(estimate.parameter.dimension)) }
                }
            } }
        } }
    }
}
