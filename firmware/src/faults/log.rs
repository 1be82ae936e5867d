//! Which fault is latched, and how often each has occurred.

use wire::fault::times::LOOP_RESETS;
use wire::{FAULTS, Fault, FaultRecord, TraceEntry};

use super::black_box::BlackBox;

/// Faults since the start, and the record of the first.
#[derive(Debug)]
pub struct FaultLog {
    latched: Option<Fault>,
    counters: [u16; FAULTS],
    black_box: &'static mut BlackBox,
}

impl FaultLog {
    /// The log of a board that has just started.
    pub fn new(black_box: &'static mut BlackBox) -> Self {
        let latched = black_box.fault_at_start();
        let mut log = Self { latched, counters: [0; FAULTS], black_box };
        latched.into_iter().for_each(|fault| log.count(fault));
        log
    }

    /// What outlives the log.
    pub fn into_black_box(self) -> &'static mut BlackBox {
        self.black_box
    }

    /// The fault that is latched.
    pub fn latched(&self) -> Option<Fault> {
        self.latched
    }

    /// How often each has occurred.
    pub fn counters(&self) -> heapless::Vec<u16, FAULTS> {
        heapless::Vec::from_array(self.counters)
    }

    /// The first fault since the last acknowledgement.
    pub fn record(&self) -> Option<FaultRecord> {
        self.black_box.record()
    }

    /// Resets in a row that no power-on explains.
    pub fn resets(&self) -> u32 {
        self.black_box.resets()
    }

    /// Counts a fault.
    pub fn count(&mut self, fault: Fault) {
        if let Some(counter) = self.counters.get_mut(usize::from(fault.code()) - 1) {
            *counter = counter.saturating_add(1);
        }
    }

    /// Counts a fault and latches it, if none is latched, or none that lasts as long. The record
    /// stays that of the first.
    pub fn latch(&mut self, fault: Fault, tick: u32) {
        self.count(fault);
        if self.latched.is_none() {
            self.black_box.seal(fault, tick, 0);
        }
        if self
            .latched
            .is_none_or(|latched| fault.outlasts_acknowledgement() && !latched.outlasts_acknowledgement())
        {
            self.latched = Some(fault);
        }
    }

    /// Releases the fault; answers whether it can be released.
    pub fn acknowledge(&mut self) -> bool {
        let outlasts = self.latched.is_some_and(Fault::outlasts_acknowledgement);
        if outlasts || self.black_box.resets() >= LOOP_RESETS {
            return false;
        }
        self.latched = None;
        self.black_box.reopen();
        true
    }

    /// Adds a tick to the trace.
    #[inline(always)]
    pub fn note(&mut self, entry: TraceEntry) {
        self.black_box.note(entry);
    }

    /// The board has run long enough to forget the resets before.
    pub fn settle(&mut self) {
        self.black_box.settle();
    }
}
