//! What a run over the link begins and ends with, whatever it drives.

use std::thread;
use std::time::{Duration, Instant};

use wire::joint::{JointBoardState, JointReport, JointRequest};

use super::JointMeasured;
use super::error::JointBoardError;
use super::link::JointLink;
use crate::stop::Stop;

/// The board's tick. Unit: s.
pub const PERIOD_S: f64 = 1e-3;
/// A board whose ticks stand still for so long has none of its own.
const STANDS_STILL: Duration = Duration::from_secs(2);
/// A pause where no tick has passed since the last answer.
const PAUSE: Duration = Duration::from_millis(1);

/// What was recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Recorded {
    /// Rows.
    pub rows: usize,
    /// Ticks from row to row; 1: as many as the link carries.
    pub every: u16,
    /// Rows that the link, or this machine, was too slow for.
    pub missed: usize,
    /// Ticks that ended after their deadline, during the run.
    pub late_ticks: u32,
}

impl Recorded {
    /// For people.
    pub fn in_words(&self) -> String {
        let Self { rows, every, missed, late_ticks } = self;
        let step = match every {
            1 => "as many as the link carries".to_owned(),
            every => format!("one each {} ms", 1e3 * f64::from(*every) * PERIOD_S),
        };
        let mut words = format!("{rows} rows, {step}; ticks late: {late_ticks}");
        if *missed > 0 {
            words += &format!(
                "; rows missed: {missed}, link or machine was too slow: --every {} is easier",
                2 * u32::from(*every)
            );
        }
        words
    }
}

/// A board while it is driven.
#[derive(Debug)]
pub(super) struct Run<'a> {
    link: &'a mut JointLink,
    stop: &'a Stop,
    /// At the start.
    begin: JointReport,
    last: JointReport,
    /// When the last tick that was new was heard of.
    moved: Instant,
}

impl<'a> Run<'a> {
    /// Takes the two steps of a start, the second of which is `start`; the board is in one of the
    /// states `done` then.
    pub(super) fn start(
        link: &'a mut JointLink,
        stop: &'a Stop,
        start: &JointRequest,
        done: &[JointBoardState],
    ) -> Result<Self, JointBoardError> {
        link.order(&JointRequest::Arm, &[])?;
        let started = link.order(start, done).and_then(|()| link.report(&JointRequest::Aim(None)));
        if started.is_err() {
            // It may have been heard; a board that is gone vents by itself.
            let _ = link.order(&JointRequest::Stop, &[]);
        }
        let begin = started?;
        Ok(Self { link, stop, begin, last: begin, moved: Instant::now() })
    }

    /// Does the work, then vents, however it ended.
    pub(super) fn work<T>(
        mut self,
        work: impl FnOnce(&mut Self) -> Result<T, JointBoardError>,
    ) -> Result<T, JointBoardError> {
        let done = work(&mut self);
        // A board that is gone vents by itself.
        let vented = self.link.order(&JointRequest::Stop, &[]);
        let done = done?;
        vented?;
        Ok(done)
    }

    /// The report of the start.
    pub(super) fn begin(&self) -> &JointReport {
        &self.begin
    }

    /// Asks for what is answered by the last tick, which is a later one than before.
    ///
    /// # Errors
    /// A stop is requested; the board does not answer, has vented, or its ticks stand still.
    pub(super) fn ask(&mut self, request: &JointRequest) -> Result<JointReport, JointBoardError> {
        loop {
            if self.stop.is_requested() {
                return Err(JointBoardError::Stopped);
            }
            let report = self.link.report(request);
            let report = match report {
                // At fault it takes no pressures any more, and says why.
                Err(JointBoardError::AtFault(fault)) => {
                    return Err(JointBoardError::Fault { time_s: self.since_begin_s(), fault });
                }
                Err(JointBoardError::State(state)) => return Err(JointBoardError::Vented(state)),
                other => other?,
            };
            let passed = report.ticks.wrapping_sub(self.last.ticks).cast_signed();
            self.last = report;
            if let Some(fault) = report.tick.fault {
                return Err(JointBoardError::Fault { time_s: self.since_begin_s(), fault });
            }
            if !report.tick.state.is_driven() || passed < 0 {
                return Err(JointBoardError::Vented(report.tick.state));
            }
            if passed > 0 {
                self.moved = Instant::now();
                return Ok(report);
            }
            if self.moved.elapsed() > STANDS_STILL {
                return Err(JointBoardError::StandsStill);
            }
            thread::sleep(PAUSE);
        }
    }

    fn since_begin_s(&self) -> f64 {
        f64::from(self.last.ticks.wrapping_sub(self.begin.ticks)) * PERIOD_S
    }

    /// What a report tells of the joint.
    pub(super) fn measured(&self, report: &JointReport) -> JointMeasured {
        let hello = self.link.hello();
        JointMeasured {
            pressures_bar: [0, 1]
                .map(|place| rounded(hello.pressures[place].value(report.pressure_codes[place]))),
            angle_deg: rounded(hello.angle.value(report.angle_code).to_degrees()),
        }
    }

    /// What both converters have put out. Unit: bar.
    pub(super) fn commands_bar(&self, report: &JointReport) -> [f32; 2] {
        report.tick.dac_codes.map(|code| self.link.hello().command.value(code))
    }

    /// Ticks that were late since the start.
    pub(super) fn late_ticks(&self) -> u32 {
        self.last.late_ticks.wrapping_sub(self.begin.late_ticks)
    }
}

/// Without the digits that are the converter's alone.
fn rounded(value: f32) -> f64 {
    (f64::from(value) * 1e4).round() / 1e4
}

/// Which reports become rows: the first one at or behind every Nth tick.
#[derive(Debug)]
pub(super) struct Rows {
    every: u32,
    next: u32,
    pub(super) recorded: Recorded,
}

impl Rows {
    pub(super) fn new(every: u16) -> Self {
        let every = every.max(1);
        Self { every: every.into(), next: 0, recorded: Recorded { every, ..Recorded::default() } }
    }

    /// Whether the report of this tick since the begin is a row; counts what was missed before it.
    pub(super) fn takes(&mut self, tick: u32) -> bool {
        if tick < self.next {
            return false;
        }
        // Where every tick is wanted, those that no answer was for are nobody's loss.
        if self.every > 1 {
            self.recorded.missed += ((tick - self.next) / self.every) as usize;
        }
        self.recorded.rows += 1;
        self.next = (tick / self.every + 1) * self.every;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_the_first_reports_of_their_ticks_and_what_is_missing_is_counted() {
        let mut rows = Rows::new(10);
        let taken: Vec<u32> =
            [0, 3, 9, 11, 14, 20, 29, 52, 60, 61].into_iter().filter(|tick| rows.takes(*tick)).collect();
        assert_eq!(taken, [0, 11, 20, 52, 60]);
        // Those of 30 and 40; that of 50 came late.
        assert_eq!((rows.recorded.rows, rows.recorded.missed), (5, 2));
        let mut all = Rows::new(1);
        assert_eq!([0, 4, 5, 9].map(|tick| all.takes(tick)), [true; 4]);
        assert_eq!(all.recorded.missed, 0);
        assert!(
            rows.recorded
                .in_words()
                .contains("rows missed: 2, link or machine was too slow: --every 20 is easier")
        );
    }
}
