//! What is named: what each cause means, and its parameters in words with their units.

use maud::{Markup, html};

use crate::diagnosis::{Diagnosis, Verdict};
use crate::report::bars::significant;

/// Ends of parameters' names, each with its unit; the longer of two that fit comes first.
const UNITS: [(&str, &str); 10] = [
    ("_mm_per_n", "mm/N"),
    ("_mm_per_k", "mm/K"),
    ("mm_per_s", "mm/s"),
    ("_per_decade", "per decade"),
    ("_per_n", "1/N"),
    ("_per_k", "1/K"),
    ("_bar", "bar"),
    ("_hz", "Hz"),
    ("_mm", "mm"),
    ("_s", "s"),
];

/// The section of the report.
pub fn section(diagnosis: &Diagnosis) -> Markup {
    html! {
        @if !diagnosis.causes.is_empty() {
            @if diagnosis.verdict == Verdict::Unexplained {
                h2 { "The causes that go farthest, and do not explain it" }
                p { "They make the error smaller, but too much is left: something else is at work, and may be what they pass for." }
            } @else {
                h2 { "The causes" }
            }
            dl { @for named in &diagnosis.causes {
                dt { (named.cause.name()) }
                dd {
                    (named.cause.meaning()) ". Beside the others it explains " (format!("{:.0}", 100.0 * named.share))
                    " % of the square of the first error."
                    @if !named.parameters.is_empty() {
                        div.wide { table { @for same in named.parameters.chunk_by(|one, other| one.0 == other.0) {
                            @let (words, unit) = quantity(same[0].0);
                            @let values: Vec<String> = same.iter().map(|(_, value)| significant(*value)).collect();
                            tr { td { (words) } td { (values.join(", ")) } td { (unit) } }
                        } } }
                    }
                    ul { @for words in &named.evidence { li { (words) } } }
                }
            } }
        }
    }
}

/// A parameter's name in words, and its unit.
fn quantity(name: &str) -> (String, &'static str) {
    let (stem, unit) = UNITS
        .iter()
        .find_map(|(end, unit)| name.strip_suffix(end).map(|stem| (stem, *unit)))
        .unwrap_or((name, ""));
    let words = if stem.is_empty() { "rate".to_owned() } else { stem.replace('_', " ") };
    (words, unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_end_of_a_name_is_its_unit() {
        let pairs = [
            ("time_constant_s", ("time constant", "s")),
            ("offset_mm_per_n", ("offset", "mm/N")),
            ("gain_per_k", ("gain", "1/K")),
            ("mm_per_s", ("rate", "mm/s")),
            ("damping_ratio", ("damping ratio", "")),
        ];
        for (name, (words, unit)) in pairs {
            assert_eq!(quantity(name), (words.to_owned(), unit));
        }
    }
}
