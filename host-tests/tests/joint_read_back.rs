//! What a joint's board has been told is read back bit by bit, in every state, and costs a joint
//! that is driven nothing; what it says of itself.

use board_models::joint::joint_parameters;
use firmware::faults::black_box::Reset;
use firmware::joint::lock_step::LockStepJoint;
use firmware::joint::{JointBoard, JointNode, JointSamples, JointScalings, JointTask, carry_out, recall};
use firmware::scaling::{COMMAND, REFERENCE_CODE, SUPPLY, TEMPERATURE};
use firmware::store::{JointParameters, ParameterStore, Sealed};
use firmware::timing::TickEnd;
use firmware::{AcquisitionError, AdcCode, BlackBox, DacCode, TickClock};
use host_tests::flash::MockFlash;
use host_tests::kept_joint::{KeptJoint, SECTOR};
use host_tests::store::{joint_calibration, joint_set};
use model_core::joint::{JointTarget, PullParameters};
use wire::joint::{
    BoardJointParameters, JOINT_VERSION, JointAim, JointBoardState, JointConfiguration, JointFault,
    JointRequest, JointResponse, JointSettings, JointStatus, JointTickRequest, JointTiming,
};
use wire::{FRAME_BYTES, Fault, Protection, Receiver, Refusal, State, fingerprint};

/// More ticks than a board looks at its dump valve's coil for.
const BEGINNING: u32 = 100;
/// Whatever only asks.
const QUESTIONS: [JointRequest; 6] = [
    JointRequest::Identify,
    JointRequest::Aim(None),
    JointRequest::Settings(None),
    JointRequest::Installed,
    JointRequest::Control,
    JointRequest::Status,
];

fn settings() -> JointSettings {
    JointSettings { protection: joint_set().protection, calibration: joint_calibration() }
}

/// A joint whose numbers are none that a decimal fraction would be.
fn control() -> BoardJointParameters {
    let mut control = joint_set().control.expect("a joint");
    let odd = |number: &mut f32| *number = f32::from_bits(number.to_bits() | 1);
    let joint = &mut control.joint;
    for muscle in &mut joint.muscles {
        let PullParameters { arm, knee, friction, slip, lowest, highest, valve_lag_s } = muscle;
        arm.iter_mut().chain([knee, valve_lag_s]).for_each(odd);
        friction.iter_mut().chain(slip).chain(lowest).chain(highest).for_each(odd);
    }
    joint.passive.iter_mut().chain([&mut joint.viscosity, &mut joint.swing]).for_each(odd);
    joint.reaches.iter_mut().for_each(odd);
    [&mut control.pid.kp, &mut control.pid.ki, &mut control.turn_rad_per_s].into_iter().for_each(odd);
    control
}

fn configure(control: BoardJointParameters) -> JointRequest {
    JointRequest::Configure(JointConfiguration { version: JOINT_VERSION, control })
}

/// A board that was given both.
fn given() -> KeptJoint {
    let mut board = KeptJoint::start(MockFlash::blank());
    assert!(matches!(board.answer(&JointRequest::Settings(Some(settings()))), JointResponse::Settings(_)));
    assert_eq!(board.answer(&configure(control())), JointResponse::Accepted);
    board
}

/// The joint as it comes out of the frame of the answer.
fn read_back(board: &mut KeptJoint) -> Option<BoardJointParameters> {
    let mut buffer = [0; FRAME_BYTES];
    let answer = board.answer(&JointRequest::Control);
    let frame = wire::encode(&answer, &mut buffer).expect("a frame holds the largest joint");
    let mut receiver = Receiver::new();
    let received = frame.iter().find_map(|byte| receiver.push::<JointResponse>(*byte));
    match received {
        Some(Ok(JointResponse::Control(control))) => control,
        other => panic!("{other:?}"),
    }
}

fn assert_reads_back(board: &mut KeptJoint, state: JointBoardState) {
    assert_eq!(board.board.task().state(), state);
    let told = read_back(board).expect("a joint");
    assert_eq!(told, control());
    assert_eq!(fingerprint(&told), fingerprint(&control()), "{state:?}: bit by bit");
    assert_eq!(board.answer(&JointRequest::Settings(None)), JointResponse::Settings(settings()));
    assert_eq!(board.board.task().state(), state, "asking changes no state");
}

/// A tick of a joint at these pressures (bar) and this angle (rad), as sensors of the calibration
/// see it.
fn tick(board: &mut KeptJoint, pressures: [f32; 2], angle: f32) -> ([u16; 2], f32) {
    let by = JointScalings::calibrated(&joint_calibration()).expect("working sensors");
    let [of_a, of_b] = by.pressures;
    let [a, b] = pressures;
    board.board.feed(&JointTickRequest {
        target: None,
        pressure_codes: [of_a.code(a), of_b.code(b)],
        angle_code: by.angle.code(angle),
    });
    let reply = board.board.tick();
    (reply.dac_codes, reply.due_rad)
}

