//! A made-up muscle whose extensions are known.

use model_core::envelope::EnvelopeParameters;
use model_core::extension::{
    CreepParameters, DriftParameters, ProfileParameters, RateDependentThresholdsParameters,
    RateDependentWidthParameters, TransportDelayParameters, ValveLagParameters,
};
use model_core::{ExtensionParameters, Kind};

use super::given::judge;
use super::heldout::gain;
use super::jump::Jump;
use super::task::Task;
use super::{Extension, Operator, Plain, Split, plainer};
use crate::Columns;
use identification::{CONVERGED, HostParameters, Loss, Options, Problem, Weights, identify};

/// Triangles of several heights and speeds, with a hold. Units: s, bar.
fn drive() -> (Vec<f64>, Vec<f64>) {
    let time_s: Vec<f64> = (0..1500).map(|row| f64::from(row) * 0.02).collect();
    let input = |&t: &f64| {
        let period_s = if t < 15.0 { 3.0 } else { 1.0 };
        let place = (t / period_s).fract();
        let height = 6.0 - 0.9 * (t / 3.0).floor().rem_euclid(5.0);
        height * (1.0 - (2.0 * place - 1.0).abs())
    };
    let input = time_s.iter().map(input).collect();
    (time_s, input)
}

/// An operator with a few effects.
pub fn model() -> Extension {
    let (_, input) = drive();
    let mut play = 0.0;
    let output: Vec<f64> = input
        .iter()
        .map(|&p| {
            play = f64::clamp(play, p - 0.4, p + 0.4);
            30.0 * (0.5 * (0.6 * p + 0.4 * play) - 1.2).tanh() + 25.0
        })
        .collect();
    let problem = Problem { input: &input, output: &output, scored: &vec![true; input.len()] };
    let options = Options {
        model: Kind::Mgpi,
        knots: Some(6),
        plays: 4,
        weights: Weights::Exponential,
        dead_zones: 4,
        loss: Loss::Squares,
        starts: 2,
        seed: 1,
        threads: 1,
        tolerance: CONVERGED,
    };
    let fit = identify(&problem, &options, &|_| ()).expect("a model");
    let extensions = ExtensionParameters {
        valve_lag: Some(ValveLagParameters::new(0.1)),
        transport_delay: Some(TransportDelayParameters { delay_s: 0.05 }),
        viscous_lag: Some(ProfileParameters::constant(0.004)),
        rate_dependent_thresholds: Some(RateDependentThresholdsParameters {
            exponent: 0.5,
            filter_s: 0.01,
            gain: ProfileParameters::constant(0.05),
            pressure: None,
        }),
        creep: Some(CreepParameters {
            time_constants_s: [1.0].into_iter().collect(),
            fractions: [0.1].into_iter().collect(),
        }),
        drift: Some(DriftParameters { rate_per_s: 0.02, compensated: false }),
        ..ExtensionParameters::default()
    };
    let jump = Some(Jump { time_s: 20.0, height: 0.4 });
    Extension { parameters: fit.parameters, density: fit.density, extensions, jump }
}

/// What that muscle would be recorded to do.
pub fn recorded(model: &Extension) -> Columns {
    let (time_s, input) = drive();
    let scored = vec![true; time_s.len()];
    let columns = Columns { time_s, input, input_is_command: true, scored, ..Columns::default() };
    Columns { output: model.answer(&columns).expect("it runs"), ..columns }
}

#[test]
fn refining_finds_the_effects_again() {
    let truth = model();
    let columns = recorded(&truth);
    let rows: Vec<usize> = (0..columns.time_s.len()).collect();
    let task = Task { reached: 0.1, ..Task::alone(&columns, &rows) };
    let mut start = truth.clone();
    start.extensions.transport_delay = Some(TransportDelayParameters { delay_s: 0.03 });
    start.extensions.viscous_lag = Some(ProfileParameters::constant(0.002));
    let before = task.rms(&start).expect("it runs");
    let (found, _) = task.refined(start).expect("it runs");
    let after = task.rms(&found).expect("it runs");
    assert!(after < 0.1 * before, "{before} {after}");
    let delay_s = found.extensions.transport_delay.expect("a delay").delay_s;
    assert!((delay_s - 0.05).abs() < 0.005, "{delay_s}");
}

#[test]
fn a_slope_that_no_row_teaches_becomes_as_those_beside_it() {
    let truth = model();
    let mut columns = recorded(&truth);
    // The highest knots are at 4.8 and 6 bar.
    columns.input.iter_mut().for_each(|input| *input = input.min(4.5));
    columns.output = truth.answer(&columns).expect("it runs");
    let rows: Vec<usize> = (0..columns.time_s.len()).collect();
    let task = Task { reached: 0.1, ..Task::alone(&columns, &rows) };
    let rises = |model: &Extension| -> Vec<f64> {
        let HostParameters::Cascade(cascade) = &model.parameters else { panic!("a cascade") };
        let EnvelopeParameters::PiecewiseLinear(envelope) = &cascade.envelope else { panic!("knots") };
        envelope.values.windows(2).map(|pair| pair[1] - pair[0]).collect()
    };
    let mut wild = truth.clone();
    if let HostParameters::Cascade(cascade) = &mut wild.parameters
        && let EnvelopeParameters::PiecewiseLinear(envelope) = &mut cascade.envelope
        && let Some(last) = envelope.values.last_mut()
    {
        *last += 100.0 * rises(&truth)[4];
    }
    let (found, _) = task.refined(wild).expect("it runs");
    let ratio = rises(&found)[4] / rises(&found)[3];
    assert!((0.2..5.0).contains(&ratio), "{:?}", rises(&found));
}

