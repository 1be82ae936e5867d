//! The two models beside each other, on one scale: without and with the named causes.

use maud::{Markup, html};

use super::view::View;
use super::{Gained, evidence, with_unit};
use crate::bars::{Bar, Mark, bars};
use crate::page::explained;
use crate::plot::Style;
use diagnosis::{Columns, Verdict};
use recording::numbers::range;

/// What two models simulate, a value a scored row as [`View`] has them, and how they err. Output
/// unit.
struct Compared {
    names: [String; 2],
    /// Name and unit of the input that both simulate from, and its values.
    input: (String, Vec<f64>),
    simulated: [Vec<f64>; 2],
    residuals: [Vec<f64>; 2],
    /// Root mean square error over the rows that are drawn, and over the held-out ones.
    errors: [[f64; 2]; 2],
}

impl Compared {
    fn new(view: &View<'_>, columns: &Columns, gained: Option<&Gained<'_>>) -> Self {
        let answers = gained.and_then(|gained| gained.extended.answers(columns));
        let (simulated, command) = match answers {
            Some(answers) => {
                ([view.rows(&answers.plain), view.rows(&answers.extended)], answers.from_command)
            }
            None => {
                let residuals = [&view.diagnosis.residual_before, &view.diagnosis.residual_after];
                (residuals.map(|residual| view.measured_less(&view.scored(residual))), None)
            }
        };
        let residuals = [view.measured_less(&simulated[0]), view.measured_less(&simulated[1])];
        let heldout =
            gained.map_or(view.diagnosis.heldout, |gained| (gained.gain.before.rmse, gained.gain.after.rmse));
        let what = if gained.is_some() { "operator model" } else { "flexible hysteresis" };
        let causes: Vec<_> = view.diagnosis.causes.iter().map(|named| named.cause).collect();
        Self {
            names: [format!("{what} alone"), format!("{what} with {}", evidence::name(&causes))],
            errors: [
                [root_mean_square(&residuals[0]), heldout.0],
                [root_mean_square(&residuals[1]), heldout.1],
            ],
            input: match command {
                Some(command) => (format!("command ({})", columns.input_unit), view.rows(&command)),
                None => (view.input_axis(), view.input.clone()),
            },
            simulated,
            residuals,
        }
    }
}

/// The section of the report.
pub fn section(view: &View<'_>, columns: &Columns, gained: Option<&Gained<'_>>) -> Markup {
    if view.diagnosis.causes.is_empty() {
        return html! {
            h2 { "After" }
            p { "No cause is named, so nothing is added to the model." }
        };
    }
    let compared = Compared::new(view, columns, gained);
    let Compared { names: [without, with], input, simulated, residuals, errors } = &compared;
    let outputs = [&view.measured, &simulated[0], &simulated[1]].map(range);
    let low = outputs.iter().fold(f64::INFINITY, |low, output| low.min(output.0));
    let high = outputs.iter().fold(f64::NEG_INFINITY, |high, output| high.max(output.1));
    let looped = |name, simulated| {
        let mut plot = view.loops(format!("Loop: {name}"), (input.0.clone(), &input.1), (name, simulated));
        plot.reaches = Some((low, high));
        plot
    };
    let plots = [
        (
            view.output_over_time(
                "Output: before and after",
                vec![
                    view.line("measured", Style::Measured, &view.measured),
                    view.line(without, Style::Ink, &simulated[0]),
                    view.line(with, Style::Model, &simulated[1]),
                ],
            ),
            "Measured, and both models. Their root mean square errors here are the upper bars.",
        ),
        (
            view.errors_over_time(
                "Error: before and after",
                vec![
                    view.line(without, Style::Ink, &residuals[0]),
                    view.line(with, Style::Model, &residuals[1]),
                ],
            ),
            "What the named causes take away, and what they leave.",
        ),
        (
            looped(without, &simulated[0]),
            "Before. Where the two lines part, something is missing in the model.",
        ),
        (
            looped(with, &simulated[1]),
            "After, on the same scale. What is left between the lines is not explained.",
        ),
    ];
    let names = ["all scored rows, as drawn below", "held-out rows"];
    let is_named = super::are_causes_named(view.diagnosis.verdict);
    let groups: Vec<Bar<'_>> = [(without, &errors[0], false), (with, &errors[1], is_named)]
        .map(|(name, values, is_chosen)| Bar { name, values, is_chosen })
        .into_iter()
        .collect();
    let noise = view.diagnosis.anatomy.noise.deviation;
    let mark = Mark { name: "noise of the sensor", value: noise };
    html! {
        @if view.diagnosis.verdict == Verdict::Unexplained { h2 { "With the causes that go farthest" } }
        @else { h2 { "After: with the named causes" } }
        (what_is_compared(&compared, gained))
        (bars(&format!("Root mean square error ({})", view.unit()), &names, &groups, Some(&mark)))
        p {
            (gain_in_words([errors[0][1], errors[1][1]], noise))
            @if let Some(Gained { gain, .. }) = gained {
                " (standard error of the difference " (with_unit(gain.gain_error, view.unit())) ")"
            }
            "."
            @if gained.is_some_and(|gained| !gained.gain.is_sure()) {
                " Chance may do as much: try the extended model on another recording before it is used for one."
            }
        }
        (explained(&plots))
    }
}

fn what_is_compared(compared: &Compared, gained: Option<&Gained<'_>>) -> Markup {
    html! { p {
        @match gained {
            Some(Gained { gain, other, .. }) => {
                "Both models are of the kind that runs on the board, and simulate from the " (compared.input.0)
                " and the recorded columns alone, never from the measured output. Held out are "
                @match (other, gain.from_s) {
                    (Some(other), _) => { "the rows of " (other) ", which took no part in anything." }
                    (None, Some(from_s)) => {
                        "the rows from " (format!("{from_s:.0}")) " s on, by models of the rows before."
                    }
                    (None, None) => {
                        "stretches all through the recording, by models of the rows between, since its first two thirds \
                         do not move the input both ways or its last third hardly moves it."
                    }
                }
            }
            None => { "The flexible hysteresis with the named causes added, fitted together. Held out are blocks of time that the \
                fit has not seen." }
        }
    } }
}

/// What the held-out error without and with the causes comes to, above the noise.
fn gain_in_words([before, after]: [f64; 2], noise: f64) -> String {
    if after >= before {
        "That is no gain: on held-out rows the model is no better with the causes than without".to_owned()
    } else if after <= noise {
        "That is all that could be gained on held-out rows, down to the noise of the sensor".to_owned()
    } else {
        let share = 100.0 * (before - after) / (before - noise);
        format!(
            "Of what could be gained on held-out rows, down to the noise of the sensor, that is {share:.0} %"
        )
    }
}

/// Of the values that are numbers.
fn root_mean_square(values: &[f64]) -> f64 {
    let (sum, count) = values
        .iter()
        .filter(|value| value.is_finite())
        .fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_gain_is_above_what_could_be_gained() {
        let words = |before, after| gain_in_words([before, after], 0.1);
        assert!(words(1.1, 0.6).ends_with("50 %"), "{}", words(1.1, 0.6));
        assert!(words(1.1, 0.05).contains("all that could be gained"));
        assert!(words(0.05, 0.04).contains("all that could be gained"));
        assert!(words(1.0, 1.2).contains("no gain"));
    }
}
