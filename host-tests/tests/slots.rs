//! The exchange in slots: when each member answers, what it takes and what not, and what disturbs
//! nobody.

use fleet::board::Board;
use host_tests::bus::{BusBoard, frame};
use wire::registers::{Command, Id, UNIT};
use wire::slots::{ANSWER_BYTES, Answer, FUNCTION, LEAST_GAP_US, MOST_MEMBERS, Member, Outcome, Said};
use wire::slots::{Slots, request};
use wire::{BusParameters, Fault, Protection, State};

/// How long the host may be silent here. Unit: tick.
const PATIENCE: u32 = 50;
/// More than all slots of a frame take. Unit: tick.
const LONG: u32 = 200;

fn asked(unit: u8) -> Member {
    Member { unit, said: Said::Nothing, until: 0 }
}

fn framed(sequence: u16, members: &[Member]) -> Vec<u8> {
    request(sequence, LEAST_GAP_US, members).expect("fits").to_vec()
}

/// Ticks of a board in which nothing is asked: in which of them it sends what.
fn sent(board: &mut Board, ticks: u32) -> Vec<(u32, Vec<u8>)> {
    let tick = |tick| {
        board.tick_at(410, 205);
        (tick, board.idle())
    };
    (1..=ticks).map(tick).filter(|(_, sent)| !sent.is_empty()).collect()
}

/// What a board answers to a frame, in its slot.
fn answered(board: &mut Board, frame: &[u8]) -> Answer {
    assert!(board.send(frame).is_empty(), "at once");
    let sent = sent(board, LONG);
    let [(_, answer)] = &*sent else { panic!("{sent:02x?}") };
    Answer::of_frame(answer).expect("an answer")
}

/// The tick in which a slot begins on a new board's line.
fn slot_tick(place: usize) -> u32 {
    Slots::new(&BusParameters::STANDARD, LEAST_GAP_US).begin_us(place).div_ceil(1_000)
}

/// A board that tracks, with a host that has to show that it lives; its last heartbeat was 100.
fn tracking() -> BusBoard {
    let mut board = BusBoard::configured();
    board.set(Id::BusSilent, PATIENCE.into()).expect("vented");
    board.set(Id::Heartbeat, 100.0).expect("taken");
    board.open(Command::Start);
    board
}

fn said(board: &mut BusBoard, sequence: u16, said: Said, ahead: i32) -> Outcome {
    let until = board.control().ticks().wrapping_add_signed(ahead);
    let frame = framed(sequence, &[Member { unit: UNIT, said, until }]);
    assert!(board.send(&frame).is_empty());
    let sent = sent(board, 2);
    Answer::of_frame(&sent.first().expect("in the first slot").1).expect("an answer").outcome
}

#[test]
fn each_member_answers_once_in_the_tick_of_its_slot_whoever_is_missing_and_whoever_speaks() {
    let members: Vec<Member> = (1..=8).map(asked).collect();
    let frame = framed(1, &members);
    // Nobody has the numbers 2, 5 and 7.
    for (place, unit) in [(0, 1), (2, 3), (3, 4), (5, 6), (7, 8)] {
        let mut board = Board::of_number(unit, Protection::SIMULATED);
        sent(&mut board, 3);
        assert!(board.send(&frame).is_empty(), "at once");
        let mut answers = Vec::new();
        for tick in 1..=LONG {
            // The others answer in their slots.
            if tick < slot_tick(place) && (1..place).any(|other| slot_tick(other) == tick) {
                let answer =
                    Answer { unit: 99, ..answered(&mut Board::of_number(1, Protection::SIMULATED), &frame) };
                assert!(board.send(&answer.frame().expect("fits")).is_empty());
            }
            answers.extend(sent(&mut board, 1).into_iter().map(|(_, answer)| (tick, answer)));
        }
        let [(tick, answer)] = &*answers else { panic!("board {unit}: {answers:02x?}") };
        assert_eq!(*tick, slot_tick(place), "board {unit}");
        assert_eq!((answer.len(), Answer::of_frame(answer).expect("whole").unit), (ANSWER_BYTES, unit));
    }
}

