//! The loop recorded in RAM at the tick's rate: a ring of the last ticks, or of every Nth.
//!
//! It records from the start of the board on, and stops by itself when a fault vents: what led to
//! it is then there to be read. A host that wants something else says [`CaptureOrder::Start`].

use wire::{CAPTURE_CHUNK, CaptureOrder, CaptureSample, Captured};

/// Samples that are kept: a second at the tick's rate. Unit: 1.
pub const CAPACITY: usize = 1000;

/// The ring.
#[derive(Clone, Debug)]
pub struct Capture {
    samples: [CaptureSample; CAPACITY],
    /// Where the next sample goes.
    next: usize,
    kept: usize,
    /// Ticks between two samples that are not kept.
    skip: u16,
    /// Ticks until the next sample.
    wait: u16,
    /// The tick of the last sample.
    last_tick: u32,
    /// Samples since the recording began.
    taken: u32,
    is_stopped: bool,
}

impl Capture {
    /// An empty ring, recording. All zeros, so that the image need not hold it.
    pub const fn new() -> Self {
        let nothing = CaptureSample {
            reference_mm: 0.0,
            pressure_code: 0,
            contraction_code: 0,
            dac_code: 0,
            feedback_4096th_bar: 0,
        };
        Self {
            samples: [nothing; CAPACITY],
            next: 0,
            kept: 0,
            skip: 0,
            wait: 0,
            last_tick: 0,
            taken: 0,
            is_stopped: false,
        }
    }

    /// Takes a tick.
    pub fn take(&mut self, tick: u32, sample: CaptureSample) {
        if self.is_stopped {
            return;
        }
        if self.wait > 0 {
            self.wait -= 1;
            return;
        }
        self.wait = self.skip;
        if let Some(place) = self.samples.get_mut(self.next) {
            *place = sample;
        }
        self.next = if self.next + 1 < CAPACITY { self.next + 1 } else { 0 };
        self.kept = (self.kept + 1).min(CAPACITY);
        self.last_tick = tick;
        self.taken = self.taken.wrapping_add(1);
    }

    /// Samples since the recording began.
    pub fn taken(&self) -> u32 {
        self.taken
    }

    /// Samples that are kept.
    pub fn kept(&self) -> u16 {
        self.kept as u16
    }

    /// Ticks from sample to sample, 0 if it does not record.
    pub fn every(&self) -> u16 {
        if self.is_stopped { 0 } else { self.skip.saturating_add(1) }
    }

    /// Keeps what there is.
    pub fn stop(&mut self) {
        self.is_stopped = true;
    }

    /// Carries an order out; a reading has an answer.
    pub fn apply(&mut self, order: CaptureOrder) -> Option<Captured> {
        match order {
            CaptureOrder::Start(every) => {
                (self.next, self.kept, self.wait, self.taken) = (0, 0, 0, 0);
                (self.skip, self.is_stopped) = (every.saturating_sub(1), false);
                None
            }
            CaptureOrder::Stop => {
                self.stop();
                None
            }
            CaptureOrder::Read(from) => Some(self.read(from.into())),
        }
    }

    /// A part of what is kept, from this sample on, counted from the oldest.
    pub fn read(&self, from: usize) -> Captured {
        let oldest = if self.kept < CAPACITY { 0 } else { self.next };
        let chunk = (from..self.kept).take(CAPTURE_CHUNK);
        let age = (self.kept.saturating_sub(1)).saturating_sub(from) as u32;
        let every = self.skip.saturating_add(1);
        Captured {
            first_tick: self.last_tick.wrapping_sub(age * u32::from(every)),
            every,
            kept: self.kept(),
            samples: chunk.filter_map(|i| self.samples.get((oldest + i) % CAPACITY).copied()).collect(),
        }
    }
}

impl Default for Capture {
    fn default() -> Self {
        Self::new()
    }
}
