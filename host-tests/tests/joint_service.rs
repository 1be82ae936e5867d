//! A joint whose pressures come from the host, without a model: what starts it, what it does, and
//! what vents it. The plant is one that does what it is told.

use board_models::joint::joint_parameters;
use firmware::joint::ANGLE;
use firmware::joint::lock_step::LockStepJoint;
use firmware::scaling::{COMMAND, PRESSURE};
use model_core::joint::JointTarget;
use wire::joint::{
    Channel, JOINT_VERSION, JointAim, JointBoardState, JointConfiguration, JointFault, JointReport,
    JointRequest, JointResponse, JointTickReply, JointTickRequest,
};
use wire::registers::ARMED_TICKS;
use wire::{Fault, Protection, Refusal};

/// Pressures that the host asks for. Unit: bar.
const PRESSURES: [f32; 2] = [3.0, 2.0];
/// How long a host may be silent. Unit: tick.
const PATIENCE: u32 = Protection::STANDARD.bus_silent_ticks;
/// The standard limits: the mean of a muscle's pressure vents above it. Unit: bar.
const HIGHEST_BAR: f32 = 6.6;

/// A board whose pressures are what it puts out.
struct Filled {
    board: LockStepJoint,
    last: JointTickReply,
}

impl Filled {
    /// Vented, without a joint.
    fn off() -> Self {
        let mut board = LockStepJoint::new(Protection::STANDARD);
        let last = board.tick();
        Self { board, last }
    }

    /// In service, its pressures at what is asked for.
    fn served() -> Self {
        let mut joint = Self::off();
        assert_eq!(joint.order(&JointRequest::Arm), JointResponse::Accepted);
        assert_eq!(joint.order(&JointRequest::Service), JointResponse::Accepted);
        for _ in 0..600 {
            joint.press(PRESSURES);
            joint.tick(|_| ());
        }
        assert_eq!((joint.last.state, joint.last.fault), (JointBoardState::Service, None));
        joint
    }

    fn order(&mut self, request: &JointRequest) -> JointResponse {
        self.board.answer(request)
    }

    fn press(&mut self, pressures: [f32; 2]) -> JointReport {
        match self.order(&JointRequest::Press(pressures)) {
            JointResponse::Report(report) => report,
            other => panic!("{other:?}"),
        }
    }

    fn tick(&mut self, change: impl FnOnce(&mut JointTickRequest)) -> JointTickReply {
        let mut request = JointTickRequest {
            target: None,
            pressure_codes: self.last.dac_codes.map(|code| PRESSURE.code(COMMAND.value(code))),
            angle_code: ANGLE.code(0.1),
        };
        change(&mut request);
        self.board.feed(&request);
        self.last = self.board.tick();
        self.last
    }

    /// In which tick with these samples, and a host that goes on, both are vented, and by what.
    fn vented_by(&mut self, change: impl Fn(u32, &mut JointTickRequest)) -> (u32, JointFault) {
        for tick in 1..=10_000 {
            self.order(&JointRequest::Press(PRESSURES));
            let reply = self.tick(|request| change(tick, request));
            if let Some(fault) = reply.fault {
                assert_eq!((reply.dac_codes, reply.state), ([0; 2], JointBoardState::Fault), "{fault}");
                return (tick, fault);
            }
        }
        panic!("nothing has vented the joint: {:?}", self.last);
    }
}

