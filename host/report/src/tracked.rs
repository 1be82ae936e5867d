//! Report of a reference tracked by the firmware: how near the muscle came, and what drove the
//! valve.

use maud::{Markup, html};

use super::bars::{Bar, bars};
use super::page::{explained, page};
use super::tracking::Tracking;
use board_client::pil::lock_step::Run;

/// What percentages refer to: a stroke, or another length.
#[derive(Clone, Copy, Debug)]
pub struct Stroke {
    /// Unit: mm.
    pub mm: f64,
    /// Whose it is.
    pub whose: &'static str,
}

/// A run with its name.
struct Named {
    name: String,
    tracking: Tracking,
}

/// The report as an HTML file, for runs by their names in the results; `source`: what was tracked,
/// with what.
pub fn to_html(runs: &[(&str, &Run)], stroke: Stroke, source: &str) -> String {
    let overruns: u32 = runs.iter().map(|(_, run)| run.overruns).sum();
    let runs: Vec<Named> = runs
        .iter()
        .map(|(name, run)| Named { name: in_words(name), tracking: Tracking::of_run(run) })
        .collect();
    let times = match runs.len() {
        1 => "once".to_owned(),
        count => format!("{count} times"),
    };
    let body = html! {
        p { "The firmware tracked the reference " (times) "; " (overruns) " ticks were late. Percentages refer to "
            (stroke.whose) ", " (format!("{:.1}", stroke.mm)) " mm." }
        (figures(&runs, stroke))
        @for Named { name, tracking } in &runs {
            h2 { (name) }
            div.run {
                (tracking.stack(name))
                (explained(&[
                    (tracking.linearity(&format!("{name}: desired and actual contraction")), "On the dashed line both are equal."),
                    (tracking.loops(&format!("{name}: loop of the muscle")), "The hysteresis that the controller drives it around."),
                ]))
            }
        }
        p { "An error that comes back in every cycle, the model has wrong. Where the feedback is small beside the feed-forward, \
            the model does the work." }
    };
    page("Tracking by the firmware", &body, source)
}

/// What drove the valve in a run.
fn in_words(name: &str) -> String {
    match name {
        "tracking" => "Feed-forward and feedback",
        "feedforward_only" => "Feed-forward alone",
        "feedback_only" => "Feedback alone",
        other => other,
    }
    .to_owned()
}

fn figures(runs: &[Named], stroke: Stroke) -> Markup {
    let figures: Vec<[f64; 2]> = runs
        .iter()
        .map(|run| run.tracking.figures())
        .map(|figures| [figures.rmse, figures.max_error])
        .collect();
    let groups: Vec<Bar<'_>> = runs
        .iter()
        .zip(&figures)
        .map(|(run, values)| Bar { name: &run.name, values, is_chosen: false })
        .collect();
    html! {
        (bars("How far the muscle is from its reference (mm)", &["root mean square", "largest"], &groups, None))
        ul { @for (run, [rmse, _]) in runs.iter().zip(&figures) {
            li { (run.name) ": root mean square " (format!("{:.2}", 100.0 * rmse / stroke.mm)) " % of " (stroke.whose) }
        } }
    }
}
