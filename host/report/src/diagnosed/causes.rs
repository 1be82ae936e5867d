//! What is named: what each cause means, and its parameters in words with their units.

use maud::{Markup, html};

use super::are_causes_named;
use diagnosis::shown::quantity;
use diagnosis::{Diagnosis, Named, Verdict};
use recording::model_file::names::Names;
use recording::numbers::significant;

/// The section of the report.
pub fn section(diagnosis: &Diagnosis, units: Names) -> Markup {
    let is_explained = diagnosis.verdict != Verdict::Unexplained;
    let listed = if is_explained { &diagnosis.causes } else { &diagnosis.best_fit };
    html! {
        @if !listed.is_empty() {
            @if !is_explained {
                h2 { "The causes that go farthest, and do not explain it" }
                p { "They make the error smaller, but too much is left: something else is at work, and may be what they pass for." }
            } @else {
                h2 { "The causes" }
            }
            dl { @for named in listed {
                dt.best[are_causes_named(diagnosis.verdict)] { (named.cause.name()) }
                dd {
                    (named.cause.meaning()) ". It takes away " (significant(100.0 * share(named, diagnosis.heldout.1)))
                    " % of the square of the error that is there without it."
                    @if !named.parameters.is_empty() {
                        div.wide { table {
                            thead { tr { th { "parameter" } th { "value (unit of the row)" } th { "unit" } } }
                            tbody { @for same in named.parameters.chunk_by(|one, other| one.0 == other.0) {
                            @let (words, unit) = quantity(same[0].0, units);
                            @let values: Vec<String> = same.iter().map(|(_, value)| significant(*value)).collect();
                                tr { td { (words) } td { (values.join(", ")) } td { (unit) } }
                            } }
                        } }
                    }
                    ul { @for words in &named.evidence { li { (words) } } }
                }
            } }
        }
    }
}

/// The share of the square of the error without a cause that goes with it, from 0 to 1. `heldout`: the error with all causes on
/// held-out rows, output unit.
fn share(named: &Named, heldout: f64) -> f64 {
    let share =
        named.without.as_ref().map_or(named.share, |without| 1.0 - (heldout / without.heldout).powi(2));
    share.clamp(0.0, 1.0)
}
