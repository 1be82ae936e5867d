//! What vents a joint: each fault of a channel, of the angle, of the board, and orders that have no
//! place. The plant is one that does what it is told; what is wrong is put into its samples.

use board_models::joint::joint_parameters;
use firmware::joint::ANGLE;
use firmware::joint::lock_step::LockStepJoint;
use firmware::scaling::{COMMAND, PRESSURE};
use model_core::joint::JointTarget;
use wire::joint::{
    BoardJointParameters, Channel, JOINT_VERSION, JointAim, JointBoardState, JointConfiguration, JointFault,
    JointReport, JointRequest, JointResponse, JointTickReply, JointTickRequest,
};
use wire::{Fault, Protection, Refusal};

/// A stiffness that the joint can do. Unit: N m/rad.
const STIFFNESS: f32 = 40.0;
const WANTED: JointTarget<f32> = JointTarget { angle: 0.2, stiffness: STIFFNESS, load: 0.0 };

/// Codes by which a sensor that is seen to live is off now and then: more than a stuck one's.
const ALIVE: u16 = 6;

/// A board on a plant that is where it is wanted.
struct Obedient {
    board: LockStepJoint,
    last: JointTickReply,
}

impl Obedient {
    fn ready() -> Self {
        Self::ready_by(joint_parameters())
    }

    fn ready_by(control: BoardJointParameters) -> Self {
        let mut board = LockStepJoint::new(Protection::STANDARD);
        let configuration = JointConfiguration { version: JOINT_VERSION, control };
        assert_eq!(board.answer(&JointRequest::Configure(configuration)), JointResponse::Accepted);
        let last = board.tick();
        Self { board, last }
    }

    fn starting() -> Self {
        Self::ready().started()
    }

    fn started(mut self) -> Self {
        let joint = &mut self;
        assert_eq!(joint.board.answer(&JointRequest::Arm), JointResponse::Accepted);
        assert_eq!(joint.board.answer(&JointRequest::Start(STIFFNESS)), JointResponse::Accepted);
        self
    }

    fn tracking() -> Self {
        Self::tracking_by(joint_parameters())
    }

    fn tracking_by(control: BoardJointParameters) -> Self {
        let mut joint = Self::ready_by(control).started();
        for _ in 0..20_000 {
            if joint.tick(|_| ()).state == JointBoardState::Tracking {
                break;
            }
        }
        assert_eq!(joint.last.state, JointBoardState::Tracking, "{:?}", joint.last);
        for _ in 0..500 {
            joint.tick(|_| ());
        }
        assert!(joint.last.fault.is_none() && joint.last.dac_codes.iter().all(|code| *code > 0));
        joint
    }

    /// A tick with samples that may be changed.
    fn tick(&mut self, change: impl FnOnce(&mut JointTickRequest)) -> JointTickReply {
        let mut request = JointTickRequest {
            target: Some(WANTED),
            pressure_codes: self.last.dac_codes.map(|code| PRESSURE.code(COMMAND.value(code))),
            angle_code: ANGLE.code(self.last.due_rad),
        };
        change(&mut request);
        match self.board.answer(&JointRequest::Tick(request)) {
            JointResponse::Tick(reply) => self.last = reply,
            other => panic!("{other:?}"),
        }
        self.last
    }

