//! The control code against a plant that is an MGPI model: with the board's model matched, then
//! wrong.
//!
//! `cargo test -p host-tests --test mgpi_plant -- --nocapture` prints the figures.

use host_tests::{
    FunctionPlant, HostBoard, PERIOD_S, configuration, figures, identified, raised_cosines, run,
};
use identification::{CONVERGED, Loss, Options, Weights};
use model_core::envelope::EnvelopeParameters;
use model_core::{Hysteresis, Kind, Mgpi, MgpiParameters, Mode, ModelParameters, paper};

const SIZE: usize = paper::SIZE;
/// Lag of the pressure under feedback. Unit: s.
const LAG_S: f64 = 0.005;
type Parameters = MgpiParameters<f64, SIZE, SIZE>;

fn truth() -> Parameters {
    paper::mgpi().expect("valid")
}

/// The tracking RMSE of board model against the paper's model as plant, in % of the plant's stroke.
fn rmse_percent<const N: usize, const M: usize>(model: &ModelParameters<f64, N, M>, mode: Mode) -> f64 {
    let plant_model = Mgpi::try_new(&truth()).expect("valid");
    let (_, full) = plant_model.output_range();
    let stroke = full - plant_model.output_range().0;
    let mut state = plant_model.rest_state();
    // With feedback the pressure follows within a few ticks, as behind every valve: around a plant
    // without any lag the sample time alone makes a proportional loop of this gain oscillate.
    let follow = if mode == Mode::FeedforwardOnly { 1.0 } else { 1.0 - (-PERIOD_S / LAG_S).exp() };
    let mut pressure = 0.0;
    let mut plant = FunctionPlant(|command: f64| {
        pressure += follow * (command - pressure);
        (pressure, plant_model.step(&mut state, pressure).expect("finite"))
    });
    // From 5 mm, since 1.9 mm remain at 0 bar once the muscle has been up.
    let reference = raised_cosines(5.0, &[110.0, 80.0, 50.0]);
    let run = run(&mut HostBoard::default(), &mut plant, &configuration(model), mode, &reference);
    100.0 * figures(&run.expect("no fault")).rmse / stroke
}

fn assert_between(what: &str, value: f64, [low, high]: [f64; 2]) {
    println!("{what}: RMSE {value:.4} % of stroke");
    assert!((low..high).contains(&value), "{what}: {value:.4} % of stroke is not within {low} to {high}");
}

#[test]
fn a_matched_model_tracks_by_feedforward_alone_to_the_resolution_of_the_converters() {
    // A step of the DAC is 2.4 mbar, about 0.05 mm: the bound below is what it leaves, not 0.
    assert_between(
        "matched, feed-forward only",
        rmse_percent(&ModelParameters::Cascade(truth()), Mode::FeedforwardOnly),
        [0.01, 0.02],
    );
    assert_between(
        "matched, both",
        rmse_percent(&ModelParameters::Cascade(truth()), Mode::Both),
        [0.01, 0.02],
    );
}

#[test]
fn feedback_mends_what_a_model_wrong_by_ten_per_cent_leaves() {
    type Spoil = fn(&mut Parameters);
    let cases: [(&str, Spoil, [f64; 2], [f64; 2]); 4] = [
        ("c1 + 10 %", scale_steepness, [3.8, 4.6], [0.7, 1.0]),
        ("weights of the dead zones - 10 %", scale_output, [4.3, 5.2], [1.7, 2.2]),
        ("thresholds of the plays + 10 %", scale_thresholds, [0.38, 0.48], [0.15, 0.20]),
        ("weights of the plays - 10 %", scale_weights, [2.6, 3.2], [0.9, 1.15]),
    ];
    for (what, spoil, alone, both) in cases {
        let mut model = truth();
        spoil(&mut model);
        let model = ModelParameters::Cascade(model);
        let with_feedback = rmse_percent(&model, Mode::Both);
        let without = rmse_percent(&model, Mode::FeedforwardOnly);
        assert_between(&format!("{what}, feed-forward only"), without, alone);
        assert_between(&format!("{what}, both"), with_feedback, both);
        assert!(with_feedback < 0.5 * without, "{what}: feedback mends too little");
    }
}

fn scale_steepness(parameters: &mut Parameters) {
    match &mut parameters.envelope {
        EnvelopeParameters::Tanh(envelope) => envelope.c1 *= 1.1,
        other => panic!("{other:?} has no c1"),
    }
}

fn scale_output(parameters: &mut Parameters) {
    parameters.dead_zones.weights.iter_mut().for_each(|w| *w *= 0.9);
}

fn scale_thresholds(parameters: &mut Parameters) {
    parameters.plays.thresholds.iter_mut().for_each(|r| *r *= 1.1);
}

fn scale_weights(parameters: &mut Parameters) {
    parameters.plays.weights.iter_mut().for_each(|p| *p *= 0.9);
}

#[test]
fn models_identified_with_other_numbers_of_operators_track_their_plant() {
    for (plays, dead_zones, alone, both) in [
        (5, 6, [0.22, 0.34], [0.09, 0.15]),
        (10, 10, [0.06, 0.1], [0.03, 0.05]),
        (20, 14, [0.08, 0.14], [0.03, 0.06]),
    ] {
        let options = Options {
            model: Kind::Mgpi,
            knots: None,
            weights: Weights::Exponential,
            loss: Loss::Squares,
            plays,
            dead_zones,
            starts: 8,
            seed: 1,
            threads: 0,
            tolerance: CONVERGED,
        };
        let model = identified(&options);
        let what = format!("identified with {plays} plays, {dead_zones} dead zones");
        let rmse = |mode| rmse_percent(&model, mode);
        assert_between(&format!("{what}, feed-forward only"), rmse(Mode::FeedforwardOnly), alone);
        assert_between(&format!("{what}, both"), rmse(Mode::Both), both);
    }
}
