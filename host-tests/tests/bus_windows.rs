//! The windows of the bus: a configuration in blocks, a stream of set points, the recorded loop.

use board_models::{extended_parameters, paper_parameters, piecewise_parameters};
use host_tests::bus::{BusBoard, refused};
use wire::registers::{
    CAPTURE_HEAD, CAPTURE_SAMPLES, Command, Exception, Id, QUEUE_POINTS, SAMPLE_REGISTERS, STREAM_POINTS,
    StreamOrder, StreamState, UPLOAD_BYTES, UPLOAD_REGISTERS, UploadOrder, UploadResult, Value, bytes_of,
    checksum, pack_bytes, unpack_sample,
};
use wire::{CaptureSample, Configuration, State, VERSION};

type Tracking = model_core::TrackingParameters<f32, { wire::PLAYS }, { wire::DEAD_ZONES }>;

fn encoded(version: u16, tracking: &Tracking) -> Vec<u8> {
    let mut buffer = [0; UPLOAD_BYTES];
    let configuration = Configuration { version, tracking: tracking.clone() };
    postcard::to_slice(&configuration, &mut buffer).expect("fits").to_vec()
}

/// Offset and words of each block.
fn blocks(bytes: &[u8]) -> Vec<(u16, Vec<u16>)> {
    let size = 2 * usize::from(UPLOAD_REGISTERS);
    bytes
        .chunks(size)
        .enumerate()
        .map(|(k, block)| ((k * size) as u16, pack_bytes(block).collect()))
        .collect()
}

fn write_block(board: &mut BusBoard, (offset, words): &(u16, Vec<u16>)) -> Result<(), u8> {
    board.write(Id::UploadOffset.register().address, &[&[*offset], &words[..]].concat())
}

fn commit(board: &mut BusBoard, bytes: &[u8]) -> Result<(), u8> {
    board.set(Id::UploadLength, bytes.len() as f64)?;
    board.set(Id::UploadChecksum, checksum(bytes).into())?;
    board.set(Id::UploadOrder, UploadOrder::Commit.number().into())
}

fn upload(board: &mut BusBoard, bytes: &[u8]) -> Result<(), u8> {
    blocks(bytes).iter().try_for_each(|block| write_block(board, block))?;
    commit(board, bytes)
}

fn fetch(board: &mut BusBoard) -> Vec<u8> {
    board.set(Id::UploadOrder, UploadOrder::Fetch.number().into()).expect("there is one");
    let length = board.number(Id::UploadLength) as usize;
    let mut bytes = Vec::new();
    while bytes.len() < length {
        board.set(Id::UploadOffset, bytes.len() as f64).expect("within the buffer");
        let words = board.read(Id::UploadWindow.register().address, UPLOAD_REGISTERS).expect("readable");
        bytes.extend(bytes_of(&words));
    }
    bytes.truncate(length);
    assert_eq!(board.number(Id::UploadChecksum), checksum(&bytes));
    bytes
}

#[test]
fn an_upload_that_breaks_off_at_any_block_leaves_the_old_model_running_and_a_repeat_succeeds() {
    for new in [piecewise_parameters(), extended_parameters()].map(|new| new.expect("valid")) {
        let bytes = encoded(VERSION, &new);
        let blocks = blocks(&bytes);
        let mut board = BusBoard::configured();
        let old = board.parameters().clone();
        for broken_off in 0..=blocks.len() {
            board.open(Command::Start);
            for block in &blocks[..broken_off] {
                write_block(&mut board, block).expect("taken");
                board.tick();
            }
            // The host has gone; another one finds the old model at work.
            assert_eq!(board.number(Id::State), 3);
            assert_eq!(*board.parameters(), old);
            board.set(Id::Command, Command::Stop.number().into()).expect("taken");
            if broken_off < blocks.len() {
                assert_eq!(
                    commit(&mut board, &bytes),
                    refused(Exception::IllegalValue),
                    "{broken_off} blocks"
                );
                assert_eq!(board.number(Id::UploadResult), u32::from(UploadResult::Checksum.number()));
                assert_eq!((board.number(Id::State), board.parameters()), (2, &old));
            }
            // What the next broken-off one starts from holds nothing of this one.
            for block in &blocks {
                write_block(&mut board, &(block.0, vec![0; block.1.len()])).expect("taken");
            }
        }
        assert_eq!(upload(&mut board, &bytes), Ok(()));
        assert_eq!(board.number(Id::UploadResult), u32::from(UploadResult::Installed.number()));
        assert_eq!(board.parameters().tracking.as_ref(), Some(&new));
        assert_eq!(fetch(&mut board), bytes);
    }
}

