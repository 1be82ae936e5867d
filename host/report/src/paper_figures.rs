//! Figs. 8, 11, 12 and 13 of the paper, redrawn from an own recording, model and tracking run.

use maud::{Markup, html};

use super::model_run::ModelRun;
use super::page::page;
use super::plot::Plot;
use super::tracking::Tracking;
use recording::Recording;
use recording::numbers::legible;

/// The report as an HTML file. `simulated`: the model's output for every row of the recording,
/// output unit.
pub fn to_html(recording: &Recording, simulated: &[f64], tracking: &Tracking, source: &str) -> String {
    let run = ModelRun::new(recording, simulated);
    let (fit, stroke) = (recording.figures(simulated), recording.stroke());
    let model = [
        run.input("(a) Input"),
        run.loops("(b) Hysteresis loops"),
        run.output("(c) Length"),
        run.error("(d) Error"),
    ];
    let responses = [tracking.response("(a) Trajectory tracking response"), tracking.error("(b) Error")];
    let loops = [tracking.loops("Length-pressure loops of the muscle while it tracks")];
    let linearity = [tracking.linearity("Desired and actual length")];
    let unit = recording.output.channel.unit;
    let missed = tracking.figures();
    let body = html! {
        (section("Fig. 8: the model beside the recording", &model))
        p { "The model's figures: " (fit.in_words(stroke, unit)) "." }
        (section("Fig. 11: tracking with the inverse model and feedback", &responses))
        p { "Tracking: " (missed.in_words(stroke, unit)) "." }
        h2 { "What drove the valve" }
        (tracking.stack("Tracking"))
        (section("Fig. 12: loops while tracking", &loops))
        p { "The hysteresis that the controller drives the muscle around." }
        (section("Fig. 13: desired and actual length", &linearity))
        p { "On the dashed line both are equal; what is left of the hysteresis is at most "
            (legible(missed.max_error, 3)) " " (unit) " from it." }
    };
    page("The paper's figures from own measurements", &body, source)
}

fn section(title: &str, plots: &[Plot<'_>]) -> Markup {
    html! {
        h2 { (title) }
        div.plots { @for plot in plots { (plot.figure()) } }
    }
}
