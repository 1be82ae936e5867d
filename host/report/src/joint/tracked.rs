//! Report of `mgpi pil --joint`: angle and stiffness by the firmware of two channels.

use board_client::joint::JointSample;
use board_client::joint::log::{figures, limited};
use maud::{Markup, html};
use recording::numbers::legible;

use super::super::page::{explained, page};
use super::super::plot::{Height, Plot, Style};
use super::over_time;

/// The report as an HTML file, for a run; `range_deg`: what percentages refer to, the model's range
/// of angles; `source`: what was tracked, with what.
pub fn to_html(samples: &[JointSample], range_deg: f64, source: &str) -> String {
    let of = |value: fn(&JointSample) -> f64| -> Vec<f64> { samples.iter().map(value).collect() };
    let time_s = of(|sample| sample.time_s);
    let wanted = of(|sample| sample.wanted.angle_deg);
    let due = of(|sample| f64::from(sample.reply.due_rad).to_degrees());
    let angle = of(|sample| sample.measured.angle_deg);
    let error = of(|sample| sample.wanted.angle_deg - sample.measured.angle_deg);
    let (asked, stiffness) =
        (of(|sample| sample.wanted.stiffness), of(|sample| sample.reply.stiffness.into()));
    let feedback = of(|sample| sample.reply.feedback_nm.into());
    let [pressure_a, pressure_b] =
        [of(|sample| sample.measured.pressures_bar[0]), of(|sample| sample.measured.pressures_bar[1])];
    let [command_a, command_b] =
        [of(|sample| sample.commands_bar[0].into()), of(|sample| sample.commands_bar[1].into())];
    let (measured, model) = (Style::Measured, Style::Model);
    let stack = [
        over_time(
            "Angle",
            "angle (degrees)",
            &time_s,
            &[("actual", measured, &angle), ("due", Style::Error, &due), ("reference", model, &wanted)],
        ),
        over_time(
            "Error of the angle: reference less actual",
            "error (degrees)",
            &time_s,
            &[("", Style::Error, &error)],
        ),
        over_time(
            "Stiffness",
            "stiffness (N m/rad)",
            &time_s,
            &[("due", measured, &stiffness), ("reference", model, &asked)],
        ),
        over_time(
            "Muscle a",
            "pressure (bar)",
            &time_s,
            &[("measured", measured, &pressure_a), ("command", model, &command_a)],
        ),
        over_time(
            "Muscle b",
            "pressure (bar)",
            &time_s,
            &[("measured", measured, &pressure_b), ("command", model, &command_b)],
        ),
    ];
    let beside = [(
        over_time("Torque of the feedback", "torque (N m)", &time_s, &[("", Style::Error, &feedback)]),
        "What the model and the unknown torques leave to the feedback: small beside the torques of the muscles, the model \
         does the work.",
    )];
    let figures = figures(samples);
    let share =
        |deg: f64| format!("{} degrees, {:.2} % of the range", legible(deg, 3), 100.0 * deg / range_deg);
    let body = html! {
        p.verdict { "The angle is off by " (share(figures.rmse)) " (root mean square), by " (legible(figures.max_error, 3))
            " degrees at most." }
        (limits(samples))
        p { "Due is the reference as fast as the controller allows it: steps become ramps. The stiffness is that of the model; nothing \
             measures it." }
        div.run {
            div.stack { @for plot in stack { (Plot { height: Height::Low, ..plot }.figure()) } }
            (explained(&beside))
        }
    };
    page("A joint by the firmware of two channels", &body, source)
}

/// How often the pressures' bounds were in the way.
fn limits(samples: &[JointSample]) -> Markup {
    let [angle, stiffness] = limited(samples);
    html! {
        @if angle + stiffness > 0 {
            p { "Bounds of the pressures, or the slew rate, kept the angle from being reached in " (angle) ", the stiffness in "
                (stiffness) " of " (samples.len()) " ticks." }
        }
    }
}