#[test]
fn a_commit_of_what_is_no_configuration_says_why_and_changes_nothing() {
    let good = paper_parameters().expect("valid");
    let mut too_high = good.clone();
    too_high.command_max = 9.0;
    let mut backwards = good.clone();
    backwards.period_s = -1.0;
    let long = [encoded(VERSION, &good), vec![0]].concat();
    for (bytes, result, words) in [
        (encoded(VERSION + 1, &good), UploadResult::Version, ""),
        (vec![VERSION as u8, 0xFF, 0xFF], UploadResult::Unreadable, ""),
        (long, UploadResult::Unreadable, ""),
        (encoded(VERSION, &too_high), UploadResult::Parameter, "command_max_bar is 9, must be 0 to 8"),
        (encoded(VERSION, &backwards), UploadResult::Parameter, "period_s"),
    ] {
        let mut board = BusBoard::configured();
        let old = board.parameters().clone();
        assert_eq!(upload(&mut board, &bytes), refused(Exception::IllegalValue), "{result:?}");
        assert_eq!(board.number(Id::UploadResult), u32::from(result.number()));
        let message = board.read(Id::Message.register().address, 50).expect("readable");
        let message =
            String::from_utf8(bytes_of(&message).take_while(|&byte| byte != 0).collect()).expect("text");
        assert!(message.contains(words) && message.is_empty() == words.is_empty(), "{result:?}: {message}");
        assert_eq!(*board.parameters(), old);
    }
}

#[test]
fn a_commit_while_tracking_is_busy() {
    let mut board = BusBoard::configured();
    let (old, bytes) = (board.parameters().clone(), encoded(VERSION, &extended_parameters().expect("valid")));
    board.open(Command::Start);
    assert_eq!(upload(&mut board, &bytes), refused(Exception::DeviceBusy));
    assert_eq!(board.number(Id::UploadResult), u32::from(UploadResult::WrongState.number()));
    assert_eq!((board.number(Id::State), board.parameters()), (3, &old));
}

#[test]
fn a_block_beyond_the_buffer_is_refused_and_one_up_to_its_end_is_not() {
    let mut board = BusBoard::configured();
    let words = vec![0xABCD; UPLOAD_REGISTERS.into()];
    let last = UPLOAD_BYTES as u16 - 2 * UPLOAD_REGISTERS;
    assert_eq!(write_block(&mut board, &(last, words.clone())), Ok(()));
    assert_eq!(write_block(&mut board, &(last + 1, words)), refused(Exception::IllegalValue));
    assert_eq!(board.number(Id::UploadOffset), u32::from(last));
}

/// Words of a push.
fn push(board: &mut BusBoard, number: u32, points: &[f32]) -> Result<(), u8> {
    let points = points.iter().flat_map(|&point| Value::F32(point).words());
    let words: Vec<u16> = Value::U32(number).words().chain(points).collect();
    board.write(Id::PushNumber.register().address, &words)
}

fn stream_order(board: &mut BusBoard, order: StreamOrder) -> Result<(), u8> {
    board.set(Id::StreamOrder, order.number().into())
}

/// A board that tracks and has an interval of so many ticks.
fn streaming(interval: u16) -> BusBoard {
    let mut board = BusBoard::configured();
    board.open(Command::Start);
    board.set(Id::StreamInterval, interval.into()).expect("idle");
    board
}

/// The references of the next ticks.
fn references(board: &mut BusBoard, ticks: usize) -> Vec<f32> {
    let reference = |board: &mut BusBoard| {
        // What the next tick will have.
        let reference = board.get(Id::ReferenceMm).number() as f32;
        board.tick();
        reference
    };
    (0..ticks).map(|_| reference(board)).collect()
}

#[test]
fn a_stream_is_the_straight_lines_between_its_points_from_the_tick_that_it_says() {
    for interval in [1_u16, 2, 7, 100] {
        let mut board = streaming(interval);
        let points = [4.0_f32, 10.0, 3.0, 3.0, 50.0];
        push(&mut board, 0, &points).expect("room");
        stream_order(&mut board, StreamOrder::Play).expect("points");
        board.tick();
        let first = board.number(Id::Ticks) + 1;
        let width = usize::from(interval);
        let played = references(&mut board, 4 * width + 1);
        assert_eq!(board.number(Id::StreamStart), first);
        for (k, played) in played.into_iter().enumerate() {
            let (at, share) = (k / width, (k % width) as f32 / f32::from(interval));
            let next = points.get(at + 1).unwrap_or(&points[at]);
            let expected = points[at] + share * (next - points[at]);
            assert!(
                (played - expected).abs() < 1e-5,
                "interval {interval}, tick {k}: {played}, not {expected}"
            );
        }
    }
}

