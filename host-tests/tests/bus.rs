//! The bus against the control it speaks for: every register, every exception, and frames that are
//! none.

use std::collections::HashSet;

use board_models::extended_parameters;
use host_tests::bus::{BusBoard, frame, random_frames, refused};
use wire::registers::{
    Access, Command, Exception, GROUPS, Id, Kind, Learning, MOST_READ, MOST_WRITTEN, Register, TABLE, UNIT,
    Value, fields,
};
use wire::{Configuration, Protection, Request, Response, VERSION};

/// Counters of the requests, and why the last one was refused.
const OF_REQUESTS: [Id; 5] = [Id::BusFrames, Id::BusDamaged, Id::BusRefused, Id::UploadResult, Id::Message];

/// No answer.
const SILENCE: [u8; 0] = [];

fn order(board: &mut BusBoard, command: Command) -> Result<(), u8> {
    board.set(Id::Command, command.number().into())
}

/// Everything that the registers say, but for what tells of the bus's requests themselves.
fn contents(board: &mut BusBoard) -> Vec<(&'static str, Vec<u16>)> {
    let registers = TABLE.iter().filter(|register| !OF_REQUESTS.contains(&register.id));
    registers
        .map(|register| (register.name, board.read(register.address, register.words()).expect(register.name)))
        .collect()
}

#[test]
fn every_register_is_read_by_either_function_and_in_any_company() {
    let mut board = BusBoard::configured();
    for register in TABLE.iter().filter(|register| !OF_REQUESTS.contains(&register.id)) {
        let by_3 = board.read(register.address, register.words()).expect(register.name);
        let address = register.address.to_be_bytes();
        let by_4 = board.ask(&[&[4], &address[..], &register.words().to_be_bytes()].concat());
        let bytes: Vec<u8> = by_3.iter().flat_map(|word| word.to_be_bytes()).collect();
        assert_eq!(by_4[2..], bytes, "{}", register.name);
        // A word alone, and with its neighbour.
        for offset in 0..register.words() {
            assert_eq!(
                board.read(register.address + offset, 1).map(|words| words[0]),
                Ok(by_3[usize::from(offset)])
            );
        }
    }
}

#[test]
fn every_written_register_reads_as_it_was_written_at_both_limits_and_refuses_what_is_beyond() {
    // What has an effect of its own, or takes no value alone.
    let special = [
        Id::Command,
        Id::SetpointBar,
        Id::StreamOrder,
        Id::StreamPlayIn,
        Id::PushNumber,
        Id::PushPoints,
        Id::UploadOrder,
        Id::BusTake,
        Id::CalibrationChecksum,
        Id::InputsChecksum,
        Id::UpdateOrder,
        Id::UpdateOlder,
        Id::UpdateOffset,
        Id::UpdateWindow,
    ];
    for register in &TABLE {
        let Access::Write(min, max) = register.access else { continue };
        let is_part = fields::CALIBRATION.contains(&register.id) || fields::INPUTS.contains(&register.id);
        if special.contains(&register.id) || is_part {
            continue;
        }
        for number in [min, max] {
            let mut board = BusBoard::configured();
            // Gains are checked together; the lowest command is below the highest.
            let wanted = match register.id {
                Id::CommandMin => 0.5 * number.min(1.0),
                Id::CommandMax => number.max(2.0),
                _ => number,
            };
            assert_eq!(board.set(register.id, wanted), Ok(()), "{} = {wanted}", register.name);
            assert_eq!(board.get(register.id), Value::of_number(register.kind, wanted), "{}", register.name);
        }
        let mut board = BusBoard::configured();
        let before = contents(&mut board);
        for number in beyond(register.kind, min, max) {
            assert_eq!(
                board.set(register.id, number),
                refused(Exception::IllegalValue),
                "{} = {number}",
                register.name
            );
        }
        assert_eq!(contents(&mut board), before, "{}", register.name);
    }
}

