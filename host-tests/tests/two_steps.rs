//! A valve is opened in two steps, by this board's number alone, and stays open as long as its host
//! shows that it lives; limits are compiled in for both ports.

use board_models::{extended_parameters, paper_parameters};
use firmware::scaling::{COMMAND, VENT};
use firmware::{BlackBox, Capture, Control, TickClock};
use host_tests::bus::{BusBoard, frame, refused};
use model_core::Mode;
use wire::registers::{ARMED_TICKS, Command, Exception, Id, Value};
use wire::{Configuration, Fault, Protection, Refusal, Request, Response, State, VERSION};

fn order(board: &mut BusBoard, command: Command) -> Result<(), u8> {
    board.set(Id::Command, command.number().into())
}

fn pass(board: &mut BusBoard, ticks: u32) {
    (0..ticks).for_each(|_| _ = board.tick());
}

/// How long the host may be silent here. Unit: tick.
const PATIENCE: u32 = 50;

/// A board that tracks, with a host that has to show that it lives.
fn tracking() -> BusBoard {
    let mut board = BusBoard::configured();
    board.set(Id::BusSilent, PATIENCE.into()).expect("vented");
    board.open(Command::Start);
    board
}

fn latched(board: &mut BusBoard) -> u32 {
    board.number(Id::Fault)
}

#[test]
fn no_valve_is_opened_by_one_command_and_the_board_says_what_is_missing() {
    for command in [Command::Start, Command::Service] {
        let mut board = BusBoard::configured();
        assert_eq!(order(&mut board, command), refused(Exception::DeviceBusy), "{command:?}");
        assert_eq!(board.control().state(), State::Ready);
        let words = board.read(Id::Message.register().address, 50).expect("readable");
        let message: Vec<u8> = words.into_iter().flat_map(u16::to_be_bytes).collect();
        assert!(String::from_utf8_lossy(&message).contains("command 6 first"), "{command:?}");
        order(&mut board, Command::Arm).expect("ready");
        assert_eq!(board.number(Id::Armed), u32::from(ARMED_TICKS));
        order(&mut board, command).expect("armed");
        assert!(board.control().state().is_driven());
        assert_eq!(board.number(Id::Armed), 0);
    }
    // By the link too.
    let mut board = BusBoard::configured();
    for request in [Request::Start(Mode::Both), Request::Service(100)] {
        assert_eq!(board.request(&request), Response::Refused(Refusal::NotArmed));
    }
}

#[test]
fn what_was_armed_is_armed_for_its_time_and_not_a_tick_longer() {
    for (ticks, is_taken) in [(u32::from(ARMED_TICKS) - 1, true), (ARMED_TICKS.into(), false)] {
        let mut board = BusBoard::configured();
        order(&mut board, Command::Arm).expect("ready");
        pass(&mut board, ticks);
        assert_eq!(order(&mut board, Command::Start).is_ok(), is_taken, "{ticks} ticks");
    }
}

#[test]
fn whatever_happens_between_the_steps_ends_the_start() {
    let happens: [fn(&mut BusBoard); 4] = [
        |board| order(board, Command::Stop).expect("always taken"),
        |board| order(board, Command::Acknowledge).expect("taken"),
        |board| board.set(Id::Kp, 0.1).expect("installed again"),
        |board| {
            board.control().report(Fault::EmergencyStop);
            order(board, Command::Acknowledge).expect("taken");
        },
    ];
    for (number, happens) in happens.into_iter().enumerate() {
        let mut board = BusBoard::configured();
        order(&mut board, Command::Arm).expect("ready");
        happens(&mut board);
        pass(&mut board, 2);
        assert_eq!(board.control().state(), State::Ready);
        assert_eq!(order(&mut board, Command::Start), refused(Exception::DeviceBusy), "{number}");
    }
    // A service that was left is not entered again by its code.
    let mut board = BusBoard::configured();
    board.open(Command::Service);
    order(&mut board, Command::Stop).expect("taken");
    assert_eq!(order(&mut board, Command::Service), refused(Exception::DeviceBusy));
    assert_eq!(board.request(&Request::Service(100)), Response::Refused(Refusal::NotArmed));
}

#[test]
fn another_heartbeat_is_a_sign_of_life_and_the_same_one_is_none() {
    let mut board = tracking();
    for number in 0..20 {
        pass(&mut board, PATIENCE - 10);
        board.set(Id::Heartbeat, f64::from(number % 2)).expect("any number");
        assert_eq!(board.control().state(), State::Tracking);
    }
    // The host's program stands; what sends for it goes on.
    for _ in 0..PATIENCE {
        board.set(Id::Heartbeat, 1.0).expect("any number");
        board.tick();
    }
    assert_eq!(board.control().state(), State::Tracking);
    board.tick();
    assert_eq!(latched(&mut board), u32::from(Fault::HeartbeatStands.code()));
}