#[test]
fn a_stream_begins_in_the_ticks_that_it_is_told_and_counts_anew_when_told_again() {
    let play_in = |board: &mut BusBoard, ticks: u16| board.set(Id::StreamPlayIn, ticks.into());
    for interval in [1_u16, 10] {
        let mut board = streaming(interval);
        board.set(Id::SetpointMm, 7.0).expect("it tracks");
        board.tick();
        assert_eq!(play_in(&mut board, 5), refused(Exception::DeviceBusy), "there is nothing to play");
        push(&mut board, 0, &[20.0, 30.0]).expect("room");
        assert_eq!(play_in(&mut board, 0), refused(Exception::IllegalValue));
        play_in(&mut board, 300).expect("points");
        (0..100).for_each(|_| _ = board.tick());
        assert_eq!(board.number(Id::StreamPlayIn), 200);
        assert_eq!(board.set(Id::SetpointMm, 5.0), refused(Exception::DeviceBusy), "they are the stream's");
        play_in(&mut board, 50).expect("it waits");
        // The next tick has its set point already; point 0 is that of the 50th behind it.
        board.tick();
        let first = board.number(Id::Ticks) + 50;
        assert_eq!(references(&mut board, 49), [7.0; 49]);
        assert_eq!((board.get(Id::ReferenceMm).number(), board.number(Id::StreamPlayIn)), (20.0, 0));
        assert_eq!(board.number(Id::StreamStart), first);
        assert_eq!(play_in(&mut board, 5), refused(Exception::DeviceBusy), "it plays");
        (0..interval).for_each(|_| _ = board.tick());
        assert_eq!(board.get(Id::ReferenceMm).number(), 30.0);
    }
}

#[test]
fn out_of_points_the_last_is_held_and_counted_and_the_next_is_gone_to_unless_the_end_was_announced() {
    let mut board = streaming(4);
    push(&mut board, 0, &[1.0, 2.0]).expect("room");
    stream_order(&mut board, StreamOrder::Play).expect("points");
    (0..5).for_each(|_| _ = board.tick());
    assert_eq!(references(&mut board, 4), [2.0; 4]);
    assert_eq!(board.number(Id::StreamState), u32::from(StreamState::Underrun.number()));
    assert_eq!(board.number(Id::StreamUnderrun), 4);
    push(&mut board, 2, &[6.0]).expect("room");
    board.tick();
    assert_eq!(references(&mut board, 5), [2.0, 3.0, 4.0, 5.0, 6.0]);
    stream_order(&mut board, StreamOrder::End).expect("it plays");
    board.tick();
    assert_eq!(board.number(Id::StreamState), u32::from(StreamState::Done.number()));
    let counted = board.number(Id::StreamUnderrun);
    (0..10).for_each(|_| _ = board.tick());
    assert_eq!(board.number(Id::StreamUnderrun), counted);
    assert_eq!(board.get(Id::ReferenceMm).number(), 6.0);
}

#[test]
fn a_push_that_is_repeated_changes_nothing_and_a_gap_or_an_overflow_is_refused_as_a_whole() {
    let mut board = streaming(1);
    let points: Vec<f32> = (0..STREAM_POINTS).map(f32::from).collect();
    for _ in 0..3 {
        push(&mut board, 0, &points).expect("room");
        assert_eq!(board.number(Id::StreamPushed), u32::from(STREAM_POINTS));
    }
    assert_eq!(push(&mut board, u32::from(STREAM_POINTS) + 1, &[1.0]), refused(Exception::IllegalValue));
    // The end of the last push, and what follows it.
    push(&mut board, u32::from(STREAM_POINTS) - 1, &[59.0, 60.0]).expect("room");
    let mut next = u32::from(STREAM_POINTS) + 1;
    while board.number(Id::StreamFree) >= STREAM_POINTS.into() {
        push(&mut board, next, &points).expect("room");
        next += u32::from(STREAM_POINTS);
    }
    assert_eq!(push(&mut board, next, &points), refused(Exception::DeviceBusy));
    assert_eq!(board.number(Id::StreamPushed), next);
    assert_eq!(board.number(Id::StreamFree), u32::from(QUEUE_POINTS) - next);
    // Points without a number.
    let address = Id::PushPoints.register().address;
    assert_eq!(board.write(address, &[0, 0]), refused(Exception::IllegalValue));
}

#[test]
fn the_set_points_are_the_streams_while_it_plays_and_a_stop_clears_it() {
    let mut board = streaming(1000);
    push(&mut board, 0, &[1.0, 2.0]).expect("room");
    stream_order(&mut board, StreamOrder::Play).expect("points");
    assert_eq!(board.set(Id::SetpointMm, 5.0), refused(Exception::DeviceBusy));
    assert_eq!(board.set(Id::StreamInterval, 5.0), refused(Exception::DeviceBusy));
    assert_eq!(stream_order(&mut board, StreamOrder::Play), refused(Exception::DeviceBusy));
    board.set(Id::Command, Command::Stop.number().into()).expect("a stop is always taken");
    assert_eq!(board.number(Id::StreamState), u32::from(StreamState::Idle.number()));
    assert_eq!(board.number(Id::StreamPushed), 0);
    assert_eq!(push(&mut board, 0, &[1.0]), refused(Exception::DeviceBusy));
}

