//! The control code against the rig, with a model identified from the rig's recording.
//!
//! `cargo test -p host-tests --test rig_plant -- --nocapture` prints the figures.

use host_tests::{HostBoard, configuration, figures, raised_cosines, rig, run};
use identification::{CONVERGED, Fit, Loss, Options, Problem, Weights, identify};
use model_core::{Hysteresis, Kind, Mode};
use wire::Protection;

/// The model of the project's own recording, as `mgpi identify` finds it.
fn identified() -> Fit {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/rig-fig8.csv");
    let text = std::fs::read_to_string(path).expect("the recording is part of the project");
    let rows: Vec<Vec<f64>> = text
        .lines()
        .filter(|line| line.starts_with(|first: char| first.is_ascii_digit()))
        .map(|line| line.split(',').map(|field| field.parse().expect("a number")).collect())
        .collect();
    let (input, output): (Vec<f64>, Vec<f64>) = rows.iter().map(|row| (row[2], row[3])).unzip();
    let problem = Problem { input: &input, output: &output, scored: &vec![true; input.len()] };
    let options = Options {
        model: Kind::Mgpi,
        knots: None,
        weights: Weights::Exponential,
        loss: Loss::Squares,
        plays: 10,
        dead_zones: 10,
        starts: 16,
        seed: 1,
        threads: 0,
        tolerance: CONVERGED,
    };
    identify(&problem, &options, &|_| ()).expect("identified")
}

#[test]
fn on_the_rig_feedback_and_feedforward_together_beat_each_alone_within_bounds() {
    let fit = identified();
    let configuration = configuration(&fit.parameters);
    let reference = raised_cosines(5.0, &[110.0, 80.0, 50.0]);
    let (rest, full) = fit.model.output_range();
    let rmse_percent = |mode| {
        let run = run(&mut HostBoard::default(), &mut rig(7), &configuration, mode, &reference);
        let figures = figures(&run.expect("no fault"));
        println!(
            "{mode:?}: RMSE {:.3} mm, {:.3} % of stroke",
            figures.rmse,
            100.0 * figures.rmse / (full - rest)
        );
        100.0 * figures.rmse / (full - rest)
    };
    let both = rmse_percent(Mode::Both);
    let feedforward_only = rmse_percent(Mode::FeedforwardOnly);
    let feedback_only = rmse_percent(Mode::FeedbackOnly);
    assert!((0.25..0.38).contains(&both), "both: {both} %");
    assert!((0.55..0.8).contains(&feedforward_only), "feed-forward only: {feedforward_only} %");
    assert!((8.0..11.5).contains(&feedback_only), "feedback only: {feedback_only} %");
    assert!(both < feedforward_only && feedforward_only < feedback_only);
}

#[test]
fn the_standard_protection_raises_no_alarm_on_the_rig_however_fast_the_reference() {
    let configuration = configuration(&identified().parameters);
    let slow = raised_cosines(5.0, &[110.0, 60.0]);
    // A swing in a second, and jumps over the whole stroke every three.
    let fast = slow.iter().step_by(20).copied().cycle().take(20_000).collect::<Vec<_>>();
    let jumps = (0..30_000).map(|tick| if tick / 3000 % 2 == 0 { 10.0 } else { 110.0 }).collect::<Vec<_>>();
    let protection = Protection { self_test_ticks: 0, ..Protection::STANDARD };
    for (name, reference) in [("slow", &slow), ("fast", &fast), ("jumps", &jumps)] {
        for mode in [Mode::Both, Mode::FeedforwardOnly, Mode::FeedbackOnly] {
            let run =
                run(&mut HostBoard::protected(protection), &mut rig(7), &configuration, mode, reference);
            assert!(run.is_ok(), "{name}, {mode:?}: {:?}", run.err());
        }
    }
}
