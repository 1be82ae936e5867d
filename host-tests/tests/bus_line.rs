//! How the board is reached: number, rate, parity, patience; and who it says it is.

use firmware::identity::SOURCE;
use fleet::board::IDENTITY;
use host_tests::bus::{BusBoard, frame, refused};
use wire::registers::{BusListens, Command, Exception, Id, UNIT};
use wire::{BusParameters, Parity};

/// Ticks until a board that hears nobody tries another line.
const PATIENCE: u32 = 10_000;
const STATE: [u8; 5] = [3, 2, 0, 0, 1];

/// Whether it answers by a number.
fn answers_by(board: &mut BusBoard, unit: u8) -> bool {
    board.be_silent();
    board.send(&frame(unit, &STATE)).first() == Some(&unit)
}

/// The parameters other than a new board's.
const OTHER: BusParameters =
    BusParameters { unit: 17, baud: 19_200, parity: Parity::Even, turnaround_us: 2_500 };

/// Keeps [`OTHER`] in a board, by one write.
fn keep_other(board: &mut BusBoard) {
    let words = [17, 1, 0, 19_200, 0, 2_500];
    assert_eq!(board.write(Id::BusNumber.register().address, &words), Ok(()));
    assert_eq!(board.parameters().bus, OTHER);
}

/// Lets ticks pass, with a look at the bus in each.
fn pass(board: &mut BusBoard, ticks: u32) {
    for _ in 0..ticks {
        board.tick();
        board.idle();
    }
}

#[test]
fn a_board_answers_by_its_old_number_until_it_is_told_to_take_the_new_one() {
    let mut board = BusBoard::new();
    keep_other(&mut board);
    assert_eq!(board.number(Id::BusListens), u32::from(BusListens::Former.number()));
    assert!(answers_by(&mut board, UNIT) && !answers_by(&mut board, 17));
    // The answer comes by the old number.
    assert_eq!(board.set(Id::BusTake, 1.0), Ok(()));
    pass(&mut board, 2);
    assert_eq!(board.line(), Some(OTHER));
    assert!(!answers_by(&mut board, UNIT));
    // The new patience: the answer is not there at once, but some ticks later.
    assert!(board.send(&frame(17, &STATE)).is_empty());
    let answers: Vec<_> = (0..5)
        .map(|_| {
            board.tick();
            board.idle().first().copied()
        })
        .collect();
    assert_eq!(answers, [None, None, Some(17), None, None]);
}

#[test]
fn who_speaks_again_before_the_answer_gets_the_second_answer_alone() {
    let mut board = BusBoard::new();
    assert_eq!(board.set(Id::BusTurnaround, 2_000.0), Ok(()));
    assert_eq!(board.set(Id::BusTake, 1.0), Ok(()));
    pass(&mut board, 2);
    board.be_silent();
    assert!(board.send(&frame(UNIT, &STATE)).is_empty());
    board.tick();
    assert!(board.send(&frame(UNIT, &[3, 2, 0, 0, 2])).is_empty());
    let sent: Vec<u8> = (0..5)
        .flat_map(|_| {
            board.tick();
            board.idle()
        })
        .collect();
    assert_eq!(sent.len(), 9, "{sent:02x?}");
}

#[test]
fn a_board_that_hears_nobody_tries_the_line_of_a_new_board_in_turns_until_it_hears_somebody() {
    let mut board = BusBoard::new();
    keep_other(&mut board);
    board.set(Id::BusTake, 1.0).expect("taken");
    pass(&mut board, 2);
    pass(&mut board, PATIENCE - 3);
    assert_eq!(board.line(), Some(OTHER));
    pass(&mut board, 3);
    let standard = BusParameters { unit: 17, ..BusParameters::STANDARD };
    assert_eq!(board.line(), Some(standard));
    pass(&mut board, PATIENCE);
    assert_eq!(board.line(), Some(OTHER));
    pass(&mut board, PATIENCE);
    assert_eq!(board.line(), Some(standard));
    // Noise does not settle it; a whole frame does, whoever it is for.
    board.send(&[0x55; 40]);
    pass(&mut board, PATIENCE);
    assert_eq!(board.line(), Some(OTHER));
    pass(&mut board, PATIENCE);
    board.be_silent();
    board.send(&frame(99, &STATE));
    pass(&mut board, 3 * PATIENCE);
    assert_eq!(board.line(), Some(standard));
    assert_eq!(board.parameters().bus, OTHER);
    // It can be reached by that, and told another rate.
    assert!(answers_by(&mut board, 17));
}

