//! What a board tells of itself: telemetry, the record of its first fault, captured ticks.

use serde::{Deserialize, Serialize};

use crate::{FAULTS, Fault, State};

/// What the board counts and measures all the time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Telemetry {
    /// The board's state.
    pub state: State,
    /// The fault that is latched.
    pub fault: Option<Fault>,
    /// Ticks since the board started.
    pub ticks: u32,
    /// Longest time from a tick's due moment to its end, while the valve was driven or not. Unit:
    /// core clock cycle.
    pub worst_tick_cycles: u32,
    /// Mean of the same. Unit: core clock cycle.
    pub mean_tick_cycles: u32,
    /// Ticks that found the one before unfinished.
    pub overruns: u32,
    /// Ticks that ended after their deadline.
    pub late_ticks: u32,
    /// Ticks in which a limit or a slew rate changed the command.
    pub limited_ticks: u32,
    /// Samples of sensors that were replaced by the one before.
    pub bridged_samples: u32,
    /// Resets in a row that no power-on explains.
    pub resets: u32,
    /// The last samples.
    pub signals: Signals,
    /// How often each fault has occurred since the start, by its number less one.
    pub faults: heapless::Vec<u16, FAULTS>,
}

/// Measured quantities.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Signals {
    /// Unit: bar.
    pub pressure_bar: f32,
    /// Unit: mm.
    pub contraction_mm: f32,
    /// Unit: bar.
    pub supply_bar: f32,
    /// Of the board. Unit: °C.
    pub temperature_c: f32,
}

/// A tick in the trace before a fault.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TraceEntry {
    /// Number of the tick since the board started.
    pub tick: u32,
    /// Unit: ADC code.
    pub pressure_code: u16,
    /// Unit: ADC code.
    pub contraction_code: u16,
    /// Unit: ADC code.
    pub supply_code: u16,
    /// What was written to the valve. Unit: DAC code.
    pub dac_code: u16,
    /// Unit: 1/64 mm, saturated.
    pub reference_64th_mm: i16,
}

/// Length of the trace.
pub const TRACE: usize = 13;

/// The first fault since the last acknowledgement; it survives a reset.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaultRecord {
    /// What happened.
    pub fault: Fault,
    /// In which tick since the start of the board.
    pub tick: u32,
    /// What is known beyond that: for a hard fault the processor's fault status, for others 0.
    pub detail: u32,
    /// The ticks before it, oldest first; as many as there were.
    pub trace: heapless::Vec<TraceEntry, TRACE>,
}

/// What to do with the memory that records the loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CaptureOrder {
    /// Begin again, and keep every Nth tick until [`CaptureOrder::Stop`] or a fault; the
    /// oldest ones go when the memory is full. 0 counts as 1.
    Start(u16),
    /// Keep what there is.
    Stop,
    /// Read from this sample on, counted from the oldest that is kept.
    Read(u16),
}

/// A captured tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CaptureSample {
    /// Unit: mm.
    pub reference_mm: f32,
    /// Unit: ADC code.
    pub pressure_code: u16,
    /// Unit: ADC code.
    pub contraction_code: u16,
    /// Unit: DAC code.
    pub dac_code: u16,
    /// The feedback part of the command. Unit: 1/4096 bar, saturated.
    pub feedback_4096th_bar: i16,
}

/// The most captured ticks in a response.
pub const CAPTURE_CHUNK: usize = 48;

/// A part of what was captured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Captured {
    /// Number of the tick of the first sample below.
    pub first_tick: u32,
    /// Ticks from sample to sample.
    pub every: u16,
    /// Samples that are kept in all.
    pub kept: u16,
    /// From the one that was asked for; none beyond the last.
    pub samples: heapless::Vec<CaptureSample, CAPTURE_CHUNK>,
}
