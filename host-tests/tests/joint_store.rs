//! What a board of a joint keeps without power, and what it makes of it at its next start.

use firmware::faults::black_box::Reset;
use firmware::joint::{JointScalings, JointTask, carry_out, recall};
use firmware::scaling::COMMAND;
use firmware::store::{JointParameters, ParameterStore, Sealed, Set};
use firmware::{BlackBox, TickClock};
use host_tests::flash::{MockFlash, Tear};
use host_tests::kept_joint::{KeptJoint, SECTOR};
use host_tests::store::{joint_calibration, joint_set, numbered, paper_set};
use model_core::joint::JointTarget;
use wire::joint::{
    BoardJointParameters, Channel, JOINT_VERSION, JointAim, JointBoardState, JointConfiguration, JointFault,
    JointHello, JointRequest, JointResponse, JointSettings, JointTickReply, JointTickRequest,
};
use wire::{Fault, Protection, Refusal, State, fingerprint};

/// More ticks than a board looks at its dump valve's coil for.
const BEGINNING: u32 = 100;

fn settings() -> JointSettings {
    JointSettings { protection: joint_set().protection, calibration: joint_calibration() }
}

fn control() -> BoardJointParameters {
    joint_set().control.expect("a joint")
}

fn configure(control: BoardJointParameters) -> JointRequest {
    JointRequest::Configure(JointConfiguration { version: JOINT_VERSION, control })
}

fn new_board() -> KeptJoint {
    KeptJoint::start(MockFlash::blank())
}

/// A board that was given all that it can keep.
fn given() -> KeptJoint {
    let mut board = new_board();
    let set = board.answer(&JointRequest::Settings(Some(settings())));
    assert_eq!(set, JointResponse::Settings(settings()));
    assert_eq!(board.answer(&configure(control())), JointResponse::Accepted);
    board
}

fn flash_with<P: Set>(set: &P) -> MockFlash<SECTOR> {
    let mut store = ParameterStore::new(MockFlash::blank());
    assert_eq!(store.save(State::Ready, set), Ok(()));
    store.into_flash()
}

fn hello(board: &mut KeptJoint) -> JointHello {
    match board.answer(&JointRequest::Identify) {
        JointResponse::Hello(hello) => hello,
        other => panic!("{other:?}"),
    }
}

/// Which joint it has.
fn joint_of(board: &mut KeptJoint) -> Option<u32> {
    match board.answer(&JointRequest::Installed) {
        JointResponse::Installed(joint) => joint,
        other => panic!("{other:?}"),
    }
}

fn settings_of(board: &mut KeptJoint) -> JointSettings {
    match board.answer(&JointRequest::Settings(None)) {
        JointResponse::Settings(settings) => settings,
        other => panic!("{other:?}"),
    }
}

/// A tick of a joint at these pressures (bar) and this angle (rad), as sensors of the calibration
/// see it.
fn tick(board: &mut KeptJoint, [a, b]: [f32; 2], angle: f32) -> JointTickReply {
    let by = JointScalings::calibrated(&joint_calibration()).expect("working sensors");
    let [of_a, of_b] = by.pressures;
    board.board.feed(&JointTickRequest {
        target: None,
        pressure_codes: [of_a.code(a), of_b.code(b)],
        angle_code: by.angle.code(angle),
    });
    board.board.tick()
}

/// A tick of a joint that rests, vented.
fn rest(board: &mut KeptJoint) -> JointTickReply {
    tick(board, [0.0; 2], 0.0)
}

#[test]
fn a_joint_and_its_settings_are_there_behind_a_restart_bit_by_bit() {
    let mut board = given().restarted();
    assert_eq!(*board.parameters(), joint_set());
    assert_eq!(settings_of(&mut board), settings());
    let by = JointScalings::calibrated(&joint_calibration()).expect("working sensors");
    let joint = joint_of(&mut board);
    let JointHello { pressures, angle, fault, .. } = hello(&mut board);
    assert_eq!((joint, fault), (Some(fingerprint(&control())), None));
    assert_eq!((pressures, angle), (by.pressures, by.angle));
    // Which muscle is which matters.
    let mut swapped = control();
    swapped.joint.muscles.reverse();
    assert_ne!(joint, Some(fingerprint(&swapped)));
}

