//! Limits and calibration of a joint's board: what they change, what is refused, and in which
//! words.

use board_models::joint::joint_parameters;
use firmware::joint::lock_step::LockStepJoint;
use firmware::joint::{JointScalings, JointTask, carry_out};
use firmware::scaling::{COMMAND, PRESSURE};
use firmware::{BlackBox, TickClock};
use model_core::joint::JointTarget;
use wire::joint::{
    Channel, JOINT_VERSION, JointBoardState, JointCalibration, JointConfiguration, JointFault, JointRequest,
    JointResponse, JointSettings, JointTickReply, JointTickRequest,
};
use wire::{Fault, Line, Protection, Refusal};

const STANDARD: JointSettings = JointSettings {
    protection: Protection::STANDARD,
    calibration: JointCalibration { pressures: [None; 2], angle: None },
};
/// Lines of sensors that are off as far as working ones may be, each otherwise.
const CALIBRATION: JointCalibration = JointCalibration {
    pressures: [
        Some(Line { zero_code: 430.0, codes_per_unit: 300.0 }),
        Some(Line { zero_code: 380.0, codes_per_unit: 350.0 }),
    ],
    angle: Some(Line { zero_code: 2250.0, codes_per_unit: 1100.0 }),
};

/// A board whose joint is where it is to be, seen by sensors of some lines.
struct Seen {
    board: LockStepJoint,
    by: JointScalings,
    last: JointTickReply,
}

impl Seen {
    fn new(settings: &JointSettings, by: JointScalings) -> Self {
        let mut board = LockStepJoint::new(Protection::STANDARD);
        let set = board.answer(&JointRequest::Settings(Some(*settings)));
        assert_eq!(set, JointResponse::Settings(*settings));
        let last = board.tick();
        Self { board, by, last }
    }

    fn order(&mut self, requests: &[JointRequest]) {
        for request in requests {
            assert_eq!(self.board.answer(request), JointResponse::Accepted, "{request:?}");
        }
    }

    fn tick(&mut self, change: impl FnOnce(&mut JointTickRequest)) -> JointTickReply {
        let commands = self.last.dac_codes.map(|code| COMMAND.value(code));
        let [a, b] = self.by.pressures;
        let mut request = JointTickRequest {
            target: Some(JointTarget { angle: 0.2, stiffness: 40.0, load: 0.0 }),
            pressure_codes: [a.code(commands[0]), b.code(commands[1])],
            angle_code: self.by.angle.code(self.last.due_rad),
        };
        change(&mut request);
        self.board.feed(&request);
        self.last = self.board.tick();
        self.last
    }

    /// Presses both until something vents, at most so long. Unit: tick.
    fn pressed(&mut self, pressures: [f32; 2], ticks: u32) -> Option<(u32, JointFault)> {
        (1..=ticks).find_map(|tick| {
            self.board.answer(&JointRequest::Press(pressures));
            self.tick(|samples| samples.target = None).fault.map(|fault| (tick, fault))
        })
    }
}

fn served(settings: &JointSettings) -> Seen {
    let mut joint = Seen::new(settings, JointScalings::STANDARD);
    joint.order(&[JointRequest::Arm, JointRequest::Service]);
    joint
}

fn limited(change: impl FnOnce(&mut Protection)) -> JointSettings {
    let mut settings = STANDARD;
    change(&mut settings.protection);
    settings
}

fn configure() -> JointRequest {
    JointRequest::Configure(JointConfiguration { version: JOINT_VERSION, control: joint_parameters() })
}

#[test]
fn limits_act_until_others_are_given_and_behind_a_configuration_too() {
    let soft = limited(|protection| protection.overpressure_soft_bar = 4.0);
    let mut joint = served(&soft);
    let refused = joint.board.answer(&JointRequest::Press([4.1, 2.0]));
    assert!(matches!(refused, JointResponse::Refused(Refusal::Parameter(_))), "{refused:?}");
    assert_eq!(joint.pressed([3.9, 2.0], 1000), None);
    let high = (0..200_u16).find_map(|tick| {
        joint.board.answer(&JointRequest::Press([3.9, 2.0]));
        let bar = (3.9 + 0.1 * f32::from(tick)).min(4.2);
        joint.tick(|samples| samples.pressure_codes[0] = PRESSURE.code(bar)).fault
    });
    assert_eq!(high, Some(JointFault::OfChannel(Channel::A, Fault::OverpressureSoft)));

    let patient = limited(|protection| protection.bus_silent_ticks = 40);
    let mut joint = served(&patient);
    let silent = (1..100).find(|_| joint.tick(|samples| samples.target = None).fault.is_some());
    assert_eq!((silent, joint.last.fault), (Some(41), Some(JointFault::OfBoard(Fault::BusSilent))));

    let slow = limited(|protection| protection.soft_start_bar_per_s = 2.0);
    let mut joint = Seen::new(&slow, JointScalings::STANDARD);
    joint.order(&[configure(), JointRequest::Arm, JointRequest::Start(40.0)]);
    for _ in 0..500 {
        joint.tick(|_| ());
    }
    let [a, b] = joint.last.dac_codes.map(|code| COMMAND.value(code));
    assert!((0.9..1.01).contains(&a) && (0.9..1.01).contains(&b), "{a} and {b} bar after half a second");

    // Those before are gone with others.
    let mut joint = Seen::new(&soft, JointScalings::STANDARD);
    joint.board.answer(&JointRequest::Settings(Some(STANDARD)));
    joint.order(&[JointRequest::Arm, JointRequest::Service]);
    assert_eq!(joint.pressed([6.0, 2.0], 1000), None);
}

