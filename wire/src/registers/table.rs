//! The table.

use super::windows::{
    CAPTURE_SAMPLES, MESSAGE_REGISTERS, QUEUE_POINTS, SAMPLE_REGISTERS, STREAM_POINTS, TRACE_ENTRY_REGISTERS,
    UPLOAD_BYTES, UPLOAD_REGISTERS,
};
use super::{Access, Kind, Register};
use crate::image::Place;
use crate::{FAULTS, TRACE};

/// The highest command, pressure of the strongest muscles that the board is made for. Unit: bar.
pub const HIGHEST_BAR: f64 = 8.0;

/// The highest rate of the bus: a sixteenth of the internal oscillator's 16 MHz, by which a board
/// goes on whose crystal has failed; the port samples each bit sixteen times. Unit: bit/s.
const HIGHEST_BAUD: f64 = 1_000_000.0;

/// The largest place for an image. Unit: byte.
const LARGEST_PLACE: f64 = Place::B.bytes() as f64;

/// Registers that belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Group {
    /// Of its first register.
    pub address: u16,
    /// A heading.
    pub title: &'static str,
    /// How its registers go together.
    pub doc: &'static str,
}

/// The groups, by their addresses.
pub const GROUPS: [Group; 12] = [
    Group {
        address: 0x0000,
        title: "Identification",
        doc: "Who the board is, the versions of everything that has one, and how its codes are scaled: \
              code = zero code + codes per unit times quantity.",
    },
    Group {
        address: 0x0100,
        title: "Control",
        doc: "Orders and set points. Written together they are taken in this order: mode, set points, command; they may be \
              written all the time with command 0. A command that the state does not take is refused with exception 6, as \
              is `setpoint_bar` outside the service state, other than 0, and a set point while the stream plays; set points that \
              are written together with command 2, to stop, are not taken. A valve is opened in two steps: command 6, then 1 or 5 \
              within 2000 ticks; each by a request of its own, to this board alone. While it is driven the host has to write another \
              number to `heartbeat` at least every `bus_silent_ticks`: the same again is no sign of life.",
    },
    Group {
        address: 0x0200,
        title: "Status",
        doc: "What the board does and measures. Cycles are those of the processor's clock; in the emulator they say nothing.",
    },
    Group {
        address: 0x0300,
        title: "Controller",
        doc: "Gains and limits of the installed configuration. A write installs the configuration again and stores it, as an \
              upload does: refused with exception 6 while the valve is driven, and on a board without a configuration.",
    },
    Group {
        address: 0x0400,
        title: "Protection",
        doc: "Limits of the plant, refused with exception 6 while the valve is driven; kept without power. What is written \
              here cannot be switched off; a board in the emulator starts with most of it off (infinite).",
    },
    Group {
        address: 0x0500,
        title: "Faults",
        doc: "Numbers and cures are in faults.md. The record is that of the first fault since the last acknowledgement, \
              with the ticks before it; it outlives a reset.",
    },
    Group {
        address: 0x0600,
        title: "Stream",
        doc: "Set points at equal intervals, in mm while tracking and in bar in the service state, interpolated by the \
              board, so that the bus's timing does not matter. Points are pushed with the number of the first: what the \
              board has already is passed over (a push may be repeated), a gap is refused with exception 3, more than is \
              free with exception 6. A change to a state without a drive, or to another one, clears the stream.",
    },
    Group {
        address: 0x0700,
        title: "Capture",
        doc: "The loop, recorded in a ring at the tick's rate. Samples are numbered from the start of the recording: write \
              the number wanted, then read the window. If its first sample has a higher number, those between are lost.",
    },
    Group {
        address: 0x0800,
        title: "Upload",
        doc: "A configuration in blocks: write blocks at their offsets, then length and checksum, then commit. Until the \
              commit succeeds the old configuration stays; a commit while the valve is driven is refused with exception 6, \
              one of a content that is not valid with exception 3. Exception 4: it is in use, but the flash has not kept it. Fetch, and the same window reads the installed one.",
    },
    Group {
        address: 0x0900,
        title: "Bus",
        doc: "How the board is reached, kept without power. What is written here is taken at the next start, or by `bus_take`: \
              the answer still comes by the old parameters. A board that hears no whole frame for 10 s behind either listens \
              by 115,200 bit/s without parity, under its own number, and by its parameters, 10 s each in turns, until it hears \
              one. Refused with exception 6 while the valve is driven, and as a broadcast, but for `bus_take` alone.",
    },
    Group {
        address: 0x0A00,
        title: "Calibration",
        doc: "What two points a sensor have shown, and how the sensors are connected (`mgpi calibrate`), kept without power \
              apart from the model. The registers up to a checksum are written at once, with one that fits. A sensor whose input \
              changes begins by the line of its range; each line may differ from that, or from the standard sensor's, by \
              a fifth of its gain downwards, a quarter upwards, and a tenth of its span at zero. Refused with exception 6 while \
              the valve is driven, else with 3, and `message` says why.",
    },
    Group {
        address: 0x0B00,
        title: "Update",
        doc: "A new image into the place of the flash that does not run (`mgpi update`): begin, then blocks in order by \
              `update_offset`, each with the window behind it, then take, then restart. A block that has come already may be \
              repeated; one that leaves a gap, or differs from what was written, is refused with exception 3. The first \
              block of a sector erases it, which takes up to 2 s, in which the board hears nothing. A take that is refused is \
              exception 3, and `update_result` says why. All is refused with exception 6 while the valve is driven, and as a \
              broadcast, and with 4 by a board that takes no images.",
    },
];