/// Settings alone, as before a recording: what watches, and what drives, goes by them.
#[test]
fn limits_and_calibration_that_were_kept_act_without_a_joint() {
    let mut board = new_board();
    let mut slow = settings();
    slow.protection.soft_start_bar_per_s = 2.0;
    assert_eq!(board.answer(&JointRequest::Settings(Some(slow))), JointResponse::Settings(slow));
    let mut board = board.restarted();
    for request in [JointRequest::Arm, JointRequest::Service] {
        assert_eq!(board.answer(&request), JointResponse::Accepted, "{request:?}");
    }
    let mut last = rest(&mut board);
    for _ in 0..500 {
        board.answer(&JointRequest::Press([3.0, 2.0]));
        last = tick(&mut board, last.dac_codes.map(|code| COMMAND.value(code)), 0.0);
    }
    let reached = last.dac_codes.map(|code| COMMAND.value(code));
    assert!(reached.iter().all(|bar| (0.9..1.05).contains(bar)), "{reached:?} bar after half a second");
    // By the standard line 7.0 bar, which bursts nothing.
    let burst = tick(&mut board, [7.6, 1.0], 0.0);
    assert_eq!(burst.fault, Some(JointFault::OfChannel(Channel::A, Fault::OverpressureHard)));
    assert_eq!(burst.dac_codes, [0; 2]);
}

#[test]
fn a_joint_that_was_kept_is_controlled_as_one_that_was_just_given() {
    let run = |mut board: KeptJoint| {
        let mut last = rest(&mut board);
        for _ in 0..BEGINNING {
            last = rest(&mut board);
        }
        for request in [JointRequest::Arm, JointRequest::Start(40.0)] {
            assert_eq!(board.answer(&request), JointResponse::Accepted, "{request:?}");
        }
        let codes: Vec<[u16; 2]> = (0..6000)
            .map(|_| {
                let target = JointTarget { angle: 0.1, stiffness: 40.0, load: 0.0 };
                let aimed = board.answer(&JointRequest::Aim(Some(JointAim { target, by_tick: 0 })));
                assert!(matches!(aimed, JointResponse::Report(_)));
                // Its pressures and its angle are what they are to be.
                last = tick(&mut board, last.dac_codes.map(|code| COMMAND.value(code)), last.due_rad);
                last.dac_codes
            })
            .collect();
        assert_eq!((last.state, last.fault), (JointBoardState::Starting, None));
        codes
    };
    let (kept, just_given) = (run(given().restarted()), run(given()));
    assert!(kept == just_given);
    assert!(kept.iter().any(|[a, b]| a != b && *a > 0 && *b > 0), "both are driven, each by its own");
}

#[test]
fn a_board_that_starts_with_a_joint_looks_at_itself_gets_ready_and_drives_nothing_until_it_is_told() {
    let mut board = given().restarted();
    assert_eq!(hello(&mut board).state, JointBoardState::Off, "its coil is looked at");
    let orders = [JointRequest::Start(40.0), JointRequest::Service];
    let mut states = Vec::new();
    for tick in 0..3000 {
        // Neither a target nor an order opens a valve of a board that nobody has armed.
        let target = JointTarget { angle: 0.2, stiffness: 40.0, load: 0.0 };
        board.answer(&JointRequest::Aim(Some(JointAim { target, by_tick: 0 })));
        for order in &orders {
            assert_ne!(board.answer(order), JointResponse::Accepted, "{tick}");
        }
        let reply = rest(&mut board);
        assert_eq!((reply.dac_codes, reply.fault), ([0; 2], None), "{tick}");
        states.push(reply.state);
    }
    states.dedup();
    assert_eq!(states, [JointBoardState::Off, JointBoardState::Ready]);
    assert_eq!(board.answer(&JointRequest::Start(40.0)), JointResponse::Refused(Refusal::NotArmed));
}

