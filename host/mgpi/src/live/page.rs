//! The page: its frame here, what moves in `live.js`, and what plots do in the reports' `plot.js`.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use report::page::head;
use report::plot::{Line, Plot, Style};

/// What draws the page.
pub const SCRIPT: &str = include_str!("live.js");

/// What this page has beyond the reports.
const LIVE_STYLE: &str = "
.bar { display: flex; flex-wrap: wrap; gap: .6rem 1rem; align-items: center; position: sticky; top: 0;
  background: var(--paper); padding: .5rem 0; border-bottom: 1px solid var(--rule); z-index: 1 }
#state { font-weight: 600; font-size: 1.15rem; min-width: 7rem } #state::before { content: '\\25CF'; margin-right: .4rem }
#state.driven::before { color: #0072B2 } #state.fault::before { content: '\\25B2'; color: #D55E00 }
#state.ended::before { content: '\\25A0' }
.bar button { font: inherit; padding: .4rem 1.2rem; border: 1px solid var(--ink); border-radius: .3rem; cursor: pointer;
  background: var(--paper); color: var(--ink) } .bar button:disabled { opacity: .4; cursor: default }
.bar #stop { background: #B3261E; border-color: #B3261E; color: #fff; font-weight: 600 }
.plots { margin-top: 1rem } #now, #figures { font-variant-numeric: tabular-nums }
#figures { display: grid; grid-template-columns: max-content 1fr; gap: 0 1rem; margin: .6rem 0 } #figures dd { margin: 0 }
.problem { border-left: .3rem solid #D55E00; padding-left: .8rem }
#faults dt { margin-top: .6rem; font-style: normal; font-weight: 600 } #counters { column-width: 16rem; padding: 0; list-style: none }
";

/// A plot that the script fills.
fn plot(id: &str, title: &str, [x, y]: [&str; 2], lines: &[(&'static str, Style)]) -> Markup {
    let lines = lines.iter().map(|&(name, style)| Line { name, style, x: &[], y: &[] });
    let clock = if x == TIME { "board" } else { "" };
    let plot = Plot {
        title: title.to_owned(),
        x: x.to_owned(),
        y: y.to_owned(),
        lines: lines.collect(),
        clock: clock.to_owned(),
        ..Plot::default()
    };
    html! { div id=(id) { (plot.figure()) } }
}

const TIME: &str = "time (s)";
const CONTRACTION: &str = "contraction (mm)";
const PRESSURE: &str = "pressure (bar)";

/// The whole page.
pub fn page() -> String {
    let contraction = [("measured", Style::Measured), ("reference", Style::Model)];
    let pressure = [("measured", Style::Measured), ("command", Style::Model)];
    let error = [("reference less measured", Style::Error)];
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
                    button #stop type="button" disabled { "Stop and vent" }
                    button #acknowledge type="button" disabled { "Acknowledge" }
                    button #pause type="button" aria-pressed="false" { "Pause the page" }
                    button #save type="button" disabled { "Save as CSV" }
                    span #now {}
                }
                p #problem .problem role="alert" hidden {}
                dl #figures {
                    dt { "RMSE" } dd #rmse { "–" }
                    dt { "mode" } dd #mode { "–" }
                    dt { "gains" } dd #gains { "–" }
                }
                div.plots {
                    (plot("contraction", "Contraction", [TIME, CONTRACTION], &contraction))
                    (plot("pressure", "Pressure", [TIME, PRESSURE], &pressure))
                    (plot("loop", "Loop of the last 30 s", [PRESSURE, CONTRACTION], &[("", Style::Measured)]))
                    (plot("error", "Error", [TIME, "error (mm)"], &error))
                }
                h2 { "Faults" }
                dl #faults { dt { "none since the start" } }
                h2 { "Ticks and bus" }
                ul #counters {}
                footer { p {
                    "A page that is paused goes on to collect; the board takes no notice. \"Save as CSV\" saves all rows that this page \
                    has seen, at most the last " (KEPT_MINUTES) " minutes. Served by " (recording::TOOL) " on this machine; nothing leaves it."
                } }
                script src="plot.js" {}
                script src="live.js" data-kept-minutes=(KEPT_MINUTES) {}
            }
        }
    }
    .into_string()
}

/// How long the page keeps rows for the file. Unit: minutes.
const KEPT_MINUTES: u32 = 60;