#[test]
fn both_pressures_are_the_hosts_without_a_joint_behind_two_steps_and_begin_at_none() {
    let mut joint = Filled::off();
    let off = JointResponse::WrongState(JointBoardState::Off);
    assert_eq!(joint.order(&JointRequest::Press(PRESSURES)), off);
    assert_eq!(joint.order(&JointRequest::Service), JointResponse::Refused(Refusal::NotArmed));
    assert_eq!(joint.order(&JointRequest::Arm), JointResponse::Accepted);
    for _ in 0..ARMED_TICKS {
        assert_eq!(joint.tick(|_| ()).dac_codes, [0; 2]);
    }
    assert_eq!(joint.order(&JointRequest::Service), JointResponse::Refused(Refusal::NotArmed), "too late");
    assert_eq!(joint.order(&JointRequest::Arm), JointResponse::Accepted);
    assert_eq!(joint.order(&JointRequest::Service), JointResponse::Accepted);
    // An arming is for one start.
    assert_eq!(joint.order(&JointRequest::Stop), JointResponse::Accepted);
    assert_eq!(joint.order(&JointRequest::Service), JointResponse::Refused(Refusal::NotArmed));
    assert_eq!(joint.order(&JointRequest::Arm), JointResponse::Accepted);
    assert_eq!(joint.order(&JointRequest::Service), JointResponse::Accepted);
    assert!(joint.board.task().keeps_dump_closed());
    let mut last = [0; 2];
    for _ in 0..400 {
        joint.press(PRESSURES);
        let codes = joint.tick(|_| ()).dac_codes;
        // As fast as a soft start, 10 bar/s.
        assert!(codes.iter().zip(last).all(|(code, last)| code.abs_diff(last) <= 5), "{last:?} to {codes:?}");
        last = codes;
    }
    assert_eq!(last, PRESSURES.map(|bar| COMMAND.code(bar)));
    let report = joint.press([2.0, 3.0]);
    assert_eq!(report.tick, joint.last, "the last tick answers");
    joint.tick(|_| ());
    assert_eq!(joint.order(&JointRequest::Stop), JointResponse::Accepted);
    let reply = joint.tick(|_| ());
    assert_eq!((reply.state, reply.dac_codes), (JointBoardState::Off, [0; 2]));
    assert!(!joint.board.task().keeps_dump_closed());
}

#[test]
fn what_asks_for_too_much_is_refused_changes_nothing_and_is_no_sign_of_life() {
    let mut joint = Filled::served();
    let codes = joint.last.dac_codes;
    for pressures in [[HIGHEST_BAR + 0.01, 2.0], [3.0, HIGHEST_BAR + 0.01], [-0.01, 2.0], [3.0, -0.01]] {
        let refused = joint.order(&JointRequest::Press(pressures));
        assert!(matches!(refused, JointResponse::Refused(Refusal::Parameter(_))), "{refused:?}");
        assert_eq!(joint.tick(|_| ()).dac_codes, codes);
    }
    joint.press([HIGHEST_BAR, 0.0]);
    let mut joint = Filled::served();
    let mut ticks = 1;
    while {
        joint.order(&JointRequest::Press([9.0; 2]));
        joint.tick(|_| ()).fault.is_none()
    } {
        ticks += 1;
        assert!(ticks <= PATIENCE, "it is a sign of life");
    }
    // The last one was before the tick in which silence began.
    assert_eq!(ticks, PATIENCE);
    assert_eq!(joint.last.fault, Some(JointFault::OfBoard(Fault::BusSilent)));
    for nonsense in [[f32::NAN, 2.0], [3.0, f32::INFINITY]] {
        let mut joint = Filled::served();
        assert_eq!(joint.press(nonsense).tick.fault, Some(JointFault::OfBoard(Fault::Reference)));
        assert_eq!(joint.tick(|_| ()).dac_codes, [0; 2]);
    }
}

#[test]
fn a_silent_host_vents_and_neither_questions_nor_targets_are_signs_of_life() {
    let target = JointTarget { angle: 0.0, stiffness: 40.0, load: 0.0 };
    let aim = JointRequest::Aim(Some(JointAim { target, by_tick: 0 }));
    for request in [None, Some(JointRequest::Aim(None)), Some(JointRequest::Identify), Some(aim)] {
        let mut joint = Filled::served();
        let mut ticks = 0;
        while joint.tick(|_| ()).fault.is_none() {
            request.iter().for_each(|request| drop(joint.order(request)));
            ticks += 1;
            assert!(ticks <= PATIENCE, "{request:?} keeps it driven");
        }
        let reply = joint.last;
        assert_eq!((reply.fault, reply.dac_codes), (Some(JointFault::OfBoard(Fault::BusSilent)), [0; 2]));
    }
}