#[test]
fn a_joint_seen_by_calibrated_sensors_starts_tracks_and_is_watched_by_them() {
    let calibrated = JointSettings { calibration: CALIBRATION, ..STANDARD };
    let by = JointScalings::calibrated(&CALIBRATION).expect("working sensors");
    let mut joint = Seen::new(&calibrated, by);
    match joint.board.answer(&JointRequest::Identify) {
        JointResponse::Hello(hello) => {
            assert_eq!((hello.pressures, hello.angle), (by.pressures, by.angle));
            assert_eq!(hello.pressures.map(|scaling| scaling.codes_per_unit), [300.0, 350.0]);
            assert_eq!((hello.angle.zero_code, hello.angle.codes_per_unit), (2250.0, 1100.0));
        }
        other => panic!("{other:?}"),
    }
    joint.order(&[configure(), JointRequest::Arm, JointRequest::Start(40.0)]);
    for _ in 0..12_000 {
        joint.tick(|_| ());
    }
    assert_eq!((joint.last.state, joint.last.fault), (JointBoardState::Tracking, None));
    assert!(joint.last.feedback_nm.abs() < 0.2, "{:?}", joint.last);
    // What bursts is seen by its own line: 7.6 bar, which the standard one takes for 7.0 and 8.0.
    for (place, channel) in Channel::BOTH.into_iter().enumerate() {
        for (bar, is_burst) in [(7.6, true), (7.4, false)] {
            let mut joint = Seen::new(&calibrated, by);
            joint.order(&[JointRequest::Arm, JointRequest::Service]);
            joint.tick(|_| ());
            let code = by.pressures[place].code(bar);
            let fault = joint.tick(|samples| samples.pressure_codes[place] = code).fault;
            let burst = JointFault::OfChannel(channel, Fault::OverpressureHard);
            assert_eq!(fault, is_burst.then_some(burst), "{channel}: {bar} bar");
        }
    }
    // By the standard lines the same joint is another one.
    let mut joint = Seen::new(&STANDARD, by);
    joint.order(&[configure(), JointRequest::Arm, JointRequest::Start(40.0)]);
    let fault = (0..12_000).find_map(|_| joint.tick(|_| ()).fault).expect("it is seen");
    assert!(matches!(fault, JointFault::Another(_) | JointFault::OfChannel(..)), "{fault}");
}

/// A real board's task: its ticks have a clock.
fn on_board() -> JointTask {
    let clock = TickClock { period_s: 1e-3, deadline_cycles: 84_000 };
    JointTask::on_board(Protection::STANDARD, clock, Box::leak(Box::new(BlackBox::new())))
}

#[test]
fn what_no_muscle_and_no_working_sensor_has_is_refused_in_words_and_changes_nothing() {
    let line = |zero_code, codes_per_unit| Some(Line { zero_code, codes_per_unit });
    let calibrated = |change: &dyn Fn(&mut JointCalibration)| {
        let mut settings = limited(|protection| protection.supply_min_bar = 3.0);
        change(&mut settings.calibration);
        settings
    };
    let refusals = [
        (
            limited(|protection| protection.overpressure_hard_bar = 9.0),
            "overpressure_hard_bar is 9, must be 0 to 8.5",
        ),
        (limited(|protection| protection.authority_bar = f32::INFINITY), "authority_bar is inf"),
        (limited(|protection| protection.slew_bar_per_s = f32::NAN), "slew_bar_per_s is NaN"),
        (calibrated(&|calibration| calibration.pressures[0] = line(409.5, 500.0)), "pressure a: 1.526251"),
        (
            calibrated(&|calibration| calibration.pressures[1] = line(900.0, 327.6)),
            "pressure b: its zero is off",
        ),
        (calibrated(&|calibration| calibration.angle = line(2047.5, -1173.0)), "angle: -1 times"),
        (calibrated(&|calibration| calibration.angle = line(f32::NAN, 1173.0)), "angle: its zero is off"),
    ];
    for (settings, words) in refusals {
        let mut board = on_board();
        match carry_out(&mut board, &JointRequest::Settings(Some(settings))) {
            JointResponse::Refused(Refusal::Parameter(said)) => assert!(said.contains(words), "{said}"),
            other => panic!("{words}: {other:?}"),
        }
        let kept = carry_out(&mut board, &JointRequest::Settings(None));
        assert_eq!(kept, JointResponse::Settings(STANDARD), "{words}");
    }
    // A simulation has no ceilings, but its limits are numbers.
    let mut board = LockStepJoint::new(Protection::STANDARD);
    let [(wide, _), _, (nonsense, _), ..] = refusals;
    assert_eq!(board.answer(&JointRequest::Settings(Some(wide))), JointResponse::Settings(wide));
    assert!(matches!(board.answer(&JointRequest::Settings(Some(nonsense))), JointResponse::Refused(_)));
}

#[test]
fn nothing_is_set_while_a_valve_is_driven_or_at_fault_and_an_arming_is_for_what_was_set() {
    let other = limited(|protection| protection.supply_min_bar = 3.0);
    let set = JointRequest::Settings(Some(other));
    let mut joint = served(&STANDARD);
    assert_eq!(joint.board.answer(&set), JointResponse::WrongState(JointBoardState::Service));
    assert!((0..600).any(|_| joint.tick(|samples| samples.angle_code = 0).fault.is_some()));
    assert_eq!(joint.board.answer(&set), JointResponse::WrongState(JointBoardState::Fault));
    assert_eq!(joint.board.answer(&JointRequest::Settings(None)), JointResponse::Settings(STANDARD));
    joint.order(&[JointRequest::Acknowledge, JointRequest::Arm]);
    assert_eq!(joint.board.answer(&set), JointResponse::Settings(other));
    assert_eq!(joint.board.answer(&JointRequest::Service), JointResponse::Refused(Refusal::NotArmed));
}
