//! The record of the first fault, with the ticks before it, in memory that a reset leaves alone.
//!
//! It is written tick by tick, so that whatever stops the program finds the trace there and has
//! only to [`seal`] it; once sealed it does not change until the fault is acknowledged. A checksum
//! tells a record from what RAM holds after power-on.
//!
//! # Limits
//! It survives resets, not a loss of power.
//!
//! [`seal`]: BlackBox::seal

use wire::fault::times::LOOP_RESETS;
use wire::{Fault, FaultRecord, TRACE, TraceEntry};

/// What the memory begins with. Another layout needs another number.
const LAYOUT: u32 = 0x4D47_5049;
/// `crc`'s parameters of the everyday CRC-32.
const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

/// Why the board has started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reset {
    /// Power came on: what memory holds is no record.
    PowerOn,
    /// The reset pin, or a debugger.
    Pin,
    /// The program itself, after a panic or a fault of the processor, which are sealed before; or a
    /// debugger.
    Software,
    /// The hardware watchdog was not fed.
    Watchdog,
    /// The voltage was too low for a moment.
    BrownOut,
}

/// The record. In whole words, so that any content of the memory is one, valid or not.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct BlackBox {
    layout: u32,
    resets: u32,
    /// 0 while it is open.
    fault: u32,
    tick: u32,
    detail: u32,
    /// Entries written in all.
    written: u32,
    trace: [[u32; 4]; TRACE],
    crc: u32,
}

impl BlackBox {
    /// An open record without entries.
    pub const fn new() -> Self {
        Self {
            layout: LAYOUT,
            resets: 0,
            fault: 0,
            tick: 0,
            detail: 0,
            written: 0,
            trace: [[0; 4]; TRACE],
            crc: 0,
        }
    }

    /// What has to go on in, made of what the memory held at the start; sealed, if the reset itself
    /// is a fault.
    #[must_use]
    pub fn after(reset: Reset, found: Self) -> Self {
        let is_valid = reset != Reset::PowerOn && found.layout == LAYOUT && found.crc == found.checksum();
        let mut kept = if is_valid { found } else { Self::new() };
        let is_own = match reset {
            // A program that ends itself has sealed the record; a debugger has not.
            Reset::Software => kept.fault != 0,
            Reset::Watchdog | Reset::BrownOut => true,
            Reset::PowerOn | Reset::Pin => false,
        };
        if is_own {
            kept.resets = kept.resets.saturating_add(1);
        }
        let own = match reset {
            Reset::Watchdog => Some(Fault::WatchdogReset),
            Reset::BrownOut => Some(Fault::BrownOut),
            Reset::PowerOn | Reset::Pin | Reset::Software => None,
        };
        if let Some(fault) = own {
            kept.crash(fault, 0);
        }
        if kept.record().is_none() {
            kept = Self { resets: kept.resets, ..Self::new() };
        }
        kept.crc = kept.checksum();
        kept
    }

    /// The fault that the board has to begin with.
    pub fn fault_at_start(&self) -> Option<Fault> {
        if self.resets >= LOOP_RESETS { Some(Fault::ResetLoop) } else { self.fault() }
    }

    /// Resets in a row that no power-on explains.
    pub fn resets(&self) -> u32 {
        self.resets
    }

    /// The board has run long enough: the next reset is the first again.
    pub fn settle(&mut self) {
        self.resets = 0;
        self.crc = self.checksum();
    }

    /// Adds a tick to the trace, while it is open.
    #[inline(always)]
    pub fn note(&mut self, entry: TraceEntry) {
        if self.fault != 0 {
            return;
        }
        let TraceEntry { tick, pressure_code, contraction_code, supply_code, dac_code, reference_64th_mm } =
            entry;
        let pair = |low: u16, high: u16| u32::from(low) | u32::from(high) << 16;
        if let Some(place) = self.trace.get_mut(self.written as usize % TRACE) {
            *place = [
                tick,
                pair(pressure_code, contraction_code),
                pair(supply_code, dac_code),
                u32::from(reference_64th_mm.cast_unsigned()),
            ];
        }
        self.written = self.written.wrapping_add(1);
    }

    /// Closes the record with a fault, if none has closed it before.
    pub fn seal(&mut self, fault: Fault, tick: u32, detail: u32) {
        if self.fault == 0 {
            (self.fault, self.tick, self.detail) = (fault.code().into(), tick, detail);
            self.crc = self.checksum();
        }
    }

    /// Closes the record with what has ended the program, in the last tick that it knows of.
    pub fn crash(&mut self, fault: Fault, detail: u32) {
        let last_tick = self.entries().last().map_or(0, |entry| entry.tick);
        self.seal(fault, last_tick, detail);
    }

    /// Begins again.
    pub fn reopen(&mut self) {
        *self = Self { resets: self.resets, ..Self::new() };
        self.crc = self.checksum();
    }

    /// The record, once it is closed.
    pub fn record(&self) -> Option<FaultRecord> {
        let fault = self.fault()?;
        Some(FaultRecord { fault, tick: self.tick, detail: self.detail, trace: self.entries().collect() })
    }

    fn fault(&self) -> Option<Fault> {
        Fault::of_code(u8::try_from(self.fault).ok()?)
    }

    /// The trace, oldest first.
    fn entries(&self) -> impl Iterator<Item = TraceEntry> {
        let written = self.written as usize;
        let first = written.saturating_sub(TRACE);
        (first..written).filter_map(|i| self.trace.get(i % TRACE)).map(
            |&[tick, sensors, valve, reference]| {
                let (low, high) = (|word: u32| word as u16, |word: u32| (word >> 16) as u16);
                TraceEntry {
                    tick,
                    pressure_code: low(sensors),
                    contraction_code: high(sensors),
                    supply_code: low(valve),
                    dac_code: high(valve),
                    reference_64th_mm: low(reference).cast_signed(),
                }
            },
        )
    }

    /// Over what does not change any more: all of a closed record; of an open one not the trace.
    fn checksum(&self) -> u32 {
        let Self { layout, resets, fault, tick, detail, written, trace, crc: _ } = self;
        let mut digest = CRC.digest();
        let mut add = |word: &u32| digest.update(&word.to_le_bytes());
        [layout, resets, fault, tick, detail].into_iter().for_each(&mut add);
        if *fault != 0 {
            add(written);
            trace.as_flattened().iter().for_each(add);
        }
        digest.finalize()
    }
}

impl Default for BlackBox {
    fn default() -> Self {
        Self::new()
    }
}