#[test]
fn pressures_are_no_sign_of_life_for_a_joint_that_is_controlled() {
    let mut joint = Filled::off();
    let configuration = JointConfiguration { version: JOINT_VERSION, control: joint_parameters() };
    for order in [JointRequest::Configure(configuration), JointRequest::Arm, JointRequest::Start(40.0)] {
        assert_eq!(joint.order(&order), JointResponse::Accepted);
    }
    let starting = JointResponse::WrongState(JointBoardState::Starting);
    let mut ticks = 0;
    while joint.tick(|_| ()).fault.is_none() {
        assert_eq!(joint.order(&JointRequest::Press(PRESSURES)), starting);
        ticks += 1;
        assert!(ticks <= PATIENCE, "they are a sign of life");
    }
    assert_eq!(ticks, PATIENCE);
    assert_eq!(joint.last.fault, Some(JointFault::OfBoard(Fault::BusSilent)));
}

#[test]
fn what_is_watched_while_tracking_is_watched_and_vents_both() {
    for (place, channel) in Channel::BOTH.into_iter().enumerate() {
        let of = |fault| JointFault::OfChannel(channel, fault);
        let vented = |change: &dyn Fn(u32, &mut JointTickRequest)| Filled::served().vented_by(change);
        assert_eq!(vented(&|_, samples| samples.pressure_codes[place] = 0), (3, of(Fault::PressureSensor)));
        let burst = PRESSURE.code(Protection::STANDARD.overpressure_hard_bar + 0.1);
        let burst = vented(&|_, samples| samples.pressure_codes[place] = burst);
        assert_eq!(burst, (1, of(Fault::OverpressureHard)));
        let spikes = vented(&|tick, samples| {
            samples.pressure_codes[place] = PRESSURE.code(if tick % 2 == 0 { 0.2 } else { 5.8 });
        });
        assert_eq!(spikes.1, of(Fault::PressureSpiking));
        // The valve lets no air in, from the begin on.
        let mut joint = Filled::off();
        for order in [JointRequest::Arm, JointRequest::Service] {
            assert_eq!(joint.order(&order), JointResponse::Accepted);
        }
        let stuck = joint.vented_by(|tick, samples| {
            samples.pressure_codes[place] = PRESSURE.code(0.0) + 6 * (tick % 2) as u16;
        });
        assert_eq!(stuck.1, of(Fault::ValveStuck), "after {} ticks", stuck.0);
        // With a sensor that never moves it is not known which of both is stuck.
        let mut joint = Filled::off();
        for order in [JointRequest::Arm, JointRequest::Service] {
            assert_eq!(joint.order(&order), JointResponse::Accepted);
        }
        let stuck = joint.vented_by(|_, samples| samples.pressure_codes[place] = PRESSURE.code(0.0));
        assert_eq!(stuck.1, of(Fault::PressureStuck), "after {} ticks", stuck.0);
        let mean = vented(&|tick, samples| {
            let from = PRESSURE.value(samples.pressure_codes[place]);
            samples.pressure_codes[place] = PRESSURE.code((from + 0.4 * tick as f32).min(6.9));
            samples.angle_code += 6 * (tick % 2) as u16;
        });
        assert_eq!(mean.1, of(Fault::OverpressureSoft));
    }
    assert_eq!(Filled::served().vented_by(|_, samples| samples.angle_code = 0), (3, JointFault::AngleSensor));
    let spikes = Filled::served()
        .vented_by(|tick, samples| samples.angle_code = ANGLE.code(if tick % 2 == 0 { -0.4 } else { 0.4 }));
    assert_eq!(spikes.1, JointFault::AngleSpiking);
}

