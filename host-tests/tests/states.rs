//! The state machine, every state with every event: the table by itself, and the control through
//! its orders.

use firmware::state_machine::{Event, Next, next};
use host_tests::bench::Bench;
use host_tests::configuration;
use model_core::{Mode, ModelParameters, paper};
use wire::{Configuration, Fault, Protection, Refusal, Request, Response, State};

/// A row a state, a column an event in the order of [`Event::ALL`]: the first letters of the state
/// that follows, `home`, or `-` for refused.
const EXPECTED: [(State, &str); 7] = [
    (State::Off, "Self - - - - Off Serv Off Faul Off"),
    (State::SelfTest, "Self Read - - - Self - Self Faul -"),
    (State::Ready, "Self - Trac - - Read Serv Read Faul Read"),
    (State::Tracking, "- - - Trac Hold Read - - Faul -"),
    (State::Holding, "- - - Trac Hold Read - - Faul -"),
    (State::Fault, "Faul - - - - Faul - home Faul -"),
    (State::Service, "- - - - - home Serv - Faul -"),
];

fn abbreviated(next: Next) -> String {
    match next {
        Next::To(state) => format!("{state:?}").chars().take(4).collect(),
        Next::Home => "home".to_owned(),
        Next::Refused => "-".to_owned(),
    }
}

fn configuration_of_paper() -> Configuration {
    configuration(&ModelParameters::Cascade(paper::mgpi().expect("valid")))
}

/// A bench whose control is in a state, with or without a configuration before; none where that
/// cannot be.
fn bench_in(state: State, is_configured: bool) -> Option<Bench> {
    let mut bench = Bench::new(1);
    if is_configured {
        bench.demand(&Request::Configure(configuration_of_paper()));
        if state != State::SelfTest {
            (0..Protection::STANDARD.self_test_ticks).for_each(|_| bench.tick());
        }
    }
    match (state, is_configured) {
        (State::Off, false) | (State::SelfTest | State::Ready, true) => {}
        (State::Tracking, true) => bench.open(&Request::Start(Mode::Both)),
        (State::Holding, true) => {
            bench.open(&Request::Start(Mode::Both));
            bench.demand(&Request::SetMode(Mode::Hold));
        }
        (State::Fault, _) => bench.control().report(Fault::BrownOut),
        (State::Service, _) => bench.open(&Request::Service(100)),
        _ => return None,
    }
    assert_eq!(bench.state(), state);
    Some(bench)
}

/// Lets an event happen; answers whether it was refused.
fn cause(bench: &mut Bench, event: Event) -> bool {
    let request = match event {
        Event::Install => Request::Configure(configuration_of_paper()),
        Event::Start => Request::Start(Mode::Both),
        Event::SetMode => Request::SetMode(Mode::FeedforwardOnly),
        Event::Hold => Request::SetMode(Mode::Hold),
        Event::Stop => Request::Stop,
        Event::Service => Request::Service(200),
        Event::Acknowledge => Request::Acknowledge,
        Event::Arm => Request::Arm,
        Event::Trip => {
            bench.control().report(Fault::Panic);
            return false;
        }
        // The board's own: it cannot be asked for, and happens in one state only.
        Event::Tested => {
            let before = bench.state();
            (0..Protection::STANDARD.self_test_ticks).for_each(|_| bench.tick());
            return bench.state() == before;
        }
    };
    if matches!(event, Event::Start | Event::Service) {
        // The first of the two steps; refused where the second is.
        bench.request(&Request::Arm);
    }
    let state = bench.state();
    match bench.request(&request) {
        Response::Accepted => false,
        Response::Refused(refusal) => {
            assert_eq!(refusal, Refusal::WrongState(state), "{event:?}");
            true
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_table_is_the_expected_one_in_every_state_with_every_event() {
    for (state, expected) in EXPECTED {
        let found: Vec<_> = Event::ALL.iter().map(|&event| abbreviated(next(state, event))).collect();
        assert_eq!(found.join(" "), expected, "{state:?}");
    }
    assert_eq!(EXPECTED.map(|(state, _)| state), State::ALL);
}

#[test]
fn the_control_does_what_the_table_says_in_every_state_with_every_event() {
    let mut pairs = 0;
    for state in State::ALL {
        for is_configured in [false, true] {
            for event in Event::ALL {
                let Some(mut bench) = bench_in(state, is_configured) else { continue };
                let was_refused = cause(&mut bench, event);
                let expected = match next(state, event) {
                    Next::To(next) => next,
                    Next::Home if is_configured => State::SelfTest,
                    Next::Home => State::Off,
                    Next::Refused => state,
                };
                let place = format!("{state:?}, {event:?}, configured: {is_configured}");
                assert_eq!(bench.state(), expected, "{place}");
                assert_eq!(was_refused, next(state, event) == Next::Refused, "{place}");
                pairs += 1;
            }
        }
    }
    assert_eq!(pairs, 9 * Event::ALL.len());
}

#[test]
fn only_a_tested_board_or_one_in_service_drives_and_a_fault_is_left_by_acknowledgement_alone() {
    for state in State::ALL {
        for event in Event::ALL {
            let Next::To(follower) = next(state, event) else { continue };
            if follower.is_driven() && !state.is_driven() {
                let by_service = event == Event::Service;
                assert!(by_service || (state, event) == (State::Ready, Event::Start), "{state:?}, {event:?}");
            }
            assert!(state != State::Fault || follower == State::Fault, "{event:?}");
        }
    }
}

#[test]
fn a_refused_configuration_leaves_the_old_one_and_the_state() {
    let mut bench = bench_in(State::Ready, true).expect("can be");
    let mut wrong = configuration_of_paper();
    wrong.tracking.period_s = 0.002;
    assert!(matches!(bench.request(&Request::Configure(wrong)), Response::Refused(Refusal::Parameter(_))));
    bench.open(&Request::Start(Mode::Both));
    let limits = Protection { slew_bar_per_s: f32::NAN, ..Protection::STANDARD };
    assert!(matches!(bench.request(&Request::Protect(limits)), Response::Refused(Refusal::Parameter(_))));
    let in_motion = bench.request(&Request::Protect(Protection::STANDARD));
    assert_eq!(in_motion, Response::Refused(Refusal::WrongState(State::Tracking)));
}