#[test]
fn a_plain_model_that_has_come_to_a_worse_end_begins_from_the_operator_beside_a_cause() {
    let beside_a_cause = model();
    let sound = Extension { extensions: ExtensionParameters::default(), ..beside_a_cause.clone() };
    let columns = recorded(&sound);
    let rows: Vec<usize> = (0..columns.time_s.len()).collect();
    let task = Task::alone(&columns, &rows);
    let mut worse = sound.clone();
    let HostParameters::Cascade(cascade) = &mut worse.parameters else { panic!("a cascade") };
    cascade.dead_zones.weights.iter_mut().for_each(|weight| *weight *= 1.5);
    let plain = plainer(&task, worse.clone(), &beside_a_cause);
    assert_eq!(plain.extensions, ExtensionParameters::default());
    assert!(task.rms(&plain) < task.rms(&worse), "{:?} {:?}", task.rms(&plain), task.rms(&worse));
    assert_eq!(plainer(&task, sound.clone(), &worse).parameters, sound.parameters);
}

#[test]
fn a_given_operator_whose_thresholds_cannot_change_is_extended_before_itself() {
    let truth = model();
    let columns = recorded(&truth);
    let rows: Vec<usize> = (0..columns.time_s.len()).collect();
    let task = Task { reached: 0.1, ..Task::alone(&columns, &rows) };
    let plain = Extension { extensions: ExtensionParameters::default(), ..truth.clone() };
    let before = |all: &ExtensionParameters<f64>| ExtensionParameters {
        rate_dependent_thresholds: None,
        rate_dependent_width: Some(RateDependentWidthParameters {
            radius: 0.4,
            exponent: 0.5,
            filter_s: 0.01,
            width: ProfileParameters::constant(0.05),
        }),
        ..all.clone()
    };
    let form = |parameters| {
        let operator = Operator { parameters, density: truth.density };
        let (_, refitted) = judge(&task, &operator, (&plain, &truth), before).expect("it runs");
        refitted.extensions.rate_dependent_thresholds.is_some()
    };
    assert!(form(truth.parameters.clone()));
    let HostParameters::Cascade(mut negative) = truth.parameters.clone() else { panic!("a cascade") };
    negative.plays.weights[1] = -0.1 * negative.plays.q;
    assert!(!form(HostParameters::Cascade(negative)));
}

#[test]
fn the_gain_is_that_of_the_rows_asked_for() {
    let truth = model();
    let columns = recorded(&truth);
    let plain = Extension { extensions: ExtensionParameters::default(), ..truth.clone() };
    let split = Split::of(&columns, &(0..1500).collect::<Vec<_>>());
    let gained = gain(&columns, &split, (&plain, &truth), 0.0).expect("enough rows");
    assert_eq!(gained.from_s, Some(columns.time_s[1000]));
    assert_eq!(gained.after.rmse, 0.0);
    assert!((gained.share().expect("something to gain") - 1.0).abs() < 1e-12);
    assert!(gained.is_sure());
    assert!(!gain(&columns, &split, (&truth, &plain), 0.0).expect("enough rows").is_sure());
    assert!(gained.before.rmse > 0.5, "{}", gained.before.rmse);
    let few = Split { untaught: split.untaught[..5].to_vec(), ..split };
    assert_eq!(gain(&columns, &few, (&plain, &truth), 0.0), None);
}

#[test]
fn a_plain_model_is_found_in_a_fast_recording_and_holds_for_all_its_inputs() {
    // 1 kHz, of which one sample in 100 is scored; the last triangle goes farthest.
    let time_s: Vec<f64> = (0..30_000).map(|row| f64::from(row) * 0.001).collect();
    let input = |t: &f64| (4.0 + (t / 7.5).floor()) * (1.0 - (2.0 * (t / 7.5).fract() - 1.0).abs());
    let input: Vec<f64> = time_s.iter().map(input).collect();
    let mut play = 0.0;
    let output = input.iter().map(|&p| {
        play = f64::clamp(play, p - 0.4, p + 0.4);
        30.0 * (0.2 * (p + play) - 1.2).tanh()
    });
    let output = output.collect();
    let columns = Columns { scored: vec![true; input.len()], time_s, input, output, ..Columns::default() };
    let scored: Vec<usize> = (0..30_000).step_by(100).collect();
    let plain = Plain::new(&columns, &scored).expect("a model");
    let whole = plain.whole.rmse(&columns);
    // Of a stroke of 52 mm.
    assert!(whole < 0.5, "{whole}");
    for model in [&plain.whole, &plain.taught] {
        let (low, high) = model.parameters.input();
        assert!(low <= 0.0 && high >= 6.99, "{low} to {high}");
    }
    let Columns { input, output, scored, .. } = &columns;
    let options = Options {
        model: Kind::Mgpi,
        knots: None,
        plays: 10,
        weights: Weights::Exponential,
        dead_zones: 10,
        loss: Loss::Squares,
        starts: identification::STARTS,
        seed: identification::SEED,
        threads: 0,
        tolerance: CONVERGED,
    };
    let alone = identify(&Problem { input, output, scored }, &options, &|_| ()).expect("a fit");
    let alone = recording::figures::Figures::of(output, &alone.simulated, scored).rmse;
    assert!(whole <= 1.001 * alone, "{whole} {alone}");
}
