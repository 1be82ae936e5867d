//! A board at its link follows a reference, and what becomes of it.
//!
//! # How time is kept
//! By the board: each answer carries the number of its tick, from which the reference is looked up.
//! A target is sent for a tick ahead, by as many as two answers take, and the board goes there
//! along a straight line ([`wire::joint::JointAim`]): so the course is smooth however slow the link
//! is, as long as an answer comes within 100 ticks.

use model_core::joint::JointTarget;
use wire::joint::{BoardJointParameters, JointAim, JointBoardState, JointReport, JointRequest};

use super::deploy::configure;
use super::error::JointBoardError;
use super::link::JointLink;
use super::run::{PERIOD_S, Recorded, Rows, Run};
use super::start::{APPROACH_S, LONGEST_S, approach};
use super::{JointSample, JointWanted};
use crate::stop::Stop;

/// A target is sent ahead by this many ticks at least, and at most.
const SHORTEST_AHEAD: u32 = 10;
const LONGEST_AHEAD: u32 = 200;

/// What is given a row as it comes.
pub type Heard<'a> = dyn FnMut(&JointSample) -> Result<(), JointBoardError> + 'a;

/// What a board is to do.
#[derive(Clone, Copy, Debug)]
pub struct Course<'a> {
    /// At each tick; at least one.
    pub wanted: &'a [JointWanted],
    /// Every Nth tick is a row; 1: as many as the link carries.
    pub every: u16,
}

/// Gives a board its joint, starts it, goes to the first point, and follows the course to its end.
/// However it ends, both muscles are vented.
///
/// # Errors
/// The board refuses, does not answer, or vents by itself; the joint is not the model's; a stop is
/// requested; `heard` has failed.
pub fn track(
    link: &mut JointLink,
    control: &BoardJointParameters,
    course: &Course<'_>,
    stop: &Stop,
    heard: &mut Heard<'_>,
) -> Result<Recorded, JointBoardError> {
    let Some(first) = course.wanted.first() else { return Ok(Recorded::default()) };
    configure(link, control)?;
    let start = JointRequest::Start(first.stiffness as f32);
    let done = [JointBoardState::Starting, JointBoardState::Tracking];
    let run = Run::start(link, stop, &start, &done)?;
    run.work(|run| {
        let started = tried(run, first)?;
        let from = f64::from(started.tick.due_rad).to_degrees();
        let ticks = (APPROACH_S / PERIOD_S).round() as u32;
        let way = |tick: u32| {
            let share = f64::from(tick.min(ticks)) / f64::from(ticks);
            JointWanted { angle_deg: approach(from, first.angle_deg, share), ..*first }
        };
        let reached = follow(run, started, started.ticks, ticks, &way, &mut |_, _, _| Ok(()))?;
        let mut rows = Rows::new(course.every);
        let last = course.wanted.len() - 1;
        let wanted = |tick: u32| course.wanted[(tick as usize).min(last)];
        let begin = started.ticks.wrapping_add(ticks);
        follow(run, reached, begin, last as u32, &wanted, &mut |run, tick, report| {
            if !rows.takes(tick) {
                return Ok(());
            }
            heard(&JointSample {
                time_s: f64::from(tick) * PERIOD_S,
                wanted: wanted(tick),
                measured: run.measured(report),
                commands_bar: run.commands_bar(report),
                reply: report.tick,
            })
        })?;
        Ok(Recorded { late_ticks: run.late_ticks(), ..rows.recorded })
    })
}

/// Waits until the board has tried the joint.
fn tried(run: &mut Run<'_>, first: &JointWanted) -> Result<JointReport, JointBoardError> {
    let begin = run.begin().ticks;
    loop {
        // A sign of life: what it says counts behind the start.
        let report = run.ask(&aim(first, 0))?;
        if report.tick.state == JointBoardState::Tracking {
            return Ok(report);
        }
        if f64::from(report.ticks.wrapping_sub(begin)) * PERIOD_S > LONGEST_S {
            return Err(JointBoardError::NotStarted(LONGEST_S));
        }
    }
}

/// Sends what is wanted of so many ticks from `begin` on, until a report is of the last one or a
/// later; `each` is given the reports since the begin, up to the last tick.
fn follow(
    run: &mut Run<'_>,
    from: JointReport,
    begin: u32,
    last: u32,
    wanted: &dyn Fn(u32) -> JointWanted,
    each: &mut dyn FnMut(&Run<'_>, u32, &JointReport) -> Result<(), JointBoardError>,
) -> Result<JointReport, JointBoardError> {
    let (mut before, mut ahead) = (from, SHORTEST_AHEAD);
    loop {
        let by_tick = before.ticks.wrapping_add(ahead);
        // Before the begin, as between two courses, the first is wanted.
        let since = |tick: u32| tick.wrapping_sub(begin).cast_signed().max(0).cast_unsigned();
        let report = run.ask(&aim(&wanted(since(by_tick)), by_tick))?;
        let passed = report.ticks.wrapping_sub(before.ticks);
        ahead = (2 * passed).clamp(SHORTEST_AHEAD, LONGEST_AHEAD);
        before = report;
        let tick = report.ticks.wrapping_sub(begin).cast_signed();
        if (0..=last.cast_signed()).contains(&tick) {
            each(run, tick.cast_unsigned(), &report)?;
        }
        if tick >= last.cast_signed() {
            return Ok(report);
        }
    }
}

/// Where to go, by which tick of the board.
fn aim(wanted: &JointWanted, by_tick: u32) -> JointRequest {
    let target = JointTarget {
        angle: wanted.angle_deg.to_radians() as f32,
        stiffness: wanted.stiffness as f32,
        load: wanted.torque_nm as f32,
    };
    JointRequest::Aim(Some(JointAim { target, by_tick }))
}
