//! Report of `mgpi identify --joint`: the simulated angle beside the measured one, how stiff the
//! joint may be, and what is known about its parameters.

use identification::joint::{IdentifiedJoint, JointEstimate, Slack};
use maud::html;
use recording::joint::columns::JointRecording;
use recording::joint::file::JointIdentification;
use recording::numbers::{legible, significant};

use super::super::page::{explained, page, reading};
use super::super::plot::{Line, Style};
use super::super::table::{Row, table};
use super::{degrees, over_time, plot};

/// Angles at which the stiffness is drawn.
const ANGLES: usize = 61;
const FIGURES: [&str; 3] = ["rows", "RMSE (degrees)", "RMSE (% of range)"];
const LEFT_OUT: [&str; 5] = ["muscle", "below (bar)", "down to (bar)", "time (s)", "rows"];
const PARAMETERS: [&str; 3] = ["parameter (unit)", "value", "standard error"];

/// The report as an HTML file, for a joint that was identified from a recording.
pub fn to_html(found: &IdentifiedJoint, recording: &JointRecording) -> String {
    let IdentifiedJoint { file, known, simulated_rad, heldout_rad, unseen } = found;
    let JointRecording { time_s, pressures_bar: [a, b], angle_rad, scored, torque_nm, .. } = recording;
    let angle = degrees(angle_rad);
    let simulated = degrees(simulated_rad);
    // What does not count leaves a gap.
    let error = |simulated: &[f64], counts: &[bool]| -> Vec<f64> {
        let rows = simulated.iter().zip(angle_rad).zip(counts);
        rows.map(
            |((simulated, angle), counts)| if *counts { (angle - simulated).to_degrees() } else { f64::NAN },
        )
        .collect()
    };
    let (of_fit, of_unseen) = (error(simulated_rad, scored), error(heldout_rad, unseen));
    let counted: Vec<f64> =
        angle.iter().zip(scored).map(|(angle, is)| if *is { *angle } else { f64::NAN }).collect();
    // What was left out, and gaps elsewhere.
    let mut left_out = vec![f64::NAN; angle.len()];
    for rows in known.slack.iter().map(|slack| slack.rows.clone()) {
        left_out[rows.clone()].copy_from_slice(&angle[rows]);
    }
    let mut angles_over_time =
        vec![("measured", Style::Measured, &*angle), ("simulated", Style::Model, &simulated)];
    if !known.slack.is_empty() {
        angles_over_time.push(("left out", Style::Error, &left_out));
    }
    let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    let sum: Vec<f64> = a.iter().zip(b).map(|(a, b)| a + b).collect();

    let (first, last) = file.parameters.angles;
    let at = |place: usize| first + (last - first) * place as f64 / (ANGLES - 1) as f64;
    let angles: Vec<f64> = (0..ANGLES).map(|place| at(place).to_degrees()).collect();
    let (soft, stiff): (Vec<f64>, Vec<f64>) =
        (0..ANGLES).map(|place| file.joint.stiffness_range(at(place))).unzip();
    let measured = Style::Measured;
    let plots = [
        (
            over_time("Angle over time", "angle (degrees)", time_s, &angles_over_time),
            "Simulated from both pressures and the torque alone. Rows that do not count are shown here, too.",
        ),
        (
            over_time(
                "Error over time: measured less simulated",
                "error (degrees)",
                time_s,
                &[("of the fit", Style::Error, &of_fit), ("held out", Style::Model, &of_unseen)],
            ),
            "Held out: by a model of the other blocks of time. Far more than the error of the fit: record more.",
        ),
        (
            plot(
                "Loops: angle over the difference of both pressures",
                "pressure a - pressure b (bar)",
                "angle (degrees)",
                vec![
                    Line { name: "measured", style: measured, x: &difference, y: &counted },
                    Line { name: "simulated", style: Style::Model, x: &difference, y: &simulated },
                ],
            ),
            "The loops are friction. How wide they are depends on the sum of both pressures.",
        ),
        (
            plot(
                "Where it was recorded",
                "angle (degrees)",
                "pressure a + pressure b (bar)",
                vec![Line { name: "", style: measured, x: &counted, y: &sum }],
            ),
            "Neither muscle is slack within this area, and the controller does not leave it. What it does not cover, the \
             model does not know.",
        ),
        (
            plot(
                "Stiffness that may be asked for",
                "angle (degrees)",
                "stiffness (N m/rad)",
                vec![
                    Line { name: "most", style: measured, x: &angles, y: &stiff },
                    Line { name: "least", style: Style::Error, x: &angles, y: &soft },
                ],
            ),
            "Against a slow swing, nothing else acting. The bounds of the pressures are those of the recording.",
        ),
        (
            over_time(
                "What drove it",
                "pressure (bar)",
                time_s,
                &[("a", measured, a), ("b", Style::Model, b)],
            ),
            "a: the muscle that turns the joint to larger angles.",
        ),
        (
            over_time("Torque from outside", "torque (N m)", time_s, &[("", measured, torque_nm)]),
            "Without a known torque in a part of the recording nothing tells how strong the joint is.",
        ),
    ];
    let JointIdentification { rmse_deg, heldout_rmse_deg, scored_rows, recording: from, .. } =
        &file.identification;
    let range_deg = (last - first).to_degrees();
    let row = |(name, rmse): (&str, f64)| -> Row {
        vec![name.to_owned(), legible(rmse, 4), format!("{:.2}", 100.0 * rmse / range_deg)].into()
    };
    let figures: Vec<Row> =
        [("of the fit", *rmse_deg), ("held out", *heldout_rmse_deg)].into_iter().map(row).collect();
    let or_dash = |error: Option<f64>| error.map_or_else(|| "–".to_owned(), significant);
    let estimates: Vec<Row> = known
        .estimates
        .iter()
        .map(|JointEstimate { name, unit, value, standard_error }| {
            vec![format!("{name} ({unit})"), legible(*value, 4), or_dash(*standard_error)].into()
        })
        .collect();
    let stretches: Vec<Row> = known
        .slack
        .iter()
        .map(|Slack { muscle, below_bar, lowest_bar, rows }| {
            let (from_s, to_s) = (time_s[rows.start], time_s[rows.end - 1]);
            vec![
                ["a", "b"][*muscle].to_owned(),
                format!("{below_bar:.1}"),
                format!("{lowest_bar:.2}"),
                format!("{from_s:.2} to {to_s:.2}"),
                rows.len().to_string(),
            ]
            .into()
        })
        .collect();
    let stiffness = ["least", "largest"].into_iter().zip(known.stiffness);
    let name = recording.source.file.rsplit(['/', '\\']).next().unwrap_or_default();
    let body = html! {
        p.verdict { "Simulated, the angle is off by " (legible(*heldout_rmse_deg, 3)) " degrees, "
            (format!("{:.2}", 100.0 * heldout_rmse_deg / range_deg)) " % of its range, in rows that the model has not seen." }
        (table(&FIGURES.map(str::to_owned), &figures))
        p { (scored_rows) " rows count, at angles of " (format!("{:.2} to {:.2}", first.to_degrees(), last.to_degrees())) " degrees." }
        ul { @for (which, (value, error)) in stiffness {
            li { "In the middle of the angles the " (which) " stiffness is " (legible(value, 2)) " N m/rad"
                @match error {
                    Some(error) => { ", standard error " (significant(error)) " N m/rad." }
                    None => { "; the recording does not tell how sure that is." }
                }
            }
        } }
        (reading(name, &recording.notes))
        @if !stretches.is_empty() {
            h2 { "Left out" }
            p { "In these stretches a muscle's pressure was so low that the torque did not answer to it: the muscle was slack, or the joint at \
                 its end stop, which shows alike. Look where the angle stands still. Times are those of the plots." }
            (table(&LEFT_OUT.map(str::to_owned), &stretches))
        }
        (explained(&plots))
        h2 { "Parameters" }
        p { "A dash: the parameter stands at a bound, or the recording says nothing about it by itself. "
            @if known.memory > 1 {
                "Residuals are correlated over about " (known.memory) " rows, which makes the errors larger. "
            }
            "One of them may hardly be known and the angle and the stiffness still well: what one stop does, its neighbours can do nearly \
             as well." }
        (table(&PARAMETERS.map(str::to_owned), &estimates))
    };
    page(&format!("Joint of {name}"), &body, &format!("Recording with SHA-256 {}", from.sha256))
}