/// Numbers of a kind outside these limits, and for quantities what is no number.
fn beyond(kind: Kind, min: f64, max: f64) -> Vec<f64> {
    let numbers = match kind {
        Kind::U16 => vec![min - 1.0, max + 1.0, f64::from(u16::MAX)],
        Kind::I16 => vec![min - 1.0, max + 1.0],
        Kind::U32 | Kind::I32 => vec![min - 1.0, max + 1.0, f64::from(u32::MAX)],
        Kind::F32 => {
            let [below, above] = [min, max].map(|limit| f64::from((limit as f32).abs().max(1e-3) * 1e-6));
            vec![min - below, max + above, f64::NAN, f64::INFINITY, f64::NEG_INFINITY]
        }
    };
    let is_one = |number: &f64| Value::of_number(kind, *number).number() == *number || kind == Kind::F32;
    numbers.into_iter().filter(|number| is_one(number) && !(min..=max).contains(number)).collect()
}

#[test]
fn addresses_without_a_register_and_what_is_only_read_are_refused() {
    let mut board = BusBoard::configured();
    let before = contents(&mut board);
    for address in 0..=u16::MAX {
        let register = Register::at(address);
        let read = board.read(address, 1);
        assert_eq!(read.is_ok(), register.is_some(), "{address:#06x}");
        if register.is_none() {
            assert_eq!(read, refused(Exception::IllegalAddress));
        }
        if register.is_none_or(|register| register.access == Access::Read) {
            assert_eq!(board.write(address, &[0]), refused(Exception::IllegalAddress), "{address:#06x}");
        }
    }
    assert_eq!(contents(&mut board), before);
}

#[test]
fn half_of_a_pair_is_not_written() {
    let mut board = BusBoard::configured();
    for register in &TABLE {
        if matches!(register.access, Access::Write(..)) && register.kind.words() == 2 {
            for offset in 0..2 {
                let written = board.write(register.address + offset, &[0]);
                assert_eq!(written, refused(Exception::IllegalValue), "{}", register.name);
            }
        }
    }
}

#[test]
fn lengths_that_do_not_fit_are_refused() {
    let mut board = BusBoard::configured();
    let [high, low] = Id::UploadWindow.register().address.to_be_bytes();
    let refusal = |function: u8| vec![function | 0x80, Exception::IllegalValue.number() as u8];
    for function in [3, 4] {
        for count in [0, MOST_READ + 1, u16::MAX] {
            let [count_high, count_low] = count.to_be_bytes();
            assert_eq!(
                board.ask(&[function, high, low, count_high, count_low]),
                refusal(function),
                "{count}"
            );
        }
    }
    // No registers; bytes that are not two a register; more registers than a write has.
    assert_eq!(board.ask(&[16, high, low, 0, 0, 0]), refusal(16));
    assert_eq!(board.ask(&[16, high, low, 0, 2, 2, 0, 0]), refusal(16));
    assert_eq!(board.ask(&[16, high, low, 0, 1, 3, 0, 0, 0]), refusal(16));
    let most = usize::from(MOST_WRITTEN);
    assert_eq!(board.ask(&[&[16, high, low, 0, 124, 246][..], &vec![0; 2 * most]].concat()), refusal(16));
}

#[test]
fn functions_that_the_board_does_not_have_are_refused() {
    let mut board = BusBoard::configured();
    for function in 1..=127 {
        // 65 is asked of all at once alone: see `slots.rs`.
        if [3, 4, 6, 8, 16, 17, 22, 23, 65].contains(&function) {
            continue;
        }
        let pdu = match function {
            15 => vec![15, 0, 0, 0, 1, 1, 0],
            _ => vec![function, 0, 0, 0, 1],
        };
        board.be_silent();
        let request = frame(UNIT, &pdu);
        let response = [board.send(&request), board.be_silent()].concat();
        assert_eq!(
            response,
            frame(UNIT, &[function | 0x80, Exception::IllegalFunction.number() as u8]),
            "{function}"
        );
    }
}

