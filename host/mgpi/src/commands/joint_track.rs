//! `mgpi track --joint`: a board with two channels, at its service link, follows a reference.

use std::path::Path;

use board_client::joint::link::Address;
use board_client::joint::log::{COLUMNS, row};
use board_client::joint::run::PERIOD_S;
use board_client::joint::track::{Course, track};
use board_client::joint::{JointSample, parameters, settings};
use board_client::part::Part;
use board_client::stop::Stop;
use recording::Choice;

use super::duration_bar::bar;
use super::joint_board::{BoardArguments, note_unkept};
use super::joint_run::Asked;
use crate::Error;
use crate::output::Outputs;

/// What a joint is tracked with.
pub struct Arguments<'a> {
    pub model: &'a Path,
    pub reference: &'a Path,
    pub choice: Choice,
    pub address: Address,
    pub board: &'a BoardArguments,
    pub every: u16,
    pub log: Option<&'a Path>,
    pub report: Option<&'a Path>,
    pub json: Option<&'a Path>,
    pub force: bool,
}

/// Tracks.
///
/// # Errors
/// A file is not what it should be, the board is not one of a joint, refuses or vents, the joint is
/// not the model's, an output cannot be written, or the user interrupts.
pub fn run(arguments: &Arguments<'_>, mut outputs: Outputs) -> Result<(), Error> {
    let Arguments { model, reference, choice, address, board, every, log, .. } = arguments;
    let asked = Asked::read(model, reference, choice, PERIOD_S.recip())?;
    let control = parameters(&asked.file.parameters, PERIOD_S)?;
    let settings = board.settings()?;
    let mut link = board.open(address)?;
    if let Some(settings) = &settings {
        settings::give(&mut link, settings)?;
    }
    let mut part = log.map(|log| Part::begin(log, COLUMNS, arguments.force)).transpose()?;
    let stop = Stop::on_signals();
    let duration_s = (asked.wanted.len() - 1) as f64 * PERIOD_S;
    let bar = bar(duration_s);
    bar.set_message("the board fills and tries the joint");
    let mut samples: Vec<JointSample> = Vec::new();
    let course = Course { wanted: &asked.wanted, every: *every };
    let tracked = track(&mut link, &control, &course, &stop, &mut |sample| {
        if let Some(part) = &mut part {
            part.add(&row(sample))?;
        }
        bar.set_position((1e3 * sample.time_s) as u64);
        bar.set_message(live(sample));
        samples.push(*sample);
        Ok(())
    });
    bar.finish_and_clear();
    note_unkept(&link);
    let tracked = match tracked {
        Ok(tracked) => tracked,
        Err(error) => {
            if let Some(kept) = part.and_then(Part::keep) {
                eprintln!("what was tracked is kept in {}", kept.display());
            }
            return Err(error.into());
        }
    };
    let grown = part.map(Part::finish).transpose()?;
    if let (Some(file), Some(grown)) = (log, &grown) {
        outputs.stage(file, &grown.content)?;
    }
    let others = [
        ("every", tracked.every.into()),
        ("missed", tracked.missed.into()),
        ("late_ticks", tracked.late_ticks.into()),
    ];
    asked.finish(&samples, &others, (arguments.report, arguments.json), outputs)?;
    if let Some(grown) = grown {
        grown.remove();
    }
    say!("log           {}", tracked.in_words());
    Ok(())
}

/// A moment in a line.
fn live(sample: &JointSample) -> String {
    let JointSample { time_s, wanted, measured, reply, .. } = sample;
    let [a, b] = measured.pressures_bar;
    let (angle, error) = (measured.angle_deg, measured.angle_deg - wanted.angle_deg);
    let stiffness = reply.stiffness;
    format!(
        "{time_s:.1} s {angle:.1} degrees, error {error:+.2}, {stiffness:.0} N m/rad, {a:.2} and {b:.2} bar"
    )
}