#[test]
fn a_joint_and_its_settings_are_read_back_bit_by_bit_in_every_state_and_behind_a_restart() {
    let mut board = KeptJoint::start(MockFlash::blank());
    assert_eq!(read_back(&mut board), None, "a new board has no joint");
    let mut board = given();
    assert_reads_back(&mut board, JointBoardState::Ready);
    let mut board = board.restarted();
    assert_reads_back(&mut board, JointBoardState::Off);
    (0..BEGINNING).for_each(|_| _ = tick(&mut board, [0.0; 2], 0.0));
    for (order, state) in [
        (JointRequest::Service, JointBoardState::Service),
        (JointRequest::Start(40.0), JointBoardState::Starting),
    ] {
        for request in [JointRequest::Arm, order] {
            assert_eq!(board.answer(&request), JointResponse::Accepted, "{request:?}");
        }
        assert_reads_back(&mut board, state);
        assert_eq!(board.answer(&JointRequest::Stop), JointResponse::Accepted);
    }
    JointNode::task(&mut board, |task| task.report_of_board(Fault::EmergencyStop));
    assert_reads_back(&mut board, JointBoardState::Fault);
}

#[test]
fn a_board_in_lock_step_reads_back_what_it_has_until_power_is_lost() {
    let mut board = LockStepJoint::new(Protection::SIMULATED);
    assert_eq!(board.answer(&JointRequest::Control), JointResponse::Control(None));
    assert_eq!(board.answer(&configure(control())), JointResponse::Accepted);
    board.answer(&JointRequest::Settings(Some(settings())));
    assert_eq!(board.answer(&JointRequest::Control), JointResponse::Control(Some(control())));
    assert_eq!(board.answer(&configure(joint_parameters())), JointResponse::Accepted);
    let refused = BoardJointParameters { period_s: 0.0, ..control() };
    assert!(matches!(board.answer(&configure(refused)), JointResponse::Refused(_)));
    assert_eq!(board.answer(&JointRequest::Control), JointResponse::Control(Some(joint_parameters())));
}

/// One board is asked all questions each tick, and so is not the other.
#[test]
fn reading_back_changes_no_tick_of_a_joint_that_is_driven_and_is_no_sign_of_life() {
    let run = |questions: &[JointRequest]| {
        let mut board = given();
        (0..BEGINNING).for_each(|_| _ = tick(&mut board, [0.0; 2], 0.0));
        for request in [JointRequest::Arm, JointRequest::Start(40.0)] {
            assert_eq!(board.answer(&request), JointResponse::Accepted, "{request:?}");
        }
        let (mut ticks, mut last) = (Vec::new(), ([0; 2], 0.0));
        for number in 0..16_000 {
            if number < 14_000 {
                let target = JointTarget { angle: 0.1, stiffness: 40.0, load: 0.0 };
                board.answer(&JointRequest::Aim(Some(JointAim { target, by_tick: 0 })));
            }
            for question in questions {
                let answer = board.answer(question);
                assert!(
                    !matches!(answer, JointResponse::Refused(_) | JointResponse::WrongState(_)),
                    "{answer:?}"
                );
            }
            last = tick(&mut board, last.0.map(|code| COMMAND.value(code)), last.1);
            ticks.push((last, board.board.task().state(), board.board.task().fault()));
        }
        ticks
    };
    let asked = run(&QUESTIONS);
    assert!(asked == run(&[]), "a tick is another one");
    let states: Vec<JointBoardState> = asked.iter().map(|(_, state, _)| *state).collect();
    let of = |state| states.iter().filter(|is| **is == state).count();
    assert!(of(JointBoardState::Tracking) > 1000, "it has tracked");
    let silent = asked.iter().position(|(.., fault)| fault.is_some()).expect("its host is silent");
    assert_eq!(asked[silent].2, Some(JointFault::OfBoard(Fault::BusSilent)));
    let patience = joint_set().protection.bus_silent_ticks as usize;
    assert_eq!(silent, 13_999 + patience, "so long behind the last target");
    assert!(of(JointBoardState::Fault) == 16_000 - silent);
}

