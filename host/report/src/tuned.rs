//! Report of `mgpi tune`: the loop on its flattest and its steepest slope, and everything between.

use std::f64::consts::PI;

use maud::html;
use num_complex::Complex;
use tuning::{SENSITIVITY, Tuned, feedback};

use super::page::{explained, page};
use super::plot::{Line, Plot, Scale, Style};

/// The report as an HTML file; `source`: the model.
pub fn to_html(found: &Tuned, source: &str) -> String {
    let Tuned { tuning, assumptions, limit, view } = found;
    let acts = feedback(tuning);
    let plants = view.plants(&acts);
    let hz: Vec<f64> = plants.omegas.iter().map(|omega| omega / (2.0 * PI)).collect();
    // The least or the most over all plants, a value a frequency.
    let of = |value: fn(Complex<f64>) -> f64, pick: fn(f64, f64) -> f64| -> Vec<f64> {
        let at = |(k, &omega): (usize, &f64)| {
            let controller = acts.response(omega);
            let all = plants.responses.iter().map(|plant| value(plant[k] * controller));
            all.reduce(pick).unwrap_or(f64::NAN)
        };
        plants.omegas.iter().enumerate().map(at).collect()
    };
    let open = |open: Complex<f64>| open.norm();
    let felt = |open: Complex<f64>| 1.0 / (1.0 + open).norm();
    let (open_least, open_most) = (of(open, f64::min), of(open, f64::max));
    let (felt_least, felt_most) = (of(felt, f64::min), of(felt, f64::max));
    let limit_line = vec![SENSITIVITY; hz.len()];
    let (mut places, mut driven, mut turned) = (Vec::new(), Vec::new(), Vec::new());
    let mut slopes = view.slopes().to_vec();
    slopes.sort_by(|a, b| a.contraction.total_cmp(&b.contraction));
    for slope in &slopes {
        places.push(slope.contraction);
        driven.push(slope.driven);
        turned.push(slope.turned);
    }
    let plot = |title: &str, x: &str, y: &str, scale| Plot {
        title: title.to_owned(),
        x: x.to_owned(),
        y: y.to_owned(),
        scale,
        ..Plot::default()
    };
    let line = |name, style, x, y| Line { name, style, x, y };
    let (most, least) = (Style::Measured, Style::Error);
    let loops = Plot {
        lines: vec![
            line("steepest", most, &hz[..], &open_most[..]),
            line("flattest", least, &hz[..], &open_least[..]),
        ],
        ..plot("Gain of the open loop", "frequency (Hz)", "gain", Scale::Logarithm)
    };
    let sensitivity = Plot {
        lines: vec![
            line("most", most, &hz[..], &felt_most[..]),
            line("least", least, &hz[..], &felt_least[..]),
            line("promised", Style::Model, &hz[..], &limit_line[..]),
        ],
        ..plot("What is felt of a disturbance", "frequency (Hz)", "share", Scale::Logarithm)
    };
    let of_slopes = Plot {
        lines: vec![
            line("driven on", most, &places[..], &driven[..]),
            line("just turned round", least, &places[..], &turned[..]),
        ],
        ..plot("Slopes of the muscle", "contraction", "slope", Scale::Linear)
    };
    let body = html! {
        p { "On every slope of the loop, and where the muscle is as much later or steeper as the recording leaves open, the largest sensitivity is \
             at most " (format!("{:.2}", tuning.maximum_sensitivity)) ", the gain margin at least "
             (format!("{:.1}", tuning.gain_margin)) ", the phase margin at least "
             (format!("{:.0}", tuning.phase_margin_deg)) " degrees. Disturbances are lessened up to "
             (format!("{:.2}", tuning.bandwidth_hz.0)) " to " (format!("{:.2}", tuning.bandwidth_hz.1)) " Hz." }
        p { "What limits it: " (limit.words()) "." }
        @if !assumptions.is_empty() { h2 { "What had to be assumed" } ul { @for assumed in assumptions { li { (assumed) } } } }
        h2 { "The loop" }
        (explained(&[
            (loops, "Above 1 the loop follows. The lines are the most and the least of all that the plant may be."),
            (sensitivity, "Below 1 a disturbance is lessened, above it is made larger: by no more than what is promised."),
            (of_slopes, "What the feedback has to be safe on."),
        ]))
    };
    page("Feedback of a model", &body, &format!("Model {source}"))
}
