//! All faults: detection, reaction, time, cause and cure. `docs/faults.md` is made of this table
//! (`cargo xtask faults`), and every row has a test that injects its fault. A host shows cause and
//! cure to its user.
//!
//! Times count from the tick in which what is detected begins, with
//! [`crate::Protection::STANDARD`].

use super::Fault;
use super::times::{
    ALLOWANCE_TICKS, AUTHORITY_TICKS, BAD_IN_A_ROW, DUMP_TICKS, IMPLAUSIBLE_TICKS, JUMPS_IN_A_ROW,
    LATE_IN_A_ROW, LOOP_RESETS, MISSING_IN_A_ROW, STOP_TICKS, STRAY_TICKS, STUCK_TICKS, VENTING_TICKS,
};

/// What a fault leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reaction {
    /// The valve is vented; state `Fault`.
    Vent,
    /// `Vent` or feedback alone, as the protection says.
    AsConfigured,
    /// It is counted.
    Count,
}

/// What ends a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Latch {
    /// The host acknowledges it; it comes back if its cause is still there.
    Acknowledged,
    /// Power is taken away.
    PowerOn,
    /// Nothing is latched.
    Never,
}

/// A fault.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Which.
    pub fault: Fault,
    /// Its name in words.
    pub title: &'static str,
    /// When it is seen.
    pub detection: &'static str,
    /// What it leads to.
    pub reaction: Reaction,
    /// What ends it.
    pub latch: Latch,
    /// The most ticks from the begin of what is detected to the reaction. 0: at the start of the
    /// board.
    pub within_ticks: u32,
    /// What is behind it.
    pub cause: &'static str,
    /// What helps.
    pub cure: &'static str,
}