#[test]
fn in_the_service_state_the_stream_is_the_command_within_what_is_compiled_in() {
    let mut board = BusBoard::configured();
    board.open(Command::Service);
    board.set(Id::StreamInterval, 50.0).expect("idle");
    assert_eq!(push(&mut board, 0, &[0.0, 8.1]), refused(Exception::IllegalValue));
    push(&mut board, 0, &[0.0, 3.0, 3.0]).expect("room");
    stream_order(&mut board, StreamOrder::Play).expect("points");
    (0..130).for_each(|_| _ = board.tick());
    assert!((board.get(Id::CommandBar).number() - 3.0).abs() < 0.01);
    assert_eq!(board.control().state(), State::Service);
    // What was driven stays until a new stream begins.
    stream_order(&mut board, StreamOrder::Clear).expect("always");
    push(&mut board, 0, &[1.0]).expect("room");
    board.set(Id::StreamPlayIn, 30.0).expect("points");
    (0..20).for_each(|_| _ = board.tick());
    assert!((board.get(Id::CommandBar).number() - 3.0).abs() < 0.01);
    (0..30).for_each(|_| _ = board.tick());
    assert!((board.get(Id::CommandBar).number() - 1.0).abs() < 0.01);
}

/// The window, from the sample of this number on: number of the first, its tick, the samples.
fn window(board: &mut BusBoard, from: u32) -> (u32, u32, Vec<CaptureSample>) {
    board.set(Id::CaptureFrom, from.into()).expect("any number");
    let address = Id::CaptureFirst.register().address;
    let words = board.read(address, CAPTURE_HEAD + CAPTURE_SAMPLES * SAMPLE_REGISTERS).expect("readable");
    let (head, samples) = words.split_at(CAPTURE_HEAD.into());
    let pair = |words: &[u16]| u32::from(words[0]) << 16 | u32::from(words[1]);
    let (chunks, _) = samples.as_chunks();
    (
        pair(head),
        pair(&head[2..]),
        chunks[..head[4].into()].iter().map(|words| unpack_sample(*words)).collect(),
    )
}

#[test]
fn whoever_reads_on_follows_the_recording_without_loss_and_with_every_tick() {
    for every in [1_u16, 3] {
        let mut board = streaming(1);
        // The reference tells the ticks apart: 1/8 mm each.
        let points: Vec<f32> = (0..STREAM_POINTS).map(|k| 0.125 * f32::from(k)).collect();
        push(&mut board, 0, &points).expect("room");
        stream_order(&mut board, StreamOrder::Play).expect("points");
        board.set(Id::CaptureEvery, every.into()).expect("any time");
        board.tick();
        let mut read: Vec<(u32, CaptureSample)> = Vec::new();
        let first_tick = board.number(Id::Ticks);
        for _ in 0..12 {
            (0..10).for_each(|_| _ = board.tick());
            let (first, tick, samples) = window(&mut board, read.len() as u32);
            assert_eq!(first as usize, read.len());
            let ticks = (tick..).step_by(every.into());
            read.extend(ticks.zip(samples));
        }
        assert!(read.len() >= 120 / usize::from(every) - 24, "{}", read.len());
        for (k, (tick, sample)) in read.into_iter().enumerate() {
            assert_eq!(tick, first_tick + k as u32 * u32::from(every));
            let played = (tick - first_tick).saturating_sub(1).min(u32::from(STREAM_POINTS) - 1);
            assert_eq!(sample.reference_mm, 0.125 * played as f32, "tick {tick}");
        }
    }
}

#[test]
fn samples_that_were_lost_show_in_the_number_of_the_first() {
    let mut board = BusBoard::configured();
    board.set(Id::CaptureEvery, 1.0).expect("any time");
    (0..1500).for_each(|_| _ = board.tick());
    let (first, _, samples) = window(&mut board, 100);
    assert_eq!((first, samples.len()), (500, CAPTURE_SAMPLES.into()));
    assert_eq!((board.number(Id::CaptureKept), board.number(Id::CaptureTaken)), (1000, 1500));
    let (first, _, samples) = window(&mut board, 1490);
    assert_eq!((first, samples.len()), (1490, 10));
    assert_eq!(window(&mut board, 5000).2, []);
    board.set(Id::CaptureEvery, 0.0).expect("any time");
    board.tick();
    assert_eq!(board.number(Id::CaptureTaken), 1500);
}
