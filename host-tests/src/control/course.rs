//! One run of the control code with a plant.

use model_core::{Mode, Surroundings};
use rig::plant::Plant;
use wire::BoardTracking;

use super::reference::Course;
use crate::PERIOD_S;
use wire::registers::HIGHEST_BAR;

/// A step of the command's converter: 10 bar in 12 bits. Unit: bar.
pub(super) const STEP_BAR: f64 = 10.0 / 4096.0;

/// A tick in the log.
#[derive(Clone, Copy, Debug)]
pub struct Tick {
    /// What was to be reached. Unit: mm.
    pub reference_mm: f64,
    /// What the sensor said. Unit: mm.
    pub measured_mm: f64,
    /// What an exact sensor would have said. Unit: mm.
    pub contraction_mm: f64,
    /// Unit: bar.
    pub command_bar: f64,
}

/// What a run is made of.
#[derive(Debug)]
pub struct Setting<'a> {
    /// The controller.
    pub tracking: &'a BoardTracking,
    /// What acts.
    pub mode: Mode,
    /// How far ahead the reference is given. Unit: s.
    pub preview_s: f64,
    /// A value a tick. Unit: mm.
    pub reference_mm: &'a [f64],
    /// What is added to it, a value a tick. Unit: mm.
    pub correction_mm: &'a [f64],
    /// What load comes when.
    pub course: Course,
    /// Force at 6 bar and no contraction. Unit: N.
    pub blocked_n: f64,
    /// What becomes of a command.
    pub converter: Converter,
}

/// What becomes of a command on its way to the valve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Converter {
    /// 12 bits over 10 bar.
    Steps,
    /// The command itself.
    Exact,
}

/// Runs the controller with a plant. `disturbed` is what the sensor says, given the tick and what
/// it would say.
pub fn run(setting: &Setting<'_>, plant: &mut Plant, disturbed: impl Fn(usize, f64) -> f64) -> Vec<Tick> {
    let Setting { tracking, mode, reference_mm, correction_mm, course, blocked_n, preview_s, converter } =
        *setting;
    let ahead = (preview_s / PERIOD_S).round() as usize;
    let last = reference_mm.len() - 1;
    let wanted = |tick: usize| {
        let tick = tick.min(last);
        (reference_mm[tick] + correction_mm.get(tick).copied().unwrap_or(0.0)) as f32
    };
    let mut state = tracking.rest_state(mode);
    let (mut command_bar, mut surroundings) = (0.0_f64, Surroundings::default());
    // As on the board: the feed-forward of a tick is prepared in the one before it.
    let mut prepared = tracking.prepare(&mut state, wanted(ahead), &surroundings).expect("finite");
    (0..reference_mm.len())
        .map(|tick| {
            plant.put_on(blocked_n * course.load_share(tick));
            let measured = plant.step(command_bar, if tick == 0 { 0.0 } else { PERIOD_S });
            let contraction_mm = plant.exact_mm();
            let measured_mm = disturbed(tick, measured.contraction_mm);
            let asked = tracking.act(&mut state, mode, prepared, measured_mm as f32).expect("finite");
            let bar = f64::from(asked.command);
            let put_out = match converter {
                Converter::Steps => (bar / STEP_BAR).round() * STEP_BAR,
                Converter::Exact => bar,
            };
            command_bar = put_out.clamp(0.0, HIGHEST_BAR);
            surroundings = Surroundings {
                load: Some(measured.load_n as f32),
                temperature: Some(measured.temperature_c as f32),
            };
            prepared = tracking.prepare(&mut state, wanted(tick + 1 + ahead), &surroundings).expect("finite");
            Tick { reference_mm: reference_mm[tick], measured_mm, contraction_mm, command_bar }
        })
        .collect()
}
