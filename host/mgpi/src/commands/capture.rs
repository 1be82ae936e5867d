//! `mgpi capture`: an excitation through a board, and a recording of what the muscle does.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::Args;

use super::duration_bar::bar;
use super::joint_capture::{self, JointArguments};
use super::kept::keep;
use super::number::positive;
use super::port::PortArguments;
use super::reading::Reading;
use super::show::{Show, show_rows};
use crate::Error;
use crate::output::Outputs;
use board_client::bus::Board;
use board_client::bus::excitation::triangles_and_holds;
use board_client::bus::play::{Drive, POINTS_PER_S, Piece, Played, Tick, play};
use board_client::bus::recording::{COLUMNS, from_point, rows, seam};
use board_client::growing::{Growing, head};
use board_client::pil::reference::Reference;
use board_client::stop::Stop;
use recording::TOOL;

/// The column of the command.
const COLUMN: &str = "command_bar";

/// Plays an excitation through a board and records the muscle, tick by tick. Ctrl-C vents.
#[derive(Args, Debug)]
pub struct Arguments {
    /// What is played: time_s, command_bar, from `mgpi plan` for instance [default: triangles of
    /// falling height, two fast swings, holds]; of a joint time_s, command_a_bar, command_b_bar and
    /// valid, 0 until it is filled and swung
    #[arg(long, value_name = "EXC.csv", conflicts_with_all = ["max_bar", "duration_s"])]
    excitation: Option<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// Highest command of the default excitation in bar
    #[arg(long, default_value_t = 6.0, value_name = "BAR", value_parser = positive)]
    max_bar: f64,
    /// Length of the default excitation in s [default: 120; of a joint some 310]
    #[arg(long, value_name = "S", value_parser = positive)]
    duration_s: Option<f64>,
    /// Where the recording goes; it grows in a file beside it, REC.csv.part
    #[arg(short = 'o', value_name = "REC.csv")]
    recording: PathBuf,
    /// Record every Nth tick [default: as many as the bus carries; of a joint 10]
    #[arg(long, value_name = "TICKS", value_parser = clap::value_parser!(u16).range(1..=1000))]
    every: Option<u16>,
    /// Also show the board on a page at this address, as `mgpi watch` does
    #[arg(long, value_name = "ADDRESS")]
    http: Option<SocketAddr>,
    /// Go on with a recording that was interrupted; a joint is filled and swung again before
    #[arg(long, conflicts_with = "force")]
    resume: bool,
    /// Overwrite an existing recording, or the part of one
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    joint: JointArguments,
    #[command(flatten)]
    port: PortArguments,
}

/// Length of the default excitation of a muscle. Unit: s.
const DURATION_S: f64 = 120.0;
/// A joint is recorded at 100 Hz, five rows in the lag of a regulator. Unit: tick.
const EVERY: u16 = 10;

/// Captures.
///
/// # Errors
/// The excitation is not valid, the board does not play it, the recording cannot be written, or the
/// user interrupts.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { excitation, recording: file, every, resume, force, .. } = arguments;
    let inputs: Vec<_> = excitation.iter().map(PathBuf::as_path).collect();
    let mut outputs = Outputs::claim([file], &inputs, *force)?;
    if arguments.joint.is_meant() {
        let joint = joint_capture::Arguments {
            joint: &arguments.joint,
            excitation: excitation.as_deref(),
            choice: arguments.reading.choice(),
            recording: file,
            max_bar: arguments.max_bar,
            duration_s: arguments.duration_s,
            every: every.unwrap_or(EVERY),
            address: arguments.port.link(),
            resume: *resume,
            force: *force,
        };
        return joint_capture::run(joint, outputs);
    }
    let (points, words) = arguments.points()?;
    let mut board = arguments.port.open()?;
    let head = head(&comments(&board, &words), COLUMNS);
    let (mut growing, from_s) = match resume {
        true => {
            let (growing, seam) = Growing::resume(file, &head, |reached| seam(&points, reached))?;
            (growing, seam.from_s)
        }
        false => (Growing::begin(file, &head, *force)?, 0.0),
    };
    let duration_s = points.len() as f64 / POINTS_PER_S;
    let points = points[from_point(from_s)..].to_vec();
    let piece = Piece { drive: Drive::Valve, points, every: *every };
    let bar = bar(duration_s);
    let mut show = arguments.http.map(Show::start).transpose()?;
    let stop = Stop::on_signals();
    let played = play(&mut board, &piece, &stop, &mut |board: &mut Board, ticks: &[Tick]| {
        show_rows(show.as_mut(), board, &stop, ticks.iter().map(|tick| (tick, None)))?;
        if let Some(last) = ticks.last() {
            let reached_s = last.time_s + from_s;
            bar.set_position((1e3 * reached_s) as u64);
            bar.set_message(format!(
                "{reached_s:.1} of {duration_s:.1} s, {:.2} bar, {:.1} mm",
                last.pressure_bar, last.contraction_mm
            ));
        }
        Ok(growing.add(&rows(ticks, from_s))?)
    });
    bar.finish_and_clear();
    let played = match played {
        Ok(played) => played,
        Err(error) => {
            keep(growing);
            return Err(error.into());
        }
    };
    let finished = growing.finish()?;
    outputs.stage(file, &finished.content)?;
    outputs.commit()?;
    finished.remove();
    say!("{}: {}", file.display(), in_words(&played, board.identity().period_s));
    Ok(())
}

impl Arguments {
    /// The points to be played, and what they are.
    fn points(&self) -> Result<(Vec<f32>, String), Error> {
        let Some(file) = &self.excitation else {
            let (max_bar, duration_s) = (self.max_bar, self.duration_s.unwrap_or(DURATION_S));
            let course = triangles_and_holds(max_bar, duration_s);
            let count = (duration_s * POINTS_PER_S).round() as usize + 1;
            let times = (0..count).map(|point| point as f64 / POINTS_PER_S);
            let points = course.samples(times).map(|bar| bar as f32).collect();
            return Ok((points, format!("triangles, swings and holds, 0 to {max_bar} bar, {duration_s} s")));
        };
        let choice = self.reading.choice();
        let table = choice.table(file)?;
        let reference = Reference::of(&table, COLUMN, choice, POINTS_PER_S)?;
        reference.say_notes(file);
        let points = reference.points(0.0).map(|bar| bar as f32).collect();
        Ok((points, format!("{}, SHA-256 {}", file.display(), table.sha256())))
    }
}

/// The first lines of a recording.
fn comments(board: &Board, excitation: &str) -> [String; 2] {
    let [major, minor, patch] = board.identity().release;
    [
        format!("recorded by {TOOL} from a board, firmware {major}.{minor}.{patch}"),
        format!("excitation: {excitation}"),
    ]
}

/// What was recorded, for people.
pub(super) fn in_words(played: &Played, period_s: f64) -> String {
    let Played { rows, every, lost_rows, overruns } = played;
    let step_ms = 1e3 * f64::from(*every) * period_s;
    let mut words = format!("{rows} rows, one each {step_ms} ms; ticks late: {overruns}");
    if *lost_rows > 0 {
        words += &format!("; {lost_rows} rows lost, the bus was too slow: --every {} is easier", 2 * every);
    }
    words
}
