//! `mgpi capture --joint`: both pressures through a board with two channels, and a recording of
//! what the joint does.

use std::path::Path;

use board_client::growing::{Growing, head};
use board_client::joint::excitation::Excitation;
use board_client::joint::link::Address;
use board_client::joint::record::{JointRow, record};
use board_client::joint::run::PERIOD_S;
use board_client::joint::seam::seam;
use board_client::joint::settings;
use board_client::stop::Stop;
use clap::Args;
use recording::joint::columns::COLUMNS;
use recording::{Choice, TOOL};
use rig::joint::protocol::{JointProtocol, JointRange};

use super::duration_bar::bar;
use super::joint_board::{BoardArguments, note_unkept};
use super::kept::keep;
use super::number::{positive, share};
use crate::Error;
use crate::output::Outputs;

/// What is asked of a joint beside what is of a muscle.
#[derive(Args, Debug)]
#[command(next_help_heading = "Joint")]
pub struct JointArguments {
    /// Record two muscles at a joint, by a board with two channels at its service link: a full
    /// swing, then triangles and small swings at five common pressures, and ramps
    #[arg(long, conflicts_with_all = ["http", "unit", "parity"])]
    joint: bool,
    /// Lowest command of a joint in bar: where both muscles are still taut
    #[arg(long, default_value_t = 1.8, value_name = "BAR", value_parser = positive, requires = "joint", conflicts_with = "excitation")]
    min_bar: f64,
    /// Largest difference of a joint's commands to what they have in common, as a share of it
    #[arg(long, default_value_t = 0.22, value_name = "SHARE", value_parser = share, requires = "joint", conflicts_with = "excitation")]
    swing: f64,
    /// Known torque on the joint in N m, towards larger angles, of a weight that hangs at it all
    /// through the recording
    #[arg(long, default_value_t = 0.0, value_name = "NM", allow_hyphen_values = true, requires = "joint")]
    torque_newton_metre: f64,
    #[command(flatten)]
    board: BoardArguments,
}

/// What any muscle is recorded with.
pub struct Arguments<'a> {
    pub joint: &'a JointArguments,
    /// What is played instead of the excitation of its own.
    pub excitation: Option<&'a Path>,
    pub choice: Choice,
    pub recording: &'a Path,
    pub max_bar: f64,
    pub duration_s: Option<f64>,
    pub every: u16,
    pub address: Address,
    pub resume: bool,
    pub force: bool,
}

impl JointArguments {
    /// Whether it is a joint.
    pub fn is_meant(&self) -> bool {
        self.joint
    }
}

/// Captures.
///
/// # Errors
/// There is no such excitation, the board is not one of a joint, refuses or vents, the recording
/// cannot be written, or the user interrupts.
pub fn run(arguments: Arguments<'_>, mut outputs: Outputs) -> Result<(), Error> {
    let Arguments { joint, recording: file, every, address, resume, force, .. } = &arguments;
    let (excitation, words) = arguments.excitation()?;
    let settings = joint.board.settings()?;
    let mut link = joint.board.open(address)?;
    if let Some(settings) = &settings {
        settings::give(&mut link, settings)?;
        note_unkept(&link);
    }
    let [major, minor, patch] = link.hello().firmware;
    let comments = [
        format!("recorded by {TOOL} from a board of a joint, firmware {major}.{minor}.{patch}"),
        format!("excitation: {words}; a row each {every} ticks of 1 ms"),
    ];
    let head = head(&comments, COLUMNS);
    let (mut growing, excitation, from_s) = match resume {
        true => {
            let mut next = 0;
            let (growing, seam) = Growing::resume(file, &head, |reached| {
                let (seam, tick) = seam(&excitation, reached);
                next = tick;
                seam
            })?;
            (growing, if next > 0 { excitation.from_tick(next) } else { excitation }, seam.from_s)
        }
        false => (Growing::begin(file, &head, *force)?, excitation, 0.0),
    };
    let duration_s = from_s + excitation.duration_s();
    let bar = bar(duration_s);
    let stop = Stop::on_signals();
    let recorded = record(&mut link, &excitation, &stop, &mut |row: &JointRow| {
        let row = JointRow { time_s: row.time_s + from_s, ..*row };
        bar.set_position((1e3 * row.time_s) as u64);
        let [a, b] = row.measured.pressures_bar;
        let (time_s, angle_deg) = (row.time_s, row.measured.angle_deg);
        bar.set_message(format!(
            "{time_s:.1} of {duration_s:.1} s, {a:.2} and {b:.2} bar, {angle_deg:.1} degrees"
        ));
        Ok(growing.add(&row.to_csv())?)
    });
    bar.finish_and_clear();
    let recorded = match recorded {
        Ok(recorded) => recorded,
        Err(error) => {
            keep(growing);
            return Err(error.into());
        }
    };
    let grown = growing.finish()?;
    outputs.stage(file, &grown.content)?;
    outputs.commit()?;
    grown.remove();
    say!("{}: {}", file.display(), recorded.in_words());
    Ok(())
}

impl Arguments<'_> {
    /// What is played, and what it is.
    fn excitation(&self) -> Result<(Excitation, String), Error> {
        let &JointArguments { min_bar, swing, torque_newton_metre: torque_nm, .. } = self.joint;
        let max_bar = self.max_bar;
        if !torque_nm.is_finite() {
            return Err(Error::Usage(format!("--torque-newton-metre is {torque_nm}, must be a number")));
        }
        if let Some(file) = self.excitation {
            let (excitation, sha256) = Excitation::read(file, &self.choice, torque_nm, self.every)?;
            let words = format!("{}, SHA-256 {sha256}, torque {torque_nm} N m", file.display());
            return Ok((excitation, words));
        }
        let range = JointRange { min_bar, max_bar, swing };
        let protocol = JointProtocol::without_weights(&range, self.duration_s).ok_or_else(|| {
            Error::Usage(format!(
                "--min-bar {min_bar} and --max-bar {max_bar}: no common pressure in between leaves room for a swing by a \
                 share of {swing}; the highest has to be more than {:.2} bar",
                min_bar * (1.0 + swing) / (1.0 - swing)
            ))
        })?;
        let duration_s = protocol.duration_s();
        let ticks = (duration_s / PERIOD_S).round() as usize;
        let at = |tick: usize| protocol.commands_bar(tick as f64 * PERIOD_S).map(|bar| bar as f32);
        let excitation = Excitation {
            pressures_bar: (0..=ticks).map(at).collect(),
            counts: (0..=ticks).map(|tick| protocol.counts(tick as f64 * PERIOD_S)).collect(),
            torque_nm,
            every: self.every,
        };
        let words = format!(
            "swings by {swing} of five common pressures, {min_bar} to {max_bar} bar, {duration_s:.1} s, torque {torque_nm} N m"
        );
        Ok((excitation, words))
    }
}