macro_rules! table {
    ($($address:literal $id:ident $name:literal $kind:ident [$length:expr] $unit:literal $access:expr, $doc:literal;)*) => {
        /// A register's name in programs.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u8)]
        pub enum Id {
            $(#[doc = $doc] $id,)*
        }

        /// All registers, by their addresses.
        pub static TABLE: [Register; [$(Id::$id),*].len()] = [
            $(Register {
                id: Id::$id,
                name: $name,
                address: $address,
                kind: Kind::$kind,
                length: $length,
                unit: $unit,
                access: $access,
                doc: $doc,
            },)*
        ];

        impl Id {
            /// Its row.
            #[allow(clippy::indexing_slicing, reason = "constants: the compiler has looked at each")]
            pub const fn register(self) -> &'static Register {
                match self {
                    $(Self::$id => &TABLE[Id::$id as usize],)*
                }
            }
        }
    };
}

/// The ends of the range in which a set point may be.
const MM: Access = Access::Write(-20.0, 200.0);
const BAR: Access = Access::Write(0.0, HIGHEST_BAR);
const WORD: Access = Access::Write(0.0, u16::MAX as f64);
const DOUBLE_WORD: Access = Access::Write(0.0, u32::MAX as f64);
const READ: Access = Access::Read;
/// Codes of 0 and per unit that a converter of 12 bits has anything to do with.
const ZERO: Access = Access::Write(-4_095.0, 4_095.0);
const GAIN: Access = Access::Write(1.0, 4_095.0);
/// Ends of a sensor's range that anybody has.
const RANGE: Access = Access::Write(-10_000.0, 10_000.0);

const fn write(min: f64, max: f64) -> Access {
    Access::Write(min, max)
}

