//! `mgpi pil`: the firmware, in the emulator, tracks a reference with a plant.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use model_core::{Hysteresis, Mode};

use super::board_model;
use super::gains::Gains;
use super::joint_pil;
use super::learnt::{self, Learning};
use super::number::positive;
use super::plant::PlantArguments;
use super::reading::Reading;
use super::tuned;
use crate::Error;
use crate::output::Outputs;
use board_client::bus::settings::settle;
use board_client::emulator::image;
use board_client::part::Part;
use board_client::pil::bench::{Bench, Broken, Finished};
use board_client::pil::configuration;
use board_client::pil::followed;
use board_client::pil::lock_step::Run;
use board_client::pil::reference::Reference;
use board_client::pil::results::{self, figures, json, log};
use board_client::stop::Stop;
use report::tracked::{self, Stroke};

/// The runs, as they are called in the results.
const RUNS: [(&str, Mode); 3] = [
    ("tracking", Mode::Both),
    ("feedforward_only", Mode::FeedforwardOnly),
    ("feedback_only", Mode::FeedbackOnly),
];
/// The progress bar is moved once in so many ticks.
const TICKS_A_MOVE: u64 = 250;

/// Runs the firmware in the loop: three times, with feed-forward and feedback, and with either
/// alone.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The model, from `mgpi identify`
    #[arg(long, value_name = "MODEL.toml")]
    model: PathBuf,
    /// What to track: time_s, reference_mm; of a joint time_s, reference_deg, stiffness_nm_per_rad
    /// and, if it is known, torque_newton_metre
    #[arg(long, value_name = "REF.csv")]
    reference: PathBuf,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    plant: PlantArguments,
    /// Ticks a second
    #[arg(long, default_value_t = 1000.0, value_name = "HZ", value_parser = positive)]
    rate_hz: f64,
    /// Where the log of the combined run goes; a run that does not come to its end leaves
    /// LOG.csv.part
    #[arg(short = 'o', value_name = "LOG.csv")]
    log: Option<PathBuf>,
    /// Where the log of the run with feed-forward only goes
    #[arg(long, value_name = "LOG.csv")]
    feedforward_log: Option<PathBuf>,
    /// Where the log of the run with feedback only goes
    #[arg(long, value_name = "LOG.csv")]
    feedback_log: Option<PathBuf>,
    /// Also write a page that shows the runs: one HTML file
    #[arg(long, value_name = "REPORT.html")]
    report: Option<PathBuf>,
    /// Also write the figures as JSON
    #[arg(long, value_name = "FIGURES.json")]
    json: Option<PathBuf>,
    /// The firmware's ELF file [default: that of MGPI_FIRMWARE, else the one built beside this
    /// program]
    #[arg(long, value_name = "ELF")]
    firmware: Option<PathBuf>,
    /// The model is that of two muscles at a joint, from `mgpi identify --joint`: the firmware of
    /// two channels runs; a plant then answers
    /// `time_s command_a_bar command_b_bar` with `pressure_a_bar pressure_b_bar angle_deg`
    #[arg(
        long,
        conflicts_with_all = ["feedforward_log", "feedback_log", "no_monitors", "plant", "Learning", "Gains"]
    )]
    joint: bool,
    /// Limits and calibration that the board of a joint is given
    #[arg(long, value_name = "SETTINGS.toml", requires = "joint")]
    settings: Option<PathBuf>,
    /// Also show what firmware and plants have to say
    #[arg(long, short)]
    verbose: bool,
    /// Overwrite existing outputs
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    learning: Learning,
    #[command(flatten)]
    gains: Gains,
}