#[test]
fn the_answer_tells_what_the_registers_tell() {
    let mut board = tracking();
    assert_eq!(said(&mut board, 101, Said::SetPoint(2.5), 20), Outcome::Taken);
    let ticks = board.control().ticks();
    let answer = answered(&mut board, &framed(102, &[asked(9), asked(UNIT)]));
    assert_eq!((answer.unit, answer.state, answer.fault, answer.ticks), (UNIT, State::Tracking, 0, ticks));
    assert_eq!(answer.sequence, 102);
    let read = |board: &mut BusBoard, id| board.get(id).number() as f32;
    // It rests at codes that stay; reference and command move.
    assert!((answer.pressure_bar - read(&mut board, Id::PressureBar)).abs() < 1e-6);
    assert!((answer.contraction_mm - read(&mut board, Id::ContractionMm)).abs() < 1e-6);
    assert!((answer.supply_bar - read(&mut board, Id::SupplyBar)).abs() < 1e-3);
    assert!((answer.temperature_c - read(&mut board, Id::TemperatureC)).abs() < 1e-2);
    assert!((answer.reference_mm - 2.5).abs() < 1e-6, "{answer:?}");
}

#[test]
fn a_set_point_that_is_late_too_far_ahead_or_repeated_is_not_taken_and_is_no_sign_of_life() {
    for (sequence, ahead, outcome) in [
        (101, -1, Outcome::Late),
        (101, -60_000, Outcome::Late),
        (101, 1_001, Outcome::Ahead),
        (100, 20, Outcome::Repeated),
        (99, 20, Outcome::Repeated),
    ] {
        let mut board = tracking();
        let before = board.control().ticks();
        while board.control().state() == State::Tracking {
            assert_eq!(said(&mut board, sequence, Said::SetPoint(5.0), ahead), outcome);
            assert!(board.control().ticks() - before < 2 * PATIENCE, "{outcome:?} keeps it alive");
        }
        assert_eq!(board.number(Id::Fault), u32::from(Fault::BusSilent.code()), "{outcome:?}");
        assert!(board.get(Id::SetpointMm).number().abs() < 1e-6, "{outcome:?} was taken");
        assert_eq!(board.number(Id::Heartbeat), 100, "{outcome:?}");
        assert!(board.number(Id::BusRefused) > 0, "{outcome:?}");
    }
}

#[test]
fn the_same_frame_again_is_told_as_repeated_and_the_board_vents_in_its_time() {
    let mut board = tracking();
    let until = board.control().ticks() + 900;
    let frame = framed(101, &[Member { unit: UNIT, said: Said::SetPoint(3.0), until }]);
    let begin = board.control().ticks();
    let mut outcomes = Vec::new();
    while board.control().state() == State::Tracking && board.control().ticks() - begin < 3 * PATIENCE {
        board.send(&frame);
        outcomes.extend(sent(&mut board, 2).into_iter().filter_map(|(_, sent)| Answer::of_frame(&sent)));
    }
    assert_eq!(outcomes[0].outcome, Outcome::Taken);
    assert!(outcomes[1..].iter().all(|answer| answer.outcome == Outcome::Repeated));
    let took = board.control().ticks() - begin;
    assert!((PATIENCE..PATIENCE + 5).contains(&took), "{took} ticks");
}

#[test]
fn fresh_frames_drive_and_keep_alive_with_and_without_a_set_point() {
    let mut board = tracking();
    for round in 0..u16::try_from(2 * PATIENCE).expect("few") {
        let what = if round % 2 == 0 { Said::SetPoint(f32::from(round % 8)) } else { Said::Lives };
        assert_eq!(said(&mut board, 101 + round, what, 3), Outcome::Taken, "round {round}");
    }
    assert_eq!(board.control().state(), State::Tracking);
    assert!((board.get(Id::SetpointMm).number() - 2.0).abs() < 1e-6);
    // What is only asked gives no sign of life.
    for sequence in 300..300 + PATIENCE {
        assert_eq!(said(&mut board, sequence as u16, Said::Nothing, 3), Outcome::Asked);
    }
    assert_eq!(board.number(Id::Fault), u32::from(Fault::BusSilent.code()));
}

#[test]
fn a_set_point_beyond_the_limits_or_not_finite_is_refused_as_a_whole() {
    let mut board = tracking();
    for mm in [-20.1, 200.1, f32::NAN, f32::INFINITY] {
        assert_eq!(said(&mut board, 101, Said::SetPoint(mm), 20), Outcome::Refused, "{mm}");
        assert_eq!(board.number(Id::Heartbeat), 100, "its sign of life was taken");
    }
}

