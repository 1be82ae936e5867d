//! What is named: what each cause means, and its parameters in words with their units.

use maud::{Markup, html};

use super::are_causes_named;
use crate::table::{Row, table};
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
                    (named.cause.meaning()) ". It takes away " (percent(share(named, diagnosis.heldout.1)))
                    " % of the square of the error " @if diagnosis.is_judged_at_the_valve(named.cause) { "of the pressure " }
                    "that is there without it."
                    @if !named.parameters.is_empty() {
                        (parameters(named, units))
                    }
                    ul { @for words in &named.evidence { li { (words) } } }
                }
            } }
        }
    }
}

/// Its parameters; those of one name in one row.
fn parameters(named: &Named, units: Names) -> Markup {
    let row = |same: &[(&'static str, f64)]| {
        let (words, unit) = quantity(same[0].0, units);
        let values: Vec<String> = same.iter().map(|(_, value)| significant(*value)).collect();
        vec![format!("{words} ({unit})"), values.join(", ")].into()
    };
    let rows: Vec<Row> = named.parameters.chunk_by(|one, other| one.0 == other.0).map(row).collect();
    table(&["parameter (unit)", "value"].map(str::to_owned), &rows)
}

/// A share in percent; a share below 1 is never rounded to 100 %.
fn percent(share: f64) -> String {
    // From here on four digits would say 100.0.
    const ALMOST_ALL: f64 = 0.9995;
    if (ALMOST_ALL..1.0).contains(&share) {
        return "more than 99.9".to_owned();
    }
    significant(100.0 * share)
}

/// The share of the square of the error without a cause that goes with it, from 0 to 1. `heldout`:
/// the error with all causes on held-out rows, output unit.
fn share(named: &Named, heldout: f64) -> f64 {
    let share =
        named.without.as_ref().map_or(named.share, |without| 1.0 - (heldout / without.heldout).powi(2));
    share.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_all_is_not_called_all() {
        assert_eq!([0.5, 0.9994, 0.99999, 1.0].map(percent), ["50.0", "99.9", "more than 99.9", "100"]);
    }
}