/// Tracks.
///
/// # Errors
/// A file is not what it should be, firmware or plant do not do their work, an output cannot be
/// written, or the user interrupts.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { log: main_log, feedforward_log, feedback_log, json: json_file, rate_hz, .. } = arguments;
    let logs = [main_log, feedforward_log, feedback_log];
    let learning = &arguments.learning;
    let files = logs.into_iter().flatten().chain(json_file).chain(&arguments.report).chain(&learning.learn);
    let inputs: Vec<&Path> = [&arguments.model, &arguments.reference]
        .into_iter()
        .chain(&learning.correction)
        .chain(&arguments.settings)
        .map(PathBuf::as_path)
        .collect();
    let mut outputs = Outputs::claim(files, &inputs, arguments.force)?;
    if arguments.joint {
        return joint_pil::run(
            &joint_pil::Arguments {
                model: &arguments.model,
                reference: &arguments.reference,
                choice: arguments.reading.choice(),
                rate_hz: *rate_hz,
                settings: arguments.settings.as_deref(),
                plant: arguments.plant.joint(),
                firmware: arguments.firmware.as_deref(),
                verbose: arguments.verbose,
                log: main_log.as_deref(),
                report: arguments.report.as_deref(),
                json: json_file.as_deref(),
            },
            outputs,
        );
    }
    let passes = learning.passes()?;
    let model = board_model::read(&arguments.model)?;
    let mut configuration = configuration(&arguments.model, &model, *rate_hz)?;
    let is_tuned = tuned::is_tuned(&arguments.model, &model, rate_hz.recip());
    let asked = arguments.gains.asked();
    settle(&mut configuration.tracking, None, &asked, is_tuned)?;
    tuned::warn(&arguments.model, &model, &configuration.tracking, &asked);
    let reference = Reference::read(&arguments.reference, arguments.reading.choice(), *rate_hz)?;
    let corner_hz = match &learning.learn {
        Some(_) => learnt::corner_hz(&arguments.model, &model, &configuration.tracking, Mode::Both)?,
        None => 0.0,
    };
    let mut lesson = learning.lesson(reference, corner_hz, model.model.output_range())?;
    let firmware = image::find(arguments.firmware.as_deref())?;
    let plant = arguments.plant.program();
    let stop = Stop::on_signals();
    let protection = arguments.plant.protection(configuration.tracking.period_s);
    // The last pass is the one that is logged, beside those of the other modes.
    for _ in 1..passes {
        let given = lesson.given();
        let ran = with_progress(given.ticks() as u64, |ticked| {
            let bench = Bench {
                firmware: &firmware,
                configuration: &configuration,
                protection,
                plant: &plant,
                reference: &given,
                stop: stop.clone(),
            };
            bench.run(&[Mode::Both], ticked)
        });
        match ran {
            Ok(finished) => lesson.take(&finished[0].run.samples),
            Err(broken) => {
                lesson.keep(outputs);
                return Err((*broken.problem).into());
            }
        }
        if lesson.has_ended() {
            break;
        }
    }
    let reference = lesson.given();
    let bench = Bench {
        firmware: &firmware,
        configuration: &configuration,
        protection,
        plant: &plant,
        reference: &reference,
        stop,
    };

    let parts: Vec<Option<Part>> = logs
        .iter()
        .map(|log| log.as_ref().map(|log| Part::begin(log, results::COLUMNS, arguments.force)).transpose())
        .collect::<Result<_, _>>()?;
    let begin = Instant::now();
    let ran = with_progress((RUNS.len() * reference.ticks()) as u64, |ticked| {
        bench.run(&RUNS.map(|(_, mode)| mode), ticked)
    });
    let finished = match ran {
        Ok(finished) => finished,
        Err(Broken { problem, runs }) => {
            keep(parts, &runs)?;
            lesson.keep(outputs);
            return Err((*problem).into());
        }
    };
    // No row has come into them.
    parts.into_iter().flatten().for_each(|part| drop(part.keep()));
    let seconds = begin.elapsed().as_secs_f64();

    for (file, finished) in logs.into_iter().zip(&finished) {
        if let Some(file) = file {
            outputs.stage(file, log(&finished.run).as_bytes())?;
        }
    }
    let named = || RUNS.iter().map(|(name, _)| *name).zip(finished.iter().map(|finished| &finished.run));
    let mut results = json(named(), model.output.unit);
    let limits = (configuration.tracking.command_min, configuration.tracking.command_max);
    named().for_each(|(name, run)| followed::tell(name, run, limits, &mut results));
    results["model"] = board_model::worth_json(Some(&model));
    let stroke_mm = model.stroke();
    if let Some(file) = &arguments.report {
        let (model, reference) = (arguments.model.display(), arguments.reference.display());
        let source = format!("Reference {reference}, model {model}");
        let runs: Vec<_> = named().collect();
        let stroke = Stroke { mm: stroke_mm, whose: "stroke" };
        outputs.stage(file, tracked::to_html(&runs, stroke, &source).as_bytes())?;
    }
    if passes > 1 {
        lesson.take(&finished[0].run.samples);
        results["passes"] = lesson.passes_json();
        lesson.stage(&mut outputs)?;
    }
    if let Some(file) = json_file {
        outputs.stage(file, format!("{results:#}\n").as_bytes())?;
    }
    outputs.commit()?;
    if arguments.verbose {
        print_messages(&finished);
    }
    for (name, run) in named() {
        say!("{name:<17} {}", figures(run).in_words(stroke_mm, model.output.unit));
    }
    let ticks = finished.len() * reference.ticks();
    say!("{ticks} ticks in {seconds:.1} s, {:.0} a second", ticks as f64 / seconds);
    Ok(())
}

/// Keeps what the runs have come to in the logs that are wanted of them.
fn keep(parts: Vec<Option<Part>>, runs: &[Run]) -> Result<(), Error> {
    for (part, run) in parts.into_iter().zip(runs) {
        let Some(mut part) = part else { continue };
        part.add(&results::rows(&run.samples))?;
        if let Some(kept) = part.keep() {
            eprintln!("what was tracked is kept in {}", kept.display());
        }
    }
    Ok(())
}

/// Does the work under a progress bar; the work calls what it is given once a tick.
fn with_progress<T>(ticks: u64, work: impl FnOnce(&(dyn Fn() + Sync)) -> T) -> T {
    let style = ProgressStyle::with_template("tracking {wide_bar} {msg}, {eta} left");
    let bar = ProgressBar::new(ticks).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let done = AtomicU64::new(0);
    let result = work(&|| {
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        if done.is_multiple_of(TICKS_A_MOVE) {
            bar.set_position(done);
            bar.set_message(format!("{:.0} ticks/s", bar.per_sec()));
        }
    });
    bar.finish_and_clear();
    result
}

fn print_messages(finished: &[Finished]) {
    for ((name, _), Finished { log, plant_messages, .. }) in RUNS.iter().zip(finished) {
        say!("{name}, the firmware's log:\n{log}\n{name}, the plant's messages:\n{plant_messages}");
    }
}
