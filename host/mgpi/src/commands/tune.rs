//! `mgpi tune`: the feedback that goes with a model, with stated margins.

use std::path::{Path, PathBuf};

use clap::Args;
use recording::model_file::ModelFile;
use recording::model_file::control::Observer;
use serde_json::json;
use tuning::slopes::Slope;
use tuning::{Tuned, tune};

use super::number::positive;
use super::reading::Reading;
use super::{diagnose, recorded, tuned};
use crate::Error;
use crate::output::Outputs;

/// Tunes the feedback for a model: gains with stated margins on every slope of its loop.
///
/// pil and deploy use the gains of a model's file where it has some. A model for which no gains are
/// safe is refused with the reason.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The model, from `mgpi identify` or `diagnose`
    #[arg(value_name = "MODEL.toml")]
    model: PathBuf,
    /// Where the model goes with its gains
    #[arg(short = 'o', value_name = "TUNED.toml")]
    tuned: Option<PathBuf>,
    /// A recording of the muscle that says what its model file does not: how late it is, how noisy,
    /// how the valve lags
    #[arg(long, value_name = "REC.csv")]
    recording: Option<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// Time constant of the valve in s, from its data sheet, where no command was recorded beside
    /// the pressure
    #[arg(long, value_name = "S", value_parser = positive)]
    valve_lag_s: Option<f64>,
    /// Ticks a second of the board
    #[arg(long, default_value_t = 1000.0, value_name = "HZ", value_parser = positive)]
    rate_hz: f64,
    /// Gains that grow where the muscle is flatter: a disturbance observer. Quicker, and less sure
    /// on a muscle whose model is off where it turns round
    #[arg(long)]
    observer: bool,
    /// Also write a page that shows the loop: one HTML file
    #[arg(long, value_name = "REPORT.html")]
    report: Option<PathBuf>,
    /// Also write the tuning as JSON
    #[arg(long, value_name = "TUNING.json")]
    json: Option<PathBuf>,
    /// Overwrite existing outputs
    #[arg(long)]
    force: bool,
}

/// Tunes.
///
/// # Errors
/// A file is not what it should be, no feedback is safe, or an output cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { model: file, tuned: to, recording, reading, rate_hz, valve_lag_s, .. } = arguments;
    let Arguments { observer, report, json: figures, force, .. } = arguments;
    let inputs: Vec<&Path> = [file].into_iter().chain(recording).map(PathBuf::as_path).collect();
    let mut outputs = Outputs::claim(to.iter().chain(report).chain(figures), &inputs, *force)?;
    let mut model = ModelFile::read(file)?;
    if let Some(recording) = recording {
        let choice = reading.choice().like(&model.input, &model.output);
        let columns = diagnose::read(recording, &choice)?.columns;
        model.recorded = recorded::of_columns(&model, &columns);
    }
    let found = tune(&model, rate_hz.recip(), *valve_lag_s, *observer)
        .map_err(|source| Error::Tuning { file: file.clone(), source })?;
    let tuning = &found.tuning;
    model.tuning = Some(tuning.clone());
    if let Some(to) = to {
        outputs.stage(to, model.to_toml().as_bytes())?;
    }
    if let Some(page) = report {
        outputs.stage(page, report::tuned::to_html(&found, &file.display().to_string()).as_bytes())?;
    }
    if let Some(figures) = figures {
        outputs.stage(figures, format!("{:#}\n", to_json(&model, &found)).as_bytes())?;
    }
    outputs.commit()?;
    print_summary(&model, &found);
    Ok(())
}

/// For programs.
fn to_json(model: &ModelFile, found: &Tuned) -> serde_json::Value {
    let tuning = &found.tuning;
    let (input, output) = (model.input.unit.suffix(), model.output.unit.suffix());
    let mut json = json!({
        "derivative_filter_s": tuning.derivative_filter_s,
        "tracking_time_s": tuning.tracking_time_s,
        "lag_s": tuning.lag_s,
        "delay_s": tuning.delay_s,
        "maximum_sensitivity": tuning.maximum_sensitivity,
        "gain_margin": tuning.gain_margin,
        "phase_margin_deg": tuning.phase_margin_deg,
        "bandwidth_least_hz": tuning.bandwidth_hz.0,
        "bandwidth_most_hz": tuning.bandwidth_hz.1,
        "learning_hz": tuning.learning_hz,
        "limited_by": tuning.limited_by,
        "assumptions": found.assumptions,
    });
    json[format!("kp_{input}_per_{output}")] = tuning.kp.into();
    json[format!("ki_{input}_per_{output}_s")] = tuning.ki.into();
    json[format!("kd_{input}_s_per_{output}")] = tuning.kd.into();
    json[format!("slew_{input}_per_s")] = tuning.slew_per_s.into();
    if let Some(Observer { slope, reach, band }) = tuning.observer {
        json[format!("observer_slope_{output}_per_{input}")] = slope.into();
        json["observer_reach"] = reach.into();
        json[format!("observer_band_{output}")] = band.into();
    }
    json
}

/// For people.
fn print_summary(model: &ModelFile, found: &Tuned) {
    let tuning = &found.tuning;
    let (input, output) = (model.input.unit, model.output.unit);
    let slopes = found.view.slopes();
    let ends = |of: fn(&Slope) -> f64| {
        let values = slopes.iter().map(of);
        values.fold((f64::INFINITY, 0.0_f64), |(least, most), slope| (least.min(slope), most.max(slope)))
    };
    let (driven, turned) = (ends(|slope| slope.driven), ends(|slope| slope.turned));
    say!(
        "slopes        {:.3} to {:.3} {output}/{input} driven on, {:.3} to {:.3} just turned round",
        driven.0,
        driven.1,
        turned.0,
        turned.1
    );
    say!(
        "gains         kp {:.4} {input}/{output}, ki {:.4} {input}/({output} s), kd {:.5} {input} s/{output}",
        tuning.kp,
        tuning.ki,
        tuning.kd
    );
    if let Some(Observer { slope, reach, band }) = tuning.observer {
        say!(
            "observer      the gains are for {slope:.3} {output}/{input}, and up to {reach:.1} times as large where the muscle \
             is flatter; moves within {band:.4} {output} are noise"
        );
    }
    if let Some(slew) = tuning.slew_per_s {
        say!("slew          {slew:.0} {input}/s");
    }
    if tuning.lag_s > 0.0 || tuning.delay_s > 0.0 {
        say!(
            "led           lag {:.4} s and dead time {:.4} s beside the model's",
            tuning.lag_s,
            tuning.delay_s
        );
    }
    say!("promised      {}", tuned::words(tuning));
    say!("limited by    {}", found.limit.words());
    say!("learning      of what repeats, up to {:.2} Hz", tuning.learning_hz);
    found.assumptions.iter().for_each(|assumed| say!("assumed       {assumed}"));
}
