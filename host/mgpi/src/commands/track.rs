//! `mgpi track`: a board tracks a reference.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use model_core::{Hysteresis, Mode, Surroundings};

use super::board_model;
use super::capture::in_words;
use super::duration_bar::bar;
use super::joint_board::BoardArguments;
use super::joint_track;
use super::learnt::{self, Learning};
use super::port::PortArguments;
use super::reading::Reading;
use super::show::{Show, show_rows};
use crate::Error;
use crate::output::Outputs;
use board_client::bus::adapted::Adapted;
use board_client::bus::play::{Drive, POINTS_PER_S, Piece, Played, Tick, play};
use board_client::bus::{Board, BoardError, upload};
use board_client::part::Part;
use board_client::pil::lock_step::{Measurement, Run, Sample};
use board_client::pil::reference::Reference;
use board_client::pil::{followed, preview_s, results};
use board_client::stop::Stop;
use recording::unit::Unit;
use report::tracked::{self, Stroke};
use wire::registers::{self, Id};

/// Columns of the live view's track.
const TRACK: usize = 30;

/// Tracks a reference with a board, and logs. Ctrl-C stops and vents.
#[derive(Args, Debug)]
pub struct Arguments {
    /// What to track: time_s, reference_mm; of a joint time_s, reference_deg, stiffness_nm_per_rad
    /// and, if it is known, torque_newton_metre
    #[arg(long, value_name = "REF.csv")]
    reference: PathBuf,
    #[command(flatten)]
    reading: Reading,
    /// The model that the board has: says what it is worth, and that the board has it. Of a joint
    /// the model that the board is given
    #[arg(long, value_name = "MODEL.toml", required_if_eq("joint", "true"))]
    model: Option<PathBuf>,
    /// What drives the valve
    #[arg(long, default_value = "both")]
    mode: ModeName,
    /// Where the log goes; it grows in a file beside it, LOG.csv.part, which an interruption leaves
    #[arg(short = 'o', value_name = "LOG.csv")]
    log: Option<PathBuf>,
    /// Also write the figures as JSON
    #[arg(long, value_name = "FIGURES.json")]
    json: Option<PathBuf>,
    /// Also write a page that shows the run: one HTML file
    #[arg(long, value_name = "REPORT.html")]
    report: Option<PathBuf>,
    /// The board's feed-forward follows a muscle that warms up, ages or is loaded. What it has
    /// learnt stays until the board starts again or gets another model
    #[arg(long, conflicts_with = "learn")]
    adapt: bool,
    /// Log every Nth tick [default: as many as the bus carries]
    #[arg(long, value_name = "TICKS", value_parser = clap::value_parser!(u16).range(1..=1000))]
    every: Option<u16>,
    /// Also show the board on a page at this address, as `mgpi watch` does
    #[arg(long, value_name = "ADDRESS")]
    http: Option<SocketAddr>,
    /// Overwrite existing outputs
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    learning: Learning,
    /// Track with two muscles at a joint, by a board with two channels at its service link
    #[arg(long, help_heading = "Joint", conflicts_with_all = ["mode", "adapt", "http", "Learning", "unit", "parity"])]
    joint: bool,
    #[command(flatten)]
    board: BoardArguments,
    #[command(flatten)]
    port: PortArguments,
}

/// What drives the valve.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum ModeName {
    /// Feed-forward and feedback
    Both,
    /// The model's inverse alone
    Feedforward,
    /// The feedback alone
    Feedback,
}

impl ModeName {
    /// The mode, and what its run is called in the results.
    fn mode(self) -> (Mode, &'static str) {
        match self {
            Self::Both => (Mode::Both, "tracking"),
            Self::Feedforward => (Mode::FeedforwardOnly, "feedforward_only"),
            Self::Feedback => (Mode::FeedbackOnly, "feedback_only"),
        }
    }
}

