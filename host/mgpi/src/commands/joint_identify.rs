//! `mgpi identify --joint`: two muscles at a joint, from a recording to a model.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use recording::Choice;
use recording::joint::columns::JointRecording;
use recording::numbers::significant;
use report::joint::identified::to_html;
use serde_json::{Value, json};

use super::joint_slack::{Places, SlackAt};
use crate::Error;
use crate::output::Outputs;
use identification::joint::{JointEstimate, identify_joint, without_slack};

/// So many slack stretches are said.
const MOST_SAID: usize = 4;

/// What a joint is identified with.
pub struct Arguments<'a> {
    /// At least one.
    pub recordings: &'a [PathBuf],
    pub choice: Choice,
    pub swing_deg: f64,
    pub model_file: &'a Path,
    pub report: Option<&'a Path>,
    pub json: Option<&'a Path>,
}

/// Identifies a joint.
///
/// # Errors
/// The recording is not what it should be, no joint can be made of it, or an output cannot be
/// written.
pub fn run(arguments: &Arguments<'_>, mut outputs: Outputs) -> Result<(), Error> {
    let Arguments { recordings: files, choice, swing_deg, model_file, report, json } = arguments;
    let read = |file: &PathBuf| -> Result<JointRecording, Error> {
        let recording = JointRecording::of(&choice.table(file)?, choice)?;
        for note in &recording.notes {
            eprintln!("note: {}: {note}", recording::input::name(file));
        }
        Ok(recording)
    };
    let recordings = files.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let places = Places::of(&recordings, files);
    let Some(recording) = recordings.into_iter().reduce(JointRecording::followed_by) else {
        return Err(Error::Usage("--joint takes a recording".to_owned()));
    };
    let file = &recording.source.file;
    let identified = identify_joint(&recording, swing_deg * PI / 180.0)
        .map_err(|source| Error::Joint { file: file.into(), source })?;
    let (found, known) = (&identified.file, &identified.known);
    let slack: Vec<SlackAt<'_>> = known.slack.iter().map(|slack| places.slack(slack)).collect();
    outputs.stage(model_file, found.to_toml().as_bytes())?;
    if let Some(page) = report {
        let taut = without_slack(&recording, &known.slack);
        outputs.stage(page, to_html(&identified, &taut).as_bytes())?;
    }
    let (lowest, highest) = found.parameters.angles;
    let degrees = |angle: f64| angle * 180.0 / PI;
    let range_deg = degrees(highest - lowest);
    let [(soft, of_soft), (stiff, of_stiff)] = known.stiffness;
    let identification = &found.identification;
    let estimate = |estimate: &JointEstimate| {
        let JointEstimate { name, unit, value, standard_error } = estimate;
        json!({ "name": name, "unit": unit, "value": value, "standard_error": standard_error })
    };
    let parameters: Vec<Value> = known.estimates.iter().map(estimate).collect();
    if let Some(figures) = json {
        let value = json!({
            "rmse_deg": identification.rmse_deg,
            "heldout_rmse_deg": identification.heldout_rmse_deg,
            "range_deg": range_deg,
            "scored_rows": identification.scored_rows,
            "softest_nm_per_rad": soft,
            "stiffest_nm_per_rad": stiff,
            "softest_standard_error": of_soft,
            "stiffest_standard_error": of_stiff,
            "parameters": parameters,
            "slack": slack.iter().map(SlackAt::to_json).collect::<Vec<_>>(),
        });
        outputs.stage(figures, format!("{value:#}\n").as_bytes())?;
    }
    outputs.commit()?;
    let share = |deg: f64| format!("{deg:.4} degrees ({:.2} % of range)", 100.0 * deg / range_deg);
    say!("joint         {} rows that count, from {file}", identification.scored_rows);
    for slack in slack.iter().take(MOST_SAID) {
        say!("slack         {}", slack.in_words());
    }
    if let Some(more) = slack.get(MOST_SAID..).filter(|more| !more.is_empty()) {
        let rows: usize = more.iter().map(|slack| slack.slack.rows.len()).sum();
        say!("slack         and {} stretches more, {rows} rows; --json has them all", more.len());
    }
    say!("angles        {:.2} to {:.2} degrees", degrees(lowest), degrees(highest));
    say!("training      RMSE of the simulated angle {}", share(identification.rmse_deg));
    say!("held out      RMSE {} (blocks all through the recording)", share(identification.heldout_rmse_deg));
    let sure = |value: f64, error: Option<f64>| match error {
        Some(error) => format!("{value:.1} ± {}", significant(error)),
        None => format!("{value:.1}"),
    };
    say!(
        "stiffness     {} to {} N m/rad in the middle (± standard errors), for a swing of {swing_deg} degrees to either side",
        sure(soft, of_soft),
        sure(stiff, of_stiff)
    );
    let [a, b] = &found.parameters.muscles;
    say!("valves        lag of {:.4} s and {:.4} s", a.valve_lag_s, b.valve_lag_s);
    Ok(())
}