#[test]
fn function_6_writes_a_register() {
    let mut board = BusBoard::configured();
    let address = Id::Mode.register().address.to_be_bytes();
    let pdu = [&[6], &address[..], &[0, 2]].concat();
    assert_eq!(board.ask(&pdu), pdu);
    assert_eq!(board.number(Id::Mode), 2);
}

/// The exception of a function.
fn exception(function: u8, exception: Exception) -> Vec<u8> {
    vec![function | 0x80, exception.number() as u8]
}

#[test]
fn function_8_sends_its_data_back_and_tells_the_counters() {
    let mut board = BusBoard::configured();
    assert_eq!(board.ask(&[8, 0, 0, 0xA5, 0x37]), [8, 0, 0, 0xA5, 0x37]);
    board.read(0xFFFF, 1).expect_err("nothing is there");
    for (number, id) in [(12, Id::BusDamaged), (13, Id::BusRefused)] {
        let [high, low] = (board.number(id) as u16).to_be_bytes();
        assert_eq!(board.ask(&[8, 0, number, 0, 0]), [8, 0, number, high, low]);
    }
    // With this request itself.
    let [high, low] = (board.number(Id::BusFrames) as u16 + 1).to_be_bytes();
    assert_eq!(board.ask(&[8, 0, 14, 0, 0]), [8, 0, 14, high, low]);
    assert_eq!(board.ask(&[8, 0, 14, 0, 1]), exception(8, Exception::IllegalValue));
    // Among those that it does not have: restart, listen only.
    for number in [1, 2, 4, 10, 15, 21] {
        assert_eq!(board.ask(&[8, 0, number, 0, 0]), exception(8, Exception::IllegalFunction), "{number}");
    }
}

#[test]
fn function_17_tells_number_name_and_whether_the_valve_is_driven() {
    let mut board = BusBoard::configured();
    for (command, indicator) in
        [(Command::None, 0), (Command::Arm, 0), (Command::Start, 0xFF), (Command::Stop, 0)]
    {
        order(&mut board, command).expect("taken");
        let answer = board.ask(&[17]);
        assert_eq!(answer[..4], [17, answer.len() as u8 - 2, UNIT, indicator], "{command:?}");
        assert_eq!(answer[4..], *b"valve board 0.1.0");
    }
}

#[test]
fn function_22_changes_the_bits_of_its_mask_within_the_limits() {
    let mut board = BusBoard::configured();
    let mask = |board: &mut BusBoard, id: Id, and: u16, or: u16| {
        let words = [id.register().address, and, or].map(u16::to_be_bytes).concat();
        (words.clone(), board.ask(&[&[22][..], &words].concat()))
    };
    board.set(Id::StreamInterval, 0b1010.into()).expect("taken");
    let (request, answer) = mask(&mut board, Id::StreamInterval, 0b0110, 0b0101);
    assert_eq!(answer, [&[22][..], &request].concat());
    assert_eq!(board.number(Id::StreamInterval), 0b1010 & 0b0110 | 0b0101 & !0b0110);
    let before = contents(&mut board);
    for (id, refusal) in [
        (Id::StreamInterval, Exception::IllegalValue),
        (Id::State, Exception::IllegalAddress),
        (Id::Kp, Exception::IllegalValue),
    ] {
        // 0 beyond the limits, only read, half of a pair.
        assert_eq!(mask(&mut board, id, 0, 0).1, exception(22, refusal), "{id:?}");
    }
    assert_eq!(board.ask(&[22, 0xFF, 0xFF, 0, 0, 0, 0]), exception(22, Exception::IllegalAddress));
    assert_eq!(contents(&mut board), before);
}

/// A request of function 23.
fn read_write(read: (u16, u16), to: u16, words: &[u16]) -> Vec<u8> {
    let head = [read.0, read.1, to, words.len() as u16].map(u16::to_be_bytes).concat();
    let bytes = words.iter().flat_map(|word| word.to_be_bytes());
    [&[23][..], &head, &[2 * words.len() as u8]].concat().into_iter().chain(bytes).collect()
}