#[test]
fn an_angle_that_stands_still_while_the_muscles_change_sides_vents_both() {
    let mut joint = Filled::served();
    let mut play = |plays: &[[f32; 2]], angle: &dyn Fn(f32) -> f32| {
        for pressures in plays {
            for _ in 0..600 {
                joint.press(*pressures);
                let [a, b] = joint.last.dac_codes.map(|code| COMMAND.value(code));
                joint.tick(|samples| samples.angle_code = ANGLE.code(angle(a - b)));
                if joint.last.fault.is_some() {
                    return joint.last.fault;
                }
            }
        }
        None
    };
    // At its end, for as long as the same muscle is the stronger one, and whatever both have.
    assert_eq!(play(&[[4.5, 1.0], [3.0, 2.0], [6.0, 1.0], [3.1, 3.0], [2.0, 2.5]], &|_| 0.1), None);
    // Turned by some degrees.
    assert_eq!(play(&[[4.5, 1.0], [1.0, 4.5], [4.5, 1.0]], &|difference| 0.1 + 0.02 * difference), None);
    assert_eq!(play(&[[4.5, 1.0], [1.0, 4.5]], &|_| 0.1), Some(JointFault::AngleStuck));
    assert_eq!(joint.last.dac_codes, [0; 2]);
    // What was before a fault is forgotten.
    for order in [JointRequest::Acknowledge, JointRequest::Arm, JointRequest::Service] {
        assert_eq!(joint.order(&order), JointResponse::Accepted);
    }
    for _ in 0..600 {
        joint.press([1.0, 4.5]);
        assert_eq!(joint.tick(|_| ()).fault, None);
    }
}

#[test]
fn a_muscle_that_stays_full_behind_a_service_is_seen_without_a_joint_too() {
    let mut joint = Filled::served();
    let [a, b] = PRESSURES;
    assert_eq!(joint.order(&JointRequest::Stop), JointResponse::Accepted);
    let mut ticks = 0;
    let sinking = |ticks: u16| a * (-0.01 * f32::from(ticks)).exp();
    while joint
        .tick(|samples| samples.pressure_codes = [sinking(ticks), b].map(|bar| PRESSURE.code(bar)))
        .fault
        .is_none()
    {
        ticks += 1;
        assert!(ticks < 700, "nobody sees it");
    }
    assert_eq!(joint.last.fault, Some(JointFault::OfChannel(Channel::B, Fault::VentIneffective)));
}

#[test]
fn a_fault_is_latched_and_no_order_opens_a_valve_until_it_is_acknowledged() {
    let mut joint = Filled::served();
    joint.vented_by(|_, samples| samples.angle_code = 0);
    let at_fault = JointResponse::WrongState(JointBoardState::Fault);
    for order in [JointRequest::Arm, JointRequest::Service, JointRequest::Press(PRESSURES)] {
        assert_eq!(joint.order(&order), at_fault, "{order:?}");
        assert_eq!(joint.tick(|_| ()).dac_codes, [0; 2]);
    }
    assert_eq!(joint.order(&JointRequest::Acknowledge), JointResponse::Accepted);
    assert_eq!(joint.order(&JointRequest::Service), JointResponse::Refused(Refusal::NotArmed));
    assert_eq!(joint.order(&JointRequest::Arm), JointResponse::Accepted);
    assert_eq!(joint.order(&JointRequest::Service), JointResponse::Accepted);
    // What was asked for before is forgotten.
    for _ in 0..100 {
        assert_eq!(joint.tick(|_| ()).dac_codes, [0; 2]);
    }
}

#[test]
fn service_and_tracking_do_not_pass_into_each_other() {
    let mut joint = Filled::served();
    let serving = JointResponse::WrongState(JointBoardState::Service);
    let configuration = JointConfiguration { version: JOINT_VERSION, control: joint_parameters() };
    let configure = JointRequest::Configure(configuration);
    for order in [&configure, &JointRequest::Arm, &JointRequest::Start(40.0), &JointRequest::Service] {
        assert_eq!(joint.order(order), serving, "{order:?}");
    }
    joint.press(PRESSURES);
    assert_eq!(joint.tick(|_| ()).state, JointBoardState::Service);
    assert_eq!(joint.order(&JointRequest::Stop), JointResponse::Accepted);
    // From a board that has a joint it goes back to that.
    assert_eq!(joint.order(&configure), JointResponse::Accepted);
    assert_eq!(joint.order(&JointRequest::Arm), JointResponse::Accepted);
    assert_eq!(joint.order(&JointRequest::Service), JointResponse::Accepted);
    joint.press(PRESSURES);
    assert_eq!(joint.order(&JointRequest::Stop), JointResponse::Accepted);
    assert_eq!(joint.tick(|_| ()).state, JointBoardState::Ready);
}