#[test]
fn two_boards_of_one_number_speak_at_once_and_not_in_anybody_elses_slot() {
    let frame = framed(1, &[asked(1), asked(2), asked(3)]);
    let ticks = [0, 1].map(|_| {
        let mut board = Board::of_number(2, Protection::SIMULATED);
        board.send(&frame);
        sent(&mut board, LONG).into_iter().map(|(tick, _)| tick).collect::<Vec<_>>()
    });
    assert_eq!(ticks, [vec![slot_tick(1)], vec![slot_tick(1)]]);
}

#[test]
fn a_board_that_is_no_member_or_needs_more_than_the_gap_is_silent_and_has_taken_nothing() {
    let mut board = tracking();
    let until = board.control().ticks() + 900;
    let counted = board.number(Id::BusFrames);
    let point = |unit| Member { unit, said: Said::SetPoint(4.0), until };
    board.send(&framed(101, &[point(2), point(3)]));
    board.send(&request(101, LEAST_GAP_US - 1, &[point(UNIT)]).expect("fits"));
    // One for its own number is no request of this function.
    board.send(&frame(UNIT, &framed(101, &[point(UNIT)])[1..][..15]));
    assert!(sent(&mut board, 10).is_empty());
    assert_eq!(board.number(Id::BusFrames), counted + 1, "this reading alone");
    assert!(board.get(Id::SetpointMm).number().abs() < 1e-6);
    let mut slow = BusBoard::new();
    slow.set(Id::BusTurnaround, f64::from(LEAST_GAP_US) + 1.0).expect("taken");
    slow.set(Id::BusTake, 1.0).expect("taken");
    sent(&mut slow, 4);
    slow.idle();
    slow.send(&framed(1, &[asked(UNIT)]));
    assert!(sent(&mut slow, LONG).is_empty());
    slow.send(&request(1, LEAST_GAP_US + 1, &[asked(UNIT)]).expect("fits"));
    assert_eq!(sent(&mut slow, LONG).len(), 1);
}

#[test]
fn frames_of_a_wrong_length_or_with_more_members_than_fit_are_met_with_silence_and_the_next_is_heard() {
    let whole = framed(1, &[asked(9), asked(UNIT)]);
    let content = &whole[1..whole.len() - 2];
    let more: Vec<u8> = [content, &[7; 10]].concat();
    let less = &content[..content.len() - 1];
    let mut crowded = vec![FUNCTION, MOST_MEMBERS as u8 + 1, 0, 1, 1, 244];
    (0..=MOST_MEMBERS).for_each(|_| crowded.extend([UNIT, 0, 0, 0, 0, 0, 0, 0, 0, 0]));
    let mut none = content.to_vec();
    none[1] = 0;
    for wrong in [&more[..], less, &crowded, &none, &content[..5], &[FUNCTION]] {
        let mut board = BusBoard::new();
        board.be_silent();
        assert!(board.send(&frame(0, wrong)).is_empty());
        assert!(sent(&mut board, LONG).is_empty(), "{wrong:02x?}");
        assert_eq!(answered(&mut board, &whole).outcome, Outcome::Asked, "{wrong:02x?}");
    }
}

#[test]
fn a_damaged_frame_is_no_request() {
    let whole = framed(1, &[asked(UNIT)]);
    for place in 0..whole.len() {
        let mut board = BusBoard::new();
        let mut damaged = whole.clone();
        damaged[place] ^= 0x04;
        board.be_silent();
        board.send(&damaged);
        assert!(sent(&mut board, LONG).is_empty(), "byte {place}");
    }
}

#[test]
fn a_plain_request_before_the_slot_is_answered_in_its_place_and_a_stop_of_all_vents() {
    let mut board = tracking();
    board.send(&framed(1, &[asked(8), asked(9), asked(UNIT)]));
    assert!(sent(&mut board, 1).is_empty());
    assert_eq!(board.number(Id::State), 3);
    assert!(sent(&mut board, LONG / 10).is_empty(), "the slot's answer is forgotten");
    board.send(&framed(1, &[asked(8), asked(9), asked(UNIT)]));
    board.send(&frame(0, &[6, 1, 0, 0, 2]));
    assert!(sent(&mut board, LONG / 10).is_empty());
    assert_eq!(board.control().state(), State::Ready);
}