#[test]
fn function_23_writes_before_it_reads_and_does_neither_when_one_is_refused() {
    let mut board = BusBoard::configured();
    let mode = Id::Mode.register().address;
    assert_eq!(board.ask(&read_write((mode, 1), mode, &[2])), [23, 2, 0, 2]);
    let before = contents(&mut board);
    for (read, to, words, refusal) in [
        ((mode, 1), mode, &[9][..], Exception::IllegalValue),
        ((mode, 1), 0xFFFF, &[0], Exception::IllegalAddress),
        ((0x00FF, 1), mode, &[1], Exception::IllegalAddress),
        ((0xFFFF, 2), mode, &[1], Exception::IllegalAddress),
        ((mode, 0), mode, &[1], Exception::IllegalValue),
        ((mode, MOST_READ + 1), mode, &[1], Exception::IllegalValue),
    ] {
        assert_eq!(board.ask(&read_write(read, to, words)), exception(23, refusal), "{read:?} {to:#06x}");
    }
    // Bytes that are not two a register.
    let mut request = read_write((mode, 1), mode, &[1]);
    request[8] = 2;
    assert_eq!(board.ask(&request), exception(23, Exception::IllegalValue));
    assert_eq!(contents(&mut board), before);
    // The longest of both.
    let window = Id::UploadWindow.register().address;
    let answer = board.ask(&read_write((window, 120), window, &[0x1234; 120]));
    assert_eq!(answer, [vec![23, 240], [0x12, 0x34].repeat(120)].concat());
}

#[test]
fn function_43_says_who_made_what_in_which_release() {
    let mut board = BusBoard::configured();
    let mut objects = |code: u8, object: u8| {
        let answer = board.ask(&[43, 14, code, object]);
        let (head, mut rest) = answer.split_at(answer.len().min(7));
        if head[0] != 43 {
            return Err(answer);
        }
        assert_eq!(head[..6], [43, 14, code, 0x83, 0, 0]);
        let mut texts = Vec::new();
        while let [id, length, text @ ..] = rest {
            let (text, behind) = text.split_at(usize::from(*length));
            texts.push((*id, String::from_utf8(text.to_vec()).expect("a text")));
            rest = behind;
        }
        assert_eq!(usize::from(head[6]), texts.len());
        Ok(texts)
    };
    let ids = |texts: Vec<(u8, String)>| texts.into_iter().map(|(id, _)| id).collect::<Vec<_>>();
    assert_eq!(objects(1, 0).map(ids), Ok(vec![0, 1, 2]));
    assert_eq!(objects(2, 0).map(ids), Ok(vec![0, 1, 2, 4, 5]));
    assert_eq!(objects(3, 2).map(ids), Ok(vec![2, 4, 5, 0x80, 0x81, 0x82, 0x83]));
    // One that it does not have: from the first on, or an exception.
    assert_eq!(objects(1, 0x33).map(ids), Ok(vec![0, 1, 2]));
    assert_eq!(objects(4, 2), Ok(vec![(2, "0.1.0".to_owned())]));
    assert_eq!(objects(4, 3), Err(exception(43, Exception::IllegalAddress)));
    assert_eq!(objects(5, 0), Err(exception(43, Exception::IllegalValue)));
}