#[test]
fn readings_set_points_and_orders_that_are_repeated_are_no_sign_of_life() {
    let mut board = tracking();
    for _ in 0..PATIENCE {
        board.number(Id::State);
        board.set(Id::SetpointMm, 10.0).expect("tracking");
        order(&mut board, Command::None).expect("nothing");
        let _ = order(&mut board, Command::Start);
        board.tick();
    }
    assert_eq!(board.control().state(), State::Tracking);
    board.tick();
    assert_eq!(latched(&mut board), u32::from(Fault::BusSilent.code()));
}

#[test]
fn points_that_the_board_had_not_are_a_sign_of_life_and_a_push_that_is_repeated_is_none() {
    let mut board = tracking();
    let push = |board: &mut BusBoard, number: u32| {
        let words: Vec<u16> = Value::U32(number).words().chain(Value::F32(5.0).words()).collect();
        board.write(Id::PushNumber.register().address, &words).expect("room");
    };
    for number in 0..10 {
        pass(&mut board, PATIENCE - 10);
        push(&mut board, number);
    }
    for _ in 0..PATIENCE {
        push(&mut board, 9);
        board.tick();
    }
    assert_eq!(board.control().state(), State::Tracking);
    board.tick();
    assert_eq!(latched(&mut board), u32::from(Fault::BusSilent.code()));
}

#[test]
fn one_heartbeat_may_be_for_all_boards_and_one_stop_too() {
    let mut board = tracking();
    let [high, low] = Id::Heartbeat.register().address.to_be_bytes();
    for number in 1..10 {
        pass(&mut board, PATIENCE - 10);
        assert!(board.send(&frame(0, &[6, high, low, 0, number])).is_empty());
    }
    assert_eq!(board.control().state(), State::Tracking);
    let [high, low] = Id::Command.register().address.to_be_bytes();
    board.send(&frame(0, &[6, high, low, 0, Command::Stop.number() as u8]));
    assert_eq!(board.control().state(), State::Ready);
}

/// A board with a muscle: its ticks have a clock.
fn with_muscle() -> BusBoard {
    let clock = TickClock { period_s: 1e-3, deadline_cycles: 84_000 };
    let (black_box, capture) = (Box::leak(Box::<BlackBox>::default()), Box::leak(Box::<Capture>::default()));
    BusBoard::of(Control::new(Protection::STANDARD, Some(clock), black_box, capture))
}

fn refusal(response: Response) -> String {
    match response {
        Response::Refused(Refusal::Parameter(message)) => message.as_str().to_owned(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn no_limit_by_the_link_exceeds_what_is_compiled_in() {
    let mut board = with_muscle();
    assert_eq!(board.request(&Request::Protect(Protection::WIDEST)), Response::Accepted);
    for (wrong, name) in [
        (Protection { overpressure_hard_bar: 9.0, ..Protection::STANDARD }, "overpressure_hard_bar is 9"),
        (Protection { slew_bar_per_s: 201.0, ..Protection::STANDARD }, "slew_bar_per_s is 201"),
        (Protection { bus_silent_ticks: 60_001, ..Protection::STANDARD }, "bus_silent_ticks is 60001"),
        (Protection { authority_bar: f32::INFINITY, ..Protection::STANDARD }, "authority_bar is inf"),
    ] {
        let message = refusal(board.request(&Request::Protect(wrong)));
        assert!(message.starts_with(name) && message.contains(", must be "), "{message}");
    }
    let configure = |change: fn(&mut Configuration)| {
        let mut configuration =
            Configuration { version: VERSION, tracking: extended_parameters().expect("valid") };
        change(&mut configuration);
        Request::Configure(configuration)
    };
    let message = refusal(board.request(&configure(|wrong| wrong.tracking.command_max = 8.5)));
    assert!(message.starts_with("command_max_bar is 8.5, must be 0 to 8"), "{message}");
    let message = refusal(board.request(&configure(|wrong| wrong.tracking.slew_bar_per_s = 300.0)));
    assert!(message.starts_with("command_slew_bar_per_s is 300"), "{message}");
    assert_eq!(board.request(&configure(|_| ())), Response::Accepted);
}

#[test]
fn no_code_by_the_link_opens_the_valve_beyond_what_is_compiled_in() {
    let mut board = with_muscle();
    assert_eq!(board.request(&Request::Arm), Response::Accepted);
    let message = refusal(board.request(&Request::Service(COMMAND.code(8.1))));
    assert!(message.ends_with("must be 0 to 8"), "{message}");
    assert_eq!(board.tick().dac_code, VENT.0);
    assert_eq!(board.request(&Request::Service(COMMAND.code(8.0))), Response::Accepted);
}

#[test]
fn a_simulation_has_ceilings_on_its_bus_only() {
    let mut board = BusBoard::new();
    assert_eq!(board.request(&Request::Protect(Protection::SIMULATED)), Response::Accepted);
    let tracking = paper_parameters().expect("valid");
    let configuration = Configuration { version: VERSION, tracking };
    assert_eq!(board.request(&Request::Configure(configuration)), Response::Accepted);
    assert_eq!(board.set(Id::Slew, 201.0), refused(Exception::IllegalValue));
}
