//! What the runs leave: logs and figures, in which nothing depends on how fast the machine is.

use serde_json::{Value, json};

use super::lock_step::{Run, Sample};
use recording::figures::Figures;
use recording::unit::Unit;

/// The columns of a log: its first line.
pub const COLUMNS: &str =
    "time_s,reference_mm,contraction_mm,pressure_bar,command_bar,feedforward_bar,feedback_bar\n";

/// A run as CSV, a row a tick.
pub fn log(run: &Run) -> String {
    COLUMNS.to_owned() + &rows(&run.samples)
}

/// The rows of samples; numbers in the shortest form that reads back the same.
pub fn rows(samples: &[Sample]) -> String {
    let row = |sample: &Sample| {
        let Sample { time_s, reference_mm, measured, command_bar, feedforward_bar, feedback_bar } = sample;
        let (contraction_mm, pressure_bar) = (measured.contraction_mm, measured.pressure_bar);
        format!(
            "{time_s},{reference_mm},{contraction_mm},{pressure_bar},\
             {command_bar},{feedforward_bar},{feedback_bar}\n"
        )
    };
    samples.iter().map(row).collect()
}

/// The tracking error over all ticks. Unit: mm.
pub fn figures(run: &Run) -> Figures {
    let of = |value: fn(&Sample) -> f64| -> Vec<f64> { run.samples.iter().map(value).collect() };
    let reference_mm = of(|sample| sample.reference_mm);
    let contraction_mm = of(|sample| sample.measured.contraction_mm);
    Figures::of(&reference_mm, &contraction_mm, &vec![true; run.samples.len()])
}

/// The figures of runs by their names. Ticks: of each run; overruns: of all.
pub fn json<'a>(runs: impl IntoIterator<Item = (&'a str, &'a Run)>, unit: Unit) -> Value {
    let mut json = json!({"ticks": 0, "overruns": 0});
    let mut overruns = 0;
    for (name, run) in runs {
        json[name] = figures(run).to_json(unit);
        json["ticks"] = run.samples.len().into();
        overruns += run.overruns;
    }
    json["overruns"] = overruns.into();
    json
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pil::lock_step::Measurement;
    use model_core::Surroundings;

    fn run() -> Run {
        let sample = |time_s, reference_mm, contraction_mm| Sample {
            time_s,
            reference_mm,
            measured: Measurement {
                pressure_bar: 0.1,
                contraction_mm,
                surroundings: Surroundings::default(),
            },
            command_bar: 0.1,
            feedforward_bar: 0.3,
            feedback_bar: -0.2,
        };
        Run { samples: vec![sample(0.0, 1.0, 4.0), sample(0.001, 5.0, 1.0)], overruns: 2 }
    }

    #[test]
    fn a_log_has_a_row_a_tick() {
        let rows = ["0,1,4,0.1,0.1,0.3,-0.2\n", "0.001,5,1,0.1,0.1,0.3,-0.2\n"];
        assert_eq!(log(&run()), COLUMNS.to_owned() + rows[0] + rows[1]);
    }

    #[test]
    fn the_error_is_that_of_the_contraction_from_the_reference() {
        assert_eq!(figures(&run()), Figures { rmse: 12.5_f64.sqrt(), mae: 3.5, max_error: 4.0 });
    }

    #[test]
    fn ticks_are_those_of_a_run_and_overruns_those_of_all() {
        let unit = Unit::of_column("contraction_mm").expect("known");
        let json = json([("tracking", &run()), ("feedback_only", &run())], unit);
        assert_eq!((&json["ticks"], &json["overruns"]), (&2.into(), &4.into()));
        assert_eq!(json["feedback_only"]["mae_mm"], 3.5);
    }
}