/// A coil that is held is seen where the dump valve's output rests: as long as that is, in ticks.
#[test]
fn the_dump_valve_stays_open_at_a_start_with_a_joint_until_its_coil_was_looked_at() {
    let mut board = given().restarted();
    let open = (0..BEGINNING).take_while(|_| {
        rest(&mut board);
        !board.board.task().keeps_dump_closed()
    });
    assert!(open.count() as u32 >= u32::from(wire::fault::times::DUMP_TICKS) + 10);
    // And is a fault then, which the joint does not cure.
    let mut board = given().restarted();
    for _ in 0..BEGINNING {
        rest(&mut board);
        firmware::joint::JointNode::task(&mut board, |task| task.hear_coil(true));
    }
    assert_eq!(hello(&mut board).fault, Some(JointFault::OfBoard(Fault::DumpHeld)));
}

#[test]
fn what_only_moves_a_joint_or_only_asks_is_not_stored() {
    let mut board = given();
    let work = board.flash().work();
    for request in [
        JointRequest::Identify,
        JointRequest::Settings(None),
        JointRequest::Installed,
        JointRequest::Control,
        JointRequest::Status,
        JointRequest::Arm,
        JointRequest::Start(40.0),
        JointRequest::Stop,
        JointRequest::Acknowledge,
        // And what is stored already is not written again.
        JointRequest::Settings(Some(settings())),
        configure(control()),
    ] {
        board.answer(&request);
        assert_eq!(board.flash().work(), work, "{request:?}");
    }
}

#[test]
fn what_is_refused_is_not_stored_and_a_driven_joint_refuses_to_be_given_another() {
    let mut board = given();
    let mut slack = control();
    slack.joint.muscles[0].lowest = [f32::NAN; 2];
    assert!(matches!(board.answer(&configure(slack)), JointResponse::Refused(Refusal::Parameter(_))));
    let mut nonsense = settings();
    nonsense.protection.slew_bar_per_s = f32::NAN;
    assert!(matches!(
        board.answer(&JointRequest::Settings(Some(nonsense))),
        JointResponse::Refused(Refusal::Parameter(_))
    ));
    for request in [JointRequest::Arm, JointRequest::Service] {
        assert_eq!(board.answer(&request), JointResponse::Accepted);
    }
    let work = board.flash().work();
    let driven = JointResponse::WrongState(JointBoardState::Service);
    let other = JointSettings { protection: Protection::STANDARD, ..settings() };
    assert_eq!(board.answer(&JointRequest::Settings(Some(other))), driven);
    let mut turned = control();
    turned.turn_rad_per_s = 1.0;
    assert_eq!(board.answer(&configure(turned)), driven);
    assert_eq!(board.flash().work(), work);
    assert_eq!(*board.restarted().parameters(), joint_set());
}

#[test]
fn what_a_flash_does_not_keep_is_in_use_and_whoever_sent_it_is_told() {
    let mut board = new_board();
    board.flash().cut_after(0, Tear::Rising, 0);
    let not_stored = JointResponse::Refused(Refusal::NotStored);
    assert_eq!(board.answer(&JointRequest::Settings(Some(settings()))), not_stored);
    assert_eq!(board.answer(&configure(control())), not_stored);
    assert_eq!(settings_of(&mut board), settings());
    assert_eq!(joint_of(&mut board), Some(fingerprint(&control())));
    let mut board = board.restarted();
    assert_eq!(*board.parameters(), JointParameters::NEW);
    assert_eq!(joint_of(&mut board), None);
    // With power it is stored when it is sent again.
    assert_eq!(board.answer(&configure(control())), JointResponse::Accepted);
    assert_eq!(joint_of(&mut board.restarted()), Some(fingerprint(&control())));
}

