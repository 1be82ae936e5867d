//! A host that asks for anything, in frames that are always right: configurations are checked,
//! installed and run on any samples, and the valve's code stays within the converter's.
#![no_main]

use std::cell::Cell;

use board_client::pil::lock_step::Board;
use host_tests::HostBoard;
use libfuzzer_sys::fuzz_target;
use wire::{FRAME_BYTES, Protection, Request, Response};

thread_local! {
    /// The board of the last input: its memory is used again.
    static BOARD: Cell<Option<HostBoard>> = const { Cell::new(None) };
}

fuzz_target!(|bytes: &[u8]| {
    let mut board =
        BOARD.take().map_or_else(HostBoard::default, |board| board.restarted(Protection::SIMULATED));
    let mut rest = bytes;
    while let Ok((request, behind)) = postcard::take_from_bytes::<Request>(rest) {
        rest = behind;
        let response = board.request(&request).expect("a board on the host always answers");
        if let Response::Tick(reply) = &response {
            assert!(reply.dac_code <= 4095, "{request:?}: {reply:?}");
        }
        assert!(wire::encode(&response, &mut [0; FRAME_BYTES]).is_ok(), "{request:?}: {response:?}");
    }
    BOARD.set(Some(board));
});