/// A joint that its board refuses at a start is not told: nothing runs it.
#[test]
fn a_joint_that_is_not_the_one_that_runs_is_not_told() {
    let mut slack = joint_set();
    slack.control.iter_mut().for_each(|control| control.joint.muscles[0].lowest = [-1.0; 2]);
    let mut store = ParameterStore::new(MockFlash::<SECTOR>::blank());
    assert_eq!(store.save(State::Ready, &slack), Ok(()));
    let mut board = KeptJoint::start(store.into_flash());
    assert_eq!(board.board.task().fault(), Some(JointFault::OfBoard(Fault::ConfigurationCorrupt)));
    assert!(board.parameters().control.is_some());
    assert_eq!(read_back(&mut board), None);

    // A bit that is lost behind the start: what is kept is not what runs.
    struct Lost(KeptJoint, BoardJointParameters);
    impl JointNode for Lost {
        fn task<R>(&mut self, work: impl FnOnce(&mut JointTask) -> R) -> R {
            JointNode::task(&mut self.0, work)
        }
        fn keep(&mut self, request: &JointRequest) -> Result<(), firmware::store::SaveError> {
            self.0.keep(request)
        }
        fn control(&self) -> Option<&BoardJointParameters> {
            Some(&self.1)
        }
    }
    let not_here = JointResponse::Refused(Refusal::NotHere);
    let mut lost = Lost(given(), control());
    assert_eq!(carry_out(&mut lost, &JointRequest::Control), JointResponse::Control(Some(control())));
    lost.1.joint.passive[3] = -lost.1.joint.passive[3];
    assert_eq!(carry_out(&mut lost, &JointRequest::Control), not_here);

    // Nor is one that nobody has kept.
    let clock = TickClock { period_s: 1e-3, deadline_cycles: 84_000 };
    let mut task = JointTask::on_board(Protection::STANDARD, clock, Box::leak(Box::new(BlackBox::new())));
    assert_eq!(carry_out(&mut task, &JointRequest::Control), JointResponse::Control(None));
    recall(&mut task, &joint_set());
    assert_eq!(carry_out(&mut task, &JointRequest::Control), not_here);
}

/// Converters of a board.
struct Converters(JointSamples);

impl JointBoard for Converters {
    fn read(&mut self) -> Result<JointSamples, AcquisitionError> {
        Ok(self.0)
    }

    fn drive(&mut self, _: [DacCode; 2]) {}
}

fn status(node: &mut impl JointNode) -> JointStatus {
    match carry_out(node, &JointRequest::Status) {
        JointResponse::Status(status) => status,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_board_says_what_it_reads_of_itself() {
    let clock = TickClock { period_s: 1e-3, deadline_cycles: 84_000 };
    let black_box = Box::leak(Box::new(BlackBox::after(Reset::Watchdog, BlackBox::new())));
    let mut task = JointTask::on_board(Protection::STANDARD, clock, black_box);
    task.note(Fault::Clock);
    let calibration = Some(Sealed::new(joint_calibration()));
    recall(&mut task, &JointParameters { calibration, control: Some(joint_parameters()), ..joint_set() });
    let mut converters = Converters(JointSamples {
        pressures: [AdcCode(700), AdcCode(800)],
        angle: AdcCode(2100),
        supply: AdcCode(SUPPLY.code(7.5)),
        temperature: AdcCode(TEMPERATURE.code(42.0)),
        outputs: Some([AdcCode(0), AdcCode(2)]),
        reference: Some(AdcCode((REFERENCE_CODE * 3.3 / 3.2).round() as u16)),
    });
    let tick = |task: &mut JointTask, converters: &mut Converters, elapsed_cycles, is_overrun| {
        task.tick(converters);
        task.close_tick(TickEnd { elapsed_cycles, is_overrun });
    };
    (0..3000).for_each(|_| tick(&mut task, &mut converters, 4000, false));
    tick(&mut task, &mut converters, 9000, false);
    tick(&mut task, &mut converters, 90_000, true);
    let told = status(&mut task);
    let JointStatus { report, supply_bar, temperature_c, outputs_v, converters_supply_v, timing, resets } =
        told;
    assert_eq!(JointResponse::Report(report), carry_out(&mut task, &JointRequest::Aim(None)));
    assert_eq!((report.ticks, report.angle_code, report.late_ticks), (3002, 2100, 1));
    assert_eq!((report.pressure_codes, report.noted), ([700, 800], Some(Fault::Clock)));
    assert_eq!(report.tick.fault, task.fault());
    assert!((supply_bar - 7.5).abs() < 2e-3 && (temperature_c - 42.0).abs() < 0.2, "{told:?}");
    let supply_v = converters_supply_v.expect("it has a reference");
    let [a, b] = outputs_v.expect("it reads them back");
    assert!((supply_v - 3.2).abs() < 2e-3 && a == 0.0, "{told:?}");
    assert!((b - 2.0 / 4095.0 * 3.2).abs() < 1e-5, "{told:?}");
    let JointTiming { worst_cycles, mean_cycles, deadline_cycles, overruns } =
        timing.expect("it has a clock");
    assert_eq!((worst_cycles, deadline_cycles, overruns, resets), (90_000, 84_000, 1, 1));
    assert!((4000..4400).contains(&mean_cycles), "{mean_cycles}");

    // What a board does not have it does not say.
    converters.0.reference = None;
    tick(&mut task, &mut converters, 4000, false);
    assert_eq!((status(&mut task).outputs_v, status(&mut task).converters_supply_v), (None, None));
    let mut board = given();
    let told = status(&mut board);
    assert_eq!((told.timing, told.outputs_v, told.converters_supply_v, told.resets), (None, None, None, 0));
}
