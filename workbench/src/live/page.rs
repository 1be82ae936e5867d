//! The page: its frame here, what moves in `live.js`.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::report::page::head;
use crate::report::plot::Style;

/// What draws the page.
pub const SCRIPT: &str = include_str!("live.js");

/// What this page has beyond the reports.
const LIVE_STYLE: &str = "
.bar { display: flex; flex-wrap: wrap; gap: .6rem 1rem; align-items: center; position: sticky; top: 0;
  background: var(--paper); padding: .5rem 0; border-bottom: 1px solid var(--rule); z-index: 1 }
#state { font-weight: 600; font-size: 1.15rem; min-width: 7rem } #state::before { content: '\\25CF'; margin-right: .4rem }
#state.driven::before { color: #0072B2 } #state.fault::before { content: '\\25B2'; color: #D55E00 }
button { font: inherit; padding: .4rem 1.2rem; border: 1px solid var(--ink); border-radius: .3rem; cursor: pointer;
  background: var(--paper); color: var(--ink) }
#stop { background: #B3261E; border-color: #B3261E; color: #fff; font-weight: 600 } button:disabled { opacity: .4; cursor: default }
figure > svg { margin-top: .3rem } .plots { margin-top: 1rem } #now { font-variant-numeric: tabular-nums } .problem { border-left: .3rem solid #D55E00; padding-left: .8rem }
polyline { vector-effect: non-scaling-stroke } #faults dt { margin-top: .6rem } #counters { column-width: 16rem; padding: 0; list-style: none }
";

/// A plot that the script fills: lines, each with its name and look.
fn plot(id: &str, caption: &str, x: &str, y: &str, lines: &[(&str, Style)]) -> Markup {
    html! {
        figure {
            figcaption {
                (caption) " "
                span.legend { @for (name, style) in lines {
                    span {
                        svg width="36" height="10" aria-hidden="true" {
                            line x1="0" x2="36" y1="5" y2="5" stroke=(style.hex()) stroke-width="3" {}
                        }
                        (name)
                    }
                } }
            }
            svg id=(id) viewBox="0 0 640 340" role="img" data-x=(x) data-y=(y) {
                title { (caption) }
                g.grid stroke=(Style::Grid.hex()) {}
                g.numbers fill=(Style::Ink.hex()) font-size="20" {}
                text x="350" y="336" text-anchor="middle" font-size="20" fill=(Style::Ink.hex()) { (x) }
                text x="16" y="150" text-anchor="middle" font-size="20" fill=(Style::Ink.hex())
                    transform="rotate(-90 16 150)" { (y) }
                @for (_, style) in lines {
                    polyline fill="none" stroke=(style.hex()) stroke-width="2" {}
                }
            }
        }
    }
}

/// The whole page.
pub fn page() -> String {
    let contraction = [("measured", Style::Measured), ("wanted", Style::Model)];
    let pressure = [("measured", Style::Measured), ("command", Style::Model)];
    // Without the icon a browser would ask for one that is not there.
    let beyond = html! { link rel="icon" href="data:,"; style { (PreEscaped(LIVE_STYLE)) } };
    html! {
        (DOCTYPE)
        html lang="en" {
            (head("Valve board", &beyond))
            body {
                h1 { "Valve board" }
                div.bar {
                    span #state role="status" { "no word yet" }
                    button #stop type="button" { "Stop and vent" }
                    button #acknowledge type="button" disabled { "Acknowledge" }
                    span #now {}
                }
                p #problem .problem hidden {}
                div.plots {
                    (plot("contraction", "Contraction", "time in s", "contraction in mm", &contraction))
                    (plot("pressure", "Pressure", "time in s", "pressure in bar", &pressure))
                    (plot("loop", "Loop", "pressure in bar", "contraction in mm", &[("the last 30 s", Style::Measured)]))
                    (plot("error", "Error", "time in s", "error in mm", &[("measured less wanted", Style::Error)]))
                }
                h2 { "Faults" }
                dl #faults { dt { "none since the start" } }
                h2 { "Ticks and bus" }
                ul #counters {}
                footer { p { "Served by " (crate::TOOL) " on this machine; nothing leaves it." } }
                script src="live.js" {}
            }
        }
    }
    .into_string()
}