table! {
    0x0000 RegistersVersion "registers_version" U16 [1] "" READ, "Version of this map";
    0x0001 WireVersion "wire_version" U16 [1] "" READ, "Version of the messages, that of an uploaded configuration";
    0x0002 StorageVersion "storage_version" U16 [1] "" READ, "Layout of what is kept without power";
    0x0003 Release "release" U16 [3] "" READ, "Version of the firmware: major, minor, patch";
    0x0006 TickPeriod "tick_period_us" U32 [1] "us" READ, "Time from tick to tick";
    0x0008 PressureZero "pressure_zero_code" F32 [1] "code" READ, "Code of 0 bar at the pressure's input";
    0x000A PressureGain "pressure_codes_per_bar" F32 [1] "code/bar" READ, "Scaling of the same";
    0x000C ContractionZero "contraction_zero_code" F32 [1] "code" READ, "Code of 0 mm at the contraction's input";
    0x000E ContractionGain "contraction_codes_per_mm" F32 [1] "code/mm" READ, "Scaling of the same";
    0x0010 CommandZero "command_zero_code" F32 [1] "code" READ, "Code of 0 bar at the valve's output";
    0x0012 CommandGain "command_codes_per_bar" F32 [1] "code/bar" READ, "Scaling of the same";
    0x0014 UniqueId "unique_id" U16 [6] "" READ, "Of the processor, from its maker: no two have the same; 0 in the emulator";
    0x001A Processor "processor" U32 [1] "" READ, "Which processor it is, and which revision of it, as its register DBGMCU_IDCODE tells; 0 in the emulator";
    0x001C HardwareRevision "hardware_revision" U16 [1] "" READ, "Of the board, as its maker has written it once into the first word of the processor's OTP area; 0 where nobody has";
    0x001D SourceCommit "source_commit" U16 [10] "" READ, "Of the sources that the firmware was built from: the git commit, 20 bytes; 0 where that was not known";
    0x0027 SourceModified "source_modified" U16 [1] "" READ, "1 where the sources differed from that commit";

    0x0100 Command "command" U16 [1] "" write(0.0, 6.0), "0 nothing, 1 start, or go on from holding, 2 stop and vent, 3 hold, 4 acknowledge, 5 service, 6 arm; reads as the last one taken";
    0x0101 Mode "mode" U16 [1] "" write(0.0, 2.0), "0 feed-forward and feedback, 1 feed-forward alone, 2 feedback alone; at once while tracking, else with the next command 1";
    0x0102 SetpointMm "setpoint_mm" F32 [1] "mm" MM, "The reference";
    0x0104 SetpointBar "setpoint_bar" F32 [1] "bar" BAR, "The command in the service state";
    0x0106 Heartbeat "heartbeat" U16 [1] "" WORD, "Any number, another one each time: what a host that lives can write and one that only repeats itself cannot";
    0x0107 Armed "armed_ticks" U16 [1] "tick" READ, "How long command 1 or 5 is still taken";
    0x0108 Adaptation "adaptation" U16 [1] "" write(0.0, 2.0), "0 off, and what was learnt is forgotten (refused while the valve is driven), 1 the feed-forward follows the muscle, 2 what was learnt stays, nothing is learnt; 0 at each start of the board and for another model";

    0x0200 State "state" U16 [1] "" READ, "0 off, 1 self-test, 2 ready, 3 tracking, 4 holding, 5 fault, 6 service";
    0x0201 Fault "fault" U16 [1] "" READ, "Number of the latched fault, 0 for none";
    0x0202 Ticks "ticks" U32 [1] "tick" READ, "Ticks since the start";
    0x0204 PressureBar "pressure_bar" F32 [1] "bar" READ, "Measured in the muscle";
    0x0206 ContractionMm "contraction_mm" F32 [1] "mm" READ, "Measured";
    0x0208 ReferenceMm "reference_mm" F32 [1] "mm" READ, "What the controller was asked for";
    0x020A CommandBar "command_bar" F32 [1] "bar" READ, "What was put out to the valve";
    0x020C SupplyBar "supply_bar" F32 [1] "bar" READ, "Measured before the valve";
    0x020E TemperatureC "temperature_c" F32 [1] "°C" READ, "Measured in the processor";
    0x0210 WorstTick "worst_tick_cycles" U32 [1] "cycle" READ, "Longest time from a tick's due moment to its end";
    0x0212 MeanTick "mean_tick_cycles" U32 [1] "cycle" READ, "Mean of the same";
    0x0214 Deadline "deadline_cycles" U32 [1] "cycle" READ, "When a tick has to have ended; 0 on a board whose ticks come by the link";
    0x0216 Overruns "overruns" U32 [1] "" READ, "Ticks that found the one before unfinished";
    0x0218 LateTicks "late_ticks" U32 [1] "" READ, "Ticks that ended after their deadline";
    0x021A LimitedTicks "limited_ticks" U32 [1] "" READ, "Ticks in which a limit changed the command";
    0x021C BridgedSamples "bridged_samples" U32 [1] "" READ, "Samples that were replaced by the one before";
    0x021E Resets "resets" U32 [1] "" READ, "Resets in a row that no power-on explains";
    0x0220 BusFrames "bus_frames" U32 [1] "" READ, "Frames for this board that were whole";
    0x0222 BusDamaged "bus_damaged" U32 [1] "" READ, "Runs of bytes that were no whole frame";
    0x0224 BusRefused "bus_refused" U32 [1] "" READ, "Requests that an exception has answered";
    0x0226 PressureNoise "pressure_noise_bar" F32 [1] "bar" READ, "Noise of a single conversion of the pressure, one standard deviation; the mean of eight is what is used. 0 in the emulator";
    0x0228 ContractionNoise "contraction_noise_mm" F32 [1] "mm" READ, "The same of the contraction";
    0x022A OutputV "output_v" F32 [1] "V" READ, "Voltage at the valve's output, PA4, read back; 0 where it is not";
    0x022C ConvertersSupplyV "converters_supply_v" F32 [1] "V" READ, "Supply of the converters, by the processor's reference voltage; 0 in the emulator";
    0x022E AdaptedOffset "adapted_offset_mm" F32 [1] "mm" READ, "What was learnt of the muscle: how much further than its model it contracts in the middle of its range";
    0x0230 AdaptedGain "adapted_gain_mm" F32 [1] "mm" READ, "By how much more at the upper end";
    0x0232 AdaptedBend "adapted_bend_mm" F32 [1] "mm" READ, "By how much more at both ends";
    0x0234 AdaptedWidth "adapted_width_mm" F32 [1] "mm" READ, "How much further on the way up than in the middle of the loop";
    0x0236 AdaptedFlare "adapted_flare_mm" F32 [1] "mm" READ, "By how much more so at the upper end";
    0x0238 AdaptedSteps "adapted_steps" U32 [1] "" READ, "In how many steps that was learnt";

    0x0300 Kp "kp_bar_per_mm" F32 [1] "bar/mm" write(0.0, 10.0), "Proportional gain";
    0x0302 Ki "ki_bar_per_mm_s" F32 [1] "bar/mm s" write(0.0, 100.0), "Integral gain, bar/(mm s)";
    0x0304 Kd "kd_bar_s_per_mm" F32 [1] "bar s/mm" write(0.0, 10.0), "Derivative gain";
    0x0306 DerivativeFilter "derivative_filter_s" F32 [1] "s" write(0.0, 10.0), "Time constant of the derivative's filter";
    0x0308 TrackingTime "tracking_time_s" F32 [1] "s" write(0.001, 1000.0), "Time constant of the anti-windup";
    0x030A CommandMin "command_min_bar" F32 [1] "bar" BAR, "Lowest command";
    0x030C CommandMax "command_max_bar" F32 [1] "bar" BAR, "Highest command";
    0x030E CommandSlew "command_slew_bar_per_s" F32 [1] "bar/s" write(0.1, 200.0), "Largest rate of change of the controller's command";
    0x0310 ObserverSlope "observer_slope_mm_per_bar" F32 [1] "mm/bar" write(0.0, 1000.0), "Slope of the muscle that the gains are for; 0 switches the observer off, by which they grow where the inverse is steeper";
    0x0312 ObserverReach "observer_reach" F32 [1] "" write(1.0, 100.0), "How many times as large it may make the gains";
    0x0314 ObserverBand "observer_band_mm" F32 [1] "mm" write(0.0, 20.0), "Moves and errors that are noise to it";

    0x0400 SelfTestTicks "self_test_ticks" U32 [1] "tick" write(0.0, 10_000.0), "Length of the self-test";
    0x0402 VentedBar "vented_bar" F32 [1] "bar" write(0.0, 1.0), "Highest pressure at the end of the self-test";
    0x0404 OverpressureHard "overpressure_hard_bar" F32 [1] "bar" write(0.0, 8.5), "Pressure that vents in the sample that shows it";
    0x0406 OverpressureSoft "overpressure_soft_bar" F32 [1] "bar" BAR, "Pressure that vents as an average of some 16 samples";
    0x0408 SupplyMin "supply_min_bar" F32 [1] "bar" write(0.0, 10.0), "Lowest pressure of the supply";
    0x040A PressureJump "pressure_jump_bar" F32 [1] "bar" write(0.01, 10.0), "Largest credible change in a tick";
    0x040C ContractionJump "contraction_jump_mm" F32 [1] "mm" write(0.1, 200.0), "Largest credible change in a tick";
    0x040E StuckCommand "stuck_command_bar" F32 [1] "bar" write(0.1, 10.0), "Move of the command that a stuck sensor does not follow";
    0x0410 ImplausibleShare "implausible_share" F32 [1] "" write(0.0, 10.0), "How far outside the model's loop a contraction may be, as a share of the stroke";
    0x0412 FollowingBand "following_band_bar" F32 [1] "bar" write(0.0, 10.0), "How far pressure and command may differ for good";
    0x0414 FollowingLimit "following_limit_bar_s" F32 [1] "bar s" write(0.0, 100.0), "Integral of what they differ beyond that";
    0x0416 Authority "authority_bar" F32 [1] "bar" write(0.0, 10.0), "How much the feedback may add for good";
    0x0418 BusSilent "bus_silent_ticks" U32 [1] "tick" write(10.0, 60_000.0), "How long the host may be without a sign of life while the valve is driven";
    0x041A SoftStart "soft_start_bar_per_s" F32 [1] "bar/s" write(0.1, 200.0), "Rise of the highest command after a start";
    0x041C Slew "slew_bar_per_s" F32 [1] "bar/s" write(0.1, 200.0), "Largest rate of change of the valve's command, service included";
    0x041E TemperatureMax "temperature_max_c" F32 [1] "°C" write(0.0, 105.0), "Highest temperature of the board";
    0x0420 OnModelFault "on_model_fault" U16 [1] "" write(0.0, 1.0), "When the model does not stand its test: 0 the valve stays vented, 1 feedback alone may track";

    0x0500 RecordFault "record_fault" U16 [1] "" READ, "Number of the recorded fault, 0 for none";
    0x0501 RecordEntries "record_entries" U16 [1] "" READ, "Entries of the trace";
    0x0502 RecordTick "record_tick" U32 [1] "tick" READ, "When it happened, in ticks since the start";
    0x0504 RecordDetail "record_detail" U32 [1] "" READ, "Of a fault of the processor, its fault status";
    0x0506 FaultCounts "fault_counts" U16 [FAULTS as u16] "" READ, "How often each fault has occurred since the start, by its number less one";
    0x0540 Trace "trace" U16 [TRACE as u16 * TRACE_ENTRY_REGISTERS] "" READ, "Entries, oldest first, 7 registers each: tick (u32), codes of pressure, contraction, supply, valve, reference (i16, 1/64 mm)";

    0x0600 StreamOrder "stream_order" U16 [1] "" write(0.0, 2.0), "0 clear, 1 play, 2 no more points come; reads as the last one taken";
    0x0601 StreamInterval "stream_interval_ticks" U16 [1] "tick" write(1.0, 1000.0), "From point to point; not changed while playing";
    0x0602 StreamState "stream_state" U16 [1] "" READ, "0 idle, 1 playing, 2 out of points, 3 done";
    0x0603 StreamFree "stream_free" U16 [1] "" READ, "Free places of the queue";
    0x0604 StreamPushed "stream_pushed" U32 [1] "" READ, "Points pushed since the last clear: the number of the next";
    0x0606 StreamConsumed "stream_consumed" U32 [1] "" READ, "Points taken out of the queue since the last clear";
    0x0608 StreamUnderrun "stream_underrun_ticks" U32 [1] "tick" READ, "Ticks without a point to go to since the last clear";
    0x060A StreamStart "stream_start_tick" U32 [1] "tick" READ, "The tick in which point 0 was the set point";
    0x060C StreamPlayIn "stream_play_in_ticks" U16 [1] "tick" write(1.0, 60_000.0), "Starts the stream like stream_order 1, this many ticks from now: point 0 is then the set point, and until then the set point stays. Writing it again restarts the count. Broadcast, it starts all boards that hold points in the same tick. Reads as the ticks left";
    0x0610 PushNumber "push_number" U32 [1] "" DOUBLE_WORD, "Number of the first of the points behind it; written together with them";
    0x0612 PushPoints "push_points" F32 [STREAM_POINTS] "" MM, "Points, mm or bar; as many as are written. Reads as the next ones to be played, 0 behind the last";

    0x0700 CaptureEvery "capture_every_ticks" U16 [1] "tick" write(0.0, 1000.0), "Begins a new recording of every Nth tick; 0 stops it. A fault stops it too";
    0x0701 CaptureKept "capture_kept" U16 [1] "" READ, "Samples in the ring";
    0x0702 CaptureTaken "capture_taken" U32 [1] "" READ, "Samples since the recording began: the number of the next";
    0x0704 CaptureFrom "capture_from" U32 [1] "" DOUBLE_WORD, "Number of the sample that the window begins with";
    0x0710 CaptureFirst "capture_first" U32 [1] "" READ, "Number of the first sample of the window";
    0x0712 CaptureFirstTick "capture_first_tick" U32 [1] "tick" READ, "Its tick";
    0x0714 CaptureCount "capture_count" U16 [1] "" READ, "Samples in the window";
    0x0715 CaptureWindow "capture_window" U16 [CAPTURE_SAMPLES * SAMPLE_REGISTERS] "" READ, "5 registers each: reference (i16, 1/128 mm), codes of pressure, contraction, valve, feedback (i16, 1/4096 bar)";

    0x0800 UploadOrder "upload_order" U16 [1] "" write(0.0, 2.0), "0 nothing, 1 commit, 2 fetch; reads as 0";
    0x0801 UploadResult "upload_result" U16 [1] "" READ, "Of the last commit or write of gains: 0 none, 1 installed, 2 length or checksum, 3 unreadable, 4 version, 5 parameter, 6 state, 7 installed but not stored";
    0x0802 UploadCapacity "upload_capacity" U16 [1] "" READ, "Size of the buffer in bytes";
    0x0803 UploadLength "upload_length" U16 [1] "" write(0.0, UPLOAD_BYTES as f64), "Bytes that make up the configuration";
    0x0804 UploadChecksum "upload_checksum" U32 [1] "" DOUBLE_WORD, "CRC-32 (ISO-HDLC) over them";
    0x080F UploadOffset "upload_offset" U16 [1] "" write(0.0, UPLOAD_BYTES as f64 - 1.0), "Where the window stands in the buffer, in bytes; may be written together with it";
    0x0810 UploadWindow "upload_window" U16 [UPLOAD_REGISTERS] "" WORD, "Two bytes in a register, the first in the high half; beyond the buffer's end a write is refused, and 0 is read";
    0x0890 Message "message" U16 [MESSAGE_REGISTERS] "" READ, "Why the last commit or write of gains or protection was refused, two characters in a register";

    0x0900 BusNumber "bus_number" U16 [1] "" write(1.0, 247.0), "The board's number on the bus";
    0x0901 BusParity "bus_parity" U16 [1] "" write(0.0, 2.0), "0 none, 1 even, 2 odd; one stop bit in any case";
    0x0902 BusRate "bus_rate_bit_per_s" U32 [1] "bit/s" write(9_600.0, HIGHEST_BAUD), "Rate of both directions";
    0x0904 BusTurnaround "bus_turnaround_us" U32 [1] "us" write(0.0, 50_000.0), "Least time from the end of a request to its answer, which comes at most a tick later";
    0x0906 BusTake "bus_take" U16 [1] "" write(0.0, 1.0), "1 takes what stands above now, behind the answer; reads as 0";
    0x0907 BusListens "bus_listens" U16 [1] "" READ, "By what the board listens: 0 what stands above, 1 what stood there before, 2 the rate and parity of a new board, since nobody was heard by its own";

    0x0A00 CalibratedPressureZero "calibrated_pressure_zero_code" F32 [1] "code" ZERO, "Code of 0 bar at the pressure's input";
    0x0A02 CalibratedPressureGain "calibrated_pressure_codes_per_bar" F32 [1] "code/bar" GAIN, "Scaling of the same";
    0x0A04 CalibratedContractionZero "calibrated_contraction_zero_code" F32 [1] "code" ZERO, "Code of 0 mm at the contraction's input";
    0x0A06 CalibratedContractionGain "calibrated_contraction_codes_per_mm" F32 [1] "code/mm" GAIN, "Scaling of the same";
    0x0A08 CalibratedSupplyZero "calibrated_supply_zero_code" F32 [1] "code" ZERO, "Code of 0 bar at the supply's input";
    0x0A0A CalibratedSupplyGain "calibrated_supply_codes_per_bar" F32 [1] "code/bar" GAIN, "Scaling of the same";
    0x0A0C CalibratedCommandZero "calibrated_command_zero_code" F32 [1] "code" ZERO, "Code at the valve's output for 0 bar at the pressure's sensor";
    0x0A0E CalibratedCommandGain "calibrated_command_codes_per_bar" F32 [1] "code/bar" GAIN, "Scaling of the same";
    0x0A10 CalibrationDay "calibration_day" U32 [1] "" write(0.0, 100_000.0), "Days from 1970-01-01 to the calibration; 0 where there was none";
    0x0A12 CalibrationChecksum "calibration_checksum" U32 [1] "" DOUBLE_WORD, "CRC-32 (ISO-HDLC) over the registers of this group before it";
    0x0A20 PressureInput "pressure_input" U16 [1] "" write(0.0, 2.0), "Sensor of the pressure: 0 ratiometric, 1 4 to 20 mA, 2 0 to 10 V";
    0x0A21 PressureInputPin "pressure_input_pin_v" F32 [1] "V" write(0.0, 24.0), "Voltage at its pin by 20 mA (0.02 times the resistor) or 10 V (10 times the divider); 0 of a ratiometric one";
    0x0A23 PressureInputLow "pressure_input_low_bar" F32 [1] "bar" RANGE, "What it shows at 4 mA or 0 V; 0 of a ratiometric one";
    0x0A25 PressureInputHigh "pressure_input_high_bar" F32 [1] "bar" RANGE, "What it shows at 20 mA or 10 V; 0 of a ratiometric one";
    0x0A27 ContractionInput "contraction_input" U16 [1] "" write(0.0, 2.0), "Sensor of the contraction: 0 ratiometric, 1 4 to 20 mA, 2 0 to 10 V";
    0x0A28 ContractionInputPin "contraction_input_pin_v" F32 [1] "V" write(0.0, 24.0), "Voltage at its pin by 20 mA (0.02 times the resistor) or 10 V (10 times the divider); 0 of a ratiometric one";
    0x0A2A ContractionInputLow "contraction_input_low_mm" F32 [1] "mm" RANGE, "What it shows at 4 mA or 0 V; 0 of a ratiometric one";
    0x0A2C ContractionInputHigh "contraction_input_high_mm" F32 [1] "mm" RANGE, "What it shows at 20 mA or 10 V; 0 of a ratiometric one";
    0x0A2E SupplyInput "supply_input" U16 [1] "" write(0.0, 2.0), "Sensor of the pressure before the valve: 0 ratiometric, 1 4 to 20 mA, 2 0 to 10 V";
    0x0A2F SupplyInputPin "supply_input_pin_v" F32 [1] "V" write(0.0, 24.0), "Voltage at its pin by 20 mA (0.02 times the resistor) or 10 V (10 times the divider); 0 of a ratiometric one";
    0x0A31 SupplyInputLow "supply_input_low_bar" F32 [1] "bar" RANGE, "What it shows at 4 mA or 0 V; 0 of a ratiometric one";
    0x0A33 SupplyInputHigh "supply_input_high_bar" F32 [1] "bar" RANGE, "What it shows at 20 mA or 10 V; 0 of a ratiometric one";
    0x0A35 InputsChecksum "inputs_checksum" U32 [1] "" DOUBLE_WORD, "CRC-32 (ISO-HDLC) over the twelve registers before it";

    0x0B00 UpdateOrder "update_order" U16 [1] "" write(0.0, 3.0), "0 nothing, 1 begin, 2 take, 3 restart; reads as 0";
    0x0B01 UpdateOlder "update_older" U16 [1] "" write(0.0, 1.0), "1, written together with a take: an older release is taken too; reads as 0";
    0x0B02 UpdateResult "update_result" U16 [1] "" READ, "Of the last take since begin: 0 none, 1 taken, 2 not whole, 3 for another board, 4 for the other place, 5 older, 6 signature, 7 not stored";
    0x0B03 UpdatePlace "update_place" U16 [1] "" READ, "Where the image runs: 1 A, 2 B; 0 on a board that takes no images";
    0x0B04 UpdateTrial "update_trial" U16 [1] "" READ, "0 the image runs for good, 1 it is on trial, 2 the other one was tried and rolled back, 3 the other one is tried at the next start";
    0x0B05 UpdateKind "update_kind" U16 [1] "" READ, "For which kind of board images have to be: 1 regulator, 2 coil; 0 as for the place";
    0x0B06 UpdateNext "update_next" U32 [1] "" READ, "Bytes written since begin: where the next block goes; 0 behind a start";
    0x0B08 UpdateOffset "update_offset" U32 [1] "" write(0.0, LARGEST_PLACE), "Where the window stands in the place, in bytes, a multiple of 4; written together with it";
    0x0B0A UpdateWindow "update_window" U16 [UPLOAD_REGISTERS] "" WORD, "Two bytes in a register, the first in the high half, an even number of registers; reads what stands in the flash";
}

/// Places of the queue are told in a register.
const _: () = assert!(QUEUE_POINTS >= 2 * STREAM_POINTS);
