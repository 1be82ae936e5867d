//! What registers read as.
//!
//! A [`View`] is gathered once a request, under the control's lock as far as it needs that; so what
//! is read at once belongs together. The values are picked from it outside the lock.

use heapless::Vec;
use wire::image::Head;
use wire::registers::UPLOAD_REGISTERS;
use wire::registers::{
    CAPTURE_SAMPLES, Exception, Id, Register, SAMPLE_REGISTERS, STREAM_POINTS, TRACE_ENTRY_REGISTERS,
    UPLOAD_BYTES, VERSION, Value, mode_number, pack_bytes, pack_sample, pack_trace_entry, state_number,
};
use wire::{BusParameters, Calibration, Captured, FaultRecord, Protection, Telemetry};

use super::player::PlayerStatus;
use super::session::Session;
use crate::control::Control;
use crate::identity::{Identity, SOURCE};
use crate::node::Node;
use crate::report::{FIRMWARE_VERSION, Outputs};
use crate::scaling::Scalings;
use crate::store::LAYOUT;
use crate::update::Images;
use wire::BoardParameters;
use wire::registers::fields::{CONTROLLER, of_bus, of_controller, of_protection};

/// What a reading is answered from.
// Lives for one request, on the stack; boxing it needs a heap, which the board does not have.
#[allow(clippy::large_enum_variant)]
enum View {
    Identification {
        period_s: f32,
        identity: Identity,
        scalings: Scalings,
    },
    Control(Outputs),
    Status(Telemetry, Outputs),
    /// 0 without a configuration.
    Controller([Value; CONTROLLER.len()]),
    Protection(Protection),
    Faults(Telemetry, Option<FaultRecord>),
    Stream(PlayerStatus, Vec<f32, { STREAM_POINTS as usize }>),
    Capture {
        every: u16,
        kept: u16,
        taken: u32,
        first: u32,
        window: Captured,
    },
    Upload,
    /// As it is kept.
    Bus(BusParameters),
    Calibration(Calibration),
    /// None where no images are taken.
    Update(Option<Updating>),
}

/// What is read of an update.
struct Updating {
    place: u16,
    trial: u16,
    kind: u16,
    window: [u8; 2 * UPLOAD_REGISTERS as usize],
}

/// Writes the values of registers into `words`, big-endian, from an address on.
///
/// # Errors
/// One of the addresses has no register.
// Not inlined: what a reading needs of the stack is not needed by a write.
#[inline(never)]
pub fn read(
    session: &Session,
    address: u16,
    words: &mut [u8],
    node: &mut impl Node,
) -> Result<(), Exception> {
    let view = view(session, address, node);
    for (offset, word) in words.chunks_exact_mut(2).enumerate() {
        let address = address.checked_add(offset as u16).ok_or(Exception::IllegalAddress)?;
        let register = Register::at(address).ok_or(Exception::IllegalAddress)?;
        let (offset, width) = (address - register.address, register.kind.words());
        let value = value(session, &view, register.id, offset / width);
        word.copy_from_slice(&value.word(offset % width).to_be_bytes());
    }
    Ok(())
}

/// Gathers what the group of an address needs. Between groups there are free addresses: no reading
/// takes in two.
#[inline(never)]
fn view(session: &Session, address: u16, node: &mut impl Node) -> View {
    match address >> 8 {
        0 => {
            let (period_s, scalings) = node.control(|control| (control.period_s(), control.scalings));
            View::Identification { period_s, identity: *node.identity(), scalings }
        }
        1 => View::Control(node.control(|control| control.outputs())),
        2 => node.control(|control| View::Status(control.telemetry(), control.outputs())),
        3 => View::Controller(node.parameters().tracking.as_ref().map_or([Value::F32(0.0); _], controller)),
        4 => View::Protection(node.control(|control| control.protection)),
        5 => node.control(|control| View::Faults(control.telemetry(), control.faults.record())),
        6 => node.control(|control| {
            let waiting = control.player.waiting().take(STREAM_POINTS.into());
            View::Stream(control.player.status(), waiting.collect())
        }),
        7 => node.control(|control| capture(control, session.capture_from)),
        8 => View::Upload,
        9 => View::Bus(node.parameters().bus),
        11 => View::Update(node.images().map(|images| updating(session, images))),
        _ => View::Calibration(node.control(|control| control.scalings.calibration())),
    }
}

fn controller(tracking: &BoardParameters) -> [Value; CONTROLLER.len()] {
    let mut tracking = tracking.clone();
    CONTROLLER.map(|id| of_controller(&mut tracking, id).map_or(Value::F32(0.0), |field| field.get()))
}

// Not inlined: the other readings do not need its stack.
#[inline(never)]
fn updating(session: &Session, images: &impl Images) -> Updating {
    let running = images.running();
    let mut window = [0; 2 * UPLOAD_REGISTERS as usize];
    let stands = images.read(running.other()).get(session.update.offset as usize..).unwrap_or_default();
    window.iter_mut().zip(stands).for_each(|(byte, stands)| *byte = *stands);
    Updating {
        place: running.number(),
        trial: session.update.trial(images).number(),
        kind: Head::of(images.read(running)).map_or(0, |head| head.linked.kind),
        window,
    }
}

