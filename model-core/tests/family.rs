//! What holds for single members of the family: kinds, states at rest, steps of the fixed point,
//! refusals.

use model_core::agpi::{Agpi, AgpiParameters};
use model_core::dead_zone::DeadZoneParameters;
use model_core::egpi::{Egpi, EgpiParameters};
use model_core::envelope::{EnvelopeParameters, PiecewiseLinearParameters, TanhParameters};
use model_core::memoryless::MemorylessParameters;
use model_core::play::PlayParameters;
use model_core::{
    Hysteresis, InverseHysteresis, Invertible, Kind, List, Model, ModelParameters, cpi, mgpi::Mgpi, mpi,
    paper, sgpi,
};
use proptest::prelude::*;

const SIZE: usize = 16;
type Parameters = ModelParameters<f64, SIZE, SIZE>;

fn tanh(c2: f64, c3: f64) -> EnvelopeParameters<f64> {
    EnvelopeParameters::Tanh(TanhParameters { c0: 1.2, c1: 0.3, c2, c3 })
}

fn knots() -> EnvelopeParameters<f64> {
    EnvelopeParameters::PiecewiseLinear(PiecewiseLinearParameters {
        inputs: [0.0, 1.0, 2.5, 4.0, 6.0].into_iter().collect(),
        values: [0.0, 0.1, 0.5, 0.8, 1.0].into_iter().collect(),
    })
}

/// Thresholds up to half the height of the envelope.
fn plays(height: f64) -> PlayParameters<f64, SIZE> {
    PlayParameters::exponential(10, 0.35, 0.2, 3.0 / height, 0.05 * height).expect("fits")
}

fn agpi() -> AgpiParameters<f64, SIZE> {
    AgpiParameters {
        // The falling envelope lies above by up to 0.12 and meets the rising one towards the upper
        // end.
        rising: tanh(-0.8, 0.0),
        falling: tanh(-0.7, 0.01),
        plays: plays(1.0),
        gain: 70.0,
        offset: -2.0,
        input_min: 0.0,
        input_max: 6.0,
        preconditioned: false,
    }
}

fn egpi() -> EgpiParameters<f64, SIZE> {
    EgpiParameters { agpi: agpi(), memoryless: MemorylessParameters { rises: [8.0, 1.0, 15.0] } }
}

fn modified() -> Parameters {
    let dead_zones = DeadZoneParameters {
        thresholds: [-1.5, -0.5, 0.0, 0.4, 1.1].into_iter().collect(),
        weights: [6.0, -3.0, 12.0, -4.0, 7.0].into_iter().collect(),
        offset: 4.0,
    };
    ModelParameters::Cascade(mpi::parameters(plays(3.0), dead_zones, (-3.0, 3.0)))
}

fn family() -> Vec<Parameters> {
    let line = |envelope| sgpi::parameters(envelope, plays(1.0), 80.0, 3.0, (0.0, 6.0)).expect("fits");
    let mut bent = paper::mgpi().expect("valid").convert().expect("fits");
    bent.envelope = knots();
    vec![
        ModelParameters::Cascade(cpi::parameters(plays(3.0), 12.0, -1.0, (-2.0, 5.0)).expect("fits")),
        ModelParameters::Cascade(line(tanh(-0.8, 0.0))),
        ModelParameters::Cascade(line(knots())),
        modified(),
        ModelParameters::Cascade(paper::mgpi().expect("valid").convert().expect("fits")),
        ModelParameters::Cascade(bent),
        ModelParameters::Agpi(agpi()),
        ModelParameters::Egpi(egpi()),
    ]
}

proptest! {
    #[test]
    fn an_input_that_rests_keeps_its_branch(history in prop::collection::vec(0.0..6.0, 1..20)) {
        let model = Agpi::try_new(&agpi()).unwrap();
        let mut state = model.rest_state();
        for x in history {
            let y = model.step(&mut state, x).unwrap();
            prop_assert_eq!(model.step(&mut state, x).unwrap(), y);
        }
    }

    #[test]
    fn the_steps_of_the_fixed_point_reach_their_tolerance(wanted in prop::collection::vec(0.0..120.0, 1..60)) {
        let model = Egpi::try_new(&egpi()).unwrap();
        let inverse = model.inverse().unwrap();
        let (mut state, mut inverse_state) = (model.rest_state(), inverse.rest_state());
        let (low, high) = model.output_range();
        for y in wanted.into_iter().filter(|y| (low + 10.0..high - 10.0).contains(y)) {
            let x = inverse.step(&mut inverse_state, y).unwrap();
            let error = (model.step(&mut state, x).unwrap() - y).abs();
            prop_assert!(error <= 1.01 * inverse.tolerance(), "{error} at {y}");
        }
    }
}

#[test]
fn the_kind_is_that_of_the_parameters() {
    let kinds: Vec<Kind> = family().iter().map(ModelParameters::kind).collect();
    use Kind::{Agpi, Cpi, Egpi, Mgpi, Mpi, Sgpi};
    assert_eq!(kinds, [Cpi, Sgpi, Sgpi, Mpi, Mgpi, Mgpi, Agpi, Egpi]);
}

