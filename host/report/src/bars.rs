//! Bars with names and numbers, one group a thing, in the look of the plots: a list, so that names
//! wrap on a phone.

use maud::{Markup, html};
use recording::numbers::significant;

use super::plot::Style;

/// Height of a bar. Unit: pixels.
const HEIGHT: u32 = 14;
/// The colours of the bars of a group, in their order.
const STYLES: [Style; 2] = [Style::Measured, Style::Model];

/// A group of bars.
pub struct Bar<'a> {
    /// Its name.
    pub name: &'a str,
    /// At most as many values as there are names of bars, none negative.
    pub values: &'a [f64],
    /// Whether it is the one that was chosen.
    pub is_chosen: bool,
}

/// A value that the bars are read against.
pub struct Mark<'a> {
    /// Its name.
    pub name: &'a str,
    /// Not negative.
    pub value: f64,
}

/// Groups of bars from 0 on, each bar with its number; `names` are those of the bars of a group.
pub fn bars(title: &str, names: &[&str], groups: &[Bar<'_>], mark: Option<&Mark<'_>>) -> Markup {
    let values = groups.iter().flat_map(|group| group.values).chain(mark.map(|mark| &mark.value));
    let most = values.fold(f64::MIN_POSITIVE, |most, &value| most.max(value));
    let percent = |value: f64| format!("{:.1}%", 100.0 * value / most);
    let count = groups.iter().map(|group| group.values.len()).max().unwrap_or(0);
    html! {
        figure.bars {
            figcaption {
                (title)
                div.legend {
                    @for (name, style) in names.iter().zip(STYLES).take(count) {
                        span { (key(html! { rect width="14" height="14" fill=(style.hex()) {} })) (name) }
                    }
                    @if let Some(Mark { name, value }) = mark {
                        span { (key(stroke("50%"))) (name) " " (significant(*value)) }
                    }
                }
            }
            ul { @for group in groups {
                li.best[group.is_chosen] {
                    span.name { (group.name) }
                    @for (&value, style) in group.values.iter().zip(STYLES) {
                        svg height=(HEIGHT) aria-hidden="true" {
                            rect width=(percent(value)) height=(HEIGHT) fill=(style.hex()) {}
                            @if let Some(Mark { value, .. }) = mark { (stroke(&percent(*value))) }
                        }
                        span { (significant(value)) }
                    }
                }
            } }
        }
    }
}

/// A sign of the legend.
fn key(sign: Markup) -> Markup {
    html! { svg width="14" height="14" aria-hidden="true" { (sign) } }
}

/// The line of a mark.
fn stroke(x: &str) -> Markup {
    html! { line x1=(x) x2=(x) y1="0" y2=(HEIGHT) stroke=(Style::Ink.hex()) stroke-width="3" {} }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_bar_fills_the_drawing_and_the_others_are_in_proportion() {
        let groups = [
            Bar { name: "a", values: &[1.0, 2.0], is_chosen: false },
            Bar { name: "b", values: &[4.0], is_chosen: true },
        ];
        let drawing = bars("errors", &["one", "other"], &groups, None).into_string();
        for width in ["width=\"25.0%\"", "width=\"50.0%\"", "width=\"100.0%\""] {
            assert!(drawing.contains(width), "{width}: {drawing}");
        }
    }

    #[test]
    fn a_mark_beyond_all_bars_is_seen() {
        let groups = [Bar { name: "a", values: &[1.0], is_chosen: false }];
        let mark = Mark { name: "noise", value: 2.0 };
        let drawing = bars("errors", &[""], &groups, Some(&mark)).into_string();
        assert!(drawing.contains("width=\"50.0%\"") && drawing.contains("x1=\"100.0%\""), "{drawing}");
    }

    #[test]
    fn numbers_have_three_digits_that_count() {
        let numbers = [12.345, 0.65589, 0.0012345, -0.0451, 0.0].map(significant);
        assert_eq!(numbers, ["12.3", "0.656", "0.00123", "-0.0451", "0"]);
    }
}
