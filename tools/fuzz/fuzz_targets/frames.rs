//! A line that carries anything: what a receiver makes of it has a frame that reads back as the
//! same.
#![no_main]

use std::fmt::Debug;

use libfuzzer_sys::fuzz_target;
use serde::{Serialize, de::DeserializeOwned};
use wire::{FRAME_BYTES, Receiver, Request, Response};

fuzz_target!(|bytes: &[u8]| {
    receive::<Request>(bytes);
    receive::<Response>(bytes);
});

fn receive<M: Serialize + DeserializeOwned + Debug>(bytes: &[u8]) {
    for message in messages::<M>(bytes) {
        let frame = framed(&message);
        let again: Vec<_> = messages::<M>(&frame).iter().map(framed).collect();
        // Not the messages themselves: a NaN is unlike itself.
        assert_eq!(again, [frame], "{message:?}");
    }
}

fn messages<M: DeserializeOwned>(bytes: &[u8]) -> Vec<M> {
    let mut receiver = Receiver::new();
    bytes.iter().filter_map(|&byte| receiver.push(byte)).flatten().collect()
}

fn framed<M: Serialize>(message: &M) -> Vec<u8> {
    wire::encode(message, &mut [0; FRAME_BYTES]).expect("what came in a frame fits in one").to_vec()
}
