//! The page of many boards: a row each, what is wrong with its cause and its cure, a stop for all;
//! and their figures in the text format of Prometheus.

use std::fmt::Write;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use gateway::Gateway;
use gateway::boards::{Board, Boards};
use maud::{DOCTYPE, PreEscaped, html};
use network::Reload;
use report::page::head;
use serde_json::{Value, json};
use wire::fault::table::TABLE;

use super::server::{HTML, NO_ORDER, SCRIPT, Site};

/// The least time between two events of a page: as fast as an eye follows numbers.
const EVENT: Duration = Duration::from_millis(100);

/// What draws the page.
const PAGE_SCRIPT: &str = include_str!("fleet.js");

/// What this page has beyond the reports.
const STYLE: &str = "
.bar { display: flex; flex-wrap: wrap; gap: .6rem 1rem; align-items: center; position: sticky; top: 0;
  background: var(--paper); padding: .5rem 0; border-bottom: 1px solid var(--rule); z-index: 1 }
button { font: inherit; padding: .4rem 1.2rem; border: 1px solid var(--ink); border-radius: .3rem; cursor: pointer;
  background: var(--paper); color: var(--ink) } button:disabled { opacity: .4; cursor: default }
#stop { background: #B3261E; border-color: #B3261E; color: #fff; font-weight: 600 }
#boards { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(20rem, 100%), 1fr)); gap: .8rem; margin-top: 1rem }
.board { border: 1px solid var(--rule); border-radius: .4rem; padding: .6rem .8rem } .board h2 { font-size: 1rem; margin: 0 }
.board .state { font-weight: 600 } .board .state::before { content: '\\25CF'; margin-right: .4rem }
.board.driven .state::before { color: #0072B2 } .board.fault { border-color: #D55E00 }
.board.fault .state::before { content: '\\25B2'; color: #D55E00 } .board.unseen { border-style: dashed }
.board.unseen .state::before { content: '\\25CB' }
.board dl:not([hidden]) { display: grid; grid-template-columns: max-content 1fr; gap: 0 1rem; margin: .4rem 0; font-variant-numeric: tabular-nums }
.board dd { margin: 0 } .board .wrong { border-left: .3rem solid #D55E00; padding-left: .6rem; margin: .4rem 0 0 }
";

/// Many boards, as they are served.
#[derive(Clone)]
pub struct FleetSite {
    gateway: Arc<Gateway>,
    reload: Reload,
}

impl FleetSite {
    /// The boards of a gateway; `reload` reads its file again.
    pub fn new(gateway: Arc<Gateway>, reload: Reload) -> Self {
        Self { gateway, reload }
    }
}

impl Site for FleetSite {
    fn get(&self, path: &str) -> Option<(&'static str, String)> {
        match path {
            "/" => Some((HTML, page())),
            "/fleet.js" => Some((SCRIPT, PAGE_SCRIPT.to_owned())),
            "/fleet.json" => Some(("application/json", in_json(self.gateway.boards()).to_string())),
            "/metrics" => {
                Some(("text/plain; version=0.0.4; charset=utf-8", metrics(&self.gateway.boards().all())))
            }
            _ => None,
        }
    }

    fn order(&self, path: &str) -> Result<(), String> {
        match path {
            "/stop" => {
                self.gateway.stop_all();
                Ok(())
            }
            "/reload" => (self.reload)(),
            _ => {
                let index = path.strip_prefix("/acknowledge/").and_then(|index| index.parse().ok());
                let index: usize = index.ok_or(NO_ORDER)?;
                self.gateway.acknowledge(&[index]).map_err(|refused| refused.to_string())
            }
        }
    }

    fn events(&self) -> impl FnMut(Duration) -> Option<String> {
        let (boards, mut seen, mut last) = (self.gateway.boards().clone(), 0, None::<Instant>);
        move |limit| {
            let early = last.map_or(Duration::ZERO, |last| EVENT.saturating_sub(last.elapsed()));
            thread::sleep(early);
            let news = boards.news(&mut seen, limit).then(|| in_json(&boards).to_string());
            last = Some(Instant::now());
            news
        }
    }
}

/// All boards; what is latched with its cause and its cure.
fn in_json(boards: &Boards) -> Value {
    let board = |(index, board): (usize, &Board)| {
        let mut told = board.to_json();
        told["index"] = index.into();
        let fault = board.telemetry.as_ref().and_then(|telemetry| telemetry.fault());
        let row = fault.and_then(|fault| TABLE.iter().find(|row| row.fault == fault));
        told["fault"] =
            row.map_or(Value::Null, |row| json!({"title": row.title, "cause": row.cause, "cure": row.cure}));
        told
    };
    let all = boards.all();
    let there = all.iter().enumerate().filter(|(_, board)| !board.is_gone);
    json!({"now_s": Boards::now_s(), "boards": there.map(board).collect::<Vec<_>>()})
}

/// The figures in the text format of Prometheus, version 0.0.4.
fn metrics(boards: &[Board]) -> String {
    let now_s = Boards::now_s();
    type Figure = fn(&Board, f64) -> Option<f64>;
    let figures: [(&str, &str, &str, Figure); 12] = [
        ("seen", "gauge", "1 where the board answers", |board, _| {
            Some(f64::from(board.problem.is_none() && board.telemetry.is_some()))
        }),
        ("age_seconds", "gauge", "Since its last answer", |board, now_s| {
            board.telemetry.as_ref().map(|seen| now_s - seen.time_s)
        }),
        (
            "state",
            "gauge",
            "0 off, 1 self-test, 2 ready, 3 tracking, 4 holding, 5 fault, 6 service",
            |board, _| board.telemetry.as_ref().map(|seen| f64::from(seen.state as u8)),
        ),
        ("fault", "gauge", "Number of the latched fault, 0 for none", |board, _| {
            board.telemetry.as_ref().map(|seen| seen.fault.into())
        }),
        ("pressure_bar", "gauge", "In the muscle", |board, _| {
            board.telemetry.as_ref().map(|seen| seen.pressure_bar)
        }),
        ("contraction_mm", "gauge", "Of the muscle", |board, _| {
            board.telemetry.as_ref().map(|seen| seen.contraction_mm)
        }),
        ("command_bar", "gauge", "Put out to the valve", |board, _| {
            board.telemetry.as_ref().map(|seen| seen.command_bar)
        }),
        ("worst_tick_cycles", "gauge", "Longest time from a tick's due moment to its end", |board, _| {
            board.telemetry.as_ref().map(|seen| seen.worst_tick_cycles.into())
        }),
        ("clock_drift_ppm", "gauge", "By which the board's clock gains on this machine's", |board, _| {
            board.telemetry.as_ref().map(|seen| 1e6 * seen.drift.0)
        }),
        ("clock_bound_seconds", "gauge", "How far the time of its last answer may be off", |board, _| {
            board.telemetry.as_ref().map(|seen| seen.time_bound_s)
        }),
        ("answers_total", "counter", "Questions that it has answered", |board, _| {
            Some(board.answered as f64)
        }),
        ("lost_total", "counter", "Questions without an answer", |board, _| Some(board.lost as f64)),
    ];
    let mut text = String::new();
    for (name, kind, help, figure) in figures {
        // Writing into a text does not fail.
        let _ = writeln!(text, "# HELP mgpi_{name} {help}\n# TYPE mgpi_{name} {kind}");
        for board in boards.iter().filter(|board| !board.is_gone) {
            if let Some(value) = figure(board, now_s) {
                let [name_of_board, line] = [&board.name, &board.line].map(|label| escaped(label));
                let _ = writeln!(
                    text,
                    "mgpi_{name}{{board=\"{name_of_board}\",line=\"{line}\",number=\"{}\"}} {value}",
                    board.number
                );
            }
        }
    }
    text
}

/// A label's value as the format wants it.
fn escaped(label: &str) -> String {
    label.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}

/// The page.
fn page() -> String {
    let beyond = html! { link rel="icon" href="data:,"; style { (PreEscaped(STYLE)) } };
    html! {
        (DOCTYPE)
        html lang="en" {
            (head("Valve boards", &beyond))
            body {
                h1 { "Valve boards" }
                div.bar {
                    button #stop type="button" { "Stop and vent all" }
                    span #summary role="status" { "no word yet" }
                }
                div #boards {}
                footer { p {
                    "Served by " (recording::TOOL) " on this machine; nothing leaves it. Figures for Prometheus: "
                    a href="metrics" { "metrics" } ", for programs: " a href="fleet.json" { "fleet.json" } "."
                } }
                script src="fleet.js" {}
            }
        }
    }
    .into_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_escaped() {
        assert_eq!(escaped("a \"b\" \\ c\n"), "a \\\"b\\\" \\\\ c\\n");
    }
}