#[test]
fn a_board_whose_master_speaks_never_leaves_its_own_line() {
    let mut board = BusBoard::new();
    keep_other(&mut board);
    board.set(Id::BusTake, 1.0).expect("taken");
    pass(&mut board, 2);
    board.be_silent();
    board.send(&frame(3, &STATE));
    pass(&mut board, 4 * PATIENCE);
    assert_eq!(board.line(), Some(OTHER));
}

#[test]
fn nothing_of_the_line_changes_while_the_valve_is_driven() {
    let mut board = BusBoard::new();
    board.open(Command::Service);
    let before = board.parameters().bus;
    for (id, value) in [(Id::BusNumber, 5.0), (Id::BusRate, 9_600.0), (Id::BusTake, 1.0)] {
        assert_eq!(board.set(id, value), refused(Exception::DeviceBusy), "{id:?}");
    }
    assert_eq!(board.parameters().bus, before);
}

#[test]
fn no_broadcast_gives_all_boards_one_number_but_one_may_let_them_take_their_lines() {
    let mut board = BusBoard::new();
    let [high, low] = Id::BusNumber.register().address.to_be_bytes();
    board.send(&frame(0, &[16, high, low, 0, 1, 2, 0, 9]));
    assert_eq!(board.parameters().bus.unit, UNIT);
    keep_other(&mut board);
    let [high, low] = Id::BusTake.register().address.to_be_bytes();
    board.be_silent();
    assert!(board.send(&frame(0, &[16, high, low, 0, 1, 2, 0, 1])).is_empty());
    pass(&mut board, 2);
    assert_eq!(board.line(), Some(OTHER));
}

#[test]
fn numbers_and_rates_that_no_board_has_are_refused() {
    let mut board = BusBoard::new();
    for (id, value) in [
        (Id::BusNumber, 0.0),
        (Id::BusNumber, 248.0),
        (Id::BusParity, 3.0),
        (Id::BusRate, 9_599.0),
        (Id::BusRate, 1_000_001.0),
        (Id::BusTurnaround, 50_001.0),
    ] {
        assert_eq!(board.set(id, value), refused(Exception::IllegalValue), "{id:?} {value}");
    }
    assert_eq!(board.parameters().bus, BusParameters::STANDARD);
}

#[test]
fn a_board_says_which_processor_and_which_sources_it_has() {
    let mut board = BusBoard::new();
    let words = board.read(Id::UniqueId.register().address, 20).expect("readable");
    assert_eq!(words[..6], IDENTITY.unique_id);
    assert_eq!(words[6..9], [0x1007, 0x6413, IDENTITY.hardware_revision]);
    assert_eq!(words[9..19], SOURCE.commit);
    assert_eq!(words[19], u16::from(SOURCE.is_modified));
}

#[test]
fn the_identification_tells_all_objects_by_code_3_and_those_of_the_standard_by_code_2() {
    let mut board = BusBoard::new();
    let objects = |answer: &[u8]| {
        let (mut rest, mut objects) = (answer[7..].to_vec(), Vec::new());
        while let [id, length, text @ ..] = &*rest {
            let (text, others) = text.split_at(usize::from(*length));
            objects.push((*id, String::from_utf8(text.to_vec()).expect("text")));
            rest = others.to_vec();
        }
        objects
    };
    let all = objects(&board.ask(&[43, 14, 3, 0]));
    let of = |id: u8| all.iter().find(|(of, _)| *of == id).map(|(_, text)| text.as_str());
    assert_eq!(of(0x80), Some("003900453134510e32383732"));
    assert_eq!((of(0x81), of(0x82)), (Some("0003"), Some("10076413")));
    assert_eq!(of(0x83).map(|commit| commit.trim_end_matches('+').len()), Some(40));
    assert_eq!(objects(&board.ask(&[43, 14, 2, 0])).len(), 5);
    assert_eq!(objects(&board.ask(&[43, 14, 4, 0x80])), [(0x80, "003900453134510e32383732".to_owned())]);
}
