//! Hysteresis of a form that the plain model cannot have.

use super::*;

use crate::Columns;
use identification::{HostModel, HostParameters, simulate};
use model_core::agpi::AgpiParameters;
use model_core::egpi::EgpiParameters;
use model_core::envelope::{EnvelopeParameters, TanhParameters};
use model_core::memoryless::MemorylessParameters;
use model_core::play::PlayParameters;

/// A muscle whose rising and falling branches have envelopes of their own, under swings of one speed and many heights.
fn of_two_envelopes() -> Columns {
    let tanh = |c1, c2| EnvelopeParameters::Tanh(TanhParameters { c0: 2.84, c1, c2, c3: 0.398 });
    let agpi = AgpiParameters {
        rising: tanh(0.0596, -0.140),
        falling: tanh(0.0603, -0.139),
        plays: PlayParameters::exponential(10, 0.0022, 3.0, 16.8, 0.0826).expect("plays"),
        gain: 55.6,
        offset: -0.98,
        input_min: 0.0,
        input_max: 6.0,
        preconditioned: true,
    };
    let memoryless = MemorylessParameters { rises: [27.4, 1.14, 0.0] };
    let model = HostModel::try_new(&HostParameters::Egpi(EgpiParameters { agpi, memoryless }));
    let (mut pressure, mut target) = (0.0, 0);
    let targets = [6.0, 0.0, 5.0, 1.0, 4.0, 2.0, 6.0, 3.0, 5.5, 0.5, 4.5, 1.5, 3.5, 0.0];
    let input: Vec<f64> = (0..8000)
        .map(|_| {
            let goal: f64 = targets[target % targets.len()];
            pressure += (goal - pressure).clamp(-0.01, 0.01);
            target += usize::from(pressure == goal);
            pressure
        })
        .collect();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
    let output = simulate(&model.expect("a model"), &input).iter().map(|y| y + 0.03 * noise()).collect();
    let time_s = (0..input.len()).map(|row| row as f64 * STEP_S).collect();
    Columns { time_s, scored: vec![true; input.len()], input, output, ..Columns::default() }
}

#[test]
fn a_form_that_the_plain_model_cannot_have_is_written_and_no_cause() {
    let columns = of_two_envelopes();
    let (diagnosis, extended) = diagnose_and_extend(&columns, None, &|_, _| ()).expect("a diagnosis");
    assert_eq!(diagnosis.verdict, Verdict::Adequate, "{:?}", diagnosis.unexplained);
    assert_eq!(names(&diagnosis), []);
    let written = extended.written(&columns, None).expect("a model");
    assert!(written.rmse < 0.5 * written.plain_rmse && written.gain.is_sure(), "{}", written.rmse);
    assert_ne!(written.model.form(), extended.plain.form());
}

#[test]
fn what_is_written_is_no_further_off_on_the_given_samples_than_the_plain_model() {
    let columns = of_two_envelopes();
    let (_, mut extended) = diagnose_and_extend(&columns, None, &|_, _| ()).expect("a diagnosis");
    // As if the fit to all samples had gone astray, after that to the first two thirds has predicted the last one well.
    match &mut extended.model.parameters {
        HostParameters::Cascade(cascade) => cascade.dead_zones.offset += 50.0,
        HostParameters::Agpi(agpi) => agpi.offset += 50.0,
        HostParameters::Egpi(egpi) => egpi.agpi.offset += 50.0,
    }
    let written = extended.written(&columns, None).expect("a model");
    assert_eq!(written.rmse, written.plain_rmse);
}

#[test]
fn beside_a_noisy_pressure_nothing_is_named() {
    let noisy = sensors::noisier(of_two_envelopes(), 0.1).with_smooth_input();
    let (diagnosis, extended) = diagnose_and_extend(&noisy, None, &|_, _| ()).expect("a diagnosis");
    assert_eq!(names(&diagnosis), []);
    // What is written is driven by the noise too: there the operator of that input is no worse.
    let measured = noisy.as_measured();
    let written = extended.written(&measured, None).expect("a model");
    assert!(written.rmse <= written.plain_rmse, "{} {}", written.rmse, written.plain_rmse);
}
