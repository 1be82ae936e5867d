//! A controller that commands anything: each line that makes sense is answered by two finite
//! numbers.
#![no_main]

use board_client::pil::plant::measurement;
use libfuzzer_sys::fuzz_target;
use rig::parameters::DEAD_LOAD_N;
use rig::plant::Plant;
use rig::sensor::{Columns, Sensors};
use rig::serve::serve;

fuzz_target!(|commands: &[u8]| {
    let mut answers = Vec::new();
    let served =
        serve(commands, &mut answers, &mut Plant::at_rest(DEAD_LOAD_N, Sensors::ideal()), Columns::All);
    let lines = commands.split(|&byte| byte == b'\n').filter(|line| !line.is_empty()).count();
    let answered =
        answers.split_inclusive(|&byte| byte == b'\n').inspect(|line| assert!(measurement(line).is_some()));
    let answered = answered.count();
    assert!(answered == lines || served.is_err(), "{answered} answers to {lines} lines");
});
