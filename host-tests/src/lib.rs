//! Closed loops of the shipped control code against plants, on the host and at full speed.
//!
//! [`HostBoard`] is a board without hardware: the same [`firmware::Control`] as in the images,
//! behind the same requests, in the same lock-step as `mgpi pil`. The tests of this package hold
//! its figures within bounds on both sides, so that a drift to the better, which is as suspect as
//! one to the worse, fails too.

pub mod bench;
pub mod bus;
pub mod commands;
pub mod control;
pub mod desk;
pub mod desk_commands;
pub mod flash;
pub mod game;
pub mod joint;
pub mod joint_desk;
pub mod kept_joint;
pub mod single;
pub mod store;

use board_client::pil::lock_step::{self, Board, Measurement, Plant, Run, Wanted};
use board_client::pil::{PilError, preview_s};
use firmware::order::prepare;
use firmware::{BlackBox, Capture, Control, LockStepBoard};
use identification::{HostParameters, Options, Problem, identify, simulate};
use model_core::pid::PidParameters;
use model_core::{
    ExtensionParameters, Mode, Model, ModelParameters, ObserverParameters, Surroundings, TrackingParameters,
    paper,
};
use recording::figures::Figures;
use rig::parameters::DEAD_LOAD_N;
use rig::sensor::Sensors;
use wire::{Configuration, Protection, Request, Response, VERSION};

/// The board's tick. Unit: s.
pub const PERIOD_S: f64 = 1e-3;

/// The board's control code on the host.
#[derive(Debug)]
pub struct HostBoard {
    control: Control,
    board: LockStepBoard,
}

impl HostBoard {
    /// A board with these limits of the plant.
    pub fn protected(protection: Protection) -> Self {
        // The control keeps both for as long as the board runs.
        Self::with(protection, Box::leak(Box::default()), Box::leak(Box::default()))
    }

    /// The same board, its power lost and come back, with these limits.
    pub fn restarted(self, protection: Protection) -> Self {
        let (black_box, capture) = self.control.into_memory();
        *black_box = BlackBox::default();
        *capture = Capture::default();
        Self::with(protection, black_box, capture)
    }

    fn with(protection: Protection, black_box: &'static mut BlackBox, capture: &'static mut Capture) -> Self {
        Self { control: Control::new(protection, None, black_box, capture), board: LockStepBoard::new() }
    }
}

impl Default for HostBoard {
    fn default() -> Self {
        Self::protected(Protection::SIMULATED)
    }
}

impl Board for HostBoard {
    fn request(&mut self, request: &Request) -> Result<Response, PilError> {
        Ok(match request {
            Request::Tick(tick) => Response::Tick(self.board.tick(&mut self.control, *tick)),
            other => prepare(other).map_or_else(Response::Refused, |order| self.control.apply(order)),
        })
    }
}

/// A plant that is a function of the command (bar), called once a tick: pressure (bar), contraction
/// (mm).
pub struct FunctionPlant<F>(pub F);

impl<F: FnMut(f64) -> (f64, f64)> Plant for FunctionPlant<F> {
    fn advance(&mut self, _: f64, command_bar: f32) -> Result<Measurement, PilError> {
        let (pressure_bar, contraction_mm) = (self.0)(command_bar.into());
        Ok(Measurement { pressure_bar, contraction_mm, surroundings: Surroundings::default() })
    }
}

/// The rig with noisy sensors, one tick a call.
pub fn rig(seed: u64) -> FunctionPlant<impl FnMut(f64) -> (f64, f64)> {
    let mut rig = rig::plant::Plant::at_rest(DEAD_LOAD_N, Sensors::noisy(seed));
    FunctionPlant(move |command| {
        let measured = rig.step(command, PERIOD_S);
        (measured.pressure_bar, measured.contraction_mm)
    })
}

/// A board's configuration with the paper's gains for a model of the host.
///
/// # Panics
/// The model does not fit the board.
pub fn configuration<const N: usize, const M: usize>(model: &ModelParameters<f64, N, M>) -> Configuration {
    Configuration {
        version: VERSION,
        tracking: TrackingParameters {
            command_min: 0.0,
            command_max: model.input().1 as f32,
            model: model.convert().expect("the model fits the board"),
            extensions: ExtensionParameters::default(),
            pid: PidParameters::paper(),
            observer: ObserverParameters::default(),
            slew_bar_per_s: 100.0,
            period_s: PERIOD_S as f32,
        },
    }
}

/// A model identified from triangles of falling amplitude of the paper's model.
///
/// # Panics
/// None can be identified with these options.
pub fn identified(options: &Options) -> HostParameters {
    let truth = paper::mgpi().and_then(|parameters| parameters.convert()).expect("valid");
    let truth = Model::try_new(&ModelParameters::Cascade(truth)).expect("valid");
    let triangle = |height: f64| (0..400).map(move |k| height * (1.0 - (f64::from(k) / 200.0 - 1.0).abs()));
    let input: Vec<f64> = [6.0, 5.0, 4.0, 3.0, 2.0, 1.0].into_iter().flat_map(triangle).collect();
    let output = simulate(&truth, &input);
    let problem = Problem { input: &input, output: &output, scored: &vec![true; input.len()] };
    identify(&problem, options, &|_| ()).expect("identified").parameters
}

/// Raised cosines from `floor_mm`, a period of 20 s each, after a smooth approach of 2 s; at the
/// board's tick. Unit: mm.
pub fn raised_cosines(floor_mm: f64, amplitudes_mm: &[f64]) -> Vec<f64> {
    let rise = |share: f64| (1.0 - (std::f64::consts::PI * share).cos()) / 2.0;
    let approach = (0..2000).map(|k| floor_mm * rise(f64::from(k) / 2000.0));
    let swing = |amplitude: &f64| {
        let amplitude = *amplitude;
        (0..20_000).map(move |k| floor_mm + amplitude * rise(f64::from(k) / 10_000.0))
    };
    approach.chain(amplitudes_mm.iter().flat_map(swing)).collect()
}

/// Runs a board from rest against a plant, a reference value (mm) a tick, which the board is given
/// ahead by the delay of its model, in whole ticks.
///
/// # Errors
/// Board or plant do not do their part.
pub fn run(
    board: &mut impl Board,
    plant: &mut impl Plant,
    configuration: &Configuration,
    mode: Mode,
    reference_mm: &[f64],
) -> Result<Run, PilError> {
    let preview = (preview_s(configuration) / PERIOD_S).round() as usize;
    let ahead_mm =
        reference_mm.iter().skip(preview).chain(std::iter::repeat(&reference_mm[reference_mm.len() - 1]));
    let wanted = reference_mm.iter().zip(ahead_mm).enumerate().map(|(tick, (&reference_mm, &ahead_mm))| {
        Wanted { time_s: tick as f64 * PERIOD_S, reference_mm, ahead_mm }
    });
    lock_step::run(board, plant, configuration, mode, wanted, &|| ())
}

/// Tracking figures of a run, without its first 2 s. Unit: mm.
pub fn figures(run: &Run) -> Figures {
    let (reference, contraction): (Vec<f64>, Vec<f64>) =
        run.samples.iter().map(|sample| (sample.reference_mm, sample.measured.contraction_mm)).unzip();
    let scored: Vec<bool> = run.samples.iter().map(|sample| sample.time_s >= 2.0).collect();
    Figures::of(&contraction, &reference, &scored)
}