#[test]
fn a_broadcast_opens_no_valve() {
    let command = Id::Command.register().address.to_be_bytes();
    for (before, refused) in [
        (Command::None, Command::Arm),
        (Command::Arm, Command::Start),
        (Command::Arm, Command::Service),
        (Command::Hold, Command::Start),
    ] {
        let mut board = BusBoard::configured();
        match before {
            Command::Hold => {
                board.open(Command::Start);
                order(&mut board, Command::Hold).expect("taken");
            }
            before => order(&mut board, before).expect("taken"),
        }
        let state = board.number(Id::State);
        let count = board.number(Id::BusRefused);
        let number = refused.number().to_be_bytes();
        assert_eq!(board.send(&frame(0, &[&[6][..], &command, &number].concat())), SILENCE);
        assert_eq!(board.send(&frame(0, &[&[22][..], &command, &[0, 0], &number].concat())), SILENCE);
        // What asks for an answer is not carried out for all.
        let both = read_write((0x0100, 1), 0x0100, &[refused.number()]);
        assert_eq!(board.send(&frame(0, &both)), SILENCE);
        assert_eq!(
            (board.number(Id::State), board.number(Id::BusRefused)),
            (state, count + 2),
            "{refused:?}"
        );
    }
    // A stop for all vents.
    let mut board = BusBoard::configured();
    board.open(Command::Start);
    assert_eq!(board.send(&frame(0, &[6, 1, 0, 0, 2])), SILENCE);
    assert_eq!(board.number(Id::State), 2);
}

#[test]
fn orders_that_the_state_does_not_take_are_busy_and_change_nothing() {
    let busy = || refused(Exception::DeviceBusy);
    let mut board = BusBoard::new();
    let before = contents(&mut board);
    for command in [Command::Start, Command::Hold] {
        assert_eq!(order(&mut board, command), busy(), "{command:?}, off");
    }
    assert_eq!(board.set(Id::SetpointBar, 1.0), busy());
    assert_eq!(board.set(Id::Kp, 0.1), busy());
    assert_eq!(board.set(Id::StreamOrder, 1.0), busy());
    assert_eq!(board.set(Id::UploadOrder, 2.0), busy());
    assert_eq!(contents(&mut board), before);

    let mut board = BusBoard::configured();
    board.open(Command::Start);
    let before = contents(&mut board);
    for id in [Id::Kp, Id::VentedBar, Id::SetpointBar] {
        assert_eq!(board.set(id, 0.5), busy(), "{}, tracking", id.register().name);
    }
    for command in [Command::Start, Command::Service] {
        assert_eq!(order(&mut board, command), busy(), "{command:?}, tracking");
    }
    assert_eq!(contents(&mut board), before);
}

#[test]
fn the_whole_group_of_orders_may_be_written_all_the_time() {
    let mut board = BusBoard::configured();
    board.open(Command::Start);
    let mode = Id::Mode.register().address;
    let points = [Value::F32(12.5), Value::F32(0.0), Value::U16(77)].into_iter().flat_map(Value::words);
    let words: Vec<u16> = std::iter::once(0).chain(points).collect();
    board.write(mode, &words).expect("0 bar is what stands there");
    assert_eq!((board.get(Id::SetpointMm), board.number(Id::Heartbeat)), (Value::F32(12.5), 77));
}

#[test]
fn a_write_of_many_registers_is_refused_as_a_whole() {
    let mut board = BusBoard::configured();
    board.open(Command::Start);
    let before = contents(&mut board);
    // Mode and set point would do, the second start does not.
    let mut words = vec![Command::Start.number(), 2];
    words.extend(Value::F32(10.0).words());
    let address = Id::Command.register().address;
    assert_eq!(board.write(address, &words), refused(Exception::DeviceBusy));
    // The command would do, the set point is beyond its limits.
    words[0] = Command::Stop.number();
    words[2..].copy_from_slice(&Value::F32(1e6).words().collect::<Vec<_>>());
    assert_eq!(board.write(address, &words), refused(Exception::IllegalValue));
    assert_eq!(contents(&mut board), before);
}

#[test]
fn commands_lead_through_the_states() {
    let mut board = BusBoard::configured();
    let mut step = |command, state| {
        order(&mut board, command).expect("taken");
        assert_eq!(board.number(Id::State), state, "{command:?}");
        assert_eq!(board.number(Id::Command), u32::from(command.number()));
        order(&mut board, Command::None).expect("taken");
    };
    step(Command::Arm, 2);
    step(Command::Start, 3);
    step(Command::Hold, 4);
    step(Command::Start, 3);
    step(Command::Stop, 2);
    step(Command::Arm, 2);
    step(Command::Service, 6);
    step(Command::Stop, 2);
    board.control().report(wire::Fault::Leak);
    assert_eq!((board.number(Id::State), board.number(Id::Fault)), (5, u32::from(wire::Fault::Leak.code())));
    assert_eq!(board.number(Id::RecordFault), u32::from(wire::Fault::Leak.code()));
    order(&mut board, Command::Acknowledge).expect("taken");
    assert_eq!((board.number(Id::State), board.number(Id::Fault)), (2, 0));
}

