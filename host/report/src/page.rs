//! The page around the plots: one file, nothing from outside; its only script enlarges, points at
//! and exports plots, and the page is whole without it.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::plot::{Plot, colour_style, dashes};

/// Readable on a phone and in print, light and dark.
const STYLE: &str = "
:root { color-scheme: light dark; --ink: #222; --paper: #fff; --faint: #666; --rule: #ccc }
@media screen and (prefers-color-scheme: dark) {
  :root { --ink: #ddd; --paper: #161616; --faint: #999; --rule: #444 }
}
body { font: 1rem/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper);
  max-width: 84rem; margin: 0 auto; padding: 1rem }
h1 { font-size: 1.5rem; line-height: 1.2; overflow-wrap: anywhere } h2 { font-size: 1.15rem; margin-top: 2rem } h3 { font-size: 1rem }
p { max-width: 42rem } footer { color: var(--faint); font-size: .85rem; overflow-wrap: anywhere }
.plots { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 30rem), 1fr)); gap: 1rem }
figure { margin: 0; break-inside: avoid; display: flex; flex-direction: column }
figure > svg { width: 100%; height: auto; margin-top: auto }
.plot { cursor: crosshair; touch-action: pan-y } .plot.enlarged { touch-action: none } .plot text { user-select: none }
.plot:focus-visible, button:focus-visible { outline: 2px solid #0072B2; outline-offset: 2px }
.lines polyline { vector-effect: non-scaling-stroke } .frame { fill: #8888; stroke: none }
.cursor { pointer-events: none } .cursor line { stroke: var(--faint) } .cursor circle { stroke: var(--paper); stroke-width: 1.5 }
.readout { margin: 0; min-height: 1.5em; font-size: .85rem; font-variant-numeric: tabular-nums; max-width: none }
.tools { display: flex; gap: .4rem; justify-content: flex-end; margin-bottom: .6rem }
.tools button { font: inherit; font-size: .8rem; min-width: 2.75rem; padding: .2rem .5rem; border: 1px solid var(--rule);
  border-radius: .3rem; background: none; color: var(--ink); cursor: pointer } .tools button:disabled { opacity: .4; cursor: default }
.stack { max-width: 44rem; display: grid; gap: .4rem } .stack > figure:not(:last-child) .tools { margin-bottom: 0 }
.verdict.warning { border-left-color: #D55E00 }
@media (min-width: 72rem) { .run { display: grid; grid-template-columns: minmax(0, 44rem) minmax(0, 1fr); gap: 1rem }
  .run .plots { grid-template-columns: 1fr; align-content: start } }
.plots > div { display: grid; grid-template-rows: subgrid; grid-row: span 2; break-inside: avoid } .plots > div > p { margin-top: 0 }
figcaption { font-weight: 600 } .legend { font-weight: 400 }
.legend > span { display: inline-block; margin-right: 1rem } .legend svg { margin-right: .3rem }
table { border-collapse: collapse; font-variant-numeric: tabular-nums }
th, td { text-align: right; padding: .15rem .8rem; border-bottom: 1px solid var(--rule) }
th:first-child, td:first-child { text-align: left; padding-left: 0 }
th[colspan] { text-align: center }
.wide { overflow-x: auto } .wide th, .wide td { padding: .15rem .35rem } .best { font-weight: 600 } td:first-child { white-space: nowrap }
.bars { max-width: 52rem } .bars ul { list-style: none; margin: .4rem 0; padding: 0 }
.bars li { display: grid; grid-template-columns: minmax(7rem, 20rem) 1fr 4.6rem; gap: .1rem .6rem; align-items: center;
  break-inside: avoid; padding: .15rem 0 }
.bars li > * { grid-column: 3 } .bars li > svg { grid-column: 2; width: 100%; overflow: visible }
.bars .name { grid-column: 1; grid-row: span 2; overflow-wrap: anywhere }
@media (max-width: 40rem) { .bars li { grid-template-columns: 1fr 4.6rem } .bars li > * { grid-column: 2 }
  .bars li > svg { grid-column: 1 } .bars .name { grid-column: 1 / -1; grid-row: auto } }
@media screen and (max-width: 40rem) { .wide thead { display: none } .wide table, .wide tbody { display: block }
  .wide tr { display: grid; grid-template-columns: repeat(auto-fit, minmax(9.5rem, 1fr)); gap: 0 1rem; padding: .4rem 0;
    border-bottom: 1px solid var(--rule) }
  .wide td { display: flex; justify-content: space-between; gap: .6rem; padding: 0; border: 0 }
  .wide td::before { content: attr(data-label); color: var(--faint); font-weight: 400; font-size: .85rem; text-align: left }
  .wide td:first-child { grid-column: 1 / -1; font-weight: 600; white-space: normal } }
.verdict { font-size: 1.15rem; font-weight: 600; border-left: .3rem solid; padding-left: .8rem }
dl { max-width: 42rem } dt { font-style: italic } dt.best { font-style: normal } dd { margin: 0 0 .6rem } code { overflow-wrap: anywhere }
@media print { .hint, .tools, .readout { display: none } body { max-width: none; font-size: 10pt } .plots { grid-template-columns: 1fr 1fr }
  table { font-size: 9pt } td { white-space: nowrap } .wide { overflow: visible } .wide table { font-size: 6.5pt }
  .wide th, .wide td { padding: .1rem .3rem } }
";
/// The plots' script.
pub const PLOTS: &str = include_str!("plot.js");

/// Plots, each with a few words below.
pub fn explained(plots: &[(Plot<'_>, &str)]) -> Markup {
    html! {
        div.plots { @for (plot, words) in plots { div { (plot.figure()) p { (words) } } } }
    }
}

/// What was done to a file when it was read; nothing where it was taken as it is.
pub fn reading(file: &str, notes: &[String]) -> Markup {
    html! {
        @if !notes.is_empty() {
            p { "How " (file) " was read:" }
            ul { @for note in notes { li { (note) } } }
        }
    }
}

/// The head of a page, with what it has beyond that of all.
pub fn head(title: &str, beyond: &Markup) -> Markup {
    html! {
        head {
            meta charset="utf-8";
            meta name="viewport" content="width=device-width, initial-scale=1";
            title { (title) }
            style data-dashes=(dashes()) { (PreEscaped(STYLE)) (PreEscaped(colour_style())) }
            (beyond)
        }
    }
}

/// A page with a title and a body; `source` says where its numbers come from.
pub fn page(title: &str, body: &Markup, source: &str) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            (head(title, &html! {}))
            body {
                h1 { (title) }
                (body)
                footer {
                    p.hint { "Values are shown where you point. Drag over a part of a plot to enlarge it (two fingers, or the "
                        "wheel with Ctrl, do so too), double click to see all of it. A chosen plot answers to the keys + and -, "
                        "0 for all, the arrows for values, and Shift with an arrow to move. SVG and PNG save what you see, CSV "
                        "the points that are drawn: those of long recordings are thinned until the eye would see it." }
                    p { (source) ". Drawn by " (recording::TOOL) "." }
                }
                script { (PreEscaped(PLOTS)) }
            }
        }
    }
    .into_string()
}
