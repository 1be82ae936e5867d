//! Closed loops of the shipped control code against plants, on the host and at full speed.
//!
//! [`run`] is a board without hardware: the same [`firmware::Control`] as in the images, with its converters'
//! codes on both sides. The tests of this package hold its figures within bounds on both sides, so that a
//! drift to the better, which is as suspect as one to the worse, fails too.

use firmware::{Control, LockStepBoard, order::prepare, scaling};
use model_core::pid::PidParameters;
use model_core::{MgpiParameters, Mode, TrackingParameters};
use wire::{Configuration, Flags, Request, Response, TickRequest, VERSION};
use workbench::figures::Figures;

/// The board's tick. Unit: s.
pub const PERIOD_S: f64 = 1e-3;

/// A plant: takes the command (bar) for a period, answers pressure (bar) and contraction (mm).
pub type Plant<'a> = dyn FnMut(f64) -> (f64, f64) + 'a;

/// A board's configuration with the paper's gains for a model of the host.
///
/// # Panics
/// The model does not fit the board.
pub fn configuration<const N: usize, const M: usize>(model: &MgpiParameters<f64, N, M>) -> Configuration {
    Configuration {
        version: VERSION,
        tracking: TrackingParameters {
            command_min: 0.0,
            command_max: model.input_max as f32,
            model: model.convert().expect("the model fits the board"),
            pid: PidParameters::paper(),
            slew_bar_per_s: 100.0,
            period_s: PERIOD_S as f32,
        },
    }
}

/// Raised cosines from `floor_mm`, a period of 20 s each, after a smooth approach of 2 s; at the board's tick.
/// Unit: mm.
pub fn raised_cosines(floor_mm: f64, amplitudes_mm: &[f64]) -> Vec<f64> {
    let rise = |share: f64| (1.0 - (std::f64::consts::PI * share).cos()) / 2.0;
    let approach = (0..2000).map(|k| floor_mm * rise(f64::from(k) / 2000.0));
    let swing = |amplitude: &f64| {
        let amplitude = *amplitude;
        (0..20_000).map(move |k| floor_mm + amplitude * rise(f64::from(k) / 10_000.0))
    };
    approach.chain(amplitudes_mm.iter().flat_map(swing)).collect()
}

/// Runs the control code from rest against a plant, and answers the contraction at every tick. Unit: mm.
///
/// # Panics
/// The board refuses the configuration, or a fault ends the run.
pub fn run(
    configuration: &Configuration,
    mode: Mode,
    reference_mm: &[f64],
    plant: &mut Plant<'_>,
) -> Vec<f64> {
    let mut control = Control::new();
    let mut board = LockStepBoard::new();
    for request in [Request::Configure(configuration.clone()), Request::Start(mode)] {
        let order = prepare(request).expect("a valid request");
        assert_eq!(control.apply(order), Response::Accepted);
    }
    let tick = |&reference_mm: &f64| {
        let command_bar = f64::from(scaling::COMMAND.value(board.output().0));
        let (pressure_bar, contraction_mm) = plant(command_bar);
        let request = TickRequest {
            reference_mm: reference_mm as f32,
            pressure_code: scaling::PRESSURE.code(pressure_bar as f32),
            contraction_code: scaling::CONTRACTION.code(contraction_mm as f32),
        };
        let reply = board.tick(&mut control, request);
        assert!(reply.flags.contains(Flags::TRACKING), "a fault ended the run: {:?}", control.state());
        contraction_mm
    };
    reference_mm.iter().map(tick).collect()
}

/// Tracking figures of a run, without its first `skipped` ticks. Unit: mm.
pub fn figures(reference_mm: &[f64], contraction_mm: &[f64], skipped: usize) -> Figures {
    let scored: Vec<bool> = (0..reference_mm.len()).map(|tick| tick >= skipped).collect();
    Figures::of(contraction_mm, reference_mm, &scored)
}