#[test]
fn power_lost_at_every_byte_of_a_save_leaves_the_joint_before_or_the_new_one_and_nothing_driven() {
    let mut begun = given();
    let flash = begun.flash().clone();
    let before = begun.flash().work();
    let mut other = control();
    other.pid.ki = 4.0;
    assert_eq!(begun.answer(&configure(other.clone())), JointResponse::Accepted);
    let work = begun.flash().work() - before;
    let (mut olds, mut news) = (0, 0);
    for cut in 0..work {
        for tear in Tear::ALL {
            let mut board = KeptJoint::start(flash.clone());
            board.flash().cut_after(cut, tear, cut as u64);
            let told = board.answer(&configure(other.clone()));
            assert_eq!(told, JointResponse::Refused(Refusal::NotStored), "{tear:?} after {cut}");
            let mut board = board.restarted();
            let joint = joint_of(&mut board);
            assert_eq!(hello(&mut board).fault, None, "{tear:?} after {cut}");
            assert_eq!(settings_of(&mut board), settings());
            olds += usize::from(joint == Some(fingerprint(&control())));
            news += usize::from(joint == Some(fingerprint(&other)));
            for _ in 0..BEGINNING {
                let reply = rest(&mut board);
                assert_eq!((reply.dac_codes, reply.fault), ([0; 2], None));
            }
            assert_eq!(hello(&mut board).state, JointBoardState::Ready);
        }
    }
    assert!(olds > 0 && olds + news == 4 * work, "{olds} and {news} of {work}");
}

#[test]
fn a_flash_that_cannot_be_read_or_is_another_boards_is_a_fault_and_leaves_a_board_without_a_joint() {
    let golden = |name: &str| {
        let file = format!("{}/tests/golden/{name}", env!("CARGO_MANIFEST_DIR"));
        std::fs::read(file).expect("part of the sources")
    };
    for (bytes, fault) in [
        (vec![0; 2 * SECTOR], Fault::ConfigurationCorrupt),
        (vec![0x55; 2 * SECTOR], Fault::ConfigurationCorrupt),
        (flash_with(&paper_set()).bytes().to_vec(), Fault::ConfigurationVersion),
        (golden("store_layout_65535.bin"), Fault::ConfigurationVersion),
    ] {
        let mut board = KeptJoint::start(MockFlash::with(&bytes));
        let joint = joint_of(&mut board);
        let JointHello { state, fault: found, .. } = hello(&mut board);
        assert_eq!((state, found, joint), (JointBoardState::Fault, Some(JointFault::OfBoard(fault)), None));
        for _ in 0..BEGINNING {
            assert_eq!(rest(&mut board).dac_codes, [0; 2]);
        }
        assert_eq!(board.answer(&JointRequest::Acknowledge), JointResponse::Accepted);
        let standard = JointSettings { protection: Protection::STANDARD, calibration: Default::default() };
        assert_eq!(settings_of(&mut board), standard);
        // A board that nobody has told anything is as a new one at its next start.
        let mut board = board.restarted();
        let joint = joint_of(&mut board);
        let JointHello { state, fault: found, .. } = hello(&mut board);
        assert_eq!((state, found, joint), (JointBoardState::Off, None, None));
    }
}

/// A set that a record's checksum is right of, and that no board takes.
fn assert_recalled(set: &JointParameters, fault: Fault) -> KeptJoint {
    let mut board = KeptJoint::start(flash_with(set));
    assert_eq!(hello(&mut board).fault, Some(JointFault::OfBoard(fault)), "{set:?}");
    for _ in 0..BEGINNING {
        assert_eq!(rest(&mut board).dac_codes, [0; 2]);
    }
    board
}

#[test]
fn only_what_is_valid_is_taken_of_what_was_kept() {
    let mut slack = joint_set();
    slack.control.iter_mut().for_each(|control| control.joint.muscles[1].lowest = [9.0, 9.0]);
    let mut board = assert_recalled(&slack, Fault::ConfigurationCorrupt);
    assert_eq!(joint_of(&mut board), None);
    assert_eq!(settings_of(&mut board), settings(), "the other parts are whole");
    assert_eq!(board.answer(&JointRequest::Acknowledge), JointResponse::Accepted);
    assert_eq!(hello(&mut board).state, JointBoardState::Off);

    let mut wild = joint_set();
    wild.protection.slew_bar_per_s = -1.0;
    let mut board = assert_recalled(&wild, Fault::ConfigurationCorrupt);
    assert_eq!(settings_of(&mut board).protection, Protection::STANDARD);
    assert_eq!(joint_of(&mut board), Some(fingerprint(&control())));
    assert_eq!(board.answer(&JointRequest::Acknowledge), JointResponse::Accepted);
    assert_eq!(hello(&mut board).state, JointBoardState::Ready);

    let mut broken = joint_calibration();
    broken.angle.iter_mut().for_each(|line| line.codes_per_unit *= 2.0);
    let broken = JointParameters { calibration: Some(Sealed::new(broken)), ..joint_set() };
    let mut board = assert_recalled(&broken, Fault::CalibrationCorrupt);
    assert_eq!(settings_of(&mut board).calibration, Default::default());
    assert_eq!(settings_of(&mut board).protection, joint_set().protection);
}