fn capture(control: &Control, from: u32) -> View {
    let (taken, kept) = (control.capture.taken(), control.capture.kept());
    let oldest = taken.saturating_sub(kept.into());
    let skipped = from.saturating_sub(oldest).min(kept.into()) as u16;
    View::Capture {
        every: control.capture.every(),
        kept,
        taken,
        first: oldest.saturating_add(skipped.into()),
        window: control.capture.read(skipped.into()),
    }
}

/// The value of this number in a register's run.
fn value(session: &Session, view: &View, id: Id, index: u16) -> Value {
    match view {
        View::Identification { period_s, identity, scalings } => {
            identification(id, index, *period_s, identity, scalings)
        }
        View::Control(outputs) => match id {
            Id::Command => Value::U16(session.command.number()),
            Id::Mode => Value::U16(mode_number(session.mode)),
            Id::SetpointMm => Value::F32(outputs.next_reference_mm),
            Id::Heartbeat => Value::U16(outputs.heartbeat),
            Id::Armed => Value::U16(outputs.armed_ticks),
            Id::Adaptation => Value::U16(outputs.adaptation.learning.number()),
            _ => Value::F32(outputs.service_bar),
        },
        View::Status(telemetry, outputs) => status(session, telemetry, outputs, id),
        View::Controller(values) => {
            let place = CONTROLLER.iter().position(|register| *register == id);
            place.and_then(|place| values.get(place).copied()).unwrap_or(Value::F32(0.0))
        }
        View::Protection(protection) => {
            of_protection(&mut protection.clone(), id).map_or(Value::F32(0.0), |field| field.get())
        }
        View::Faults(telemetry, record) => faults(telemetry, record.as_ref(), id, index),
        View::Stream(status, waiting) => stream(status, waiting, id, index),
        View::Capture { every, kept, taken, first, window } => match id {
            Id::CaptureEvery => Value::U16(*every),
            Id::CaptureKept => Value::U16(*kept),
            Id::CaptureTaken => Value::U32(*taken),
            Id::CaptureFrom => Value::U32(session.capture_from),
            Id::CaptureFirst => Value::U32(*first),
            Id::CaptureFirstTick => Value::U32(window.first_tick),
            Id::CaptureCount => Value::U16((window.samples.len() as u16).min(CAPTURE_SAMPLES)),
            _ => of_entry(&window.samples, index, |sample| -> [u16; SAMPLE_REGISTERS as usize] {
                pack_sample(sample)
            }),
        },
        View::Upload => upload(session, id, index),
        View::Update(updating) => update(session, updating.as_ref(), id, index),
        View::Calibration(calibration) => calibration.value(id).unwrap_or(Value::U16(0)),
        View::Bus(bus) => match id {
            Id::BusTake => Value::U16(0),
            Id::BusListens => Value::U16(session.listening.told(bus).number()),
            _ => of_bus(&mut bus.clone(), id).map_or(Value::U16(0), |field| field.get()),
        },
    }
}

fn identification(id: Id, index: u16, period_s: f32, identity: &Identity, scalings: &Scalings) -> Value {
    let of = |words: &[u16]| Value::U16(words.get(usize::from(index)).copied().unwrap_or(0));
    match id {
        Id::RegistersVersion => Value::U16(VERSION),
        Id::WireVersion => Value::U16(wire::VERSION),
        Id::StorageVersion => Value::U16(LAYOUT),
        Id::Release => of(&FIRMWARE_VERSION),
        Id::TickPeriod => Value::U32((1e6 * period_s + 0.5) as u32),
        Id::PressureZero => Value::F32(scalings.pressure.zero_code),
        Id::PressureGain => Value::F32(scalings.pressure.codes_per_unit),
        Id::ContractionZero => Value::F32(scalings.contraction.zero_code),
        Id::ContractionGain => Value::F32(scalings.contraction.codes_per_unit),
        Id::CommandZero => Value::F32(scalings.command.zero_code),
        Id::CommandGain => Value::F32(scalings.command.codes_per_unit),
        Id::UniqueId => of(&identity.unique_id),
        Id::Processor => Value::U32(identity.processor),
        Id::HardwareRevision => Value::U16(identity.hardware_revision),
        Id::SourceCommit => of(&SOURCE.commit),
        _ => Value::U16(SOURCE.is_modified.into()),
    }
}