/// By number.
pub const TABLE: [Row; Fault::ALL.len()] = [
    vent(
        Fault::Acquisition,
        "no new samples",
        "the converter has not finished its scan, three ticks in a row; until then the last samples stand",
        MISSING_IN_A_ROW as u32,
        "the converter or its trigger timer has stopped, or its clock",
        "restart the board; if it comes back, the processor or its supply is damaged",
    ),
    vent(
        Fault::PressureSensor,
        "pressure sensor open or short",
        "its code is outside the plausible ones three ticks in a row; until then the last good one stands",
        BAD_IN_A_ROW as u32,
        "a broken wire, a short, the sensor's supply is missing",
        "measure the signal at the plug: 0.33 to 2.97 V are good; see the wiring table",
    ),
    vent(
        Fault::ContractionSensor,
        "contraction sensor open or short",
        "as for the pressure sensor",
        BAD_IN_A_ROW as u32,
        "a broken wire, a short, the rod beyond the sensor's travel, a muscle gone slack",
        "measure the signal at the plug: 0.17 to 3.13 V are good; check how the sensor is mounted",
    ),
    vent(
        Fault::Reference,
        "reference is no number",
        "the reference is infinite or not a number",
        1,
        "the host's program divides by zero or reads a hole in its data",
        "check the reference; one outside the muscle's range is no fault, it is limited",
    ),
    vent(
        Fault::SupplySensor,
        "supply sensor open or short",
        "as for the pressure sensor",
        BAD_IN_A_ROW as u32,
        "as for the pressure sensor",
        "as for the pressure sensor; without such a sensor connect its input to that of the pressure regulator's supply",
    ),
    vent(
        Fault::PressureStuck,
        "pressure sensor stuck",
        "its code stays within 4 for 200 ticks while the command moves by 1.5 bar",
        STUCK_TICKS as u32,
        "the sensor's element or its amplifier is defective, ice or dirt in its port, the tube to it is kinked; or the valve holds \
         the pressure, see valve stuck",
        "compare with a gauge; clean or replace",
    ),
    vent(
        Fault::ContractionStuck,
        "contraction sensor stuck",
        "as for the pressure sensor",
        STUCK_TICKS as u32,
        "the sensor has come off the muscle, its wiper sticks, or the muscle is blocked",
        "move the muscle by hand and watch the reading",
    ),
    vent(
        Fault::PressureSpiking,
        "pressure sensor spiking",
        "five jumps of more than 1 bar from tick to tick in a row, or one in fewer than 16 ticks for long; single ones are \
         bridged and counted",
        JUMPS_IN_A_ROW as u32,
        "a loose contact, a missing shield, a motor's cable beside the sensor's",
        "wiggle the plug and watch `bridged_samples`; ground the shield at the board",
    ),
    vent(
        Fault::ContractionSpiking,
        "contraction sensor spiking",
        "as for the pressure sensor, with jumps of more than 10 mm",
        JUMPS_IN_A_ROW as u32,
        "a loose contact, a missing shield, a worn potentiometer; or the muscle or the sensor has torn off at once",
        "look at the muscle; wiggle the plug and watch `bridged_samples`; ground the shield at the board",
    ),
    vent(
        Fault::Implausible,
        "contraction implausible for the pressure",
        "it is outside the model's outermost loop by more than 30 % of the stroke, 200 ticks in a row",
        IMPLAUSIBLE_TICKS as u32,
        "a muscle that is torn off, blocked or another one than the model's; a sensor that has slipped",
        "look at the muscle; compare the model with a new recording (`mgpi simulate`)",
    ),
    vent(
        Fault::OverpressureHard,
        "overpressure, hard limit",
        "one sample of the pressure is above 7.5 bar",
        1,
        "the regulator fails open, or somebody has opened a bypass",
        "close the supply by hand; replace the regulator if it does not hold a set point",
    ),
    vent(
        Fault::OverpressureSoft,
        "overpressure, soft limit",
        "the average over some 16 ticks is above 6.6 bar",
        64,
        "the command's limit is above what the muscle may have, or the regulator's zero or span is off",
        "check `command_max` of the configuration, and the regulator against a gauge",
    ),
    vent(
        Fault::SupplyLow,
        "supply low",
        "the average of the supply's pressure over some 64 ticks is below 4 bar",
        200,
        "the compressor is off or too small, a valve before the board is closed, a filter is clogged",
        "restore the supply, then acknowledge",
    ),
    vent(
        Fault::Leak,
        "leak or burst",
        "the pressure is below the command: the integral of what is missing beyond 1 bar comes to 1 bar s",
        1000,
        "a tube has come off, the muscle has burst or leaks, the regulator does not deliver enough",
        "listen; close the supply; replace what leaks",
    ),
    vent(
        Fault::ValveStuck,
        "valve stuck",
        "the same integral, of a pressure that is above the command or does not move; or pressure is left at the end of the \
         self-test",
        1000,
        "the regulator's piston or coil sticks, its set-point wire is broken, its outlet is closed",
        "venting may be impossible: close the supply and open the dump valve by hand; check the set point's voltage",
    ),
    vent(
        Fault::NotFinite,
        "computed value is no number",
        "feed-forward, feedback or command is infinite or not a number",
        1,
        "gains beyond what single precision can bear",
        "check the gains; what the inverse gives is always within the model's range",
    ),
    Row {
        reaction: Reaction::AsConfigured,
        ..vent(
            Fault::Model,
            "model invalid",
            "in the survey of a new configuration the inverse misses by more than 1 % of the range",
            251,
            "parameters with which single precision loses the model: a range far beyond where the muscle still moves",
            "identify over the range that is used; feedback alone tracks until then, unless the protection says otherwise",
        )
    },
    vent(
        Fault::Authority,
        "feed-forward and measurement disagree",
        "with both, the feedback asks for more than 2 bar, 1000 ticks in a row",
        AUTHORITY_TICKS as u32,
        "the model is that of another muscle or load; a sensor has slipped; gains too high",
        "track with feed-forward only and look at the error, then identify again",
    ),
    vent(
        Fault::Deadline,
        "deadline missed",
        "three ticks in a row have written the valve after the deadline, half the period, or were still busy when the next was due",
        LATE_IN_A_ROW as u32 + 1,
        "a model too large for the board's tick, above all `egpi`; the processor runs from its internal oscillator",
        "see the worst tick in the telemetry; choose a model with a cheaper inverse",
    ),
    vent(
        Fault::TaskSilent,
        "a task has stopped",
        "link or supervisor have not checked in for 250 ticks; the hardware watchdog is then no longer fed and resets the board",
        ALLOWANCE_TICKS as u32 + 2,
        "a defect in the program",
        "send the record of the fault to the maintainers",
    ),
    vent(
        Fault::BusSilent,
        "bus silent",
        "no sign of life for 500 ticks while the valve is driven: no other number in `heartbeat`, and no new point of the stream. \
         Other requests are none",
        501,
        "the host's program has ended or hangs, it writes no heartbeat, the cable is out, the wrong bit rate",
        "write another number to `heartbeat` (`Request::Heartbeat` on the link) some five times a second",
    ),
    vent(
        Fault::ConfigurationCorrupt,
        "stored configuration corrupt",
        "its checksum is wrong, or a parameter in it is not valid",
        0,
        "flash worn out, or written by something else",
        "acknowledge, configure and save again",
    ),
    vent(
        Fault::ConfigurationVersion,
        "stored configuration of another version",
        "its version is not the firmware's, and none that can be migrated",
        0,
        "the firmware was exchanged for a much older or newer one, or one for two channels at a joint",
        "acknowledge, configure and save again",
    ),
    vent(
        Fault::BrownOut,
        "brown-out",
        "the voltage detector tells less than 2.93 V: its interrupt vents at once, the tick makes a fault of it; or the supply does \
         not come up at the start; or the reset was by low voltage. Counted at the start of a chip whose brown-out reset is off",
        1,
        "the board's supply is too weak, or breaks in when the valve switches",
        "measure 24 V and 3.3 V under load; where it is counted at each start, set level 3 by the option bytes (BOR_LEV = 0)",
    ),
    vent(
        Fault::StackOverflow,
        "stack overflow",
        "a fault of the processor with the stack below its memory; vents, seals the record and resets",
        0,
        "a defect in the program",
        "send the record of the fault to the maintainers",
    ),
    vent(
        Fault::HardFault,
        "fault of the processor",
        "the processor's own; vents, seals the record and resets; `detail` is its fault status",
        0,
        "a defect in the program, or of the memory",
        "send the record of the fault to the maintainers",
    ),
    vent(
        Fault::Panic,
        "panic",
        "the program has found itself in the wrong; vents, seals the record and resets",
        0,
        "a defect in the program outside the tick",
        "send the record of the fault to the maintainers",
    ),
    vent(
        Fault::WatchdogReset,
        "reset by the watchdog",
        "the board starts, and the hardware watchdog was the reason",
        0,
        "the tick stood still: see the trace of the record",
        "send the record of the fault to the maintainers",
    ),
    Row {
        latch: Latch::PowerOn,
        ..vent(
            Fault::ResetLoop,
            "reset loop",
            "the third reset in a row without power-on, less than 10 s of running between them; a debugger's do not count",
            0,
            "whatever the record says, which is that of the first",
            "read the record, take the power away, mend the cause",
        )
    },
    Row {
        reaction: Reaction::Count,
        latch: Latch::Never,
        ..vent(
            Fault::Clock,
            "clock failure",
            "crystal or multiplier have not started in time; the internal oscillator of 16 MHz stands in, 1 % off. A crystal that \
             stops later vents within 0.1 ms, seals the record and resets; it is then latched until it is acknowledged",
            0,
            "the crystal is damaged or the wrong one",
            "replace the board; it may track until then, with a tick that is 1 % off and ten times as loaded",
        )
    },
    vent(
        Fault::Temperature,
        "board too hot",
        "the average of the processor's temperature is above 85 °C, or its sensor's code is implausible three ticks in a row",
        200,
        "the board is in the sun, in a closed box, or overloaded",
        "let it cool down, give it air, then acknowledge",
    ),
    vent(
        Fault::EmergencyStop,
        "emergency stop",
        "its contacts are open three ticks in a row; they have opened the dump valve by themselves",
        STOP_TICKS as u32,
        "somebody has pressed it, or its cable or plug is open; without an emergency stop its input has to be bridged to ground",
        "see to the danger, release the button, then acknowledge",
    ),
    vent(
        Fault::VentIneffective,
        "venting without effect",
        "the valve is vented, and in 300 ticks the pressure neither reaches 0.5 bar nor loses a fifth; the dump valve is opened. In \
         the state `Fault`, where it is open already, it is counted each 300 ticks as long as that lasts",
        VENTING_TICKS as u32,
        "the regulator, its amplifier or the converter is stuck; the pressure sensor is; or the outlet is closed",
        "keep away, close the supply by hand; then measure the set point's voltage, and compare the sensor with a gauge",
    ),
    vent(
        Fault::OutputStray,
        "output is not what was written",
        "the voltage at PA4, read back, differs by more than 39 mV (0.12 bar) from what the converter was told, three ticks in a \
         row; when vented it is above 39 mV",
        STRAY_TICKS as u32,
        "the converter is defective, or something else drives the pin: a short, an amplifier that feeds back",
        "measure PA4 without the amplifier; replace the board if it still differs",
    ),
    vent(
        Fault::ReferenceVoltage,
        "reference voltage out of range",
        "the processor's reference, by its factory value, tells a supply of the converters that is more than 6 % off 3.3 V, three \
         ticks in a row",
        STRAY_TICKS as u32,
        "the 3.3 V regulator of the board is defective or overloaded: all that is measured and put out is off by as much",
        "measure 3.3 V at the processor; replace the board",
    ),
    Row {
        latch: Latch::PowerOn,
        ..vent(
            Fault::ImageDamaged,
            "firmware damaged",
            "the checksum of the firmware, looked at in each start, is wrong: neither the set point nor the dump valve's output is \
             switched on. Counted where the firmware carries no checksum, as one that a debugger has loaded",
            0,
            "a cell of the flash has lost its content, or the firmware was not written whole",
            "flash the firmware again; if it comes back, replace the board",
        )
    },
    Row {
        latch: Latch::PowerOn,
        ..vent(
            Fault::MemoryDamaged,
            "memory damaged",
            "a word of the RAM does not keep what is written to it in the test of each start: neither the set point nor the dump \
             valve's output is switched on",
            0,
            "the processor is damaged, or its supply was out of range",
            "measure 3.3 V; if it comes back, replace the board",
        )
    },
    vent(
        Fault::DumpHeld,
        "dump valve held",
        "the dump valve's coil has a voltage though its output has rested for 20 ticks: in the self-test, and whenever the board \
         is off or at fault. At another fault it is counted each 20 ticks as long as it lasts",
        DUMP_TICKS as u32 + 1,
        "the charge pump, or what switches the coil, is defective, or somebody feeds the coil; or the wire to PB15 is broken: without \
         the second contact PB15 has to be bridged to ground",
        "the second path does not open: close the supply by hand, then measure the coil's voltage",
    ),
    vent(
        Fault::CalibrationCorrupt,
        "stored calibration corrupt",
        "the calibration that the board has kept does not fit its own checksum, or has a line that no working sensor has; model \
         and limits are whole. Until it is calibrated again the scalings are those of the standard sensors",
        0,
        "flash or RAM that loses bits, or something else has written there",
        "acknowledge, then calibrate again, or restore a backup (`mgpi calibrate`, `mgpi restore`): what is measured may be a \
         quarter off until then",
    ),
    vent(
        Fault::HeartbeatStands,
        "heartbeat stands still",
        "as for a silent bus, but the same heartbeat has come again in these 500 ticks",
        501,
        "what sends for the host goes on, and the host's program behind it stands: a PLC in stop, a gateway that repeats its last \
         image, a thread that hangs",
        "see to the program; the number has to be counted by what computes the set points, not by what sends them",
    ),
    vent(
        Fault::Adaptation,
        "muscle left what may be learnt",
        "where adaptation is switched on: of its steps, one each hundredth of the stroke, a hundred more lead out of the bounds than \
         do not. The bounds are an offset of a fifth of the range, and what is asked of the model still rising by a quarter of the \
         reference",
        1,
        "another muscle or another load than the model's; a sensor or the valve has drifted; the muscle is worn out",
        "compare the sensors with a gauge and a rule (`mgpi calibrate`), look at the muscle; then record it again and deploy its model",
    ),
];

// All resets that the text of the loop tells.
const _: () = assert!(LOOP_RESETS == 3);

const fn vent(
    fault: Fault,
    title: &'static str,
    detection: &'static str,
    within_ticks: u32,
    cause: &'static str,
    cure: &'static str,
) -> Row {
    Row {
        fault,
        title,
        detection,
        reaction: Reaction::Vent,
        latch: Latch::Acknowledged,
        within_ticks,
        cause,
        cure,
    }
}