/// What is compiled in counts for a board with muscles, whatever it has kept.
#[test]
fn a_limit_above_the_ceiling_or_a_joint_of_another_period_that_was_kept_is_a_fault() {
    let on_board = || {
        let clock = TickClock { period_s: 1e-3, deadline_cycles: 84_000 };
        JointTask::on_board(Protection::STANDARD, clock, Box::leak(Box::new(BlackBox::new())))
    };
    let mut high = joint_set();
    high.protection.overpressure_hard_bar = 9.0;
    let mut slow = joint_set();
    slow.control.iter_mut().for_each(|control| control.period_s = 2e-3);
    for (set, has_joint) in [(high, true), (slow, false)] {
        let mut task = on_board();
        recall(&mut task, &set);
        assert_eq!(task.fault(), Some(JointFault::OfBoard(Fault::ConfigurationCorrupt)));
        let installed = carry_out(&mut task, &JointRequest::Installed);
        assert_eq!(installed == JointResponse::Installed(None), !has_joint, "{installed:?}");
    }
}

#[test]
fn a_calibration_with_any_bit_lost_is_a_fault_and_the_standard_lines_stay() {
    let mut buffer = [0; 64];
    let whole = postcard::to_slice(&Sealed::new(joint_calibration()), &mut buffer).expect("fits").to_vec();
    let mut tried = 0;
    for bit in 0..8 * whole.len() {
        let mut damaged = whole.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        let Ok((sealed, [])) = postcard::take_from_bytes(&damaged) else { continue };
        tried += 1;
        let set = JointParameters { calibration: Some(sealed), ..joint_set() };
        // A line that is no number any more is not stored at all.
        if set != set.clone() {
            continue;
        }
        let mut board = KeptJoint::start(flash_with(&set));
        let found = hello(&mut board).fault;
        assert_eq!(found, Some(JointFault::OfBoard(Fault::CalibrationCorrupt)), "bit {bit}");
        assert_eq!(settings_of(&mut board).calibration, Default::default(), "bit {bit}");
    }
    assert!(tried > 8 * whole.len() * 3 / 4, "{tried} of {} bits", 8 * whole.len());
}

#[test]
fn every_flipped_bit_of_the_newest_record_leads_back_to_the_set_before() {
    let first = flash_with(&numbered(1, joint_set()));
    let begin = first.bytes().iter().rposition(|&byte| byte != 0xFF).expect("written") / 4 * 4 + 4;
    let mut store = ParameterStore::new(first);
    assert_eq!(store.save(State::Ready, &numbered(2, joint_set())), Ok(()));
    let both = store.into_flash().bytes().to_vec();
    // The last word may end in bytes that fill it up, which say nothing.
    let end = both.iter().rposition(|&byte| byte != 0xFF).expect("written") / 4 * 4;
    for bit in begin * 8..end * 8 {
        let mut bytes = both.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        let mut store = ParameterStore::new(MockFlash::<SECTOR>::with(&bytes));
        assert_eq!(store.load(), Ok(numbered(1, joint_set())), "bit {bit}");
    }
}

#[test]
fn a_board_that_starts_at_fault_has_its_joint_and_stays_at_fault_until_it_is_acknowledged() {
    let black_box = Box::leak(Box::new(BlackBox::after(Reset::Watchdog, BlackBox::new())));
    let clock = TickClock { period_s: 1e-3, deadline_cycles: 84_000 };
    let mut task = JointTask::on_board(Protection::STANDARD, clock, black_box);
    let fault = task.fault();
    assert!(fault.is_some());
    recall(&mut task, &joint_set());
    assert_eq!((task.state(), task.fault()), (JointBoardState::Fault, fault));
    assert_eq!(carry_out(&mut task, &JointRequest::Acknowledge), JointResponse::Accepted);
    assert_eq!(task.state(), JointBoardState::Ready);
}
