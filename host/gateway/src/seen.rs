//! What a board was last seen to do.

use serde_json::{Value, json};
use wire::registers::{Id, Value as RegisterValue, state};
use wire::slots::{Answer, Outcome};
use wire::{Fault, State};

/// What a board tells in one answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Telemetry {
    /// When the board was as told, on this machine's clock since the gateway's start; by how much
    /// that may be off. Unit: s.
    pub time_s: f64,
    /// See there.
    pub time_bound_s: f64,
    /// By which share the board's clock gains on this machine's, and the bound of that.
    pub drift: (f64, f64),
    /// From the question to the end of the answer. Unit: s.
    pub round_trip_s: f64,
    /// Ticks since the board's start; wraps.
    pub ticks: u32,
    /// Its state; one that is not known is no state to drive in.
    pub state: State,
    /// The number of the latched fault, 0 for none.
    pub fault: u8,
    /// Measured in the muscle. Unit: bar.
    pub pressure_bar: f64,
    /// Unit: mm.
    pub contraction_mm: f64,
    /// What the controller was asked for; none where none runs. Unit: mm.
    pub reference_mm: Option<f64>,
    /// What was put out to the valve. Unit: bar.
    pub command_bar: f64,
    /// Before the valve. Unit: bar.
    pub supply_bar: f64,
    /// In the processor. Unit: °C.
    pub temperature_c: f64,
    /// Longest time from a tick's due moment to its end. Unit: core clock cycle.
    pub worst_tick_cycles: u32,
    /// When a tick has to have ended; 0 where ticks have no clock. Unit: core clock cycle.
    pub deadline_cycles: u32,
    /// It came in the exchange in slots.
    pub in_slots: bool,
    /// What the board says there of what it was told.
    pub outcome: Option<Outcome>,
}

impl Telemetry {
    /// The last register of the answer; [`Id::State`] is the first.
    pub const LAST: Id = Id::Deadline;

    /// That of the answer's words; times are 0.
    pub fn of_words(words: &[u16]) -> Self {
        let number = |id: Id| {
            let from = usize::from(id.register().address - Id::State.register().address);
            let value =
                words.get(from..).and_then(|words| RegisterValue::of_words(id.register().kind, words));
            value.map_or(0.0, RegisterValue::number)
        };
        let state = state(number(Id::State) as u16).unwrap_or(State::Off);
        Self {
            time_s: 0.0,
            time_bound_s: 0.0,
            drift: (0.0, 0.0),
            round_trip_s: 0.0,
            ticks: number(Id::Ticks) as u32,
            state,
            fault: number(Id::Fault) as u8,
            pressure_bar: number(Id::PressureBar),
            contraction_mm: number(Id::ContractionMm),
            reference_mm: (state == State::Tracking).then(|| number(Id::ReferenceMm)),
            command_bar: number(Id::CommandBar),
            supply_bar: number(Id::SupplyBar),
            temperature_c: number(Id::TemperatureC),
            worst_tick_cycles: number(Id::WorstTick) as u32,
            deadline_cycles: number(Id::Deadline) as u32,
            in_slots: false,
            outcome: None,
        }
    }

    /// That of an answer in a slot; what it does not tell is as before, and times are 0.
    pub fn of_answer(answer: &Answer, deadline_cycles: u32) -> Self {
        let state = answer.state;
        Self {
            time_s: 0.0,
            time_bound_s: 0.0,
            drift: (0.0, 0.0),
            round_trip_s: 0.0,
            ticks: answer.ticks,
            state,
            fault: answer.fault,
            pressure_bar: answer.pressure_bar.into(),
            contraction_mm: answer.contraction_mm.into(),
            reference_mm: (state == State::Tracking).then(|| answer.reference_mm.into()),
            command_bar: answer.command_bar.into(),
            supply_bar: answer.supply_bar.into(),
            temperature_c: answer.temperature_c.into(),
            worst_tick_cycles: answer.worst_tick_cycles,
            deadline_cycles,
            in_slots: true,
            outcome: Some(answer.outcome).filter(|outcome| *outcome != Outcome::Asked),
        }
    }

    /// Why a board has not taken what it was told in a slot, in a word.
    pub fn not_taken(&self) -> Option<&'static str> {
        match self.outcome? {
            Outcome::Asked | Outcome::Taken => None,
            Outcome::Late => Some("late"),
            Outcome::Ahead => Some("ahead"),
            Outcome::Repeated => Some("repeated"),
            Outcome::Refused => Some("refused"),
        }
    }

    /// The fault, with its name.
    pub fn fault(&self) -> Option<Fault> {
        Fault::of_code(self.fault)
    }

    /// For programs.
    pub fn to_json(&self) -> Value {
        json!({
            "time_s": self.time_s, "time_bound_s": self.time_bound_s,
            "drift_ppm": 1e6 * self.drift.0, "drift_bound_ppm": 1e6 * self.drift.1,
            "round_trip_s": self.round_trip_s, "ticks": self.ticks, "state": format!("{:?}", self.state),
            "fault": self.fault, "pressure_bar": self.pressure_bar, "contraction_mm": self.contraction_mm,
            "reference_mm": self.reference_mm, "command_bar": self.command_bar, "supply_bar": self.supply_bar,
            "temperature_c": self.temperature_c, "worst_tick_cycles": self.worst_tick_cycles,
            "deadline_cycles": self.deadline_cycles, "not_taken": self.not_taken(),
        })
    }
}

/// How far a board's trajectory has come. Times are since the gateway's start. Unit: s.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// The board has its points, and waits for the start.
    Ready {
        /// When that shall be.
        start_s: f64,
    },
    /// It plays.
    Playing {
        /// The tick that had the start as its set point.
        start_tick: u32,
        /// When that was.
        start_s: f64,
        /// By how much that may be off.
        bound_s: f64,
    },
    /// It has come to its end, where the board stays.
    Done {
        /// Ticks in which points were missing.
        underrun_ticks: u32,
    },
    /// It has not begun, or not come to its end.
    Ended {
        /// Why.
        reason: String,
    },
}

impl Progress {
    /// A word for it, as programs are told.
    pub fn phase(&self) -> &'static str {
        match self {
            Self::Ready { .. } => "ready",
            Self::Playing { .. } => "playing",
            Self::Done { .. } => "done",
            Self::Ended { .. } => "ended",
        }
    }

    /// For people.
    pub fn in_words(&self) -> String {
        match self {
            Self::Ended { reason } => format!("ended: {reason}"),
            _ => self.phase().to_owned(),
        }
    }
}

/// Why a board is not seen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Problem {
    /// Its line's port cannot be used; why.
    Port(String),
    /// It does not answer, or damaged; in words.
    Silent(String),
    /// Its registers are of this version.
    OtherVersion(u16),
    /// More than one answers by its number, or somebody sends unasked.
    Several,
    /// Something that has no such registers; in words.
    NotABoard(String),
}

impl Problem {
    /// For people.
    pub fn in_words(&self) -> String {
        match self {
            Self::Port(words) | Self::Silent(words) => words.clone(),
            Self::OtherVersion(version) => format!(
                "its registers are of version {version}, this program speaks version {}: update the board or the \
                 program",
                wire::registers::VERSION
            ),
            Self::Several => {
                "more than one board answers by this number, or somebody sends unasked: `mgpi scan` tells, \
                              with one board connected alone"
                    .to_owned()
            }
            Self::NotABoard(words) => format!("no valve board answers: {words}"),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A board at rest.
    pub(crate) fn telemetry() -> Telemetry {
        Telemetry::of_words(&[])
    }
}
