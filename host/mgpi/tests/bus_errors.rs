//! What the commands say where no board answers as it should: which port, why, and what helps.

mod common;
#[path = "common/line.rs"]
mod line;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use common::Bench;
use line::{Line, framed};
use rustix::fs::{FlockOperation, flock};

/// What `mgpi status` says against a port.
fn refused(port: &str) -> String {
    Bench::new().refuses(&format!("status --timeout-s 0.05 --port {port}"))
}

fn refused_by(answer: impl FnMut(&[u8]) -> Vec<u8> + Send + 'static) -> String {
    let line = Line::new(answer);
    refused(&line.path().display().to_string())
}

#[test]
fn a_port_that_is_not_there_is_named_with_those_that_are() {
    let message = refused("/dev/ttyNOT7");
    assert!(message.contains("/dev/ttyNOT7: no such port; there"), "{message}");
}

#[test]
fn a_file_is_no_port() {
    let bench = Bench::new();
    bench.write("file", "nothing");
    let message = bench.refuses("status --port file");
    assert!(message.contains("file: not a serial port"), "{message}");
    let message = bench.refuses("status --port .");
    assert!(message.contains(".: not a serial port"), "{message}");
}

#[test]
fn a_port_that_another_program_has_is_busy() {
    let line = Line::new(|_| Vec::new());
    let other = std::fs::File::open(line.path()).expect("opened");
    flock(&other, FlockOperation::LockExclusive).expect("locked");
    let message = refused(&line.path().display().to_string());
    assert!(message.contains("busy: another program has this port"), "{message}");
}

#[test]
fn silence_is_asked_again_and_again_and_told_with_what_may_be_wrong() {
    let asked = Arc::new(AtomicUsize::new(0));
    let count = asked.clone();
    let message = refused_by(move |_| {
        count.fetch_add(1, Ordering::Relaxed);
        Vec::new()
    });
    assert!(message.contains("no answer from unit 1 within 0.05 s, asked 16 times"), "{message}");
    assert!(message.contains("115200 bit/s"), "{message}");
    assert_eq!(asked.load(Ordering::Relaxed), 16);
}

#[test]
fn noise_is_no_answer() {
    let message = refused_by(|_| b"no Modbus".to_vec());
    assert!(message.contains("damaged answers only"), "{message}");
    // A right CRC under a wrong length.
    let message = refused_by(|_| framed(&[1, 3, 0]));
    assert!(message.contains("damaged answers only"), "{message}");
}

#[test]
fn what_answers_another_function_is_no_refusal() {
    // Where an exception has its number stands the address of a writing.
    let message = refused_by(|_| framed(&[1, 16, 7, 0, 0]));
    assert!(message.contains("damaged answers only"), "{message}");
}

#[test]
fn another_device_is_not_taken_for_the_board() {
    let message = refused_by(|_| framed(&[1, 0x83, 2]));
    assert!(message.contains("no valve board answers, but something else"), "{message}");
}

#[test]
fn another_version_of_the_registers_is_refused_with_what_to_do() {
    let message = refused_by(|_| framed(&[1, 3, 2, 0, 99]));
    assert!(message.contains("version 99") && message.contains("use a newer mgpi"), "{message}");
    let message = refused_by(|_| framed(&[1, 3, 2, 0, 0]));
    assert!(message.contains("flash the firmware of this release"), "{message}");
}

#[test]
fn a_lost_answer_is_asked_for_again() {
    let mut asked = 0;
    // The first answer is lost, the second comes damaged, the third is whole.
    let message = refused_by(move |_| {
        asked += 1;
        match asked {
            1 => Vec::new(),
            2 => framed(&[1, 3, 2, 0, 99])[1..].to_vec(),
            _ => framed(&[1, 3, 2, 0, 99]),
        }
    });
    assert!(message.contains("version 99"), "{message}");
}
