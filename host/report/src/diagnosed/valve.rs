//! The valve between command and pressure: what was recorded, and what the found valve makes of the
//! command.

use maud::{Markup, html};

use super::view::View;
use super::with_unit;
use crate::bars::{Bar, bars};
use crate::page::explained;
use crate::plot::{Line, Plot, Style};
use diagnosis::valve::{BandForm, Valve, ValveFit};
use diagnosis::{Columns, Verdict};
use recording::numbers::legible;

/// The section of the report; nothing where the command was not recorded beside the pressure.
pub fn section(view: &View<'_>, columns: &Columns) -> Markup {
    let Some((fit, command)) = view.diagnosis.valve.as_ref().zip(columns.command.as_ref()) else {
        return html! {};
    };
    let pressure = format!("pressure ({})", fit.unit);
    let simulated = view.rows(&fit.valve.simulate(columns.input[0], &columns.time_s, command));
    let (command, measured) = (view.rows(command), &view.input);
    let less =
        |simulated: &[f64]| -> Vec<f64> { measured.iter().zip(simulated).map(|(a, b)| a - b).collect() };
    let (residual_ideal, residual) = (less(&command), less(&simulated));
    let over_command = |name, style, y| Line { name, style, x: &command, y };
    let plots = [
        (
            view.over_time(
                "Valve: command and pressure",
                pressure.clone(),
                vec![
                    view.line("measured pressure", Style::Measured, measured),
                    view.line("command", Style::Ink, &command),
                    view.line("simulated from the command", Style::Model, &simulated),
                ],
            ),
            "What the valve was told, what it did, and what the valve as it was found does with the command.",
        ),
        (
            view.over_time(
                "Valve: error of the pressure",
                format!("error of the {pressure}"),
                vec![
                    view.line("ideal valve", Style::Ink, &residual_ideal),
                    view.line("valve as found", Style::Model, &residual),
                ],
            ),
            "Measured less simulated: of a valve that does at once what it is told, and of the one that was found.",
        ),
        (
            Plot {
                title: "Valve: pressure over command".to_owned(),
                x: format!("command ({})", fit.unit),
                y: pressure.clone(),
                lines: vec![
                    over_command("measured", Style::Measured, measured),
                    over_command("simulated from the command", Style::Model, &simulated),
                ],
                ..Plot::default()
            },
            "A lag opens a loop that grows with the speed; a dead band makes steps; a supply that is too low cuts off the top.",
        ),
    ];
    html! {
        h2 { "The valve" }
        p { "Command and pressure were both recorded, so the valve is judged between them, and the muscle from the pressure. Found: "
            (in_words(fit)) "." }
        (errors(fit, view.diagnosis.verdict))
        (explained(&plots))
    }
}

fn errors(fit: &ValveFit, verdict: Verdict) -> Markup {
    let is_named = super::are_causes_named(verdict) && !fit.named.is_empty();
    let (ideal, found) = ([fit.ideal_rmse_bar], [fit.rmse_bar]);
    let groups = [
        Bar { name: "ideal valve: does at once what it is told", values: &ideal, is_chosen: false },
        Bar { name: "valve as found", values: &found, is_chosen: is_named },
    ];
    bars(&format!("Root mean square error of the pressure ({})", fit.unit), &[], &groups, None)
}

/// A valve's parameters.
fn in_words(ValveFit { valve, unit, .. }: &ValveFit) -> String {
    let unit = unit.symbol();
    let band = valve.band.map(|(form, band)| {
        let form = match form {
            BandForm::Hold | BandForm::HoldBetween => {
                "a dead band that ignores smaller changes of the command than"
            }
            BandForm::Backlash => "a backlash of",
        };
        format!("{form} {}", with_unit(band, unit))
    });
    [
        Some(lag_in_words(valve)),
        valve.delay_s.map(|delay_s| format!("a delay of {}", with_unit(delay_s, "s"))),
        band,
        valve.supply_bar.map(|supply_bar| format!("a supply of {}", with_unit(supply_bar, unit))),
    ]
    .into_iter()
    .flatten()
    .collect::<Vec<_>>()
    .join(", ")
}

/// One lag, two, or one that overshoots.
fn lag_in_words(valve: &Valve) -> String {
    let longer_s = valve.longer_lag_s();
    match valve.damping_ratio {
        Some(ratio) if ratio < 1.0 => {
            format!(
                "a lag of the second order of {}, damping ratio {}",
                with_unit(longer_s, "s"),
                legible(ratio, 2)
            )
        }
        Some(_) => {
            let shorter_s = valve.lag_s - longer_s;
            format!("a lag of {} and one of {}", with_unit(longer_s, "s"), with_unit(shorter_s, "s"))
        }
        None => format!("a lag of {}", with_unit(longer_s, "s")),
    }
}