fn status(session: &Session, telemetry: &Telemetry, outputs: &Outputs, id: Id) -> Value {
    match id {
        Id::State => Value::U16(state_number(telemetry.state)),
        Id::Fault => Value::U16(telemetry.fault.map_or(0, |fault| fault.code().into())),
        Id::PressureBar => Value::F32(telemetry.signals.pressure_bar),
        Id::ContractionMm => Value::F32(telemetry.signals.contraction_mm),
        Id::ReferenceMm => Value::F32(outputs.reference_mm),
        Id::CommandBar => Value::F32(outputs.command_bar),
        Id::SupplyBar => Value::F32(telemetry.signals.supply_bar),
        Id::TemperatureC => Value::F32(telemetry.signals.temperature_c),
        Id::PressureNoise => Value::F32(outputs.pressure_noise_bar),
        Id::ContractionNoise => Value::F32(outputs.contraction_noise_mm),
        Id::OutputV => Value::F32(outputs.output_v),
        Id::ConvertersSupplyV => Value::F32(outputs.converters_supply_v),
        Id::AdaptedOffset => Value::F32(outputs.adaptation.change.offset),
        Id::AdaptedGain => Value::F32(outputs.adaptation.change.gain),
        Id::AdaptedBend => Value::F32(outputs.adaptation.change.bend),
        Id::AdaptedWidth => Value::F32(outputs.adaptation.change.width),
        Id::AdaptedFlare => Value::F32(outputs.adaptation.change.flare),
        _ => Value::U32(match id {
            Id::Ticks => telemetry.ticks,
            Id::WorstTick => telemetry.worst_tick_cycles,
            Id::MeanTick => telemetry.mean_tick_cycles,
            Id::Deadline => outputs.deadline_cycles,
            Id::Overruns => telemetry.overruns,
            Id::LateTicks => telemetry.late_ticks,
            Id::LimitedTicks => telemetry.limited_ticks,
            Id::BridgedSamples => telemetry.bridged_samples,
            Id::Resets => telemetry.resets,
            Id::BusFrames => session.frames,
            Id::BusDamaged => session.damaged,
            Id::AdaptedSteps => outputs.adaptation.steps,
            _ => session.refused,
        }),
    }
}

fn faults(telemetry: &Telemetry, record: Option<&FaultRecord>, id: Id, index: u16) -> Value {
    let of_record = |get: fn(&FaultRecord) -> u32| record.map_or(0, get);
    match id {
        Id::RecordFault => Value::U16(record.map_or(0, |record| record.fault.code().into())),
        Id::RecordEntries => Value::U16(record.map_or(0, |record| record.trace.len() as u16)),
        Id::RecordTick => Value::U32(of_record(|record| record.tick)),
        Id::RecordDetail => Value::U32(of_record(|record| record.detail)),
        Id::FaultCounts => Value::U16(telemetry.faults.get(usize::from(index)).copied().unwrap_or(0)),
        _ => of_entry(
            record.map_or(&[], |record| &*record.trace),
            index,
            |entry| -> [u16; TRACE_ENTRY_REGISTERS as usize] { pack_trace_entry(entry) },
        ),
    }
}

fn stream(status: &PlayerStatus, waiting: &[f32], id: Id, index: u16) -> Value {
    match id {
        Id::StreamOrder => Value::U16(status.order.number()),
        Id::StreamInterval => Value::U16(status.interval_ticks),
        Id::StreamState => Value::U16(status.state.number()),
        Id::StreamFree => Value::U16(status.free),
        Id::StreamPushed | Id::PushNumber => Value::U32(status.pushed),
        Id::StreamConsumed => Value::U32(status.consumed),
        Id::StreamUnderrun => Value::U32(status.underrun_ticks),
        Id::StreamStart => Value::U32(status.start_tick),
        Id::StreamPlayIn => Value::U16(status.play_in_ticks),
        _ => Value::F32(waiting.get(usize::from(index)).copied().unwrap_or(0.0)),
    }
}

fn upload(session: &Session, id: Id, index: u16) -> Value {
    match id {
        Id::UploadResult => Value::U16(session.result.number()),
        Id::UploadCapacity => Value::U16(UPLOAD_BYTES as u16),
        Id::UploadLength => Value::U16(session.upload.length),
        Id::UploadChecksum => Value::U32(session.upload.checksum),
        Id::UploadOffset => Value::U16(session.upload.offset),
        Id::UploadWindow => Value::U16(session.upload.word(index)),
        Id::Message => Value::U16(pack_bytes(session.message.as_bytes()).nth(index.into()).unwrap_or(0)),
        _ => Value::U16(0),
    }
}

fn update(session: &Session, updating: Option<&Updating>, id: Id, index: u16) -> Value {
    let of = |get: fn(&Updating) -> u16| Value::U16(updating.map_or(0, get));
    match id {
        Id::UpdateResult => Value::U16(session.update.result.number()),
        Id::UpdatePlace => of(|updating| updating.place),
        Id::UpdateTrial => of(|updating| updating.trial),
        Id::UpdateKind => of(|updating| updating.kind),
        Id::UpdateNext => Value::U32(session.update.written()),
        Id::UpdateOffset => Value::U32(session.update.offset),
        Id::UpdateWindow => {
            let mut words = updating.into_iter().flat_map(|updating| pack_bytes(&updating.window));
            Value::U16(words.nth(index.into()).unwrap_or(0))
        }
        _ => Value::U16(0),
    }
}

/// The register of this number in a run of entries of `N` registers each; 0 behind the last.
fn of_entry<T, const N: usize>(entries: &[T], index: u16, pack: impl Fn(&T) -> [u16; N]) -> Value {
    let index = usize::from(index);
    let entry = entries.get(index / N).map(pack);
    Value::U16(entry.and_then(|words| words.get(index % N).copied()).unwrap_or(0))
}
