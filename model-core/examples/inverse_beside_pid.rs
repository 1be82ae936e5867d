//! A muscle that follows a reference: the inverse model as feed-forward, the PID beside it, and
//! each of them alone.
//!
//! `cargo run -p model-core --example inverse_beside_pid`

use model_core::pid::PidParameters;
use model_core::{
    ExtensionParameters, Hysteresis, Mgpi, Mode, ModelParameters, ObserverParameters, Tracking,
    TrackingParameters, paper,
};

/// From sample to sample. Unit: s.
const PERIOD_S: f64 = 0.001;

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let model = paper::mgpi()?;
    // The plant contracts by 5 % less than the model says: there is something left to correct.
    let mut weaker = model.clone();
    weaker.dead_zones.weights.iter_mut().for_each(|weight| *weight *= 0.95);
    let muscle = Mgpi::try_new(&weaker)?;
    let controller = Tracking::try_new(&TrackingParameters {
        model: ModelParameters::Cascade(model),
        extensions: ExtensionParameters::default(),
        pid: PidParameters::paper(),
        observer: ObserverParameters::default(),
        command_min: 0.0,
        command_max: paper::PRESSURE_MAX_BAR,
        slew_bar_per_s: 60.0,
        period_s: PERIOD_S,
    })?;
    for mode in [Mode::Both, Mode::FeedforwardOnly, Mode::FeedbackOnly] {
        let (mut state, mut plant) = (controller.rest_state(mode), muscle.rest_state());
        let (mut contraction, mut squares) = (muscle.step(&mut plant, 0.0)?, 0.0);
        let samples = 20_000;
        for sample in 0..samples {
            let phase = core::f64::consts::TAU * 0.1 * PERIOD_S * f64::from(sample);
            let reference = 40.0 - 40.0 * phase.cos(); // mm
            let command = controller.step(&mut state, mode, reference, contraction)?.command;
            contraction = muscle.step(&mut plant, command)?;
            squares += (contraction - reference).powi(2);
        }
        println!("{mode:?}: RMSE {:.2} mm", (squares / f64::from(samples)).sqrt());
    }
    Ok(())
}
