//! Bars with names, one group a thing, in the look of the plots.

use maud::{Markup, html};

use super::plot::Style;

/// Size of a drawing and of what is in it. Unit: pixels.
const WIDTH: f64 = 640.0;
const NAMES: f64 = 120.0;
const NUMBERS: f64 = 70.0;
const HEIGHT: f64 = 14.0;
const GAP: f64 = 10.0;
/// The colours of the bars of a group, in their order.
const STYLES: [Style; 2] = [Style::Measured, Style::Model];

/// A group of bars.
pub struct Bar<'a> {
    /// Its name.
    pub name: &'a str,
    /// At most as many values as there are names of bars, none negative.
    pub values: &'a [f64],
}

/// Groups of bars from 0 on, each bar with its number; `names` are those of the bars of a group.
pub fn bars(title: &str, names: &[&str], groups: &[Bar<'_>]) -> Markup {
    let most =
        groups.iter().flat_map(|group| group.values).fold(f64::MIN_POSITIVE, |most, &value| most.max(value));
    let count = groups.iter().map(|group| group.values.len()).max().unwrap_or(0);
    let pitch = HEIGHT * count as f64 + GAP;
    let length = |value: f64| value / most * (WIDTH - NAMES - NUMBERS);
    let keys = || names.iter().zip(STYLES).take(count);
    html! {
        figure.bars {
            figcaption {
                (title)
                div.legend { @for (name, style) in keys() {
                    span {
                        svg width="14" height="14" aria-hidden="true" { rect width="14" height="14" fill=(style.hex()) {} }
                        (name)
                    }
                } }
            }
            svg role="img" viewBox=(format!("0 0 {WIDTH} {}", pitch * groups.len() as f64))
                xmlns="http://www.w3.org/2000/svg" font-family="sans-serif" font-size="13" fill=(Style::Ink.hex()) {
                title { (title) }
                @for (i, group) in groups.iter().enumerate() {
                    g transform=(format!("translate(0,{})", pitch * i as f64)) {
                        text x=(NAMES - 8.0) y=(HEIGHT * count as f64 / 2.0 + 4.5) text-anchor="end" { (group.name) }
                        @for (k, (&value, style)) in group.values.iter().zip(STYLES).enumerate() {
                            @let top = HEIGHT * k as f64;
                            rect x=(NAMES) y=(top) width=(format!("{:.1}", length(value))) height=(HEIGHT - 1.0)
                                fill=(style.hex()) {}
                            text x=(format!("{:.1}", NAMES + length(value) + 6.0)) y=(top + HEIGHT - 3.0) { (significant(value)) }
                        }
                    }
                }
            }
        }
    }
}

/// A number with three digits that count.
fn significant(value: f64) -> String {
    let decimals = if value > 0.0 { (2.0 - value.log10().floor()).clamp(0.0, 12.0) as usize } else { 0 };
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_bar_fills_the_drawing_and_the_others_are_in_proportion() {
        let groups = [Bar { name: "a", values: &[1.0, 2.0] }, Bar { name: "b", values: &[4.0] }];
        let drawing = bars("errors", &["one", "other"], &groups).into_string();
        for width in ["width=\"112.5\"", "width=\"225.0\"", "width=\"450.0\""] {
            assert!(drawing.contains(width), "{width}: {drawing}");
        }
    }

    #[test]
    fn numbers_have_three_digits_that_count() {
        assert_eq!([12.345, 0.65589, 0.0012345, 0.0].map(significant), ["12.3", "0.656", "0.00123", "0"]);
    }
}
