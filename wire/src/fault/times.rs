//! How long a board looks before it reacts: the numbers that the fault table promises and the
//! board's monitors count by. Unit, where a constant says no other: control ticks, of 1 ms on the
//! production board.

/// Ticks in a row without new samples that are a fault.
pub const MISSING_IN_A_ROW: u16 = 3;
/// Implausible codes of a sensor, in a row, that are a fault.
pub const BAD_IN_A_ROW: u16 = 3;
/// Jumps of a sensor from tick to tick, in a row, that are a fault.
pub const JUMPS_IN_A_ROW: u16 = 5;
/// How long a sensor may show no change while the command moves.
pub const STUCK_TICKS: u16 = 200;
/// Ticks in a row with a contraction that contradicts the pressure that are a fault.
pub const IMPLAUSIBLE_TICKS: u16 = 200;
/// Ticks in a row with more feedback than it has authority for that are a fault.
pub const AUTHORITY_TICKS: u16 = 1000;
/// Within so many ticks the pressure behind a vented valve has to fall.
pub const VENTING_TICKS: u16 = 300;
/// Ticks in a row with an open emergency stop that are a fault.
pub const STOP_TICKS: u16 = 3;
/// Ticks in a row with a voltage at the valve's output that was not written, or with a reference
/// voltage out of its range, that are a fault.
pub const STRAY_TICKS: u16 = 3;
/// How long the dump valve's coil may have a voltage behind the last change of the output that
/// holds it: twice what the charge pump takes.
pub const DUMP_TICKS: u16 = 20;
/// Ticks in a row that end too late that are a fault.
pub const LATE_IN_A_ROW: u16 = 3;
/// How long a task may be silent: the link may prepare a large model, or send a long answer, for so
/// long.
pub const ALLOWANCE_TICKS: u16 = 250;
/// Resets without power-on, in a row, that are a loop. Unit: resets.
pub const LOOP_RESETS: u32 = 3;