    /// In which tick with these samples the joint is vented, and by what.
    fn vented_by(&mut self, change: impl Fn(u32, &mut JointTickRequest)) -> (u32, JointFault) {
        for tick in 1..=10_000 {
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
fn a_fault_of_one_channel_vents_both_muscles_in_the_tick_that_sees_it() {
    for (place, channel) in Channel::BOTH.into_iter().enumerate() {
        let of = |fault| JointFault::OfChannel(channel, fault);
        let open = Obedient::tracking().vented_by(|_, samples| samples.pressure_codes[place] = 0);
        assert_eq!(open, (3, of(Fault::PressureSensor)));
        let burst = PRESSURE.code(Protection::STANDARD.overpressure_hard_bar + 0.1);
        let burst = Obedient::tracking().vented_by(|_, samples| samples.pressure_codes[place] = burst);
        assert_eq!(burst, (1, of(Fault::OverpressureHard)));
        let spikes = Obedient::tracking().vented_by(|tick, samples| {
            samples.pressure_codes[place] = PRESSURE.code(if tick % 2 == 0 { 0.2 } else { 5.8 });
        });
        assert_eq!(spikes.1, of(Fault::PressureSpiking));
        // The valve lets no air in, from the begin of a start on; the sensor is seen to live.
        let (tick, stuck) = Obedient::starting().vented_by(|tick, samples| {
            samples.pressure_codes[place] = PRESSURE.code(0.0) + ALIVE * (tick % 2) as u16;
        });
        assert_eq!(stuck, of(Fault::ValveStuck), "after {tick} ticks");
        // More in the mean than a muscle bears, though no sample is beyond the hard limit.
        let (tick, mean) = Obedient::tracking().vented_by(|tick, samples| {
            let from = PRESSURE.value(samples.pressure_codes[place]);
            let bar = (from + 0.4 * tick as f32).min(Protection::STANDARD.overpressure_soft_bar + 0.3);
            samples.pressure_codes[place] = PRESSURE.code(bar);
        });
        assert_eq!(mean, of(Fault::OverpressureSoft));
        assert!(tick <= 15 + 64, "after {tick} ticks");
        // It is not above the limit that a muscle bears for good.
        let mut joint = Obedient::tracking();
        for tick in 1..=400_u16 {
            let reply = joint.tick(|samples| {
                let from = PRESSURE.value(samples.pressure_codes[place]);
                let most = Protection::STANDARD.overpressure_soft_bar - 0.05;
                let bar = (from + 0.4 * f32::from(tick)).min(most);
                samples.pressure_codes[place] = PRESSURE.code(bar);
            });
            assert_ne!(reply.fault, Some(of(Fault::OverpressureSoft)));
        }
    }
}

#[test]
fn a_pressure_that_stands_still_past_its_command_vents_both_muscles() {
    for (place, channel) in Channel::BOTH.into_iter().enumerate() {
        let mut joint = Obedient::tracking();
        let held = joint.tick(|_| ()).dac_codes.map(|code| PRESSURE.code(COMMAND.value(code)))[place];
        let (tick, stuck) = joint.vented_by(|tick, samples| {
            let angle = if tick % 2000 < 1000 { 0.4 } else { -0.4 };
            samples.target = Some(JointTarget { angle, stiffness: 50.0, load: 0.0 });
            samples.pressure_codes[place] = held;
        });
        assert_eq!(stuck, JointFault::OfChannel(channel, Fault::PressureStuck), "after {tick} ticks");
        // The command alone, with a sensor that is seen to live, does not make it one.
        let mut joint = Obedient::tracking();
        for tick in 0..400_u16 {
            let reply = joint.tick(|samples| samples.pressure_codes[place] += ALIVE * (tick % 2));
            assert_eq!(reply.fault, None);
        }
    }
}

/// A reference that goes to and fro, 0.2 rad to either side.
fn to_and_fro(tick: u32) -> JointTarget<f32> {
    JointTarget { angle: 0.2 * (tick as f32 * 1e-3 * core::f32::consts::TAU * 0.5).sin(), ..WANTED }
}

#[test]
fn an_angle_that_stands_still_while_both_pressures_would_turn_the_joint_vents_both_muscles() {
    let mut joint = Obedient::tracking();
    let held = ANGLE.code(joint.last.due_rad);
    let (tick, stuck) = joint.vented_by(|tick, samples| {
        samples.target = Some(to_and_fro(tick));
        samples.angle_code = held + (tick % 3) as u16;
    });
    assert_eq!(stuck, JointFault::AngleStuck);
    assert!((200..1000).contains(&tick), "after {tick} ticks");
    // A stiffness that steps moves both pressures, and turns nothing.
    let mut joint = Obedient::tracking();
    let held = ANGLE.code(joint.last.due_rad);
    for tick in 0..6000 {
        let stiffness = if tick % 3000 < 1500 { 60.0 } else { STIFFNESS };
        let reply = joint.tick(|samples| {
            samples.target = Some(JointTarget { stiffness, ..WANTED });
            samples.angle_code = held;
        });
        assert_eq!(reply.fault, None, "after {tick} ticks");
    }
    // Pressures that do not turn the joint accuse no angle: here those of a joint at rest.
    let mut joint = Obedient::tracking();
    let (held, codes) =
        (ANGLE.code(joint.last.due_rad), joint.last.dac_codes.map(|code| PRESSURE.code(COMMAND.value(code))));
    let (_, other) = joint.vented_by(|tick, samples| {
        samples.target = Some(to_and_fro(tick));
        samples.angle_code = held;
        samples.pressure_codes = codes.map(|code| code + ALIVE * (tick % 2) as u16);
    });
    assert_ne!(other, JointFault::AngleStuck);
}

#[test]
fn a_feedback_that_does_all_it_may_for_a_second_vents_both_muscles() {
    let wide = joint_parameters();
    // Whose bounds leave the feedback less than the 2 bar that it may put on either pressure.
    let mut narrow = joint_parameters();
    narrow.joint.muscles.iter_mut().for_each(|muscle| muscle.highest = [2.8; 2]);
    for (control, off_rad, is_fault) in [
        (&wide, 0.1, true),
        (&wide, -0.1, true),
        (&narrow, 0.1, false),
        (&narrow, 0.3, true),
        (&narrow, -0.3, true),
    ] {
        let mut joint = Obedient::tracking_by(control.clone());
        let ended = (1..=6000_u32).find_map(|tick| {
            let reply = joint.tick(|samples| {
                // As slowly as no jump is.
                let off = off_rad * (tick as f32 / 500.0).min(1.0);
                samples.angle_code =
                    ANGLE.code(ANGLE.value(samples.angle_code) - off) + ALIVE * (tick % 2) as u16;
            });
            reply.fault.map(|fault| (tick, fault))
        });
        let found = ended.map(|(_, fault)| fault);
        let expected = is_fault.then_some(JointFault::OfBoard(Fault::Authority));
        assert_eq!(found, expected, "{off_rad} rad off, {ended:?}");
        assert!(ended.is_none_or(|(tick, _)| tick >= 1000), "{off_rad} rad off, {ended:?}");
        assert!(!is_fault || joint.last.dac_codes == [0; 2]);
    }
}

#[test]
fn an_angle_that_cannot_be_vents_both_muscles() {
    for code in [0, 4095] {
        let open = Obedient::tracking().vented_by(|_, samples| samples.angle_code = code);
        assert_eq!(open, (3, JointFault::AngleSensor));
    }
    let spikes = Obedient::tracking()
        .vented_by(|tick, samples| samples.angle_code = ANGLE.code(if tick % 2 == 0 { -0.4 } else { 0.4 }));
    assert_eq!(spikes.1, JointFault::AngleSpiking);
}

#[test]
fn what_the_start_shows_of_the_pair_vents_both_muscles_before_anything_is_controlled() {
    let mut joint = Obedient::starting();
    let backwards = joint.vented_by(|_, samples| samples.angle_code = 4095 - samples.angle_code);
    assert!(matches!(backwards.1, JointFault::WrongWay(_)), "{}", backwards.1);
    // Filled in 2 s, tried in 4 s.
    assert_eq!(backwards.0, 6_000);
    let still = Obedient::starting().vented_by(|_, samples| samples.angle_code = ANGLE.code(0.0));
    assert!(matches!(still.1, JointFault::Still(_)), "{}", still.1);
    let crossed = Obedient::starting().vented_by(|_, samples| samples.pressure_codes.swap(0, 1));
    assert_eq!(crossed.1, JointFault::Crossed);
    let another = Obedient::starting()
        .vented_by(|_, samples| samples.angle_code = ANGLE.code(1.6 * ANGLE.value(samples.angle_code)));
    assert!(matches!(another.1, JointFault::Another(_)), "{}", another.1);
    let joint = another.1.to_string();
    assert!(joint.starts_with("fault 306: the joint turns by "), "{joint}");
}

#[test]
fn a_silent_host_and_a_target_that_is_no_number_vent_both_muscles() {
    let silent = Obedient::tracking().vented_by(|_, samples| samples.target = None);
    assert_eq!(silent, (Protection::STANDARD.bus_silent_ticks, JointFault::OfBoard(Fault::BusSilent)));
    let nonsense = JointTarget { stiffness: f32::NAN, ..WANTED };
    let nonsense = Obedient::tracking().vented_by(|_, samples| samples.target = Some(nonsense));
    assert_eq!(nonsense, (1, JointFault::OfBoard(Fault::Reference)));
}

fn reported(response: JointResponse) -> JointReport {
    match response {
        JointResponse::Report(report) => report,
        other => panic!("{other:?}"),
    }
}

/// A host that sends where the joint is to be some ticks ahead, each 20 ticks, makes the course
/// that one makes which says it in every tick.
#[test]
fn targets_of_some_ticks_ahead_make_a_smooth_course() {
    let course = |tick: u32| 0.2 * (tick as f32 * 1e-3 * core::f32::consts::TAU * 0.25).sin();
    let mut joint = Obedient::tracking();
    let target = |tick| JointTarget { angle: course(tick), ..WANTED };
    for _ in 0..1000 {
        joint.tick(|samples| samples.target = Some(target(0)));
    }
    let begin = reported(joint.board.answer(&JointRequest::Aim(None))).ticks;
    let (mut farthest, mut limited, ahead) = (0.0_f32, 0, 40);
    for tick in 0..4000 {
        if tick % 20 == 0 {
            let aim = JointAim { target: target(tick + ahead), by_tick: begin + tick + ahead };
            joint.board.answer(&JointRequest::Aim(Some(aim)));
        }
        let reply = joint.tick(|samples| samples.target = None);
        // The first tick behind an order is the next.
        if tick > ahead {
            farthest = farthest.max((reply.due_rad - course(tick + 1)).abs());
        }
        // From rest it begins with a jump of the speed.
        limited += u32::from(reply.is_limited && tick > ahead);
    }
    assert!(farthest < 1e-3, "{farthest} rad");
    assert_eq!(limited, 0, "the slew rate cuts off what the lead asks for");
}

#[test]
fn a_target_without_samples_acts_in_the_next_tick_and_a_question_is_no_sign_of_life() {
    let aim = |joint: &mut Obedient, target: Option<JointTarget<f32>>| {
        let aim = target.map(|target| JointAim { target, by_tick: 0 });
        reported(joint.board.answer(&JointRequest::Aim(aim)))
    };
    let mut joint = Obedient::tracking();
    let before = aim(&mut joint, Some(JointTarget { angle: -0.2, ..WANTED }));
    assert_eq!(before.tick, joint.last);
    let after = joint.tick(|samples| samples.target = None);
    assert!(after.due_rad < before.tick.due_rad, "{after:?}");
    let report = aim(&mut joint, None);
    assert_eq!((report.tick, report.ticks), (after, before.ticks + 1));
    let patience = Protection::STANDARD.bus_silent_ticks;
    for _ in 0..3 * patience {
        aim(&mut joint, Some(WANTED));
        assert_eq!(joint.tick(|samples| samples.target = None).fault, None);
    }
    let (mut ticks, silent) = (0, Some(JointFault::OfBoard(Fault::BusSilent)));
    while aim(&mut joint, None).tick.fault != silent {
        joint.tick(|samples| samples.target = None);
        ticks += 1;
        assert!(ticks <= patience, "the host's questions keep the joint driven");
    }
}

#[test]
fn a_fault_stays_until_it_is_acknowledged_and_no_order_opens_a_valve_meanwhile() {
    let mut joint = Obedient::tracking();
    joint.vented_by(|_, samples| samples.angle_code = 0);
    let fault = JointResponse::WrongState(JointBoardState::Fault);
    let configuration = JointConfiguration { version: JOINT_VERSION, control: joint_parameters() };
    for order in [JointRequest::Arm, JointRequest::Start(STIFFNESS), JointRequest::Configure(configuration)] {
        assert_eq!(joint.board.answer(&order), fault, "{order:?}");
        assert_eq!(joint.tick(|_| ()).dac_codes, [0; 2]);
    }
    assert_eq!(joint.board.answer(&JointRequest::Stop), JointResponse::Accepted);
    assert_eq!(joint.last.fault, Some(JointFault::AngleSensor));
    assert_eq!(joint.board.answer(&JointRequest::Acknowledge), JointResponse::Accepted);
    let reply = joint.tick(|_| ());
    assert_eq!((reply.state, reply.fault, reply.dac_codes), (JointBoardState::Ready, None, [0; 2]));
}

#[test]
fn a_start_needs_a_joint_an_arming_and_a_stiffness_and_a_stop_vents_at_once() {
    let mut off = LockStepJoint::new(Protection::STANDARD);
    assert_eq!(off.answer(&JointRequest::Arm), JointResponse::Accepted);
    let without_joint = JointResponse::WrongState(JointBoardState::Off);
    assert_eq!(off.answer(&JointRequest::Start(STIFFNESS)), without_joint);
    let other = JointConfiguration { version: JOINT_VERSION + 1, control: joint_parameters() };
    let refused = JointResponse::Refused(Refusal::Version(JOINT_VERSION));
    assert_eq!(off.answer(&JointRequest::Configure(other)), refused);
    let mut slack = joint_parameters();
    slack.joint.muscles[0].lowest = [0.0; 2];
    let configuration = JointConfiguration { version: JOINT_VERSION, control: slack };
    let refused = off.answer(&JointRequest::Configure(configuration));
    assert!(matches!(refused, JointResponse::Refused(Refusal::Parameter(_))), "{refused:?}");

    let mut joint = Obedient::ready();
    let unarmed = JointResponse::Refused(Refusal::NotArmed);
    assert_eq!(joint.board.answer(&JointRequest::Start(STIFFNESS)), unarmed);
    assert_eq!(joint.board.answer(&JointRequest::Arm), JointResponse::Accepted);
    let limp = joint.board.answer(&JointRequest::Start(0.0));
    assert!(matches!(limp, JointResponse::Refused(Refusal::Parameter(_))), "{limp:?}");
    assert_eq!(joint.tick(|_| ()).dac_codes, [0; 2]);

    let mut joint = Obedient::tracking();
    assert_eq!(joint.board.answer(&JointRequest::Stop), JointResponse::Accepted);
    let reply = joint.tick(|_| ());
    assert_eq!((reply.state, reply.dac_codes), (JointBoardState::Ready, [0; 2]));
}
