//! The users' bus of the production image: task, port driver, and what they need of the stack.

use std::io::{ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;

use board_models::extended_parameters;
use host_tests::bus::{frame, random_frames};
use libtest_mimic::Failed;
use wire::registers::{
    Id, UNIT, UPLOAD_BYTES, UPLOAD_REGISTERS, UploadOrder, Value, checksum, pack_bytes, state_number,
};
use wire::{Configuration, State, Telemetry, VERSION};

use super::bench::Bench;

/// How many ticks a request may take.
const ANSWER_TICKS: u32 = 10_000;
/// What has to remain of the stack. Unit: byte.
const STACK_LEFT: u32 = 8 * 1024;

/// Random frames, the bytes of one that the image takes in a tick at the least, and the ticks of
/// silence behind it.
const FRAMES: usize = 200;
const BYTES_OF_A_TICK: usize = 4;
const SILENCE_TICKS: usize = 5;

/// The image with somebody on its bus.
struct OnBus {
    bench: Bench,
    bus: UnixStream,
}

impl OnBus {
    /// Function and data of the response to a request.
    fn ask(&mut self, pdu: &[u8]) -> Result<Vec<u8>, Failed> {
        self.bus.write_all(&frame(UNIT, pdu))?;
        let mut answer = Vec::new();
        for _ in 0..ANSWER_TICKS {
            self.bench.tick(Some)?;
            let mut bytes = [0; 256];
            match self.bus.read(&mut bytes) {
                Ok(count) => answer.extend_from_slice(&bytes[..count]),
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) => return Err(error.into()),
            }
            if let [UNIT, pdu @ .., _, _] = &*answer
                && frame(UNIT, pdu) == answer
            {
                return Ok(pdu.to_vec());
            }
        }
        Err(format!("no answer to {pdu:02x?}, only {answer:02x?}").into())
    }

    fn write(&mut self, id: Id, words: &[u16]) -> Result<(), Failed> {
        let head = [id.register().address, words.len() as u16].map(u16::to_be_bytes).concat();
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
        let answer = self.ask(&[&[16], &head[..], &[bytes.len() as u8], &bytes].concat())?;
        if answer == [&[16], &head[..]].concat() {
            Ok(())
        } else {
            Err(format!("{}: {answer:02x?}", id.register().name).into())
        }
    }

    /// An order that the board keeps in its flash, which the emulator does not have: carried out,
    /// and answered by an exception.
    fn set_unstored(&mut self, id: Id, number: f64) -> Result<(), Failed> {
        match self.set(id, number) {
            Err(error) if error.message().is_some_and(|message| message.ends_with("[90, 04]")) => Ok(()),
            other => Err(format!("{}: {other:?}, where the flash keeps nothing", id.register().name).into()),
        }
    }

    fn set(&mut self, id: Id, number: f64) -> Result<(), Failed> {
        self.write(id, &Value::of_number(id.register().kind, number).words().collect::<Vec<_>>())
    }
}

/// On a vented board: the emulator's bytes have no bit times, and whole frames of them interrupt a
/// tick; those that do not are for the model of the chip (`host-tests/chip/test_link.py`).
pub fn meets_random_frames_with_exceptions() -> Result<(), Failed> {
    let (bench, bus) = Bench::with_bus(1)?;
    let mut image = OnBus { bench, bus };
    let mut answers = 0;
    for (number, frame) in random_frames(7).take(FRAMES).enumerate() {
        image.bus.write_all(&frame)?;
        for _ in 0..frame.len() / BYTES_OF_A_TICK + SILENCE_TICKS {
            image.bench.tick(Some)?;
        }
        let mut bytes = [0; 256];
        while let Ok(count) = image.bus.read(&mut bytes) {
            // Nothing but exceptions, and what is left of one.
            assert!(count <= 5, "frame {number}: {:02x?}", &bytes[..count]);
            answers += 1;
        }
    }
    let Telemetry { state, fault, .. } = image.bench.telemetry()?;
    println!("{FRAMES} random frames: {answers} answers");
    assert_eq!((state, fault), (State::Off, None));
    // To the whole ones; on a busy machine one may run into the frame before it, and is none then.
    assert!(answers > FRAMES / 8, "{answers} answers");
    Ok(())
}

pub fn takes_an_upload() -> Result<(), Failed> {
    let (bench, bus) = Bench::with_bus(1)?;
    let mut image = OnBus { bench, bus };
    let [high, low] = Id::State.register().address.to_be_bytes();
    let state = |image: &mut OnBus| image.ask(&[3, high, low, 0, 1]);
    let number = |state| state_number(state) as u8;
    assert_eq!(state(&mut image)?, [3, 2, 0, number(State::Off)]);

    let mut buffer = [0; UPLOAD_BYTES];
    let configuration = Configuration { version: VERSION, tracking: extended_parameters()? };
    let bytes = postcard::to_slice(&configuration, &mut buffer)?;
    for (block, offset) in bytes.chunks(2 * usize::from(UPLOAD_REGISTERS)).zip((0..).step_by(240)) {
        image.write(Id::UploadOffset, &[offset].into_iter().chain(pack_bytes(block)).collect::<Vec<_>>())?;
    }
    image.set(Id::UploadLength, bytes.len() as f64)?;
    image.set(Id::UploadChecksum, checksum(bytes).into())?;
    image.set_unstored(Id::UploadOrder, UploadOrder::Commit.number().into())?;
    // The gains by themselves take the longest way.
    image.set_unstored(Id::Kp, 0.06)?;
    for _ in 0..500 {
        image.bench.tick(Some)?;
    }
    assert_eq!(state(&mut image)?, [3, 2, 0, number(State::Ready)]);
    let (used, room) = (image.bench.image.stack_bytes()?, image.bench.image.stack_room());
    println!("stack: {used} of {room} bytes");
    assert!(used < room - STACK_LEFT, "{used} bytes of stack");
    Ok(())
}