/// Tracks.
///
/// # Errors
/// The reference is not valid, the board does not track, an output cannot be written, or the user
/// interrupts.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { reference: file, reading, model, mode, log, json, report, force, learning, .. } =
        arguments;
    let files = log.iter().chain(json).chain(report).chain(&learning.learn);
    let inputs: Vec<&Path> = [file].into_iter().chain(&learning.correction).map(PathBuf::as_path).collect();
    let inputs: Vec<&Path> = match model {
        // It is read before anything is written.
        Some(model) if arguments.joint => {
            inputs.into_iter().chain([model.as_path()]).chain(arguments.board.file()).collect()
        }
        _ => inputs,
    };
    let mut outputs = Outputs::claim(files, &inputs, *force)?;
    if let (true, Some(model)) = (arguments.joint, model) {
        let joint = joint_track::Arguments {
            model,
            reference: file,
            choice: reading.choice(),
            address: arguments.port.link(),
            board: &arguments.board,
            every: arguments.every.unwrap_or(1),
            log: log.as_deref(),
            report: report.as_deref(),
            json: json.as_deref(),
            force: *force,
        };
        return joint_track::run(&joint, outputs);
    }
    let passes = learning.passes()?;
    let reference = Reference::read(file, reading.choice(), POINTS_PER_S)?;
    let model = model.as_deref().map(board_model::read).transpose()?;
    let mut board = arguments.port.open()?;
    let installed = upload::fetch(&mut board)?;
    board_model::say_installed(&installed, model.as_ref());
    let ahead_s = preview_s(&installed);
    if arguments.adapt {
        board.set(Id::Adaptation, f64::from(registers::Learning::On.number())).map_err(BoardError::from)?;
    }
    let (mode, name) = mode.mode();
    let (corner_hz, range_mm) = match (&learning.learn, &model, &arguments.model) {
        (Some(_), Some(model), Some(file)) => {
            (learnt::corner_hz(file, model, &installed.tracking, mode)?, model.model.output_range())
        }
        (Some(_), ..) => {
            return Err(Error::Usage(
                "--learn needs --model MODEL.toml: what may be learnt depends on it".to_owned(),
            ));
        }
        (None, ..) => (0.0, (f64::NEG_INFINITY, f64::INFINITY)),
    };
    let duration_s = reference.ticks() as f64 / POINTS_PER_S;
    let (lowest, highest) = reference.range();
    let begin = |log: &PathBuf| Part::begin(log, results::COLUMNS, *force);
    let mut part = log.as_ref().map(begin).transpose()?;
    let mut show = arguments.http.map(Show::start).transpose()?;
    let stop = Stop::on_signals();
    let mut lesson = learning.lesson(reference.clone(), corner_hz, range_mm)?;
    let (mut run, mut played) = (Run { samples: Vec::new(), overruns: 0 }, Played::default());
    for pass in 1..=passes {
        // Once the learning has ended, one pass more is made with what stays of it.
        let is_last = pass == passes || lesson.has_ended();
        let given = lesson.given();
        let points = given.points(ahead_s).map(|mm| mm as f32).collect();
        let piece = Piece { drive: Drive::Controller(mode), points, every: arguments.every };
        let bar = bar(duration_s);
        run.samples.clear();
        let heard = play(&mut board, &piece, &stop, &mut |board: &mut Board, heard: &[Tick]| {
            let wanted: Vec<f64> = reference.values(heard.iter().map(|tick| tick.time_s)).collect();
            let samples: Vec<Sample> = heard.iter().zip(&wanted).map(sample).collect();
            // The log is that of the last pass.
            if let Some(part) = part.as_mut().filter(|_| is_last) {
                part.add(&results::rows(&samples))?;
            }
            run.samples.extend(samples);
            show_rows(show.as_mut(), board, &stop, heard.iter().zip(wanted.iter().copied().map(Some)))?;
            if let (Some(last), Some(&wanted_mm)) = (heard.last(), wanted.last()) {
                bar.set_position((1e3 * last.time_s) as u64);
                bar.set_message(live(last, wanted_mm, lowest, highest));
            }
            Ok(())
        });
        bar.finish_and_clear();
        played = match heard {
            Ok(played) => played,
            Err(error) => {
                if let Some(kept) = part.and_then(Part::keep) {
                    eprintln!("what was tracked is kept in {}", kept.display());
                }
                lesson.keep(outputs);
                return Err(error.into());
            }
        };
        if passes > 1 {
            lesson.take(&run.samples);
        }
        if is_last {
            break;
        }
    }
    run.overruns = played.overruns;
    let grown = part.map(Part::finish).transpose()?;
    if let (Some(file), Some(grown)) = (log, &grown) {
        outputs.stage(file, &grown.content)?;
    }
    let unit = Unit::MM;
    let mut results = results::json([(name, &run)], unit);
    let limits = (installed.tracking.command_min, installed.tracking.command_max);
    followed::tell(name, &run, limits, &mut results);
    results["model"] = board_model::worth_json(model.as_ref());
    if passes > 1 {
        results["passes"] = lesson.passes_json();
        lesson.stage(&mut outputs)?;
    }
    if let Some(file) = json {
        outputs.stage(file, format!("{results:#}\n").as_bytes())?;
    }
    let stroke = match &model {
        Some(model) => Stroke { mm: model.stroke(), whose: "stroke" },
        None => Stroke { mm: highest - lowest, whose: "the reference's range" },
    };
    if let Some(page) = report {
        let source = format!("Reference {}", file.display());
        outputs.stage(page, tracked::to_html(&[(name, &run)], stroke, &source).as_bytes())?;
    }
    outputs.commit()?;
    if let Some(grown) = grown {
        grown.remove();
    }
    say!("{name:<17} {}", results::figures(&run).in_words_beside((stroke.mm, stroke.whose), unit));
    say!("{}", in_words(&played, board.identity().period_s));
    if arguments.adapt {
        say!("learnt            {}", Adapted::read(&mut board).map_err(BoardError::from)?);
    }
    Ok(())
}

/// A tick in the log: what was wanted is the reference (mm) at its time, not what was handed to the
/// board ahead of it.
fn sample((tick, reference_mm): (&Tick, &f64)) -> Sample {
    Sample {
        time_s: tick.time_s,
        reference_mm: *reference_mm,
        measured: Measurement {
            pressure_bar: tick.pressure_bar,
            contraction_mm: tick.contraction_mm,
            surroundings: Surroundings::default(),
        },
        command_bar: tick.command_bar as f32,
        feedforward_bar: (tick.command_bar - tick.feedback_bar) as f32,
        feedback_bar: tick.feedback_bar as f32,
    }
}

/// A moment in a line: where it should be (`|`), and where it is (`#`), over the reference's range.
fn live(tick: &Tick, wanted_mm: f64, lowest: f64, highest: f64) -> String {
    let place = |mm: f64| {
        let share = (mm - lowest) / (highest - lowest).max(f64::MIN_POSITIVE);
        (share.clamp(0.0, 1.0) * (TRACK - 1) as f64) as usize
    };
    let mut track = ['.'; TRACK];
    track[place(wanted_mm)] = '|';
    track[place(tick.contraction_mm)] = '#';
    let track: String = track.into_iter().collect();
    let Tick { time_s, contraction_mm, pressure_bar, .. } = tick;
    let error_mm = contraction_mm - wanted_mm;
    format!("{time_s:.1} s [{track}] {contraction_mm:.1} mm, error {error_mm:+.2}, {pressure_bar:.2} bar")
}