#[test]
fn a_single_dead_zone_and_equal_envelopes_are_the_symmetric_model() {
    let envelope = tanh(-0.8, 0.0);
    let one = sgpi::parameters::<f64, SIZE, 1>(envelope.clone(), plays(1.0), 70.0, -2.0, (0.0, 6.0));
    let one = Mgpi::try_new(&one.expect("fits")).expect("valid");
    let two = AgpiParameters { rising: envelope.clone(), falling: envelope, ..agpi() };
    let two = Agpi::try_new(&two).expect("valid");
    let (mut one_state, mut two_state) = (one.rest_state(), two.rest_state());
    for k in 0..400 {
        let x = 3.0 + 3.0 * (f64::from(k) * 0.13).sin() * (f64::from(k) * 0.017).cos();
        let (y, z) = (one.step(&mut one_state, x).unwrap(), two.step(&mut two_state, x).unwrap());
        assert!((y - z).abs() < 1e-12, "{y} {z} at {x}");
    }
}

#[test]
fn a_falling_envelope_below_the_rising_one_is_refused() {
    let parameters = AgpiParameters { falling: tanh(-0.9, 0.0), ..agpi() };
    let error = Agpi::try_new(&parameters).expect_err("must be refused");
    assert!(error.parameter.starts_with("falling envelope"), "{error}");
}

#[test]
fn a_memoryless_function_without_a_proven_inverse_is_refused() {
    let inverse = |rises| {
        let parameters = EgpiParameters { memoryless: MemorylessParameters { rises }, ..egpi() };
        Egpi::try_new(&parameters).expect("a model").inverse()
    };
    let error = inverse([-20.0, 0.0, 0.0]).expect_err("the output would fall");
    assert!(error.parameter.starts_with("least slope of the output"), "{error}");
    let error = inverse([0.0, 0.0, 1e12]).expect_err("too slow");
    assert!(error.parameter.starts_with("steps of the fixed-point inverse"), "{error}");
    // Far beyond where the iteration alone contracts in time.
    assert!(inverse([0.0, 0.0, 4000.0]).is_ok());
}

#[test]
fn the_memoryless_function_rises_as_its_parameters_say() {
    let list: List<f64, 3> = [8.0, 1.0, 15.0].into_iter().collect();
    let model = Egpi::try_new(&egpi()).expect("valid");
    let plain = Agpi::try_new(&agpi()).expect("valid");
    let (_, high) = model.output_range();
    let (_, plain_high) = plain.output_range();
    assert!((high - plain_high - list.iter().sum::<f64>()).abs() < 1e-12);
}

#[test]
fn a_preconditioned_muscle_rests_as_after_a_full_cycle() {
    for parameters in family() {
        let fresh = Model::try_new(&parameters).expect("valid");
        let cycled = Model::try_new(&parameters.clone().with_preconditioned(true)).expect("valid");
        let (mut one, mut other) = (fresh.rest_state(), cycled.rest_state());
        let range = fresh.input_range();
        let cycle = [range.max(), range.min()];
        let last = cycle.map(|x| fresh.step(&mut one, x).expect("finite"))[1];
        let same = |y: f64, other: f64| {
            assert!((y - other).abs() < 1e-10, "{}: {y} and {other}", parameters.kind());
        };
        same(cycled.step(&mut other, range.min()).expect("finite"), last);
        for k in 0..100 {
            let x = range.min() + (range.max() - range.min()) * (0.5 - 0.5 * (f64::from(k) * 0.4).cos());
            let y = fresh.step(&mut one, x).expect("finite");
            same(cycled.step(&mut other, x).expect("finite"), y);
        }
    }
}

/// Searches take short ways that depend on how many operators of the capacity are in use.
#[test]
fn every_number_of_operators_of_the_boards_capacity_has_an_exact_inverse() {
    const BOARD: usize = 32;
    let mut seed = 1_u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 8) / f64::from(1 << 24)
    };
    for plays in [1, 5, 14, 15, 16, 17, 31, 32] {
        for zones in [1, 5, 15, 16, 17, 18, 31, 32] {
            let bank = PlayParameters::exponential(plays, 0.3, 1.0 / plays as f64, 2.0, 0.8 / plays as f64);
            let weight = |j: usize| if j == 0 { 60.0 } else { 40.0 / zones as f64 };
            let parameters = model_core::MgpiParameters::<f64, BOARD, BOARD> {
                envelope: tanh(-0.8, 0.0),
                plays: bank.expect("fits"),
                dead_zones: DeadZoneParameters {
                    thresholds: (0..zones).map(|j| j as f64 / zones as f64).collect(),
                    weights: (0..zones).map(weight).collect(),
                    offset: 1.0,
                },
                input_min: 0.0,
                input_max: 6.0,
                preconditioned: false,
            };
            let model = Mgpi::try_new(&parameters).expect("valid");
            let inverse = model.inverse().expect("invertible");
            let (mut state, mut inverse_state) = (model.rest_state(), inverse.rest_state());
            for k in 0..300 {
                // Ever narrower swings, then anywhere.
                let narrowing =
                    0.5 + 0.5 * (1.0 - f64::from(k) / 100.0) * if k % 2 == 0 { 1.0 } else { -1.0 };
                let x = 6.0 * if k < 100 { narrowing } else { random() };
                let y = model.step(&mut state, x).expect("finite");
                let back = inverse.step(&mut inverse_state, y).expect("finite");
                assert!((back - x).abs() < 1e-9, "{plays} plays, {zones} dead zones: {back} for {x}");
            }
        }
    }
}
