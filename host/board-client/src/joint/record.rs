//! A recording of a joint by a board at its link: both pressures from here, without a model.
//!
//! # How time is kept
//! By the board: each answer carries the number of its tick, from which the pressures are looked up
//! and by which a row has its time. What is asked for changes with each row and is held until the
//! next, so that a row's commands are those that were held since the row before, but for the time
//! that a request takes to the board; between two rows it is said again, a sign of life.

use wire::joint::{JointBoardState, JointRequest};

use super::JointMeasured;
use super::error::JointBoardError;
use super::excitation::Excitation;
use super::link::JointLink;
use super::run::{PERIOD_S, Recorded, Rows, Run};
use crate::stop::Stop;

/// A row of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointRow {
    /// Since the board was started. Unit: s.
    pub time_s: f64,
    /// What both regulators were told since the row before. Unit: bar.
    pub commands_bar: [f32; 2],
    /// What was measured.
    pub measured: JointMeasured,
    /// Unit: N m.
    pub torque_nm: f64,
    /// Whether it counts.
    pub is_valid: bool,
}

impl JointRow {
    /// As a line of CSV.
    pub fn to_csv(&self) -> String {
        let Self { time_s, commands_bar: [a, b], measured, torque_nm, is_valid } = self;
        let JointMeasured { pressures_bar: [pressure_a, pressure_b], angle_deg } = measured;
        let valid = u8::from(*is_valid);
        format!(
            "{time_s:.6},{a:.4},{b:.4},{pressure_a:.4},{pressure_b:.4},{angle_deg:.4},{torque_nm},{valid}\n"
        )
    }
}

/// What is given a row as it comes.
pub type Heard<'a> = dyn FnMut(&JointRow) -> Result<(), JointBoardError> + 'a;

/// Plays an excitation and records the joint. However it ends, both muscles are vented.
///
/// # Errors
/// The board refuses, does not answer, or vents by itself; a stop is requested; `heard` has failed.
pub fn record(
    link: &mut JointLink,
    excitation: &Excitation,
    stop: &Stop,
    heard: &mut Heard<'_>,
) -> Result<Recorded, JointBoardError> {
    let Excitation { pressures_bar, counts, torque_nm, every } = excitation;
    let Some(last) = pressures_bar.len().checked_sub(1) else { return Ok(Recorded::default()) };
    let run = Run::start(link, stop, &JointRequest::Service, &[JointBoardState::Service])?;
    run.work(|run| {
        let (begin, mut rows) = (run.begin().ticks, Rows::new(*every));
        let mut held = pressures_bar[0];
        loop {
            let report = run.ask(&JointRequest::Press(held))?;
            let tick = report.ticks.wrapping_sub(begin);
            if rows.takes(tick) {
                held = pressures_bar[(tick as usize + 1).min(last)];
                heard(&JointRow {
                    time_s: f64::from(tick) * PERIOD_S,
                    commands_bar: run.commands_bar(&report),
                    measured: run.measured(&report),
                    torque_nm: *torque_nm,
                    is_valid: counts[(tick as usize).min(last)],
                })?;
            }
            if tick as usize >= last {
                return Ok(Recorded { late_ticks: run.late_ticks(), ..rows.recorded });
            }
        }
    })
}