#[test]
fn what_is_learnt_is_switched_by_the_bus_and_not_forgotten_while_the_valve_is_driven() {
    let mut board = BusBoard::configured();
    assert_eq!(board.number(Id::Adaptation), u32::from(Learning::Off.number()));
    board.set(Id::Adaptation, Learning::On.number().into()).expect("taken");
    board.open(Command::Start);
    let busy = Exception::DeviceBusy.number() as u8;
    assert_eq!(board.set(Id::Adaptation, Learning::Off.number().into()), Err(busy));
    assert_eq!(board.number(Id::Adaptation), u32::from(Learning::On.number()));
    board.set(Id::Adaptation, Learning::Kept.number().into()).expect("taken");
    order(&mut board, Command::Stop).expect("taken");
    assert_eq!(board.number(Id::Adaptation), u32::from(Learning::Kept.number()));
    board.set(Id::Adaptation, Learning::Off.number().into()).expect("taken");
    for id in [Id::AdaptedOffset, Id::AdaptedGain, Id::AdaptedBend, Id::AdaptedWidth, Id::AdaptedFlare] {
        assert_eq!(board.get(id).number(), 0.0, "{id:?}");
    }
}

#[test]
fn a_set_point_drives_and_a_stop_vents_whatever_comes_with_it() {
    let mut board = BusBoard::configured();
    board.open(Command::Service);
    board.set(Id::SetpointBar, 2.0).expect("in service");
    (0..100).for_each(|_| _ = board.tick());
    assert!((board.get(Id::CommandBar).number() - 2.0).abs() < 0.01);
    let words: Vec<u16> = [Command::Stop.number(), 0]
        .into_iter()
        .chain(Value::F32(5.0).words())
        .chain(Value::F32(5.0).words())
        .collect();
    board.write(Id::Command.register().address, &words).expect("a stop is taken");
    board.tick();
    assert_eq!((board.number(Id::State), board.get(Id::CommandBar).number()), (2, 0.0));
}

#[test]
fn gains_that_are_written_are_installed_and_kept() {
    let mut board = BusBoard::configured();
    board.set(Id::Kp, 0.125).expect("taken");
    assert_eq!(board.parameters().tracking.as_ref().map(|tracking| tracking.pid.kp), Some(0.125));
    board.set(Id::VentedBar, 0.25).expect("taken");
    assert_eq!(board.parameters().protection.vented_bar, 0.25);
    // Lowest above highest: the model's own check, in words.
    assert_eq!(board.set(Id::CommandMax, 0.0), refused(Exception::IllegalValue));
    let message: Vec<u8> = board
        .read(Id::Message.register().address, 50)
        .expect("read")
        .into_iter()
        .flat_map(u16::to_be_bytes)
        .collect();
    assert!(
        String::from_utf8_lossy(&message).contains("command range is 0 bar"),
        "{}",
        String::from_utf8_lossy(&message)
    );
}

#[test]
fn a_broadcast_is_carried_out_and_not_answered() {
    let mut board = BusBoard::configured();
    let [high, low] = Id::Mode.register().address.to_be_bytes();
    assert_eq!(board.send(&frame(0, &[6, high, low, 0, 1])), SILENCE);
    assert_eq!(board.number(Id::Mode), 1);
    // Reading for all is not answered either.
    assert_eq!(board.send(&frame(0, &[3, high, low, 0, 1])), SILENCE);
}

