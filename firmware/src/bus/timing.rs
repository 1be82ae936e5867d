//! How long pauses are on the bus, by what its moments count.

use wire::BusParameters;

use super::listening::SILENT_S;

/// What moments count.
#[derive(Clone, Copy, Debug)]
pub enum Timing {
    /// Microseconds, on a line whose bytes take their time.
    Microseconds,
    /// Ticks, where bytes come in bursts: after so many without a byte a frame begins.
    Ticks(u32),
}

/// From tick to tick. Unit: µs.
const TICK_US: u32 = 1_000;

/// A pause between two bytes: at least so long (µs), on slow lines so many half bytes.
struct Pause {
    least_us: u32,
    half_bytes: u32,
}

/// Behind which a frame may begin: masters leave hardly more.
const MAY_BEGIN: Pause = Pause { least_us: 750, half_bytes: 3 };
/// Behind which a frame begins (Modbus over serial line 1.02, 2.5.1.1).
const BEGINS: Pause = Pause { least_us: 1_750, half_bytes: 7 };
/// What a pause may be shorter: clocks of both sides that differ, and a tick that delays one of its
/// ends by 0.01 ms. Unit: %.
const ALLOWANCE: u32 = 5;

impl Timing {
    /// Times from the end of a byte to that of the next, behind which a frame may begin, and does.
    pub fn pauses(self, bus: &BusParameters) -> [u32; 2] {
        let byte_us = 1_000_000 * bus.byte_bits() / bus.baud.max(1);
        let between_ends = |Pause { least_us, half_bytes }: Pause| {
            (least_us.max(half_bytes * byte_us / 2) + byte_us) * (100 - ALLOWANCE) / 100
        };
        match self {
            Self::Microseconds => [between_ends(MAY_BEGIN), between_ends(BEGINS)],
            Self::Ticks(ticks) => [ticks; 2],
        }
    }

    /// How long a board listens by the same parameters while nobody is heard.
    pub const fn patience(self) -> u32 {
        match self {
            Self::Microseconds => SILENT_S * 1_000_000,
            Self::Ticks(_) => SILENT_S * 1_000,
        }
    }

    /// Least time from the end of a request to its answer.
    pub const fn turnaround(self, bus: &BusParameters) -> u32 {
        self.of_us(bus.turnaround_us)
    }

    /// So many microseconds, at the least.
    pub const fn of_us(self, us: u32) -> u32 {
        match self {
            Self::Microseconds => us,
            Self::Ticks(_) => us.div_ceil(TICK_US),
        }
    }

    /// Whether moments are finer than ticks.
    pub const fn has_microseconds(self) -> bool {
        matches!(self, Self::Microseconds)
    }
}
