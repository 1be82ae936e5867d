//! A bus that carries anything, some of it in right frames: what the board sends is a frame that
//! fits the request, and the valve's command stays within what is compiled into the board.
//!
//! An input is a run of parts: a byte that says what it is, one with its length, and its contents.
#![no_main]

use std::cell::Cell;

use host_tests::bus::{BusBoard, frame};
use libfuzzer_sys::fuzz_target;
use wire::registers::{Access, FRAME_BYTES, Id};

thread_local! {
    /// The board of the last input: its memory is used again.
    static BOARD: Cell<Option<BusBoard>> = const { Cell::new(None) };
}

fuzz_target!(|bytes: &[u8]| {
    let mut board = BOARD.take().map_or_else(BusBoard::new, BusBoard::reset);
    let Access::Write(_, highest_bar) = Id::CommandMax.register().access else {
        unreachable!("the highest command can be set");
    };
    let mut rest = bytes;
    while let [kind, length, behind @ ..] = rest {
        let (part, behind) = behind.split_at(behind.len().min(usize::from(*length)));
        rest = behind;
        let unit = board.unit();
        let mut answers = match kind % 4 {
            // Bytes as they are.
            0 => board.send_all(part),
            // A frame to all, a frame to the board.
            1 => board.send_all(&frame(0, part)),
            _ => board.send_all(&frame(unit, part)),
        };
        let late = board.be_silent();
        answers.extend((!late.is_empty()).then_some(late));
        for answer in answers {
            let [by, pdu @ .., _, _] = &*answer else { panic!("{answer:02x?}") };
            // It may have been told to take another number.
            assert!([unit, board.unit()].contains(by), "{answer:02x?}");
            assert_eq!(frame(*by, pdu), answer);
            assert!(answer.len() <= FRAME_BYTES, "{answer:02x?}");
        }
        let highest = board.control().scalings().command_code(highest_bar as f32);
        assert!(board.tick().dac_code <= highest.0);
    }
    BOARD.set(Some(board));
});