#[test]
fn frames_for_others_are_met_with_silence() {
    let mut board = BusBoard::configured();
    let before = contents(&mut board);
    let [high, low] = Id::Mode.register().address.to_be_bytes();
    for unit in 2..=255 {
        assert_eq!(board.send(&frame(unit, &[6, high, low, 0, 1])), SILENCE);
    }
    assert_eq!(contents(&mut board), before);
}

#[test]
fn a_request_behind_another_boards_answer_is_heard_without_a_silence() {
    let [high, low] = Id::Mode.register().address.to_be_bytes();
    let request = frame(UNIT, &[3, high, low, 0, 1]);
    let identification = [&[43, 14, 1, 1, 0, 0, 2, 0, 3][..], b"abc", &[1, 2], b"de"].concat();
    for answer in [
        &[3, 4, 0, 1, 0, 2][..],
        &[6, high, low, 0, 1],
        &[8, 0, 0, 0xA5, 0x37],
        &[16, high, low, 0, 1],
        &[17, 4, 2, 0xFF, 65, 66],
        &[22, high, low, 0, 1, 0, 2],
        &[23, 2, 0, 1],
        &identification,
        &[0x83, 2],
    ] {
        let mut board = BusBoard::configured();
        let answers = board.send_all(&[frame(2, answer), request.clone()].concat());
        assert_eq!(answers.len(), 1, "{answer:02x?}");
    }
}

#[test]
fn damaged_truncated_and_overlong_frames_are_met_with_silence_and_the_next_one_is_heard() {
    let [high, low] = Id::Mode.register().address.to_be_bytes();
    let good = frame(UNIT, &[16, high, low, 0, 1, 2, 0, 1]);
    let mut board = BusBoard::configured();
    let damaged = (0..8 * good.len()).map(|bit| {
        let mut bytes = good.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        bytes
    });
    let truncated = (1..good.len()).map(|length| good[..length].to_vec());
    let filled =
        |length: usize| frame(UNIT, &[&[16, high, low, 0, 1, 2, 0, 1][..], &vec![0; length]].concat());
    let overlong = [1, 2, 100, 243, 244, 1000].map(filled);
    for bytes in damaged.chain(truncated).chain(overlong) {
        assert_eq!([board.send(&bytes), board.be_silent()].concat(), SILENCE, "{bytes:02x?}");
        assert_eq!(board.number(Id::Mode), 0, "{bytes:02x?}");
    }
    assert_eq!(board.send(&good), frame(UNIT, &[16, high, low, 0, 1]));
    assert_eq!(board.number(Id::Mode), 1);
}

#[test]
fn random_frames_change_no_state_and_the_loop_goes_on() {
    let mut board = BusBoard::configured();
    board.open(Command::Start);
    let before = (board.number(Id::State), contents(&mut board).len(), board.parameters().clone());
    let mut answered = HashSet::new();
    for bytes in random_frames(7).take(1000) {
        answered.extend([board.send(&bytes), board.be_silent()].concat().get(1).copied());
    }
    assert!(answered.iter().all(|function| function & 0x80 != 0), "{answered:?}");
    assert_eq!((board.number(Id::State), contents(&mut board).len(), board.parameters().clone()), before);
    assert_eq!(board.number(Id::Overruns), 0);
    assert!(board.number(Id::BusDamaged) > 700);
}

#[test]
fn what_a_board_starts_with_is_within_what_is_compiled_in() {
    let mut board = BusBoard::new();
    let protection = Protection::STANDARD;
    assert_eq!(board.request(&Request::Protect(protection)), Response::Accepted);
    let tracking = extended_parameters().expect("valid");
    let configure = Request::Configure(Configuration { version: VERSION, tracking });
    assert_eq!(board.request(&configure), Response::Accepted);
    for group in ["Controller", "Protection"].map(|title| GROUPS.iter().find(|group| group.title == title)) {
        let page = group.expect("a group").address >> 8;
        for register in TABLE.iter().filter(|register| register.address >> 8 == page) {
            let value = board.get(register.id);
            assert!(register.takes(value), "{} = {value:?}", register.name);
        }
    }
}
