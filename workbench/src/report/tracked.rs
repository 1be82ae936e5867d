//! Report of a reference tracked by the firmware: how near the muscle came, with feed-forward and feedback, and with either.

use maud::{Markup, html};

use super::bars::{Bar, bars};
use super::page::{explained, page};
use super::tracking::Tracking;
use crate::pil::lock_step::Run;

/// The report as an HTML file, for runs by their names, of which the first is shown whole. `stroke_mm`: that of the
/// model, which percentages refer to; `source`: what was tracked, with what.
pub fn to_html(runs: &[(&str, &Run)], stroke_mm: f64, source: &str) -> String {
    let runs: Vec<(String, u32, Tracking)> = runs
        .iter()
        .map(|(name, run)| (name.replace('_', " "), run.overruns, Tracking::of_run(run)))
        .collect();
    let [(_, _, whole), others @ ..] = &runs[..] else { return page("No run", &html! {}, source) };
    let response = [
        (whole.response("Tracking: over time"), "What the muscle should do, and what it does."),
        (whole.error("Tracking: error over time"), "What comes back in every cycle, the model has wrong."),
        (whole.linearity("Desired and actual contraction"), "On the dashed line both are equal."),
        (whole.loops("The loop of the muscle"), "The hysteresis that the controller drives it around."),
    ];
    let errors: Vec<_> = others
        .iter()
        .map(|(name, _, tracking)| {
            (tracking.error(&format!("Error, {name}")), "The same reference, without the other half.")
        })
        .collect();
    let overruns: u32 = runs.iter().map(|(_, overruns, _)| overruns).sum();
    let body = html! {
        p { "The firmware tracked the same reference " (runs.len()) " times, late " (overruns) " times. Per cent refer to the "
            "model's stroke of " (format!("{stroke_mm:.1}")) " mm." }
        (figures(&runs, stroke_mm))
        h2 { "With feed-forward and feedback" }
        (explained(&response))
        h2 { "With either alone" }
        (explained(&errors))
    };
    page("Tracking by the firmware", &body, source)
}

fn figures(runs: &[(String, u32, Tracking)], stroke_mm: f64) -> Markup {
    let values: Vec<[f64; 2]> = runs
        .iter()
        .map(|(_, _, tracking)| tracking.figures())
        .map(|figures| [figures.rmse, figures.max_error])
        .collect();
    let groups: Vec<Bar<'_>> = runs
        .iter()
        .zip(&values)
        .map(|((name, _, _), values)| Bar { name, values, is_chosen: false })
        .collect();
    html! {
        (bars("How far the muscle is from its reference (mm)", &["root mean square", "largest"], &groups, None))
        ul { @for ((name, _, _), [rmse, _]) in runs.iter().zip(&values) {
            li { (name) ": " (format!("{:.2}", 100.0 * rmse / stroke_mm)) " % of the stroke" }
        } }
    }
}
