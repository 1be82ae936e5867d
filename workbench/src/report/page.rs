//! The page around the plots: one file, nothing from outside, no script.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::plot::colour_style;

/// Readable on a phone and in print, light and dark.
const STYLE: &str = "
:root { color-scheme: light dark; --ink: #222; --paper: #fff; --faint: #666; --rule: #ccc }
@media screen and (prefers-color-scheme: dark) {
  :root { --ink: #ddd; --paper: #161616; --faint: #999; --rule: #444 }
}
body { font: 1rem/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper);
  max-width: 84rem; margin: 0 auto; padding: 1rem }
h1 { font-size: 1.5rem; line-height: 1.2 } h2 { font-size: 1.15rem; margin-top: 2rem }
p { max-width: 42rem } footer { color: var(--faint); font-size: .85rem; overflow-wrap: anywhere }
.plots { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 30rem), 1fr)); gap: 1rem }
figure { margin: 0; break-inside: avoid; display: flex; flex-direction: column }
figure > svg { width: 100%; height: auto; margin-top: auto }
polyline { stroke-linejoin: round }
figcaption { font-weight: 600 } .legend { font-weight: 400 }
.legend span { margin-right: 1rem; white-space: nowrap } .legend svg { margin-right: .3rem }
table { border-collapse: collapse; font-variant-numeric: tabular-nums }
th, td { text-align: right; padding: .15rem .8rem; border-bottom: 1px solid var(--rule) }
th:first-child, td:first-child { text-align: left; padding-left: 0 }
.wide { overflow-x: auto } .best { font-weight: 600 } td:first-child { white-space: nowrap }
.bars { max-width: 42rem }
@media print { body { max-width: none; font-size: 10pt } .plots { grid-template-columns: 1fr 1fr } }
";

/// A page with a title and a body; `source` says where its numbers come from.
pub fn page(title: &str, body: &Markup, source: &str) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) (PreEscaped(colour_style())) }
            }
            body {
                h1 { (title) }
                (body)
                footer { p { (source) ". Drawn by " (crate::TOOL) "." } }
            }
        }
    }
    .into_string()
}
