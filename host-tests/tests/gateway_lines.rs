//! What may be wrong on a line of a gateway: each is named with its board, and a sound line beside
//! it is not disturbed.
#![cfg(unix)]

use std::sync::{Mutex, PoisonError};
use std::thread::sleep;
use std::time::{Duration, Instant};

use fleet::line::Way;
use gateway::Gateway;
use gateway::boards::{Board, News};
use gateway::lines;
use gateway::seen::Problem;
use host_tests::desk::Desk;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// How long anything may take to be seen, on a machine with much else to do.
const PATIENCE: Duration = Duration::from_secs(20);
/// How long the sound line is watched while the other one is wrong.
const WATCHED: Duration = Duration::from_secs(2);
/// From answer to answer of a sound board: a driven board bears so long a silence, and vents then.
const LONGEST_GAP: Duration = Duration::from_millis(500);

/// One line with its neighbour at a time: boards keep real time.
static ALONE: Mutex<()> = Mutex::new(());

fn undisturbed(_: Way, bytes: Vec<u8>) -> Vec<u8> {
    bytes
}

/// A gateway with a sound line of two boards, and one that is as it is: what is seen of the boards
/// of that, as soon as `is_so`.
fn beside_a_sound_line(bad: &Desk, units: &[u8], is_so: impl Fn(&[Board]) -> bool) -> Vec<Board> {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let sound = Desk::line(1.0, &[1, 2], undisturbed);
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("lines.toml");
    let text = format!(
        "[[line]]\nname = \"sound\"\nport = {:?}\nboards = [1, 2]\n\
         [[line]]\nname = \"bad\"\nport = {:?}\nboards = {units:?}\n",
        sound.port(),
        bad.port()
    );
    std::fs::write(&file, text).expect("written");
    let gateway = Gateway::start(lines::read(&file).expect("two lines"));
    let deadline = Instant::now() + PATIENCE;
    let seen = loop {
        let boards = gateway.boards().all();
        if is_so(&boards[2..]) && boards[..2].iter().all(|board| board.telemetry.is_some()) {
            break boards[2..].to_vec();
        }
        assert!(Instant::now() < deadline, "{boards:#?}");
        sleep(Duration::from_millis(20));
    };
    let (listener, begin) = (gateway.boards().listen(), Instant::now());
    let mut last = [begin; 2];
    while begin.elapsed() < WATCHED {
        if let Some(News::Telemetry(index @ 0..=1, _)) = listener.next(Duration::from_millis(10)) {
            assert!(last[index].elapsed() < LONGEST_GAP, "{:?}", last[index].elapsed());
            last[index] = Instant::now();
        }
    }
    assert!(last.iter().all(|last| last.elapsed() < LONGEST_GAP));
    let boards = gateway.boards().all();
    assert!(boards[..2].iter().all(|board| board.problem.is_none()));
    seen
}

fn has_problems(boards: &[Board]) -> bool {
    boards.iter().all(|board| board.problem.is_some())
}

fn said(board: &Board) -> String {
    board.problem.as_ref().map(Problem::in_words).unwrap_or_default()
}

#[test]
fn two_boards_of_one_number_are_named_and_the_third_is_seen() {
    let bad = Desk::line(1.0, &[7, 7, 8], undisturbed);
    let boards = beside_a_sound_line(&bad, &[7, 8], |boards| {
        boards[0].problem.is_some() && boards[1].telemetry.is_some()
    });
    assert_eq!((&*boards[0].line, boards[0].number), ("bad", 7));
    assert_eq!(boards[0].problem, Some(Problem::Several));
    assert!(said(&boards[0]).contains("more than one board answers by this number"));
    assert_eq!(boards[1].problem, None);
}

#[test]
fn a_board_with_other_registers_is_named_with_both_versions() {
    let crc = crc::Crc::<u16>::new(&crc::CRC_16_MODBUS);
    // The answer to the question for the version, of a board that has version 2.
    let bad = Desk::line(1.0, &[7], move |way, bytes| match (way, &bytes[..]) {
        (Way::FromBoard, [unit, 3, 2, 0, 1, _, _]) => {
            let answer = [*unit, 3, 2, 0, 2];
            [&answer[..], &crc.checksum(&answer).to_le_bytes()].concat()
        }
        _ => bytes,
    });
    let boards = beside_a_sound_line(&bad, &[7], has_problems);
    assert_eq!(boards[0].problem, Some(Problem::OtherVersion(2)));
    assert!(said(&boards[0]).contains("version 2, this program speaks version 1"), "{}", said(&boards[0]));
}

#[test]
fn a_line_at_another_rate_is_asked_about() {
    // Bytes at another rate are other bytes.
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let bad = Desk::line(1.0, &[7], move |way, bytes| match way {
        Way::ToBoard => bytes,
        Way::FromBoard => bytes.iter().map(|_| random.random()).collect(),
    });
    let boards = beside_a_sound_line(&bad, &[7], has_problems);
    assert!(said(&boards[0]).contains("is the rate 115200 bit/s"), "{}", said(&boards[0]));
}

#[test]
fn a_line_with_noise_loses_questions_and_keeps_its_boards() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    // One frame in ten is damaged.
    let bad = Desk::line(1.0, &[7, 8], move |_, mut bytes| {
        if let Some(byte) = bytes.first_mut().filter(|_| random.random_range(0..10) == 0) {
            *byte ^= 0x55;
        }
        bytes
    });
    let boards = beside_a_sound_line(&bad, &[7, 8], |boards| {
        boards.iter().all(|board| board.answered > 100 && board.lost > 5)
    });
    assert!(boards.iter().all(|board| board.lost < board.answered), "{boards:#?}");
}

#[test]
fn a_board_that_babbles_is_told_on_its_line_alone() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    // Whatever is asked, much is sent that nobody has asked for.
    let bad = Desk::line(1.0, &[7], move |way, bytes| match way {
        Way::ToBoard => bytes,
        Way::FromBoard => (0..2_000).map(|_| random.random()).collect(),
    });
    let boards = beside_a_sound_line(&bad, &[7], has_problems);
    assert!(said(&boards[0]).contains("damaged answers only"), "{}", said(&boards[0]));
}

#[test]
fn boards_that_know_slots_answer_in_them_and_one_of_an_older_firmware_is_asked_by_itself() {
    // Its firmware has no function 65: it does not hear such a frame.
    let old = Desk::line(1.0, &[7], |way, bytes| match (way, &bytes[..]) {
        (Way::ToBoard, [0, 65, ..]) => Vec::new(),
        _ => bytes,
    });
    let new = Desk::line(1.0, &[7, 8], undisturbed);
    let is_seen = |boards: &[Board]| boards.iter().all(|board| board.answered > 50);
    let boards = beside_a_sound_line(&old, &[7], is_seen);
    assert!(!boards[0].in_slots && boards[0].problem.is_none(), "{boards:#?}");
    let boards =
        beside_a_sound_line(&new, &[7, 8, 9], |boards| is_seen(&boards[..2]) && has_problems(&boards[2..]));
    assert!(boards[..2].iter().all(|board| board.in_slots && board.problem.is_none()), "{boards:#?}");
}
