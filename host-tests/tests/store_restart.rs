//! A board that was configured is the same board after a restart.

use board_client::pil::lock_step::Board;
use firmware::order::prepare;
use firmware::store::{LoadError, ParameterStore, Parameters};
use host_tests::HostBoard;
use host_tests::flash::MockFlash;
use host_tests::store::paper_set;
use model_core::Mode;
use wire::{Configuration, Fault, Hello, Protection, Request, Response, State, VERSION};

fn answers(board: &mut HostBoard, request: &Request) -> Response {
    board.request(request).expect("a board on the host always answers")
}

#[test]
fn accepted_configurations_and_limits_are_taken_again() {
    let tracking = paper_set().tracking.expect("a model");
    let protection = Protection { bus_silent_ticks: 77, ..Protection::SIMULATED };
    let requests =
        [Request::Configure(Configuration { version: VERSION, tracking }), Request::Protect(protection)];
    let kept = requests.iter().fold(Parameters::FACTORY, |kept, request| {
        assert_eq!(answers(&mut HostBoard::default(), request), Response::Accepted);
        kept.changed_by(request).expect("changed")
    });
    let mut store = ParameterStore::new(MockFlash::<4096>::blank());
    assert_eq!(store.save(State::Ready, &kept), Ok(()));

    let mut board = HostBoard::default();
    let loaded = ParameterStore::<_, Parameters>::new(store.into_flash()).load().expect("stored");
    for request in loaded.requests() {
        assert_eq!(answers(&mut board, &request), Response::Accepted);
    }
    let asked: Vec<Request> = loaded.requests().collect();
    assert_eq!(asked, [requests[1].clone(), requests[0].clone()]);
    assert!(
        matches!(answers(&mut board, &Request::Identify), Response::Hello(Hello { state, .. }) if state != State::Off)
    );
}

#[test]
fn what_only_moves_the_board_is_not_kept() {
    let requests = [Request::Identify, Request::Start(Mode::Both), Request::Stop, Request::Reference(3.0)];
    assert!(requests.iter().all(|request| paper_set().changed_by(request).is_none()));
}

#[test]
fn a_new_boards_set_asks_for_no_model_and_is_valid() {
    let asked: Vec<Request> = Parameters::FACTORY.requests().collect();
    assert_eq!(asked, [Request::Protect(Protection::STANDARD)]);
    assert!(asked.into_iter().all(|request| prepare(&request).is_ok()));
}

#[test]
fn what_cannot_be_loaded_has_a_fault() {
    assert_eq!(LoadError::Layout(9).fault(), Fault::ConfigurationVersion);
    assert_eq!(LoadError::Corrupt.fault(), Fault::ConfigurationCorrupt);
}
